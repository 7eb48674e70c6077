"""Edits of MuJoCo models that are not like the shipped ones, and twins that carry mechanisms."""

from dataclasses import replace
from itertools import pairwise

import mujoco
import numpy as np
import pytest
from mechanism_support import RATE, error, integrate, push
from scipy.integrate import solve_ivp
from scipy.linalg import solve_continuous_lyapunov

from twin import mechanisms
from twin.errors import ModelError
from twin.linearise import linearise
from twin.mechanisms.edits import Line, body_named
from twin.mechanisms.shifting import later
from twin.mechanisms.sliders import as_sliders
from twin.model import Twin

ALL = mechanisms.vocabulary()
LUMPED, RIGID = Twin.load("two_storey_lumped"), Twin.load("two_storey")
GEOMS = """<mujoco><compiler {compiler}/><option gravity="0 0 0"/><worldbody><body name="ground">
<body name="floor1"><joint name="storey1" type="slide" axis="1 0 0" stiffness="100"/>
<geom size="0.1" mass="0.5" pos="0.01 0 0"/><geom size="0.1" mass="0.25"/><site name="s"/>
</body></body></worldbody>
<actuator><motor name="force_floor1" site="s" gear="1 0 0 0 0 0"/></actuator>
<sensor><framelinacc name="acc_floor1" objtype="xbody" objname="floor1"/>
<framepos name="disp_floor1" objtype="xbody" objname="floor1"/></sensor></mujoco>"""


def lengths(twin, place):
    """Length of an added tendon over the displacement of floor 2, ground free."""
    spec = mujoco.MjSpec.from_string(twin.mjcf)
    spec.delete(spec.equality("clamp"))
    Line.of(spec, place).tendon("probe")
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qvel[:] = np.random.default_rng(0).standard_normal(model.nv)
    linear = linearise(model)
    data.qvel[:] = linear.basis @ linear.basis.T @ data.qvel
    mujoco.mj_forward(model, data)
    rate = {}
    jacobian = np.zeros((3, model.nv))
    for name in ("ground", "floor1", "floor2"):
        mujoco.mj_jacBody(model, data, jacobian, None, model.body(name).id)
        rate[name] = jacobian[0] @ data.qvel
    return data.tendon(f"{place}_probe").velocity[0], rate


@pytest.mark.parametrize("twin", [LUMPED, RIGID], ids=["lumped", "rigid"])
def test_a_drift_is_between_floors_and_a_floor_s_displacement_is_absolute(twin):
    found, rate = lengths(twin, "storey2")
    assert found == pytest.approx(rate["floor2"] - rate["floor1"], rel=1e-9)
    found, rate = lengths(twin, "storey1")
    assert found == pytest.approx(rate["floor1"] - rate["ground"], rel=1e-9)
    found, rate = lengths(twin, "floor2")
    assert found == pytest.approx(rate["floor2"], rel=1e-9)


def test_a_place_that_is_not_there_is_an_error_with_those_that_are():
    spec = mujoco.MjSpec.from_string(LUMPED.mjcf)
    with pytest.raises(ModelError, match="no place 'storey3'; there are ground, storey1, storey2"):
        Line.of(spec, "storey3")
    with pytest.raises(ModelError, match="no place 'roof'; there are ground, floor1, floor2"):
        body_named(spec, "roof")


@pytest.mark.parametrize("compiler", ["", 'inertiafromgeom="true"'])
def test_mass_that_comes_from_geoms_can_be_added_to_and_taken_from(compiler):
    twin = Twin(GEOMS.format(compiler=compiler))
    for change in (-0.5, 0.5):
        changed = twin.including(ALL["mass"]("floor1", change))
        assert changed.second_order().M[0, 0] == pytest.approx(0.75 + change, rel=1e-12)
        again = Twin(changed.mjcf_of())
        assert again.second_order().M[0, 0] == pytest.approx(0.75 + change, rel=1e-12)
    with pytest.raises(ModelError, match=r"a mass of -0\.25 kg would be left"):
        twin.including(ALL["mass"]("floor1", -1.0))


def test_a_mechanism_twice_at_one_place_is_twice_as_strong_also_in_a_file_that_is_read_again():
    spring = ALL["stiffness"]("storey1", 25.0)
    wanted = replace(spring, change=50.0).edit(LUMPED.second_order()).K
    again = Twin(LUMPED.including(spring).mjcf_of()).including(spring)
    for twin in (LUMPED.including(spring, spring), again):
        np.testing.assert_allclose(twin.second_order().K, wanted, atol=1e-8)
    drift = ALL["stiffness_drift"]("storey1", 0.01, 518.0)
    assert LUMPED.including(drift, drift).compile().nu == LUMPED.compile().nu + 2
    swings = ALL["appendage"]("floor2", 0.1, 2.0, 0.02)
    twice = Twin(LUMPED.including(swings).mjcf_of()).including(swings)
    assert twice.compile().nbody == LUMPED.compile().nbody + 2


def test_the_text_stays_and_the_twin_keeps_what_it_has_when_released():
    spring = ALL["stiffness"]("storey1", 50.0)
    twin = LUMPED.including(spring)
    assert twin.mjcf == LUMPED.mjcf
    assert twin.released().mechanisms == (spring,)
    wanted = spring.edit(LUMPED.released().second_order()).K
    np.testing.assert_allclose(twin.released().second_order().K, wanted, atol=1e-8)


def test_a_base_gives_way_only_where_it_is_not_free_already():
    base = ALL["base_compliance"]("ground", 5e4, 10.0, 2.5)
    with pytest.raises(ModelError, match="the ground moves already"):
        LUMPED.including(base).released().compile()
    with pytest.raises(ModelError, match="the ground moves already"):
        base.edit(LUMPED.released().second_order())
    assert base.scaled(2.0).stiffness == 2.5e4


def test_a_shaken_base_gives_way_above_the_table():
    base = ALL["base_compliance"]("ground", 1e7, 10.0, 2.5)
    table = 0.3 * np.sin(np.arange(1000) / 100)
    stiff = LUMPED.simulate({}, RATE, 1000, ground_acceleration=table).columns["acc_floor2"]
    soft = LUMPED.including(base).simulate({}, RATE, 1000, ground_acceleration=table).columns
    assert error(soft["acc_floor2"], stiff) < 0.01


@pytest.mark.parametrize("slower", [0.1, 1.0, 10.0])
def test_springs_that_slip_let_a_slow_model_step_as_much_slower(slower):
    slip = ALL["microslip"]("storey1", 200.0 / slower**2, 1.0, 0.0, 0.004)
    assert LUMPED.including(slip).compile().opt.timestep == pytest.approx(1e-5 * max(slower, 1.0))


@pytest.mark.parametrize(("stiffness", "damping"), [(1e6, 6e4), (1e9, 1e3)])
def test_a_base_that_is_stiff_or_strongly_damped_lets_the_model_step_finely_enough(
    stiffness, damping
):
    rig = Twin.load("two_storey_lumped").including(
        ALL["base_compliance"]("ground", stiffness, damping, 2.9)
    )
    columns = rig.simulate({"force_floor2": push(1200)}, RATE, 1200).columns
    clamped = LUMPED.simulate({"force_floor2": push(1200)}, RATE, 1200).columns
    assert error(columns["acc_floor2"], clamped["acc_floor2"]) < 0.05


def test_a_file_with_drag_can_be_read_again_with_its_ground_fast_or_free():
    drag = ALL["quadratic_drag"]("floor2", 20.0)
    twin = LUMPED.including(drag)
    again = Twin(twin.mjcf_of())
    for first, second in ((twin, again), (twin.released(), again.released())):
        one, other = (t.simulate({"force_floor2": push(600)}, RATE, 600) for t in (first, second))
        assert error(other.columns["acc_floor2"], one.columns["acc_floor2"]) < 1e-3


@pytest.mark.parametrize("rate", [200, 256, 1000])
def test_a_storey_that_friction_holds_stays_as_stiff_as_if_it_were_welded(rate):
    """At steps that are too long for the friction's settings it chatters instead."""
    model = LUMPED.second_order()
    friction = ALL["coulomb_friction"]("storey2", 5.0)
    force = np.interp(np.arange(rate * 1.4) / rate, np.arange(1500) / 1000, push(1500))
    found = LUMPED.including(friction).simulate({"force_floor2": force}, rate, len(force))
    both = np.ones(2)
    m, r, k = (both @ matrix @ both for matrix in (model.M, model.R, model.K))

    def slope(t, state):
        return state[1], (
            np.interp(t * rate, np.arange(len(force)), force) - r * state[1] - k * state[0]
        ) / m

    times = np.arange(len(force)) / rate
    welded = solve_ivp(
        slope, (0, times[-1]), [0, 0], t_eval=times, rtol=1e-9, atol=1e-12, max_step=1 / rate
    ).y
    true = np.array([slope(t, state)[1] for t, state in zip(times, welded.T, strict=True)])
    for floor in ("floor1", "floor2"):
        assert error(found.columns[f"disp_{floor}"], welded[0]) < 3e-3
        assert error(found.columns[f"acc_{floor}"], true) < 0.02


def test_dry_friction_in_the_bearing_slows_the_pendulum_as_integrated():
    twin = Twin.load("two_storey_absorber")
    friction = ALL["pendulum_friction"]("pendulum", 2e-4, 1e-4)
    forces = np.zeros((1000, 3))
    forces[:, 1] = 0.1 * push(1000)
    found = twin.including(friction).simulate({"force_floor2": forces[:, 1]}, RATE, 1000).columns
    true = integrate(twin.second_order(), forces, friction, 20)[0][:, 2]
    free = integrate(twin.second_order(), forces, None, 2)[0][:, 2]
    assert error(found["angle_pendulum"], true) < 5e-3 < 0.05 < error(free, true)


def test_the_motor_delivers_late_and_less_and_sensors_record_what_they_do():
    twin = Twin.load("two_storey_absorber")
    command = 0.02 * np.sin(np.arange(500) / 20) ** 3
    motor = twin.including(ALL["motor_delay"]("pendulum", 0.0123))
    late = twin.simulate({"torque_pendulum": later(command, 0.0123, RATE)}, RATE, 500)
    moved = motor.simulate({"torque_pendulum": command}, RATE, 500)
    assert moved.qpos.tobytes() == late.qpos.tobytes()
    dead = ALL["motor_deadband"]("pendulum", 0.01).distort({"torque_pendulum": command}, RATE)
    assert np.abs(dead["torque_pendulum"]).max() == pytest.approx(0.01, rel=1e-3)
    assert not dead["torque_pendulum"][np.abs(command) < 0.01].any()
    faulty = motor.including(ALL["sensor_gain"]("acc_floor1", 2.0))
    seen = faulty.recorded(moved.columns, RATE)
    np.testing.assert_array_equal(seen["acc_floor1"], 2 * moved.columns["acc_floor1"])
    np.testing.assert_array_equal(seen["acc_floor2"], moved.columns["acc_floor2"])
    assert faulty.recorded({"torque_pendulum": command}, RATE)["torque_pendulum"] is not None


def test_a_shift_is_that_of_the_band_limited_signal_for_any_fraction_of_a_sample():
    t = np.arange(2000) / 200
    burst = np.exp(-(((t - 5) / 0.8) ** 2)) * np.sin(2 * np.pi * 31 * t)
    for delay in (0.0013, -0.0271):
        shifted = t - delay
        true = np.exp(-(((shifted - 5) / 0.8) ** 2)) * np.sin(2 * np.pi * 31 * shifted)
        assert error(later(burst, delay, 200.0), true) < 1e-6
        assert error(later(later(burst, delay, 200.0), -delay, 200.0), burst) < 1e-6


def test_slip_forgets_how_fast_it_was_moved_and_never_passes_its_yield_force():
    slip = ALL["hysteresis"]("storey1", 300.0, 0.5, 2.0, 300.0)
    slow = 0.01 * np.sin(np.linspace(0, 20, 4001))
    z_slow = z_fast = np.zeros(1)
    for k in range(4000):
        z_slow = slip.remember(z_slow, slow[k], slow[k + 1])
        if k % 10 == 9:
            z_fast = slip.remember(z_fast, slow[k - 9], slow[k + 1])
            assert abs(z_fast - z_slow) < 5e-3
        assert abs(z_slow) <= 0.5


@pytest.mark.parametrize("sharpness", [0.7, 1.0, 2.0, 5.0, 20.0])
def test_sliders_add_up_to_the_law_s_stiffness_and_yield_force(sharpness):
    stiffness, force = np.array(as_sliders(300.0, 0.5, sharpness)).T
    assert force.sum() == pytest.approx(0.5)
    assert np.all(stiffness > 0)
    assert 0.6 * 300 < stiffness.sum() <= 300 * (1 + 1e-9)


def test_an_unmeasured_force_has_its_strength_and_its_band():
    force = ALL["unmeasured_force"]("floor1", 0.3, 4.0, 0.5)
    history = force.realisation(40000, 100.0, np.random.default_rng(1))
    assert history.std() == pytest.approx(0.3, rel=0.1)
    power = np.abs(np.fft.rfft(history)) ** 2
    frequency = np.fft.rfftfreq(len(history), 0.01)
    near = np.abs(frequency - 4.0) < 1.0
    assert power[near].sum() > 0.7 * power.sum()
    assert force.oscillator() == (4.0, 0.5, 0.3)


@pytest.mark.parametrize(("frequency", "bandwidth"), [(2.4, 0.9), (2.4, 0.02), (30.0, 20.0)])
def test_an_unmeasured_force_with_edges_has_all_its_power_between_them(frequency, bandwidth):
    force = ALL["unmeasured_force"]("floor1", 0.3, frequency, bandwidth, 1.0)
    A, b, c = force.shaping()
    P = solve_continuous_lyapunov(A, -np.outer(b, b))
    assert np.sqrt(c @ P @ c) == pytest.approx(0.3, rel=1e-9)
    low, high = frequency - bandwidth / 2, frequency + bandwidth / 2

    def density(f):
        return abs(c @ np.linalg.solve(2j * np.pi * f * np.eye(len(A)) - A, b)) ** 2

    top = density(np.sqrt(low * high))
    assert density(low) == pytest.approx(top / 2, rel=1e-6)
    assert density(high) == pytest.approx(top / 2, rel=1e-6)
    assert density(high + bandwidth) < 1e-2 * top
    history = force.realisation(4000, 20 * high, np.random.default_rng(1))
    assert history.std() == pytest.approx(0.3, rel=0.5)


def test_a_lab_s_own_mechanism_comes_by_its_entry_point(monkeypatch):
    class Own(ALL["cubic_stiffness"]):
        name = "own_spring"

    class Point:
        def load(self):
            return Own

    monkeypatch.setattr(mechanisms, "entry_points", lambda group: [Point()])
    mechanisms._found.cache_clear()
    try:
        assert mechanisms.vocabulary()["own_spring"] is Own
        assert mechanisms.places(Own, LUMPED.second_order(), {}) == ["storey1", "storey2"]
    finally:
        mechanisms._found.cache_clear()


@pytest.mark.parametrize("shape", [0.5, 0.1, -0.6875])
def test_a_loop_of_any_shape_follows_the_differential_equation_of_bouc_and_wen(shape):
    k, zy, n = 5e4, 31.25, 1.0
    law = ALL["hysteresis"]("storey1", k, zy, n, 0.0, shape)

    def slope(t, z):
        v = 6e-4 * 7 * np.cos(7 * t)
        return k * v * (1 - np.abs(z / zy) ** n * (shape + 0.5 * np.sign(v * z)))

    t = np.linspace(0, 4, 4001)
    true = solve_ivp(slope, (0, 4), [0.0], t_eval=t, rtol=1e-9, atol=1e-9, max_step=1e-3).y[0]
    drift, z = 6e-4 * np.sin(7 * t), [0.0]
    for before, after in pairwise(drift):
        z.append(float(law.remember([z[-1]], before, after)[0]))
    assert error(np.array(z), true) < 2e-3


def test_a_loop_without_a_plateau_is_a_straight_spring_in_mjcf():
    spec = mujoco.MjSpec.from_string(LUMPED.mjcf)
    ALL["hysteresis"]("storey1", 300.0, 0.5, 1.0, 100.0, -0.6).apply(spec)
    tendons = [t for t in spec.tendons if "hysteresis" in t.name]
    assert [t.stiffness[0] for t in tendons] == [pytest.approx(200.0)]
