from dataclasses import replace

import numpy as np
import pytest
from absorber_support import linear_run

from twin.control.closed_loop import Schedule, run
from twin.control.excitation import WorstCase
from twin.control.lqg import lqg
from twin.control.perturbation import Perturbation
from twin.control.plant import Plant
from twin.errors import ControlError
from twin.instruments import Instrument
from twin.laboratory import Earthquake
from twin.model import Twin

IDEAL = {kind: Instrument(bits=None) for kind in ("acc", "force", "angle")}
SHORT = Schedule(6.0, 2.0)


def small(plant):
    return WorstCase((1.8, 5.5), (1e-4, 1e-4), 2e-5, moves_the_ground=plant.known_input[0] == "a")


@pytest.mark.parametrize(("delay", "rate"), [(0, 32.0), (1, 32.0), (2, 40.0), (1, 250.0)])
def test_gently_shaken_the_loop_is_the_one_scipy_simulates(plant, delay, rate):
    late = replace(plant, delay=delay)
    model = late.linear()
    controller = lqg(model, rate, delay=delay + 0.5, ramp_s=1.0)
    outcome = run(late, controller, small(plant), SHORT, instruments=IDEAL)
    inner = round(outcome.physics_hz / rate)
    force = np.append(outcome.excitation, 0.0)
    motion, torque, estimates = linear_run(model, controller, force, inner, delay, round(2 * rate))
    scale = np.abs(motion).max(axis=0)
    ours = np.column_stack([outcome.displacement, outcome.angle])
    end = -inner  # the last force is not the simulation's own
    # a table is a huge mass in the simulation, which costs digits
    near = 2e-3 if plant.known_input == "acc_ground" else 2e-4
    assert np.abs((ours - motion)[:end] / scale).max() < near
    assert np.abs(outcome.torque - torque).max() < near * np.abs(torque).max()
    assert np.abs((outcome.estimated - estimates) / scale).max() < near
    assert np.abs(torque).max() > 0


def test_the_same_seed_gives_the_same_run_and_another_another(floor_plant, controller):
    runs = [run(floor_plant, controller, WorstCase(), SHORT, seed) for seed in (1, 1, 2)]
    assert np.array_equal(runs[0].displacement, runs[1].displacement)
    assert not np.array_equal(runs[0].displacement, runs[2].displacement)


def test_nothing_acts_before_the_switch_and_one_sample_after_it(floor_plant, controller):
    outcome = run(floor_plant, controller, WorstCase(), SHORT)
    assert not outcome.torque[: 64 + 1].any()
    assert outcome.torque[65] != 0


def test_the_motors_limit_cuts_the_torque_and_is_counted(absorber_twin, controller):
    weak = Plant(absorber_twin, "force_floor1", torque_limit=2e-3)
    outcome = run(weak, controller, WorstCase((1.7, 5.7)), Schedule(16.0, 4.0))
    assert outcome.peak_torque_nm == pytest.approx(2e-3)
    assert outcome.limited >= np.count_nonzero(np.abs(outcome.torque) == 2e-3) > 0
    assert any("limit" in note for note in outcome.notes)


def test_clipped_converters_are_named(floor_plant, controller):
    narrow = {"acc_floor2": Instrument(full_scale=0.05)}
    outcome = run(floor_plant, controller, WorstCase(), SHORT, instruments=narrow)
    assert set(outcome.clipped) == {"acc_floor2"}
    assert np.abs(outcome.measured[:, 1]).max() == pytest.approx(0.05)
    assert "acc_floor2 was clipped" in " ".join(outcome.notes)


def test_a_perturbed_plant_moves_as_its_own_linearisation_says(floor_plant, controller):
    other = floor_plant.perturbed(Perturbation((1.05, 0.95), (0.95, 1.05)))
    outcome = run(other, controller, small(other), SHORT, instruments=IDEAL)
    force = np.append(outcome.excitation, 0.0)
    ours, theirs = (
        linear_run(p.linear(), controller, force, 32, 1, 64)[0][:-32, :2]
        for p in (other, floor_plant)
    )
    scale, motion = np.abs(ours).max(), outcome.displacement[:-32]
    assert np.abs(motion - ours).max() < 2e-4 * scale
    assert np.abs(motion - theirs).max() > 0.05 * scale


def test_displacements_count_from_rest(absorber_twin, controller):
    mjcf = absorber_twin.mjcf.replace(
        'name="floor1" pos="0 0 0.2839"', 'name="floor1" pos="0.02 0 0.2839"'
    )
    assert mjcf != absorber_twin.mjcf
    shifted = Plant(Twin(mjcf), "force_floor1")
    outcome = run(shifted, controller, WorstCase(), Schedule(1.0, 0.5))
    assert np.abs(outcome.displacement).max() < 0.01
    assert not outcome.displacement[0].any()


def test_an_earthquake_shakes_the_table(absorber_twin):
    table = Plant(absorber_twin, "acc_ground")
    quake = Earthquake(np.sin(np.arange(200) / 5.0), 50.0, peak=0.2)
    outcome = run(table, lqg(table.linear()), quake, SHORT)
    assert np.abs(outcome.excitation).max() == pytest.approx(0.2, rel=0.05)
    assert np.abs(outcome.displacement).max() > 1e-3


def test_what_does_not_fit_together_is_refused(floor_plant, controller, absorber_twin):
    with pytest.raises(ControlError, match="reads 'force_floor1', the plant is excited by"):
        run(Plant(absorber_twin, "force_ground"), controller, WorstCase(), SHORT)
    with pytest.raises(ControlError, match="earthquake excitation does not act as"):
        run(floor_plant, controller, Earthquake(np.ones(9), 9.0), SHORT)
    with pytest.raises(ControlError, match="control must begin within the run: 5 s of 4 s"):
        Schedule(4.0, 5.0)
    loud = {"acc": Instrument(noise_fraction=0.1)}
    with pytest.raises(ControlError, match="noise_std and a range only"):
        run(floor_plant, controller, WorstCase(), SHORT, instruments=loud)
