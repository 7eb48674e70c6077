"""What the input does between its samples, told from what is left over."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from twin.identification.levels import log_likelihood
from twin.identification.modal_response import Hold
from twin.identification.segment import Segment
from twin.identification.separable_terms import Drive, Terms

DECISIVE = 20.0
"""Difference in BIC below which records do not tell how the input behaves between samples."""


def other_hold(hold: Hold) -> Hold:
    """Return the other behaviour of an input between its samples."""
    return "held" if hold == "band-limited" else "band-limited"


def likelier_hold(drive: Drive, terms: Terms, parts: list[Segment]) -> tuple[Drive, Terms]:
    """Return drive and terms for the behaviour between samples under which less is left over."""
    there = replace(terms, hold=other_hold(terms.hold))
    other = converted(drive, terms, there)
    gain = log_likelihood(other, there, parts) - log_likelihood(drive, terms, parts)
    return (other, there) if gain > DECISIVE / 2 else (drive, terms)


def converted(drive: Drive, here: Terms, there: Terms) -> Drive:
    """Return the drive of the same modes under the other behaviour of the input.

    The response from input to mode is L / (s - l) where the input is band-limited, and
    L (e^{l dt} - 1) / l / (z - e^{l dt}) where it is held; free responses are the same.
    """
    gain = (np.exp(drive.poles * here.spectra[0].dt) - 1) / drive.poles
    v = drive.v.copy()
    inputs = here.spectra[0].U.shape[1]
    v[:, :inputs] *= (gain if there.hold == "held" else 1 / gain)[:, None]
    return replace(drive, v=v / v[np.arange(len(v)), drive.anchor][:, None])
