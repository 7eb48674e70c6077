"""What a diagnosis shows: before and after, the missing force with its law, evidence, errors."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twin.diagnosis.result import Detection, Diagnosis, Finding, ForcePicture, Trace
from twin.mechanisms import vocabulary
from twin.view.colours import GROUND, IDENTIFIED, LOCATED, MEASURED, REJECTED, SERIES, TRUE
from twin.view.diagnosis_figures import WINDOW_S, channel_errors, telling, worst_channels
from twin.view.diagnosis_words import (
    p_value,
    percent,
    place_words,
    printable,
    probability,
    twin_words,
)
from twin.view.figures import unit_of
from twin.view.force_reach import force_reach
from twin.view.page.blocks import Plot
from twin.view.page.plots import Panel, band, bars, figure, line, points, ranked

Array = NDArray[np.float64]

BAND = 1.96
"""Standard deviations to either side of 95 %."""

SHOWN_ROWS = 12
MILLI = {"m": (1e3, "mm", "mm/s", "N"), "rad": (1e3, "mrad", "mrad/s", "N m")}
"""Scale and units of a port's motion, its rate and its force, by the motion's unit."""

BEFORE, AFTER = "calibrated twin", "with the finding"


def before_after(trace: Trace, link: str) -> Plot:
    """Return a recording beside the twin before and after, and what is left, zoomed to where.

    Zooming out shows the whole recording.
    """
    before, after = channel_errors(trace, "calibrated"), channel_errors(trace, "explained")
    shown = worst_channels(trace)
    start, stop = telling(trace, WINDOW_S)
    time = np.arange(len(trace.measured)) / trace.sampling_hz
    panels = []
    for c in shown:
        name, measured = trace.outputs[c], trace.measured[:, c]
        change = f"error {percent(before[c])} → {percent(after[c])} of RMS"
        signals = [
            line(time, measured, "measured", MEASURED, 3.0),
            line(time, trace.calibrated[:, c], BEFORE, IDENTIFIED, 1.3),
            line(time, trace.explained[:, c], AFTER, TRUE, 1.3),
        ]
        left = [
            line(time, trace.calibrated[:, c] - measured, BEFORE, IDENTIFIED, 1.0),
            line(time, trace.explained[:, c] - measured, AFTER, TRUE, 1.0),
        ]
        panels += [
            Panel(f"<b>{_safe(name)}</b> [{unit_of(name)}]: {change}", signals),
            Panel(f"what is left [{unit_of(name)}]", left, share=0.55),
        ]
    role = "which the fit has not seen" if trace.role == "test" else "which the fit has seen"
    some = "" if len(shown) == len(trace.outputs) else (
        f" The {len(shown)} worst of {len(trace.outputs)} channels are shown."
    )  # fmt: skip
    seconds = len(measured) / trace.sampling_hz
    caption = (
        f"{printable(trace.name)}, {role}: the {time[stop - 1] - time[start]:.2g} s that change "
        f"most; double-click for all {seconds:.3g} s.{some}"
    )
    drawn = figure(panels, "time [s]", (time[start], time[stop - 1]), hover="x")
    return Plot(drawn, caption, [("measured", MEASURED), (BEFORE, IDENTIFIED), (AFTER, TRUE)], link)


def where(diagnosis: Diagnosis) -> Plot:
    """Return what the best explanation at every place gains, the most first.

    Before anything is fitted a place may promise more than the true one: where explanations were
    fitted, they are compared, and what the places promise only where none was.
    """
    best: dict[str, Finding] = {}
    for found in (*diagnosis.findings, *diagnosis.alternatives):
        if found.gain is not None and found.gain > _gain(best.get(found.location)):
            best[found.location] = found
    if not best:
        return _promised(diagnosis)
    rows = sorted(best.values(), key=lambda f: -_gain(f))[:SHOWN_ROWS]
    labels = [
        _safe(f"{candidate(f.mechanism.name, f.location)}: {_digits(_gain(f))}") for f in rows
    ]
    located = {f.location for f in diagnosis.findings}
    colours = [LOCATED if f.location in located else REJECTED for f in rows]
    drawn = ranked(labels, [_gain(f) for f in rows], colours, "log odds over nothing there [nat]")
    caption = "The best explanation at each place that was fitted in full, and what it gains."
    keys = [("located", LOCATED), ("elsewhere", REJECTED)]
    return Plot(drawn, caption, keys, wide=False)


def _gain(found: Finding | None) -> float:
    return 0.0 if found is None or found.gain is None else found.gain


def _promised(diagnosis: Diagnosis) -> Plot:
    located = {f.location for f in diagnosis.findings}
    rows = sorted(diagnosis.where.items(), key=lambda row: -row[1])[:SHOWN_ROWS]
    labels = [f"{_safe(place_words(place))}: {_digits(gain)}" for place, gain in rows]
    colours = [LOCATED if place in located else REJECTED for place, _ in rows]
    drawn = ranked(labels, [g for _, g in rows], colours, "promised gain in log likelihood [nat]")
    caption = "The most that a mechanism at each place promises, before any is fitted."
    keys = [("located", LOCATED), ("elsewhere", REJECTED)] if located else []
    return Plot(drawn, caption, keys, wide=False)


def alternatives(diagnosis: Diagnosis) -> Plot:
    """Return how far the other explanations are behind the best, the nearest first."""
    rivals = sorted(diagnosis.alternatives, key=_behind)[:SHOWN_ROWS]
    rows = [*diagnosis.findings[:1], *rivals]
    behind = [0.0, *(_behind(f) for f in rivals)]
    lags = ["best", *(f"{_digits(b)} behind" for b in behind[1:])]
    labels = [
        _safe(f"{candidate(f.mechanism.name, f.location)}: {lag}, {probability(f.probability)}")
        for f, lag in zip(rows, lags, strict=True)
    ]
    colours = [LOCATED, *(IDENTIFIED for _ in rivals)]
    drawn = ranked(labels, behind, colours, "log odds behind the best [nat]")
    return Plot(drawn, "Every explanation that was fitted in full, the most probable first.")


def _behind(finding: Finding) -> float:
    return max(-finding.delta_log_evidence, 0.0)


def screening(diagnosis: Diagnosis) -> Plot:
    """Return what the candidates promised before any was fitted, the best first."""
    rows = sorted(diagnosis.screening, key=lambda row: -row[2])[:SHOWN_ROWS]
    found = {(f.mechanism.name, f.location) for f in diagnosis.findings}
    colours = [LOCATED if (name, place) in found else REJECTED for name, place, _ in rows]
    gains = [max(gain, 0.0) for *_, gain in rows]
    labels = [
        f"{_safe(candidate(n, p))}: {_digits(g)}" for (n, p, _), g in zip(rows, gains, strict=True)
    ]
    drawn = ranked(labels, gains, colours, "promised gain in log likelihood [nat]")
    some = f"The {len(rows)} of {len(diagnosis.screening)} candidates that promised most"
    return Plot(drawn, f"{some}, before any was fitted.")


def candidate(name: str, place: str) -> str:
    """Return "cubic stiffness, storey 1"."""
    kind = vocabulary().get(name)
    channel = kind is not None and kind.on in ("channel", "channels")
    return f"{name.replace('_', ' ')}, {place_words(place, channel).removeprefix('channel ')}"


def _digits(value: float) -> str:
    """Return three digits or more, without an exponent."""
    return f"{value:.0f}" if abs(value) >= 100 else f"{value:.3g}"


def force(picture: ForcePicture, finding: Finding | None = None) -> list[Plot]:
    """Return the missing force at a place against drift, against rate, and over time."""
    scale, of_motion, of_rate, of_force = MILLI[picture.unit]
    place = place_words(picture.place)
    law_name = finding.mechanism.name.replace("_", " ") if finding else ""
    grey = REJECTED
    keys = [("missing force", grey)]
    both = [*keys, (law_name, LOCATED)]
    drift, rate = scale * picture.drift, scale * picture.rate
    by_drift = [points(drift, picture.latent, "missing force", grey, 3, opacity=0.55)]
    by_rate = [points(rate, picture.latent, "missing force", grey, 3, opacity=0.55)]
    grid = picture.law_drift if picture.law_rate is None else picture.law_rate
    if picture.law is not None:
        curve = _with_band(scale * grid, picture.law, picture.law_std, law_name)
        (by_drift if picture.law_rate is None else by_rate).extend(curve)
    if picture.cycle is not None and (picture.law is None or picture.law_rate is not None):
        x, y = picture.cycle.T
        by_drift.append(line(scale * x, y, law_name, LOCATED, 1.6))
    title = f"missing force at {place} [{of_force}]"
    # a few points at the ends of a recording, where a filter sees one side only, hide all others
    reach = force_reach(picture)
    over, against = (
        [Panel(title, traces, share=1.7, y_range=reach)] for traces in (by_drift, by_rate)
    )
    out = [
        Plot(figure(over, f"{place} [{of_motion}]"),
             f"Against the motion of {place}.", both if len(by_drift) > 1 else keys, wide=False),
        Plot(figure(against, f"rate of {place} [{of_rate}]"),
             "Against its rate.", both if len(by_rate) > 1 else keys, wide=False),
    ]  # fmt: skip
    if picture.piece is not None:
        time, latent, law, std = picture.piece.T
        along = [
            line(time, latent, "missing force", grey, 2.4),
            *_with_band(time, law, std, law_name),
        ]
        drawn = figure([Panel(title, along, share=1.3)], "time [s]", hover="x")
        out.append(Plot(drawn, f"Over the liveliest {time[-1] - time[0]:.2g} s.", both))
    return out


def _with_band(x: Array, law: Array, std: Array | None, name: str) -> list[dict[str, object]]:
    out = [line(x, law, name, LOCATED, 1.8)]
    if std is not None:
        out.insert(0, band(x, law - BAND * std, law + BAND * std, name, LOCATED))
    return out


def errors(diagnosis: Diagnosis) -> Plot:
    """Return the errors of the three twins beside the noise floor."""
    kinds = (("nominal", REJECTED), ("calibrated", IDENTIFIED), ("explained", TRUE),
             ("noise_floor", GROUND))  # fmt: skip
    panels = []
    for fits, title in ((diagnosis.fit, "free run over whole recordings"),
                        (diagnosis.fit_ahead, "two seconds ahead")):  # fmt: skip
        traces = []
        for kind, colour in kinds:
            share = [getattr(e, kind) for e in (fits.train, fits.test)]
            heights = [100 * s if np.isfinite(s) and s > 0 else float("nan") for s in share]
            label = [percent(s) for s in share]
            traces.append(bars(heights, ["train", "test, unseen"], twin_words(kind), colour, label))
        panels.append(Panel(f"{title}: error [% of RMS]", traces, share=1.2, log=True))
    keys = [(twin_words(kind), colour) for kind, colour in kinds]
    return Plot(figure(panels, "", type="category"), "Errors of the twins, logarithmic.", keys)


def detection(rows: Sequence[Detection]) -> Plot:
    """Return the one-step error over the noise against the level of each training recording."""
    traces, keys = [], []
    for number, row in enumerate(rows):
        colour = SERIES[number % len(SERIES)]
        level = np.asarray(row.level, float).reshape(-1, 2)
        level = level[np.argsort(level[:, 0])]
        drawn = points(level[:, 0], level[:, 1], row.channel, colour, 8)
        traces.append(drawn | {"mode": "lines+markers"})
        keys.append((f"{row.channel}, p {_equals(row.p_value)}", colour))
    noise = {"type": "line", "xref": "paper", "yref": "y", "x0": 0, "x1": 1, "y0": 1, "y1": 1,
             "line": {"color": GROUND, "dash": "dash", "width": 1}}  # fmt: skip
    title = "one-step error over noise (dashed: noise alone)"
    drawn = figure([Panel(title, traces, share=1.5, log=True)],
                   "RMS of a training recording [SI unit]", x_log=True)  # fmt: skip
    drawn["layout"]["shapes"].append(noise)
    for trace, (name, _) in zip(drawn["data"], keys, strict=True):
        trace["name"] = name
    return Plot(drawn, "A channel far above the noise at high levels only is not linear.", keys)


def _equals(value: float) -> str:
    text = p_value(value)
    return text if text.startswith("<") else f"= {text}"


def _safe(text: str) -> str:
    """Return a text that plotly takes as it is: it reads a few tags of HTML."""
    return printable(text).replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
