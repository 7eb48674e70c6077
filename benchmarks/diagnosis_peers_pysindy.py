"""``pysindy`` on a case: sparse regression of the storeys' accelerations on drifts and rates.

As its documentation has it for second-order systems with inputs: x = (drifts, rates), x' given
(the accelerations are measured), u the forces, sequentially thresholded least squares. Drifts and
rates come from the accelerations by integration in the frequency domain. The library has what the
vocabulary's laws would need: powers, sign of the rate, rate times its size. The threshold is the
one that foresees the last training recording best.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pysindy as ps
from diagnosis_peers_data import WINDOW_S, Array, Case, Records, answer, nrmse
from scipy.signal.windows import tukey

HIGH_PASS_HZ = (0.3, 0.9)
"""Below this, integration would only amplify noise; what is regressed on it is filtered alike."""
EDGE_S = 0.5
"""At both ends the integrals are those of a taper: not regressed."""
THRESHOLDS = (0.0, 1e-4, 3e-4, 6e-4, 1e-3, 2e-3, 3e-3, 1e-2, 3e-2)
"""Of a term's size, relative to the largest of its equation (all columns have unit RMS)."""
STEPS = 4
FUNCTIONS: dict[str, Callable[[Array], Array]] = {
    "same": lambda x: x,
    "square": lambda x: x**2,
    "cube": lambda x: x**3,
    "sign": lambda x: np.sign(x),  # the library asks for a plain function
    "size": lambda x: x * np.abs(x),
}
LAWS = {
    ("square", "d"): "quadratic_stiffness",
    ("cube", "d"): "cubic_stiffness",
    ("sign", "v"): "coulomb_friction",
    ("size", "v"): "quadratic_drag",
}
"""What a term of that function and state would be in the vocabulary."""


def high_passed(values: Array, sampling_hz: float, integrals: int) -> Array:
    """Return the high-passed signal, integrated so many times, (samples, n)."""
    count = len(values)
    edge = tukey(count, 2 * EDGE_S / 2 * sampling_hz / count)[:, None]
    f = np.fft.rfftfreq(2 * count, 1 / sampling_hz)
    low, high = HIGH_PASS_HZ
    passed = np.clip((f - low) / (high - low), 0, 1)
    factor = np.sin(np.pi / 2 * passed) ** 2 / (2j * np.pi * np.maximum(f, low)) ** integrals
    spectrum = np.fft.rfft(values * edge, 2 * count, axis=0)
    return np.fft.irfft(spectrum * factor[:, None], axis=0)[:count]


def to_drifts(y: Array) -> Array:
    """Return storeys' drifts (or their derivatives) from floors', (samples, n)."""
    return np.diff(y, axis=1, prepend=0.0)


def states(record: tuple[Array, Array], sampling_hz: float) -> tuple[Array, Array, Array]:
    """Return x, x' and u of one filter, (samples, 2n), (samples, 2n), (samples, r)."""
    a = to_drifts(record[1])
    d, v, a = (high_passed(a, sampling_hz, integrals) for integrals in (2, 1, 0))
    return np.hstack([d, v]), np.hstack([v, a]), high_passed(record[0], sampling_hz, 0)


class Scaled:
    """A SINDy model in units that make every state and force of RMS one."""

    def __init__(self, case: Case, records: Records, threshold: float) -> None:
        skipped = round(EDGE_S * case.sampling_hz)
        kept = slice(skipped, -skipped)
        rows = [tuple(a[kept] for a in states(r, case.sampling_hz)) for r in records]
        self.rate = case.sampling_hz
        self.x_unit = np.sqrt(np.mean(np.vstack([x for x, _, _ in rows]) ** 2, axis=0))
        u_rms = np.sqrt(np.mean(np.vstack([u for _, _, u in rows]) ** 2, axis=0))
        self.u_unit = np.where(u_rms > 0, u_rms, 1.0)
        self.n = len(case.outputs)
        library = ps.CustomLibrary(
            library_functions=list(FUNCTIONS.values()),
            function_names=[partial("{}({})".format, name) for name in FUNCTIONS],
        )
        slopes = [dx / self.x_unit for _, dx, _ in rows]
        size = np.sqrt(np.mean(np.vstack(slopes) ** 2, axis=0)).max()
        optimizer = ps.STLSQ(threshold=threshold * size, alpha=1e-9, normalize_columns=False)
        self.model = ps.SINDy(feature_library=library, optimizer=optimizer)
        names = [f"d{i + 1}" for i in range(self.n)] + [f"v{i + 1}" for i in range(self.n)]
        self.model.fit(
            [x / self.x_unit for x, _, _ in rows], t=1 / self.rate, x_dot=slopes,
            u=[u / self.u_unit for _, _, u in rows],
            feature_names=names + [f"u{i + 1}" for i in range(len(case.inputs))],
        )  # fmt: skip
        # the first half of the equations is d' = v, whatever the regression says
        self.terms = self.model.coefficients()[self.n :]
        self.names = self.model.get_feature_names()

    def slope(self, x: Array, u: Array) -> Array:
        """Return x' for many states at once, (many, 2n), as ``model.predict`` does, only faster."""
        z = np.hstack([x / self.x_unit, u / self.u_unit])
        found = np.hstack([f(z) for f in FUNCTIONS.values()]) @ self.terms.T
        return np.hstack([x[:, self.n :], found * self.x_unit[self.n :]])

    def run(self, x: Array, u: Array) -> Array:
        """Return floor accelerations, (many, samples, n).

        Args:
            x: states to start from, (many, 2n).
            u: forces at the recordings' rate, straight between samples, (many, samples, r).
        """
        many, samples, _ = u.shape
        out = np.full((many, samples, self.n), np.inf)
        h = 1 / (self.rate * STEPS)
        for k in range(samples):
            out[:, k] = np.cumsum(self.slope(x, u[:, k])[:, self.n :], axis=1)
            after = u[:, min(k + 1, samples - 1)]
            for s in range(STEPS):
                a, b, c = (u[:, k] + (after - u[:, k]) * (s + p) / STEPS for p in (0, 0.5, 1))
                k1 = self.slope(x, a)
                k2 = self.slope(x + h / 2 * k1, b)
                k3 = self.slope(x + h / 2 * k2, b)
                k4 = self.slope(x + h * k3, c)
                x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
            if not np.isfinite(x).all() or np.abs(x / self.x_unit).max() > 1e4:
                break
        return out


def together(arrays: list[Array]) -> Array:
    """Stack arrays of different lengths, zeros behind the shorter ones."""
    longest = max(len(a) for a in arrays)
    return np.stack([np.pad(a, ((0, longest - len(a)), (0, 0))) for a in arrays])


def free(model: Scaled, records: Records) -> list[Array]:
    u = together([u for u, _ in records])
    runs = model.run(np.zeros((len(records), 2 * model.n)), u)
    return [run[: len(y)] for run, (_, y) in zip(runs, records, strict=True)]


def ahead(model: Scaled, records: Records) -> list[Array]:
    """From the state that the measured accelerations (those after it, too) integrate to."""
    length = round(WINDOW_S * model.rate)
    out = []
    for u, y in records:
        x, _, _ = states((u, y), model.rate)
        begins = range(0, len(y), length)
        runs = model.run(x[list(begins)], together([u[b : b + length] for b in begins]))
        out.append(np.concatenate(list(runs))[: len(y)])
    return out


def said(model: Scaled) -> dict[str, Any]:
    """Return the nonlinear terms that were kept, the largest first, and what they would be."""
    kept = []
    for equation, row in enumerate(model.terms):
        for name, value in zip(model.names, row, strict=True):
            if value and not name.startswith("same") and "(u" not in name:
                kept.append((abs(float(value)), equation, name))
    kept.sort(reverse=True)
    first = None
    if kept:
        kind, state = kept[0][2].rstrip(")").split("(")
        if law := LAWS.get((kind, state[0])):
            first = {"mechanism": law, "location": f"storey{state[1:]}"}
    return {"nonlinear_terms": [f"acceleration {e + 1}: {n}" for _, e, n in kept[:5]],
            "nonlinear_term_count": len(kept), "says": first}  # fmt: skip


def job(case: Case) -> dict[str, Any]:
    warnings.simplefilter("ignore")
    fitted, held = case.train[:-1], case.train[-1:]
    errors = {}
    for threshold in THRESHOLDS:
        found = nrmse(held, ahead(Scaled(case, fitted, threshold), held))
        errors[threshold] = np.inf if found is None else found
    best = min(errors, key=lambda t: (errors[t], -t))
    model = Scaled(case, case.train, best)
    return {
        "free": nrmse(case.test, free(model, case.test)),
        "ahead": nrmse(case.test, ahead(model, case.test)),
        "threshold": best,
        **said(model),
    }


if __name__ == "__main__":
    answer(job)
