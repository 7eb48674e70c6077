"""A campaign that takes little time, of a module of its own so that a test can kill it."""

import time
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

from experiments.concealed import campaign, steps
from experiments.concealed import case as cases

FITS = {"nominal": 0.9, "calibrated": 0.5, "explained": 0.02, "noise_floor": 0.01}
TABLES = {"single": 2, "none": 4}
A_MOMENT_S = 0.03
"""A step takes so long, for a kill to hit it."""


def quick(model, train, test, out, seed):
    """Say something that depends on every byte of the recordings, and on nothing else."""
    time.sleep(A_MOMENT_S)
    content = b"".join(path.read_bytes() for path in (*train, *test))
    value = int(sha256(content).hexdigest()[:8], 16)
    parameters = {"change": {"value": float(value), "std": None, "unit": ""}}
    finding = {"mechanism": "mass", "location": "floor1", "parameters": parameters}
    both = {"train": FITS, "test": FITS}
    return {
        "verdict": "parameter", "findings": [{**finding, "probability": 0.9}],
        "alternatives": [], "fit": both, "fit_ahead": both, "seconds": 1.0,
    }  # fmt: skip


def reached(truth, folder):
    """Stand for the true model."""
    time.sleep(A_MOMENT_S)
    return {"fit": 0.01, "fit_ahead": 0.01}


def main(out, tables=TABLES):
    """Run with recordings of eight seconds and no true model."""
    draw = cases.draw_plan
    cases.draw_plan = lambda *a: tuple(replace(t, duration_s=8.0) for t in draw(*a))
    steps.reference = reached
    return campaign.run(tables, 3, Path(out), diagnose=quick)
