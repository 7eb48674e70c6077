"""MATLAB files whose elements claim data types that there are none of."""

import io
import struct
import zlib

import numpy as np
import pytest
from scipy.io import savemat

from twin.errors import RecordingError
from twin.formats import parse_channel_map, read_recording
from twin.formats.mat_elements import check_elements

VALUES = {"force_floor1": np.arange(50.0)}


def saved(code, compressed):
    """A file whose channel's real part has another data type than that of doubles."""
    buffer = io.BytesIO()
    savemat(buffer, VALUES)
    data = bytearray(buffer.getvalue())
    real = data.rfind(struct.pack("<II", 9, 400))
    data[real : real + 4] = struct.pack("<I", code)
    if not compressed:
        return bytes(data)
    packed, position = bytes(data[:128]), 128
    while position < len(data):
        end = position + 8 + struct.unpack_from("<I", data, position + 4)[0]
        inner = zlib.compress(bytes(data[position:end]))
        packed += struct.pack("<II", 15, len(inner)) + inner
        position = end
    return packed


@pytest.mark.parametrize("compressed", [False, True])
def test_data_types_of_no_meaning_are_refused_before_the_reader_meets_them(tmp_path, compressed):
    path = tmp_path / "harmed.mat"
    for code in (0, 8, 11, 20, 60, 163, 255, 4000):
        path.write_bytes(saved(code, compressed))
        with pytest.raises(RecordingError, match=rf"^{path}: damaged.*data type {code}"):
            read_recording(path, sampling_hz=100.0)


@pytest.mark.parametrize("compressed", [False, True])
def test_a_sound_file_passes(tmp_path, compressed):
    path = tmp_path / "sound.mat"
    path.write_bytes(saved(9, compressed))
    check_elements(path)
    channels = parse_channel_map(["force_floor1=force_floor1 [N]"])
    recording = read_recording(path, channels, 100.0)
    np.testing.assert_allclose(recording.data[:, 0], VALUES["force_floor1"])
