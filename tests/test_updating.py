"""A model updated to identified modes, and a model's shapes at its sensors."""

import json

import numpy as np
import pytest

import twin
from twin.cli import main
from twin.errors import ModelError
from twin.formats import write_recording
from twin.identification.at_sensors import modes_at_sensors, modes_of
from twin.mechanisms.mass import Mass
from twin.mechanisms.stiffness import Stiffness
from twin.model import Twin
from twin.updating import update
from twin.view.comparison import modal_rows


@pytest.fixture(scope="module")
def true():
    changes = Stiffness("storey1", -40.0), Mass("floor2", 0.05)
    return Twin.load("two_storey_lumped").including(*changes)


@pytest.fixture(scope="module")
def hit(true):
    return twin.hammer_test(true, rate_hz=64, duration_s=32)


@pytest.fixture(scope="module")
def updated(hit):
    return update(Twin.load("two_storey_lumped"), twin.identify(hit), 0.05)


def test_masses_and_stiffnesses_come_back_within_their_intervals(updated):
    expected = {
        ("stiffness", "storey1"): 478.58, ("stiffness", "storey2"): 518.58,
        ("mass", "floor1"): 0.65, ("mass", "floor2"): 1.60,
    }  # fmt: skip
    for change in updated.changes:
        if change.kind != "damping":
            truth = expected[change.kind, change.place]
            assert abs(change.updated - truth) < 3.5 * change.std
            assert change.std < 0.02 * truth


def test_the_updated_file_has_the_identified_modes(updated, true, hit, tmp_path):
    """Identify, update, simulate, compare: the loop closes."""
    path = updated.twin.export(tmp_path / "updated.xml")
    again = Twin.load(path)
    np.testing.assert_allclose(again.modes().natural_freq, true.modes().natural_freq, rtol=2e-4)
    np.testing.assert_allclose(again.modes().damping_ratio, true.modes().damping_ratio, rtol=0.03)
    simulated = twin.hammer_test(again, rate_hz=64, duration_s=32, noise=0.0)
    error = simulated.column("acc_floor2") - hit.column("acc_floor2")
    assert np.std(error) < 0.02 * np.std(hit.column("acc_floor2"))


def test_a_narrow_prior_says_that_it_is_left(hit):
    found = update(Twin.load("two_storey_lumped"), twin.identify(hit), 0.005)
    assert any(n.startswith("warning: stiffness of storey1") for n in found.notes)


def test_residues_are_those_of_the_response():
    model = Twin.load("two_storey_lumped").linear(("force_floor1",), ("acc_floor1", "acc_floor2"))
    modal, residues = modes_of(model)
    for f in (0.5, 3.0, 9.0):
        s = 2j * np.pi * f
        poles = modal.poles
        H = sum(
            r / (s - p) + r.conj() / (s - p.conj()) for r, p in zip(residues, poles, strict=True)
        )
        exact = model.state_space().frequency_response(np.array([f]))[0]
        np.testing.assert_allclose(H + model.state_space().D, exact, rtol=1e-9)


def test_the_identified_shapes_of_a_space_frame_are_the_models_at_its_sensors():
    sensors = ["acc_floor1_a.x", "acc_floor1_a.y", "acc_floor1_b.y", "acc_floor2_a.x",
               "acc_floor2_a.y", "acc_floor2_b.y"]  # fmt: skip
    portal = Twin.load("portal_3d")
    hits = [
        twin.hammer_test(portal, f"floor2_{axis}", rate_hz=128, duration_s=32, sensors=sensors)
        for axis in "xy"
    ]
    found = twin.identify(hits)
    rows = modal_rows(found, modes_at_sensors(portal, found.outputs))
    alike = [row.identified for row in rows if row.quantity.startswith("MAC")]
    assert len(alike) >= 4
    assert min(alike) > 0.95


def test_a_model_without_the_sensors_is_said(hit):
    with pytest.raises(ModelError, match="no sensor is called acc_floor1"):
        update(Twin.load("cantilever"), twin.identify(hit))


def test_the_command_writes_the_updated_model(hit, tmp_path, capsys):
    write_recording(hit, tmp_path / "hit.csv")
    arguments = ["identify", tmp_path / "hit.csv", "--model", "two_storey_lumped"]
    arguments += ["--tolerance", "0.05", "--out", tmp_path / "o", "--json", tmp_path / "f.json"]
    with pytest.raises(SystemExit) as stop:
        main([str(a) for a in arguments])
    assert stop.value.code == 0
    assert "Updated model" in capsys.readouterr().out
    assert (tmp_path / "o" / "updated.xml").exists()
    changes = json.loads((tmp_path / "f.json").read_text())["updated"]["changes"]
    assert {c["place"] for c in changes} >= {"storey1", "floor2"}
