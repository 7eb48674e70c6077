"""``sysidentpy`` on a case: polynomial NARMAX models by forward regression (FROLS), one an output.

As its documentation has it: FROLS with an information criterion and least squares, free-run
prediction and prediction over windows with ``steps_ahead``. The recordings are brought to a rate
at which the modes have about ten samples a period (at their own rate neighbouring lags are all but
the same number), laid end to end, and degree and lags are those that foresee the last
training recording best.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from diagnosis_peers_data import WINDOW_S, Array, Case, Records, answer, nrmse
from scipy.signal import decimate
from sysidentpy.basis_function import Polynomial
from sysidentpy.model_structure_selection import FROLS
from sysidentpy.parameter_estimation import LeastSquares

SLOWER = 4
SHAPES = ((1, 20), (1, 10), (2, 8), (3, 4))
"""Degree and lags of output and inputs: about as many candidates as least squares can tell."""
TERMS = 30


def slowed(records: Records) -> Records:
    """Return recordings at a lower rate, filtered without delay, the inputs one sample early.

    A force acts on the acceleration at once, and the package's lags begin at one.
    """
    out = []
    for u, y in records:
        u, y = (decimate(a, SLOWER, ftype="fir", axis=0) for a in (u, y))
        out.append((np.vstack([u[1:], u[-1:]]), y))
    return out


class Models:
    """One NARMAX model for every output."""

    def __init__(self, records: Records, degree: int, most: int) -> None:
        u, y = (np.vstack(parts) for parts in zip(*records, strict=True))
        self.unit_u = np.where(u.std(axis=0) > 0, u.std(axis=0), 1.0)
        self.unit_y = y.std(axis=0)
        lags = list(range(1, most + 1))
        self.models = []
        for column in range(y.shape[1]):
            model = FROLS(
                order_selection=True, n_info_values=TERMS, info_criteria="bic",
                ylag=lags, xlag=[lags] * u.shape[1] if u.shape[1] > 1 else lags,
                estimator=LeastSquares(), basis_function=Polynomial(degree=degree),
                err_tol=None, model_type="NARMAX",
            )  # fmt: skip
            model.fit(X=u / self.unit_u, y=(y[:, [column]] / self.unit_y[column]))
            self.models.append(model)

    def predict(self, records: Records, steps: int | None) -> list[Array]:
        """Return outputs, simulated over windows of so many steps or (None) throughout."""
        out = []
        for u, y in records:
            columns = [
                model.predict(
                    X=u / self.unit_u, y=y[:, [i]] / self.unit_y[i], steps_ahead=steps
                )[: len(y), 0] * self.unit_y[i]
                for i, model in enumerate(self.models)
            ]  # fmt: skip
            out.append(np.column_stack(columns))
        return out

    def terms(self) -> list[str]:
        """Return the regressors of more than one factor, as "y(k-1)^2"."""
        found = []
        for i, model in enumerate(self.models):
            for codes in model.final_model:
                factors = [int(c) for c in codes if c]
                if len(factors) > 1:
                    names = [f"{'y' if c < 2000 else f'u{c // 1000 - 1}'}(k-{c % 1000})"
                             for c in factors]  # fmt: skip
                    found.append(f"output {i + 1}: {' '.join(names)}")
        return found


def job(case: Case) -> dict[str, Any]:
    warnings.simplefilter("ignore")
    np.seterr(all="ignore")
    train, test = slowed(case.train), slowed(case.test)
    steps = round(WINDOW_S * case.sampling_hz / SLOWER)
    errors: dict[tuple[int, int], float] = {}
    for shape in SHAPES:
        try:
            model, held = Models(train[:-1], *shape), train[-1:]
            # a free run that diverges is worse than any that does not
            runs = [nrmse(held, model.predict(held, ahead)) for ahead in (None, steps)]
            errors[shape] = sum(1e6 if e is None else e for e in runs)
        except (ValueError, np.linalg.LinAlgError, OverflowError):
            errors[shape] = np.inf
    best = min(errors, key=lambda shape: errors[shape])
    models = Models(train, *best)
    terms = models.terms()
    return {
        "free": nrmse(test, models.predict(test, None)),
        "ahead": nrmse(test, models.predict(test, steps)),
        "degree": best[0],
        "lags": best[1],
        "nonlinear_terms": terms[:5],
        "nonlinear_term_count": len(terms),
        "says": None,  # regressors are no mechanisms and no places
    }


if __name__ == "__main__":
    answer(job)
