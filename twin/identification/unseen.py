"""How well an identified model explains a recording it was not fitted to."""

from __future__ import annotations

from twin.identification.discrete import predict
from twin.identification.records import prepare
from twin.identification.result import Identification, band_error
from twin.recording import Recording


def unseen_nrmse(result: Identification, recording: Recording) -> float:
    """Return RMS of the error over RMS of the output in the fitted band, pooled, running free.

    Only the state at the start and the sensors' offsets are taken from the recording.

    Raises:
        TwinError: the recording lacks the channels the model was identified from.
    """
    assert result.fit is not None
    records = prepare([recording], result.inputs, result.outputs)
    u, y = records.pairs[0]
    band = result.fit.w_min, result.fit.w_max
    return band_error([y], [predict(result.fit, u, y, records.dt)], records.dt, band)
