"""A cantilever with modes above the band, its exact answers, and band-limited forces."""

import numpy as np
from diagnosis_support import rng

from twin.diagnosis.measured import Measured
from twin.diagnosis.problem import Problem
from twin.model import Twin

RATE, SAMPLES = 256.0, 2048
INPUTS, OUTPUTS = ("force_tip",), ("acc_mid.x", "acc_tip.x")


def answer(model, u):
    """Return the outputs for a periodic input, exactly, (samples, m)."""
    w = 2j * np.pi * np.fft.rfftfreq(len(u), 1 / RATE)
    spectrum = np.fft.rfft(u, axis=0)
    out = []
    for s, force in zip(w, spectrum, strict=True):
        q = np.linalg.solve(s**2 * model.M + s * model.R + model.K, model.B @ force)
        out.append((model.Cd + s * model.Cv + s**2 * model.Ca) @ q + model.Cu @ force)
    return np.fft.irfft(np.array(out), len(u), axis=0)


def random_force(highest, seed):
    """A force between 8 Hz and a highest frequency, (samples, 1)."""
    draw = rng(seed)
    f = np.fft.rfftfreq(SAMPLES, 1 / RATE)
    inside = (f > 8.0) & (f < highest)
    return np.fft.irfft(inside * np.exp(2j * np.pi * draw.uniform(size=len(f))), SAMPLES)[:, None]


def problem_of(u, y, noise, between=("band_limited",)):
    model = Twin.load("cantilever").linear(INPUTS, OUTPUTS)
    levels = noise * np.ones(len(OUTPUTS))
    measured = Measured("a", u, y, np.array([1e-9]), levels)
    scale = np.full((1, len(model.coordinates)), 1e-6)
    return Problem(model, (measured,), RATE, 0.01, 0.3, between, scale)
