"""One error family: every message is one line, names what is wrong and what is available."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np


class TwinError(Exception):
    """Bad input or an impossible request. The command line prints it as one line, exit code 2.

    Examples:
        >>> import twin
        >>> try:
        ...     twin.Twin.load("two_story")
        ... except twin.TwinError as error:
        ...     print(str(error).split(":")[0])
        two_story
    """

    def __str__(self) -> str:
        return " ".join(super().__str__().split())


class RecordingError(TwinError):
    """A recording, or the file it comes from, cannot be used."""


class ModelError(TwinError):
    """An MJCF model or a frame design cannot be used."""


class ExperimentError(TwinError):
    """A virtual test, its excitation or its instruments cannot be as described."""


class IdentificationError(TwinError):
    """The data do not allow the identification that was asked for."""


class ControlError(TwinError):
    """A controller cannot be designed, run or tuned as asked."""


class NoLikelihoodError(np.linalg.LinAlgError):
    """A model that has no likelihood at certain values: it runs away, or no filter is stationary.

    Nobody's input is wrong, and a search goes on without these values, as it does where a matrix is
    singular.
    """


def available(names: Iterable[str]) -> str:
    """Return the names as a readable list for the end of an error message."""
    listed = list(names)
    return ", ".join(listed) if listed else "none"
