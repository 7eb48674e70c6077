"""The Rerun recording is read back: what was logged is what a viewer will show."""

from dataclasses import replace

import numpy as np
import pytest
from rerun.chunk import RrdReader

from twin.laboratory import Analyser, Experiment, Hammer, perform
from twin.model import Twin
from twin.view.comparison import matrices_of, proportional
from twin.view.identified_motion import identified_motion
from twin.view.magnified import factor
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


def test_frames_signals_modes_charts_and_table_are_there(chunks):
    for entity in (
        "/frame/true/floor1",
        "/frame/true/floor2/box",
        "/frame/identified",
        "/modes/mode1/identified",
        "/modes/mode2/true",
        "/recording1/signals/force_floor1/1_measured",
        "/recording1/signals/acc_floor2/2_resimulated",
        "/recording1/residual/acc_floor1",
        "/responses/force_floor1/magnitude/2_identified/acc_floor1",
        "/order/kept",
        "/errors/value",
        "/matrices/K/cells",
        "/matrices/MAC/labels",
        "/parameters",
    ):
        assert entity in chunks, sorted(chunks)


def test_the_peak_of_the_force_is_kept(chunks, identification):
    values = np.ravel(column(chunks, "/recording1/signals/force_floor1/1_measured", "scalars"))
    assert len(values) == identification.recordings[0].samples
    assert values.max() == identification.recordings[0].column("force_floor1").max()


def test_every_frame_of_the_motion_is_a_pose_in_the_recordings_time(chunks, performance):
    moved = poses(chunks, "/frame/true/floor1", "translation", 3)
    rate = performance.motion.rate_hz
    by = factor(performance.motion)
    assert by in (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
    first = round(-performance.start_s * rate)
    model, qpos = performance.motion.model, performance.motion.qpos
    import mujoco

    data = mujoco.MjData(model)
    step = round(rate / 30)
    data.qpos[:] = qpos[first + 20 * step]
    mujoco.mj_kinematics(model, data)
    true = data.body("floor1").xpos.copy()
    data.qpos[:] = qpos[0]
    mujoco.mj_kinematics(model, data)
    rest = data.body("floor1").xpos
    shown = (moved[20] - rest)[0]
    assert shown == pytest.approx(by * (true - rest)[0], rel=0.02)
    assert np.ptp(moved[:, 0]) > 1e-2


def test_a_slider_magnifies_the_largest_motion(chunks):
    for chunk in chunks["/frame/true/floor2"]:
        batch = chunk.to_record_batch()
        if "magnification" in batch.schema.names:
            at = next(n for n in batch.schema.names if n.endswith("translation"))
            x = np.array(batch.column(at).to_pylist(), float).reshape(-1, 3)[:, 0]
            assert batch.column("magnification").to_pylist()[:3] == [1, 2, 5]
            assert (x[2] - x[1]) == pytest.approx(3 * (x[1] - x[0]), rel=0.02)
            return
    raise AssertionError("no slider")


def test_the_slider_moves_the_identified_frame_and_the_beams_with_the_true_one(chunks):
    for entity in ("/frame/identified", "/frame/true/skins/0"):
        steps = [
            chunk.to_record_batch().column("magnification").to_pylist()
            for chunk in chunks[entity]
            if "magnification" in chunk.to_record_batch().schema.names
        ]
        assert len(steps) == 1, entity
        assert steps[0][:3] == [1, 2, 5]


def test_the_identified_frame_moves_as_the_true_one(identification, performance):
    mine = identified_motion(identification)
    x = mine.x[:, 1]
    recorded = identification.recordings[0].column("acc_floor1")
    again = np.gradient(np.gradient(x, 1 / mine.rate_hz), 1 / mine.rate_hz)
    # the fixture's force is held from sample to sample: half a sample late
    assert np.corrcoef(again[4::8][31:899], recorded[32:900])[0, 1] > 0.98


def poses(chunks, entity, component, width):
    """Return what was logged over time, not what the slider shows."""
    for chunk in chunks[entity]:
        batch = chunk.to_record_batch()
        if "time" in batch.schema.names:
            for name in batch.schema.names:
                if name.endswith(component):
                    return np.array(batch.column(name).to_pylist(), float).reshape(-1, width)
    raise AssertionError(f"{component} is not in {entity}")


def test_rotations_have_their_scalar_last(chunks):
    turned = poses(chunks, "/frame/true/beam1_1", "quaternion", 4)
    # Small swings about y: x and z stay zero, the scalar near one is the last number.
    assert np.abs(turned[:, 3]).min() > 0.99
    assert np.abs(turned[:, 1]).max() > 1e-4
    assert np.abs(turned[:, [0, 2]]).max() < 1e-9


def test_beams_bend_as_a_mesh_whose_ends_follow_the_bodies(chunks):
    points = column(chunks, "/frame/true/skins/0", "vertex_positions")
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
    assert "/modes/mode1/identified" in entities
    assert "/frame/identified" in entities
    assert not any(e.startswith("/frame/true") for e in entities)


def test_a_failure_leaves_no_recording_behind(identification, tmp_path, monkeypatch):
    monkeypatch.setattr("twin.view.rrd._log_signals", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        write_rrd(tmp_path / "z.rrd", identification)
    assert list(tmp_path.iterdir()) == []


def test_a_structure_that_is_no_chain_of_floors_has_no_true_matrices():
    assert matrices_of(None) is None
    assert matrices_of(Twin.load("portal_3d")) is None
    assert matrices_of(Twin.load("two_storey_lumped")).K.shape == (2, 2)


def test_a_negative_proportional_damping_is_not_shown(identification):
    assert proportional(replace(identification, alpha=0.25, beta=2e-5)) == (0.25, 2e-5)
    assert proportional(replace(identification, alpha=0.86, beta=-1e-4)) is None
    assert proportional(replace(identification, alpha=None, beta=None)) is None
