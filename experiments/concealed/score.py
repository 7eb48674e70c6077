"""A diagnosis against the truth: right or wrong, how strong, how well it explains, how long."""

from __future__ import annotations

from typing import Any

from .mechanisms import MAIN, VERDICT


def score(
    truth: dict[str, Any], diagnosis: dict[str, Any], reference: dict[str, float]
) -> dict[str, Any]:
    """Return how good a diagnosis is, as plain types.

    Args:
        truth: opened.
        diagnosis: by the schema of ``twin diagnose``; {"error": "..."} where there is none.
        reference: ``reference.reference`` on the test recordings.

    Returns:
        mechanism_right and place_right (of the first finding; of nothing, where nothing is
        concealed), right (both), verdict_right, rank (of the truth among findings and
        alternatives, from 1; None where it is not among them), strength_error (relative, of the
        main parameter, of a gain's distance from one), parameter_errors (all of them),
        explained_over_true and explained_over_true_ahead (test recordings; None for no number),
        false_alarm, probability (of the first finding), seconds, and found (what was named).
    """
    findings = diagnosis.get("findings", [])
    first = findings[0] if findings else None
    verdict = diagnosis.get("verdict")
    nothing = truth["mechanism"] == "none"
    found = (first["mechanism"], _place(first["location"])) if first else ("none", "")
    quiet = verdict == "consistent" and not findings
    mechanism_right = quiet if nothing else found[0] == truth["mechanism"]
    place_right = quiet if nothing else found[1] == _place(truth["location"])
    right = mechanism_right and place_right
    errors = _parameter_errors(truth, first) if right and first else {}
    return {
        "mechanism_right": mechanism_right,
        "place_right": place_right,
        "right": right,
        "verdict_right": verdict == VERDICT.get(truth["mechanism"], "missing_physics"),
        "rank": _rank(truth, diagnosis),
        "strength_error": errors.get(MAIN.get(truth["mechanism"], "")),
        "parameter_errors": errors,
        "explained_over_true": _ratio(diagnosis, "fit", reference),
        "explained_over_true_ahead": _ratio(diagnosis, "fit_ahead", reference),
        "false_alarm": nothing and not quiet,
        "probability": first["probability"] if first else None,
        "seconds": diagnosis.get("seconds"),
        "found": " ".join(found).strip() if "error" not in diagnosis else "error",
    }


def _place(location: str) -> str:
    """Return a location with the channels of a pair in order."""
    return "+".join(sorted(location.split("+")))


def _parameter_errors(truth: dict[str, Any], finding: dict[str, Any]) -> dict[str, float]:
    """Return the relative error of every true parameter that the finding gives, too."""
    errors = {}
    for name, true in truth["parameters"].items():
        if name in finding["parameters"] and finding["parameters"][name]["value"] is not None:
            value, scale = finding["parameters"][name]["value"], abs(true)
            if name == "gain":
                scale = abs(true - 1)
            errors[name] = abs(value - true) / scale if scale else 0.0
    return errors


def _rank(truth: dict[str, Any], diagnosis: dict[str, Any]) -> int | None:
    wanted = (truth["mechanism"], _place(truth["location"]))
    named = [*diagnosis.get("findings", []), *diagnosis.get("alternatives", [])]
    for rank, entry in enumerate(named, 1):
        if (entry["mechanism"], _place(entry["location"])) == wanted:
            return rank
    return None


def _ratio(diagnosis: dict[str, Any], kind: str, reference: dict[str, float]) -> float | None:
    fits = diagnosis.get(kind)
    if not fits or not reference.get(kind):
        return None
    return float(fits["test"]["explained"] / reference[kind])
