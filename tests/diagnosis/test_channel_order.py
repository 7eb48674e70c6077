"""Columns that stand in another order than the model's floors."""

import numpy as np
import pytest
from shaken_support import chain, ground, shaken

from twin.diagnosis.order import in_words, read_order
from twin.diagnosis.prepare import prepare
from twin.recording import Recording

MASSES, STIFFNESSES, DAMPERS = [1.0, 1.0, 1.0], [60.0, 4e3, 4e3], [1.5, 8.0, 8.0]
OUTPUTS = ("acc_floor1", "acc_floor2", "acc_floor3")


@pytest.fixture(scope="module")
def recording():
    return shaken(MASSES, STIFFNESSES, DAMPERS, ground(40, 32.0, 1, 1.0), 32.0, "r.csv")


def order(recording, columns, factor=1.0, stiffnesses=STIFFNESSES):
    model = chain(MASSES, [factor * k for k in stiffnesses]).linear(("acc_ground",), OUTPUTS, 12.0)
    u, y = recording.matrix(("acc_ground",)), recording.matrix(OUTPUTS)
    return read_order(model, u, y[:, columns], 32.0)


@pytest.mark.parametrize("factor", [0.4, 1.0, 2.5])
def test_floors_numbered_from_the_roof_are_read_from_the_ground(recording, factor):
    assert order(recording, [2, 1, 0], factor) == (2, 1, 0)
    assert order(recording, [0, 1, 2], factor) == (0, 1, 2)


def test_a_single_exchange_is_left_to_the_search(recording):
    assert order(recording, [0, 2, 1]) == (0, 1, 2)


def test_floors_that_move_alike_have_no_order(recording):
    u = recording.matrix(("acc_ground",))
    y = np.repeat(recording.matrix(OUTPUTS)[:, :1], 3, axis=1) * (1 - 1e-4 * np.arange(3))
    model = chain(MASSES, STIFFNESSES).linear(("acc_ground",), OUTPUTS, 12.0)
    assert read_order(model, u, y, 32.0) == (0, 1, 2)


def test_the_words_say_which_column_is_which():
    said = in_words("r.csv", OUTPUTS, (2, 1, 0))
    assert "acc_floor3 as acc_floor1" in said
    assert "acc_floor1 as acc_floor3" in said


def test_a_recording_in_another_order_is_laid_beside_the_twin_in_its_own(recording):
    columns = {
        name: recording.column(other) for name, other in zip(OUTPUTS, OUTPUTS[::-1], strict=True)
    }
    turned = Recording.build(
        32.0, {"acc_ground": recording.column("acc_ground"), **columns}, "turned.csv"
    )
    unseen = shaken(MASSES, STIFFNESSES, DAMPERS, ground(40, 32.0, 2, 1.0), 32.0, "unseen.csv")
    twin = chain(MASSES, STIFFNESSES)
    straight, other = (prepare(twin, [r], [unseen], 1.0, 1.0) for r in (recording, turned))
    assert np.allclose(other.train.recordings[0].y, straight.train.recordings[0].y, equal_nan=True)
    (said,) = [note for note in other.notes if "acc_floor3 as acc_floor1" in note]
    assert said.startswith("turned.csv")
    assert not any("acc_floor3 as acc_floor1" in note for note in straight.notes)
