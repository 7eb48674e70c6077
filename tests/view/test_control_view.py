"""The controlled run as figures and as a Rerun recording with two trees."""

import numpy as np
import pytest
from rerun.chunk import RrdReader

from twin.control.bare import pendulum_of
from twin.control.closed_loop import Schedule, run
from twin.control.plant import Plant
from twin.control.study import Settings, worst_case
from twin.model import Twin
from twin.view import control_figures
from twin.view.control_rrd import write_control_rrd


@pytest.fixture(scope="module")
def study():
    plant = Plant(Twin.load("two_storey_absorber"), "force_ground", 1, 0.5)
    assert pendulum_of(plant.twin).mass > 0
    believed = plant.linear()
    controller = Settings().design(believed, 1)
    outcome = run(plant, controller, worst_case(plant), Schedule(duration_s=8.0, switch_s=4.0))
    return plant, believed, controller, outcome


def test_displacements_are_drawn_in_millimetres_with_the_moment_of_switching(study):
    outcome = study[3]
    axes = control_figures.displacements(outcome).axes
    assert len(axes) == len(outcome.floors)
    lines = {line.get_label(): line for line in axes[0].lines}
    np.testing.assert_allclose(lines["true"].get_ydata(), 1e3 * outcome.displacement[:, 0])
    assert set(lines["control switched on"].get_xdata()) == {4.0}


def test_the_effort_is_drawn_with_units(study):
    labels = [ax.get_ylabel() for ax in control_figures.effort(study[3]).axes]
    assert labels == ["torque [N m]", "swing [rad]", "force_ground\n[N]"]


def test_control_lowers_the_resonances_in_the_response(study):
    plant, _, controller, _ = study
    ax = control_figures.responses(controller, plant.linear(), 1).axes[1]
    peaks = {line.get_label(): np.max(line.get_ydata()) for line in ax.lines}
    assert peaks["with control"] < peaks["without control"]


def test_plant_and_belief_are_two_trees_in_one_recording(study, tmp_path):
    plant, believed, controller, outcome = study
    path = write_control_rrd(tmp_path / "c.rrd", outcome, plant, controller, believed)
    entities = {str(c.entity_path) for c in RrdReader(str(path)).stream().to_chunks()}
    for entity in (
        "/plant/frame/pendulum",
        "/plant/displacement/floor2",
        "/plant/torque",
        "/plant/swing",
        "/plant/excitation",
        "/believed/frame",
        "/believed/displacement/floor2",
        "/responses/floor2/with_control",
        "/parameters",
        "/log",
    ):
        assert entity in entities, sorted(entities)


def test_the_front_marks_the_controller_that_was_picked():
    rows = [
        {"name": "a", "worst_reduction": 0.8, "worst_torque_nm": 0.02, "worst_swing_rad": 0.1},
        {"name": "b", "worst_reduction": 0.9, "worst_torque_nm": 0.05, "worst_swing_rad": 0.2},
    ]
    axes = control_figures.front(rows, "b", {"torque_nm": 0.5, "swing_rad": 0.8}).axes
    marked = [line for line in axes[0].lines if "picked" in str(line.get_label())]
    assert [line.get_xydata().tolist() for line in marked] == [[[0.05, 90.0]]]
    assert "limit 0.8" in axes[1].get_xlabel()
