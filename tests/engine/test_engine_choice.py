"""Which engine diagnoses what."""

from __future__ import annotations

import numpy as np
import pytest

from twin.engine.choice import diagnose, is_lumped_chain
from twin.errors import TwinError
from twin.model import Twin
from twin.recording import Recording


def recording(*names: str) -> Recording:
    return Recording.build(64.0, {name: np.arange(8.0) for name in names})


def test_a_lumped_frame_and_its_channels_are_a_chain() -> None:
    twin = Twin.load("two_storey_lumped")
    assert is_lumped_chain(twin, [recording("force_floor1", "acc_floor1", "acc_floor2")])


@pytest.mark.parametrize("name", ["portal_3d", "cantilever", "drive", "rotated_sensors"])
def test_other_structures_are_no_chain(name: str) -> None:
    assert not is_lumped_chain(Twin.load(name), [])


def test_a_chain_whose_spring_is_not_linear_already_is_none() -> None:
    twin = Twin.load("two_storey_lumped")
    text = twin.mjcf.replace('stiffness="518.577777777778"', 'stiffness="518.58 0 1.5e6"', 1)
    assert text != twin.mjcf
    assert not is_lumped_chain(Twin(text), [])


def test_an_unknown_engine_is_named_beside_those_there_are() -> None:
    with pytest.raises(TwinError, match=r"'old'; there are auto, chain, general"):
        diagnose(Twin.load("drive"), [], [], engine="old")  # type: ignore[arg-type]
