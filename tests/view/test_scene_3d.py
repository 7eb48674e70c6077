"""Structures in three dimensions in Rerun: poses along x, y and about z, columns that bend."""

import numpy as np
import pytest
import rerun as rr
from rerun.chunk import RrdReader

from twin.model import Twin
from twin.view.scene import log_motion


@pytest.fixture(scope="module")
def chunks(tmp_path_factory):
    portal = Twin.load("portal_3d")
    push = {"force_floor2_x": np.full(64, 2.0), "force_floor2_y": np.full(64, 1.0)}
    path = tmp_path_factory.mktemp("rrd") / "portal.rrd"
    stream = rr.RecordingStream("portal")
    stream.save(str(path))
    log_motion(stream, "portal", portal.simulate(push, 64.0, 64))
    stream.flush()
    del stream
    found = {}
    for chunk in RrdReader(str(path)).stream().to_chunks():
        found.setdefault(str(chunk.entity_path), []).append(chunk)
    return found


def column(chunks, entity, component):
    for chunk in chunks[entity]:
        batch = chunk.to_record_batch()
        for name in batch.schema.names:
            if name.endswith(component):
                return batch.column(name).to_pylist()
    raise AssertionError(f"{component} is not in {entity}")


def test_a_floor_moves_along_x_and_y_and_twists(chunks):
    moved = np.array(column(chunks, "/portal/floor2", "translation"), float).reshape(-1, 3)
    assert np.ptp(moved[:, 0]) > 1e-4
    assert np.ptp(moved[:, 1]) > 1e-4
    turned = np.array(column(chunks, "/portal/floor2", "quaternion"), float).reshape(-1, 4)
    assert np.ptp(turned[:, 2]) > 1e-4
    assert np.abs(turned[:, :2]).max() < 1e-9


def test_plates_loads_sensors_and_every_column_are_drawn(chunks):
    for entity in ("/portal/floor1/box", "/portal/floor2_load1/box", "/portal/ground/box"):
        assert entity in chunks, sorted(chunks)
    assert sum(name.startswith("/portal/skins/") for name in chunks) == 8
