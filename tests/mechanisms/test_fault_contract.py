"""One contract for every fault of a channel: what it changes, and how it is taken back."""

import dataclasses

import numpy as np
import pytest
from mechanism_support import error
from test_mechanism_contract import ALL, CHANNELS, DRIFT, example, ident, read_off

from twin import mechanisms
from twin.errors import ModelError
from twin.mechanisms.mechanism import ChannelFault

FAULTS = [c for c in ALL.values() if issubclass(c, ChannelFault)]


SHOWN = {
    "sensor_clipping": {"level": 0.001},
    "sensor_dropout": {"begin": 3.0, "length": 1.0},
    "sensor_spikes": {"height": 0.01, "often": 3.0},
    "sensor_quantisation": {"step": 1e-3},
}


@pytest.mark.parametrize("cls", FAULTS, ids=ident)
def test_a_fault_changes_its_channels_alone_and_is_undone_or_has_states_or_is_read_off(cls):
    rng = np.random.default_rng(5)
    columns = {name: DRIFT * rng.uniform(0.5, 2.0) for name in CHANNELS}
    start = dataclasses.replace(example(cls), **SHOWN.get(cls.name, {}))
    recorded = start.distort(columns, 100.0)
    for name, values in columns.items():
        assert (recorded[name].tobytes() == values.tobytes()) == (name not in start.channels)
    described = start.instrument(1.0)
    states = described is not None and len(described.A) > 0
    if start.of_motor or states or read_off(cls):
        return
    undone = start.undo(recorded, 100.0)
    inside = slice(20, -20) if cls.in_samples else slice(None)
    for name, values in columns.items():
        assert error(undone[name][inside], values[inside]) < 1e-3 * cls.in_samples + 1e-14
    if described is not None:
        mixed = described.D @ np.array([columns[name] for name in start.channels])
        for name, values in zip(start.channels, mixed, strict=True):
            np.testing.assert_allclose(recorded[name], values, atol=1e-15)


def test_an_unknown_mechanism_or_value_is_an_error_that_lists_what_there_is():
    with pytest.raises(ModelError, match="no mechanism 'ghost'; there are appendage, base"):
        mechanisms.from_json({"mechanism": "ghost", "location": "floor1"})
    with pytest.raises(ModelError, match="no value 'mass'; there are change"):
        mechanisms.from_json({"mechanism": "mass", "location": "floor1", "values": {"mass": 1}})
    with pytest.raises(ModelError, match="no location"):
        mechanisms.from_json({"mechanism": "mass"})
