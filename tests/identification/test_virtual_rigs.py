"""The defaults identify what the virtual laboratory records, with and without noise."""

import numpy as np
import pytest

from twin.identification.identify import identify
from twin.instruments import Instrument
from twin.laboratory import Experiment, Hammer, RandomShaking, run
from twin.model import Twin


@pytest.mark.parametrize("noise", [0.0, 0.01])
@pytest.mark.parametrize("model", ["two_storey_lumped", "two_storey"])
@pytest.mark.parametrize(
    ("excitation", "at"),
    [(Hammer(), "floor1"), (RandomShaking(), "floor1"), (RandomShaking(), "ground")],
    ids=["hammer on floor 1", "shaker on floor 1", "shaker on the ground"],
)
def test_the_defaults_find_exactly_the_modes_there_are(excitation, at, model, noise):
    instruments = {kind: Instrument(noise_fraction=noise) for kind in ("acc", "force")}
    rig = Twin.load(model)
    found = identify([run(Experiment(excitation, at=at, instruments=instruments), rig, 1)])
    true = (rig.released() if at == "ground" else rig).modes()
    assert len(found.modal.natural_freq) == len(true.natural_freq)
    # The flexible frame softens with amplitude, by a few parts in ten thousand here.
    np.testing.assert_allclose(found.modal.natural_freq, true.natural_freq, rtol=1e-3)
    assert found.second_order is not None
