"""The Rerun recording is read back: what was logged is what a viewer will show."""

import numpy as np
import pytest
from rerun.chunk import RrdReader

from twin.laboratory import Analyser, Experiment, Hammer, perform
from twin.model import Twin
from twin.view.rrd import summary, write_rrd


@pytest.fixture(scope="module")
def performance():
    analyser = Analyser(sampling_hz=32.0, duration_s=4.0)
    return perform(Experiment(Hammer(), analyser=analyser), Twin.load("two_storey"), 0)


@pytest.fixture(scope="module")
def chunks(identification, performance, tmp_path_factory):
    path = tmp_path_factory.mktemp("rrd") / "x.rrd"
    write_rrd(path, identification, Twin.load("two_storey_lumped"), performance)
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


def test_frame_signals_modes_figures_and_table_are_there(chunks):
    for entity in (
        "/frame/floor1",
        "/frame/floor2/box",
        "/modes/mode1/floors",
        "/modes/mode2/beams",
        "/signals/force_floor1/measured",
        "/signals/acc_floor2/resimulated",
        "/figures/frf",
        "/figures/singular_values",
        "/figures/stabilisation",
        "/parameters",
    ):
        assert entity in chunks, sorted(chunks)


def test_the_peak_of_the_force_is_kept(chunks, identification):
    values = np.ravel(column(chunks, "/signals/force_floor1/measured", "scalars"))
    assert len(values) == identification.recordings[0].samples
    assert values.max() == identification.recordings[0].column("force_floor1").max()


def test_every_frame_of_the_motion_is_a_pose_in_the_recordings_time(chunks, performance):
    moved = np.array(column(chunks, "/frame/floor1", "translation"), float).reshape(-1, 3)
    rate = performance.motion.rate_hz
    first = round(-performance.start_s * rate)
    model, qpos = performance.motion.model, performance.motion.qpos
    import mujoco

    data = mujoco.MjData(model)
    data.qpos[:] = qpos[first]
    mujoco.mj_kinematics(model, data)
    np.testing.assert_allclose(moved[0], data.body("floor1").xpos, atol=1e-6)
    assert np.ptp(moved[:, 0]) > 1e-3


def test_rotations_have_their_scalar_last(chunks):
    turned = np.array(column(chunks, "/frame/beam1_1", "quaternion"), float).reshape(-1, 4)
    # Small swings about y: x and z stay zero, the scalar near one is the last number.
    assert np.abs(turned[:, 3]).min() > 0.99
    assert np.abs(turned[:, 1]).max() > 1e-4
    assert np.abs(turned[:, [0, 2]]).max() < 1e-9


def test_beams_bend_as_a_mesh_whose_ends_follow_the_bodies(chunks):
    points = column(chunks, "/frame/skins/0", "vertex_positions")
    assert np.isfinite(np.concatenate([np.ravel(p) for p in points])).all()
    assert np.ptp([np.mean(np.array(p)[:, 0]) for p in points]) > 1e-4


def test_the_table_lays_identified_beside_true(identification):
    text = summary(identification, Twin.load("two_storey_lumped"))
    header = next(line for line in text.splitlines() if line.startswith("| parameter"))
    assert "identified" in header
    assert "true" in header
    assert "frequency 1" in text
    assert "K12" in text


def test_a_recording_without_a_model_has_modes_but_no_frame(identification, tmp_path):
    path = write_rrd(tmp_path / "y.rrd", identification)
    entities = {str(c.entity_path) for c in RrdReader(str(path)).stream().to_chunks()}
    assert "/modes/mode1/floors" in entities
    assert not any(e.startswith("/frame") for e in entities)


def test_a_failure_leaves_no_recording_behind(identification, tmp_path, monkeypatch):
    monkeypatch.setattr("twin.view.rrd._log_signals", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        write_rrd(tmp_path / "z.rrd", identification)
    assert list(tmp_path.iterdir()) == []
