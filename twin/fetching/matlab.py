"""One variable of a MAT file that is held in memory."""

from __future__ import annotations

import io
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from twin.errors import RecordingError, available


def variable(members: Mapping[str, bytes], file: str, name: str) -> NDArray[np.float64]:
    """Return an array of numbers.

    Raises:
        RecordingError: no such file or variable, not numbers, or not a MAT file up to version 7.
    """
    from scipy import io as matlab

    if file not in members:
        raise RecordingError(f"{file} is not there; there are {available(members)}")
    try:
        found = matlab.loadmat(io.BytesIO(members[file]))
        return np.asarray(found[name], float)
    except KeyError:
        names = [n for n in found if not n.startswith("__")]
        raise RecordingError(f"{file}: no variable '{name}'; it has {available(names)}") from None
    except Exception as error:  # damaged files raise whatever the parser stumbles over
        raise RecordingError(f"{file}: not a MAT file that can be read ({error})") from None
