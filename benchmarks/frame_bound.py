"""Cramér-Rao bound of the shaken frame's modes from its accelerations alone.

Two accelerations to one white force that is not measured, with white noise: at every line of the
band they are complex normal with a spectral matrix that the modes, the force and the noise give.
What is known: that modal forces and noise are white. What is not: frequencies, dampings, complex
shapes, the spectral matrix of the modal forces and the noise of every output. (Who knew that the
shapes are real and the force is one would know the second damping six times better, from the zeros
between the two outputs.)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twin.identification.at_sensors import modes_of
from twin.identification.output_likelihood import expected
from twin.model import Twin
from twin.recording import Recording

Array = NDArray[np.float64]

STEP = 1e-6
"""Relative step of the derivatives."""


def frame_bound(recording: Recording, band: tuple[float, float], noise: float) -> Array:
    """Return the least relative deviations of frequencies and dampings, (2, modes).

    Args:
        recording: accelerations of the frame shaken by ``force_floor1``.
        band: whose lines are used [Hz].
        noise: standard deviation of each output's noise over that of the output.
    """
    names = recording.names
    modal, residues = modes_of(Twin.load("two_storey_lumped").linear(("force_floor1",), names))
    poles = modal.poles
    # A mode's accelerance is shape s^2 / ((s - pole)(s - conj)) with this real shape.
    shapes = (residues[:, :, 0].T * (poles - poles.conj()) / poles**2).real
    n, seconds = recording.samples, recording.samples / recording.sampling_hz
    freq = np.fft.rfftfreq(n, 1 / recording.sampling_hz)
    inside = (freq > band[0]) & (freq < band[1])
    omega = 2 * np.pi * freq[inside]
    y = recording.matrix(names) - recording.matrix(names).mean(axis=0)
    power = np.abs(np.fft.rfft(y, axis=0)[inside]) ** 2 / n
    together = np.ones((len(poles), len(poles)))
    coordinates = expected(omega, seconds, poles, 2, together + 0j, np.zeros(len(poles)))
    outputs = np.einsum("oi,lij,oj->lo", shapes, coordinates, shapes).real
    force = power.sum() / outputs.sum()
    R = noise**2 * y.var(axis=0)

    def spectrum(theta: Array) -> NDArray[np.complex128]:
        w, zeta = np.abs(poles) * np.exp(theta[:2]), modal.damping_ratio * np.exp(theta[2:4])
        c = theta[5] + 1j * theta[11]
        P = force * (together + np.array([[theta[4], c], [np.conj(c), theta[6]]]))
        moved = w * (-zeta + 1j * np.sqrt(1 - zeta**2))
        seen = shapes * np.array([[1.0, 1.0], np.exp(theta[7:9] + 1j * theta[12:])])
        S = expected(omega, seconds, moved, 2, P, np.zeros(2))
        return np.asarray(seen @ S @ seen.conj().T + np.diag(R * np.exp(theta[9:11])))

    unknowns = 14
    S = spectrum(np.zeros(unknowns))
    changes = [
        np.linalg.solve(S, (spectrum(step) - spectrum(-step)) / (2 * STEP))
        for step in STEP * np.eye(unknowns)
    ]
    fisher = np.array([[np.einsum("lij,lji->", a, b).real for b in changes] for a in changes])
    return np.sqrt(np.diag(np.linalg.inv(fisher))[:4]).reshape(2, 2)
