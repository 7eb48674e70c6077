"""A diagnosis in words and numbers, which the page, the terminal and Rerun print alike."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable, Sequence

import numpy as np

from twin.diagnosis.result import Detection, Diagnosis, Finding
from twin.mechanisms.mechanism import Mechanism
from twin.place import Place
from twin.view.figures import unit_of

CLOSE = 0.05
"""An alternative at least this probable is said beside the finding."""
ROUNDED = 1.02
"""Probabilities of explanations that exclude each other sum up to one at most, but for rounding."""
LARGE, SMALL = 1e5, 1e-3
"""Numbers beyond are printed with a power of ten."""
AT_GROUND = ", at the ground "
OF_CHANNEL = "the channel's"
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

FINDING_HEADERS = ("what", "where", "values", "probability")
FIT_HEADERS = ("error, share of RMS", "nominal", "calibrated", "extended", "noise floor")
DETECTION_HEADERS = ("channel", "error / noise", "p (white)", "most at", "onset")
VERDICTS = {
    "consistent": "consistent",
    "parameter": "a parameter is off",
    "missing_physics": "physics is missing",
    "measurement": "a measurement is at fault",
    "unexplained": "outside the vocabulary",
}


def printable(text: str) -> str:
    """Return the text on one line and fit for UTF-8: file names may hold any bytes."""
    one_line = "".join(c if c.isprintable() or "\ud800" <= c <= "\udfff" else " " for c in text)
    return one_line.encode("utf-8", "backslashreplace").decode("utf-8")


def named(mechanism: Mechanism) -> str:
    """Return "cubic stiffness" for ``cubic_stiffness``."""
    return mechanism.name.replace("_", " ")


def gist(mechanism: Mechanism) -> str:
    """Return what it is in a line: the first line of the file that defines it."""
    text = sys.modules[type(mechanism).__module__].__doc__ or ""
    return text.strip().split("\n", 1)[0]


def place_words(place: str, channel: bool = False) -> str:
    """Return "storey 1" for "storey1", "channel acc_floor1" for a channel, else the port's name."""
    if channel or "+" in place:
        return f"{'channels' if '+' in place else 'channel'} {' and '.join(place.split('+'))}"
    try:
        parsed = Place.parse(place)
    except ValueError:
        return place
    return f"{parsed.kind} {parsed.number}" if parsed.number else f"the {parsed.kind}"


def where_words(mechanism: Mechanism) -> str:
    """Return "storey 1", "channel acc_floor1" or "hinge5", as what the mechanism sits on."""
    return place_words(mechanism.place, mechanism.on in ("channel", "channels"))


def located(mechanism: Mechanism) -> str:
    """Return "cubic stiffness in storey 1"."""
    words = where_words(mechanism)
    inside = "in" if words.startswith(("storey", "channel")) else "at"
    return f"{named(mechanism)} {inside} {words}"


def unit(mechanism: Mechanism, parameter: str) -> str:
    """Return the printed unit of a parameter at the mechanism's place; "" for a pure number."""
    text = mechanism.parameters[parameter].unit
    if AT_GROUND in text:
        text = text.split(AT_GROUND)[mechanism.place == "ground"]
    if text == OF_CHANNEL:
        return unit_of(mechanism.place)
    return "" if text == "1" else text.replace("^2", "²").replace("^3", "³")


def quantity(value: float, std: float, unit_text: str) -> str:
    """Return "518.6 ± 1.2 N/m": two digits of the deviation, and as many of the value."""
    after = f" {unit_text}" if unit_text else ""
    if not math.isfinite(value):
        return "∞" + after
    known = math.isfinite(std) and std > 0
    size = max(abs(value), std) if known else abs(value)
    power = math.floor(math.log10(size)) if size else 0
    scale = 10.0**power if size and not SMALL <= size < LARGE else 1.0
    raised = f" · 10{str(power).translate(RAISED)}" if scale != 1 else ""
    if not known:
        digits = f"{value / scale:.4g}"
        return f"{digits}{raised}{after}"
    decimals = min(max(1 - math.floor(math.log10(std / scale)), 0), 12)
    # what rounds to nothing has no sign
    rounded = round(value / scale, decimals) + 0.0
    pair = f"{rounded:.{decimals}f} ± {std / scale:.{decimals}f}"
    return f"({pair}){raised}{after}" if raised else f"{pair}{after}"


def values(finding: Finding) -> list[tuple[str, str, str]]:
    """Return name, value with deviation, and meaning of every parameter."""
    mechanism = finding.mechanism
    return [
        (
            name,
            quantity(float(value), finding.std.get(name, float("nan")), unit(mechanism, name)),
            mechanism.parameters[name].meaning,
        )
        for name, value in mechanism.values.items()
    ]


def twin_words(which: str) -> str:
    """Return "extended" for ``explained``, the attribute's name, and "noise floor"."""
    return "extended" if which == "explained" else which.replace("_", " ")


def percent(share: float) -> str:
    """Return a share in per cent with two or three digits."""
    if not math.isfinite(share):
        return "-"
    return f"{100 * share:.0f} %" if share >= 0.995 else f"{100 * share:.2g} %"


def probability(value: float) -> str:
    """Return a probability in per cent that claims neither certainty nor impossibility."""
    if not math.isfinite(value):
        return "-"
    if value > 0.999:
        return "> 99.9 %"
    return "< 0.1 %" if value < 0.001 else f"{100 * value:.1f} %"


def log_odds(value: float) -> str:
    """Return log odds without an exponent: three digits, or all before the point."""
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"


def p_value(value: float) -> str:
    """Return a p-value with two digits."""
    if not math.isfinite(value):
        return "-"
    return f"{value:.2g}" if value >= 1e-12 else "< 1e-12"


def verdict_sentence(diagnosis: Diagnosis) -> str:
    """Return the verdict in one sentence."""
    if not diagnosis.findings:
        return {
            "consistent": "The twin agrees with the recordings within their noise.",
            "unexplained": "The twin differs from the recordings by nothing in the vocabulary.",
        }.get(diagnosis.verdict, f"The twin differs: {VERDICTS[diagnosis.verdict]}.")
    first, *rest = diagnosis.findings
    beginning = {
        "parameter": "The twin has all the physics, but a parameter is off",
        "missing_physics": "The twin lacks physics",
        "measurement": "The twin is right and a measurement is at fault",
        "unexplained": "The twin lacks physics that is in no vocabulary, modelled as",
        "consistent": "The twin agrees with the recordings, apart from",
    }[diagnosis.verdict]
    joint = " " if beginning.endswith(("as", "from")) else ": "
    text = f"{beginning}{joint}{located(first.mechanism)}"
    rivals = _rivals(diagnosis, 0)
    if rivals:
        others = _listed([_weighed(a) for a in rivals])
        text += f" ({probability(first.probability)}), which ties with {others}"
    if rest:
        words = []
        for number, finding in enumerate(rest, start=1):
            others = " or ".join(_weighed(a) for a in _rivals(diagnosis, number))
            words.append(
                f"{_weighed(finding)} or {others}" if others else located(finding.mechanism)
            )
        text += f"; besides, with less effect, {_listed(words)}"
    return f"{text}."


def _rivals(diagnosis: Diagnosis, number: int) -> list[Finding]:
    """Return the close alternatives of a finding: of the first whose probability leaves them room.

    One that is as good as certain excludes what stands in place of a smaller finding beside it.
    """
    out = []
    for other in diagnosis.alternatives:
        if other.probability >= CLOSE:
            room = (f.probability + other.probability <= ROUNDED for f in diagnosis.findings)
            if next((i for i, fits in enumerate(room) if fits), 0) == number:
                out.append(other)
    return out


def _weighed(finding: Finding) -> str:
    return f"{located(finding.mechanism)} ({probability(finding.probability)})"


def proof_sentence(diagnosis: Diagnosis) -> str:
    """Return in one sentence what the explanation does to recordings it has not seen."""
    test = diagnosis.fit.test
    floor = f"noise floor {percent(test.noise_floor)}"
    stated = "" if test.stated is None else f"; {percent(test.stated)} was stated beforehand"
    if not diagnosis.findings:
        return f"Error on unseen recordings: {percent(test.calibrated)} of RMS ({floor})."
    return (
        f"With it the error on unseen recordings is {percent(test.explained)} of RMS instead of "
        f"{percent(test.calibrated)} after calibration ({floor}{stated})."
    )


def share_sentence(diagnosis: Diagnosis) -> str:
    """Return how much of what is missing the first finding accounts for; "" where unknown."""
    found = [f for f in diagnosis.findings[:1] if f.explained is not None]
    if not found or found[0].explained is None:
        return ""
    rest = found[0].unexplained
    left = "" if rest is None else f"; {percent(rest)} there has no name"
    what, share = located(found[0].mechanism), probability(found[0].explained)
    return f"{what[0].upper()}{what[1:]} accounts for {share} of the missing force{left}."


def finding_rows(findings: Iterable[Finding]) -> list[tuple[str, str, str, str]]:
    """Return the cells under ``FINDING_HEADERS``; the values are lines."""
    return [
        (
            named(f.mechanism),
            where_words(f.mechanism),
            "\n".join(f"{name} = {text}" for name, text, _ in values(f)) or "-",
            probability(f.probability),
        )
        for f in findings
    ]


def fit_rows(diagnosis: Diagnosis) -> list[tuple[str, ...]]:
    """Return the cells under ``FIT_HEADERS``."""
    return [
        (
            f"{title}, {role}",
            *(percent(getattr(errors, name)) for name in
              ("nominal", "calibrated", "explained", "noise_floor")),
        )
        for title, fits in (("free run", diagnosis.fit), ("two seconds ahead", diagnosis.fit_ahead))
        for role, errors in (("train", fits.train), ("test", fits.test))
    ]  # fmt: skip


def detection_rows(detection: Sequence[Detection]) -> list[tuple[str, ...]]:
    """Return the cells under ``DETECTION_HEADERS``; the onset of the error in each recording."""
    return [
        (
            d.channel,
            f"{d.excess:.3g}",
            p_value(d.p_value),
            f"{d.frequency_hz:.2f} Hz" if np.isfinite(d.frequency_hz) else "-",
            ", ".join(f"{t:.1f} s" if np.isfinite(t) else "-" for t in d.born_s) or "-",
        )
        for d in detection
    ]


def markdown(diagnosis: Diagnosis) -> str:
    """Return verdict, findings, alternatives, errors and advice for a viewer's text panel."""
    parts = [f"# {verdict_sentence(diagnosis)}", proof_sentence(diagnosis)]
    for title, found in (
        ("Findings", diagnosis.findings),
        ("Also looked at", diagnosis.alternatives),
    ):
        if found:
            # the values last: a viewer cuts a long line off at its edge
            what, where, meant, likely = FINDING_HEADERS
            rows = [(a, b, p, c.replace("\n", "; ")) for a, b, c, p in finding_rows(found)]
            parts += [f"## {title}", _table((what, where, likely, meant), rows)]
    parts += ["## Errors", _table(FIT_HEADERS, fit_rows(diagnosis))]
    following = diagnosis.next_experiment
    if following is not None:
        command = printable(following.command)
        parts += ["## Next experiment", printable(following.reason), f"    {command}"]
    parts += [f"- {printable(note)}" for note in diagnosis.notes]
    return "\n\n".join(parts)


def _table(headers: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [headers, ["---"] * len(headers), *rows]
    return "\n".join("| " + " | ".join(c.replace("|", "/") for c in line) + " |" for line in lines)


def _listed(items: Sequence[str]) -> str:
    return items[0] if len(items) == 1 else f"{', '.join(items[:-1])} and {items[-1]}"
