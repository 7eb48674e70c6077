"""A diagnosis against the truth: right or wrong, how strong, how well it explains, how long."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .mechanisms import MAIN, NEAREST, VERDICT

UNNAMED = "restoring_force"
"""The generic law, which is the right answer where no name of the vocabulary is."""

SAME = 1 + 1e-9
"""Two errors that differ by less are the same."""

Pair = tuple[str, str]
"""Mechanism and place."""


def score(
    truth: Mapping[str, Any], diagnosis: Mapping[str, Any], reference: Mapping[str, float]
) -> dict[str, Any]:
    """Return how good a diagnosis is, as plain types.

    Args:
        truth: opened.
        diagnosis: by the schema of ``twin diagnose``; {"error": "..."} where there is none.
        reference: ``reference.reference`` on the test recordings.

    Returns:
        right: the question of the case's table. One effect: the first finding has its mechanism
            and place. Two: both are among the findings. None: nothing is found. Outside the
            vocabulary: verdict "unexplained", first finding the generic law at the right place.
            Nearly in it: the first finding has the nearest name and the place, or the verdict is
            "unexplained" and the generic law is found at the place.
        first_right: the first finding is (one of) the effect(s).
        mechanism_right, place_right: of the first finding; of nothing, where nothing is concealed.
        verdict_right, false_alarm.
        besides: findings that are no effect.
        rank: of the first effect among findings and alternatives, from 1; None if not among them.
        strength_error: relative, of the main parameter, of a gain's distance from one; the
            largest where there are two effects. None unless right.
        parameter_errors: all of them, of the first finding if it is right.
        explained_over_true, explained_over_true_ahead: NRMSE on unseen recordings (None: none).
        noise_floor_over_true, noise_floor_over_true_ahead: the reported noise floor's.
        explained_over_calibrated, explained_over_calibrated_ahead.
        improved: the explained error, running free, is below the calibrated.
        ahead_not_worse: two seconds ahead it is at most the calibrated. None: no number.
        explained_share, share_error: stated of the effect's finding, and how far from the truth; of
            what is nearly in the vocabulary. None: not stated.
        stated: [probability, right] of all findings and alternatives, in their order.
        probability (of the first finding), seconds, found (what was named first), named (all).
    """
    diagnosis = by_one_name(diagnosis, truth.get("alike", {}))
    findings = diagnosis.get("findings", [])
    effects = effects_of(truth)
    named = [pair_of(finding) for finding in findings]
    wanted = [_wanted(truth, effect, diagnosis, named) for effect in effects]
    first = named[0] if named else ("none", "")
    quiet = diagnosis.get("verdict") == "consistent" and not findings
    verdict_right = diagnosis.get("verdict") == _verdict(truth)
    mechanism_right = first[0] in {pair[0] for pair in wanted} if wanted else quiet
    place_right = first[1] in {pair[1] for pair in wanted} if wanted else quiet
    first_right = first in wanted if wanted else quiet
    right = set(wanted) <= set(named) if len(wanted) > 1 else first_right
    if truth.get("table") == "outside":
        right = right and verdict_right
    if truth.get("table") == "near":
        right = first_right or (wanted[0][0] == UNNAMED and wanted[0] in named)
        verdict_right = verdict_right or diagnosis.get("verdict") == "unexplained"
    errors = [_parameter_errors(e, f) for e, f in _matched(effects, wanted, findings)]
    mains = [
        error[MAIN.get(effect["mechanism"], "")]
        for effect, error in zip(effects, errors, strict=True)
        if MAIN.get(effect["mechanism"], "") in error
    ]
    ahead = _ratio(diagnosis, "fit_ahead", "calibrated")
    free = _ratio(diagnosis, "fit", "calibrated")
    return {
        "mechanism_right": mechanism_right,
        "place_right": place_right,
        "first_right": first_right,
        "right": right,
        "verdict_right": verdict_right,
        "besides": sum(pair not in wanted for pair in named),
        "rank": _rank(wanted, diagnosis),
        "strength_error": max(mains) if right and mains else None,
        "parameter_errors": errors[0] if first_right and errors else {},
        "explained_over_true": _over(diagnosis, "fit", "explained", reference),
        "explained_over_true_ahead": _over(diagnosis, "fit_ahead", "explained", reference),
        "noise_floor_over_true": _over(diagnosis, "fit", "noise_floor", reference),
        "noise_floor_over_true_ahead": _over(diagnosis, "fit_ahead", "noise_floor", reference),
        "explained_over_calibrated": free,
        "explained_over_calibrated_ahead": ahead,
        "improved": free is not None and free < 1,
        "ahead_not_worse": None if ahead is None else ahead <= SAME,
        **_explained(truth, wanted, findings),
        "stated": _stated(wanted, diagnosis),
        "false_alarm": not effects and not quiet,
        "probability": findings[0]["probability"] if findings else None,
        "seconds": diagnosis.get("seconds"),
        "found": "error" if "error" in diagnosis else words(first),
        "named": [words(pair) for pair in named],
    }


def by_one_name(diagnosis: Mapping[str, Any], alike: Mapping[str, str]) -> dict[str, Any]:
    """Return a diagnosis in which places that move alike have one name, as the truth has it."""

    def renamed(entry: Mapping[str, Any]) -> dict[str, Any]:
        return {**entry, "location": alike.get(entry["location"], entry["location"])}

    named = {
        key: [renamed(entry) for entry in diagnosis[key]]
        for key in ("findings", "alternatives")
        if key in diagnosis
    }
    return {**diagnosis, **named}


def effects_of(truth: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return what is concealed; truths of earlier campaigns hold one effect in their own keys."""
    if "effects" in truth:
        return list(truth["effects"])
    if truth["mechanism"] == "none":
        return []
    return [{key: truth[key] for key in ("mechanism", "location", "parameters")}]


def pair_of(entry: Mapping[str, Any]) -> Pair:
    """Return mechanism and place, the channels of a swap in order."""
    return entry["mechanism"], "+".join(sorted(entry["location"].split("+")))


def words(pair: Pair) -> str:
    """Return "bumper storey2"."""
    return " ".join(pair).strip()


def _wanted(
    truth: Mapping[str, Any], effect: Mapping[str, Any], diagnosis: Mapping[str, Any],
    named: list[Pair],
) -> Pair:  # fmt: skip
    """Return what the diagnosis should say of an effect; of a near law, which of two it says."""
    mechanism, place = pair_of(effect)
    if truth.get("table") == "near":
        generic = diagnosis.get("verdict") == "unexplained" and (UNNAMED, place) in named
        return (UNNAMED if generic else NEAREST[mechanism]), place
    return (UNNAMED if truth.get("table") == "outside" else mechanism), place


def _explained(
    truth: Mapping[str, Any], wanted: list[Pair], findings: list[dict[str, Any]]
) -> dict[str, float | None]:
    """Return the share of the missing force that is said to be explained, and its error."""
    true = truth.get("evidence", {}).get("explained")
    stated = [f.get("explained") for f in findings if pair_of(f) in wanted]
    if true is None or not stated or stated[0] is None:
        return {"explained_share": None, "share_error": None}
    return {"explained_share": stated[0], "share_error": abs(stated[0] - true)}


def _verdict(truth: Mapping[str, Any]) -> str:
    if "expected" in truth:
        return str(truth["expected"])
    return VERDICT.get(truth["mechanism"], "missing_physics")


def _matched(
    effects: list[dict[str, Any]], wanted: list[Pair], findings: list[dict[str, Any]]
) -> list[tuple[dict[str, Any], dict[str, Any] | None]]:
    """Return every effect with the finding that names it."""
    by_pair = {pair_of(finding): finding for finding in reversed(findings)}
    return [(effect, by_pair.get(pair)) for effect, pair in zip(effects, wanted, strict=True)]


def _parameter_errors(
    effect: Mapping[str, Any], finding: Mapping[str, Any] | None
) -> dict[str, float]:
    """Return the relative error of every true parameter that the finding gives, too."""
    errors: dict[str, float] = {}
    given = finding["parameters"] if finding is not None else {}
    for name, true in effect["parameters"].items():
        if name in given and given[name]["value"] is not None:
            scale = abs(true - 1) if name == "gain" else abs(true)
            errors[name] = abs(given[name]["value"] - true) / scale if scale else 0.0
    return errors


def _rank(wanted: list[Pair], diagnosis: Mapping[str, Any]) -> int | None:
    for rank, entry in enumerate(_all_named(diagnosis), 1):
        if wanted and pair_of(entry) == wanted[0]:
            return rank
    return None


def _stated(wanted: list[Pair], diagnosis: Mapping[str, Any]) -> list[list[Any]]:
    return [[entry["probability"], pair_of(entry) in wanted] for entry in _all_named(diagnosis)]


def _all_named(diagnosis: Mapping[str, Any]) -> list[dict[str, Any]]:
    return [*diagnosis.get("findings", []), *diagnosis.get("alternatives", [])]


def _over(
    diagnosis: Mapping[str, Any], kind: str, which: str, reference: Mapping[str, float]
) -> float | None:
    """Return an error on the unseen recordings over the true model's."""
    error = (diagnosis.get(kind) or {}).get("test", {}).get(which)
    if error is None or not reference.get(kind):
        return None
    return float(error / reference[kind])


def _ratio(diagnosis: Mapping[str, Any], kind: str, other: str) -> float | None:
    """Return the explained error on the unseen recordings over another one."""
    errors = (diagnosis.get(kind) or {}).get("test", {})
    if errors.get("explained") is None or not errors.get(other):
        return None
    return float(errors["explained"] / errors[other])
