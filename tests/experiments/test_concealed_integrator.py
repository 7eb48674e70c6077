"""The concealed cases' integrator against scipy at tight tolerance, one law after the other."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from experiments.concealed.integrator import simulate
from experiments.concealed.mechanisms import Mechanism, build, places
from experiments.concealed.plans import FINE_HZ
from experiments.concealed.rig import TWO_STOREY

SECONDS = 1.5
KNOTS = np.arange(0.0, 3.01, 1 / 64)
VALUES = np.random.default_rng(3).normal(size=(len(KNOTS), 2)) * [1.5, 1.0]


def pull(t):
    return np.array([np.interp(t, KNOTS, VALUES[:, i]) for i in range(2)])


LAWS = {
    "none": ("", {}, ""),
    "stiffness": ("storey2", {"change": -80.0}, ""),
    "damping": ("storey1", {"change": 2.0}, ""),
    "mass": ("floor2", {"change": 0.2}, ""),
    "coulomb_friction": ("storey2", {"force": 0.15}, ""),
    "cubic_stiffness": ("storey1", {"stiffness": 4e6}, ""),
    "quadratic_stiffness": ("storey2", {"stiffness": -1.5e4}, ""),
    "bumper": ("storey2", {"gap": -0.0015, "stiffness": 5000.0}, ""),
    "clearance": ("storey1", {"gap": 0.0015, "stiffness": 250.0}, ""),
    "hysteresis": ("storey1", {"stiffness": 200.0, "yield_force": 0.3}, "bouc_wen_1"),
    "stiffness_drift": ("storey2", {"rate": 0.03}, ""),
    "quadratic_drag": ("floor1", {"coefficient": 4.0}, ""),
    "appendage": ("floor1", {"mass": 0.05, "frequency": 5.0, "damping_ratio": 0.02}, ""),
    "base_compliance": ("ground", {"stiffness": 2e4, "damping": 8.0}, ""),
}
_OPENING = {"opening": 0.7, "period": 0.8, "phase": 0.4}
LAWS |= {
    "tanh_spring": ("storey1", {"stiffness": 400.0, "width": 0.001}, ""),
    "sine_spring": ("storey2", {"stiffness": 300.0, "width": 0.0008}, ""),
    "exponential_spring": ("storey2", {"stiffness": 60.0, "width": -0.002}, ""),
    "magnet": ("storey1", {"force": -0.2, "gap": 0.006, "exponent": 3.0}, ""),
    "breathing_gap": ("storey2", {"gap": 0.0015, "stiffness": 250.0, **_OPENING}, ""),
    "moving_stop": ("storey1", {"gap": 0.002, "stiffness": 4000.0, **_OPENING}, ""),
}
CASES = [(name, *entry) for name, entry in LAWS.items()]
CASES += [
    ("hysteresis", "storey2", LAWS["hysteresis"][1], form) for form in ("bouc_wen_2", "jenkins")
]
TOLERANCE = {
    "coulomb_friction": 3e-4, "hysteresis": 1e-4, "bumper": 3e-4, "clearance": 2e-5,
    "moving_stop": 3e-4, "breathing_gap": 2e-5,
}  # fmt: skip
"""Relative; scipy's dry friction is smoothed over 2e-6 m/s, its slider over 1e-4 of its force."""


def law(name, p, form):
    """Return what pulls the upper floor back, of (t, drift, rate, z), and dz/dt."""
    if name == "coulomb_friction":
        return lambda t, d, v, z: p["force"] * np.tanh(v / 2e-6), None
    if name == "cubic_stiffness":
        return lambda t, d, v, z: p["stiffness"] * d**3, None
    if name == "quadratic_stiffness":
        return lambda t, d, v, z: p["stiffness"] * d**2, None
    if name == "bumper":
        return lambda t, d, v, z: p["stiffness"] * min(d - p["gap"], 0), None
    if name == "clearance":
        gap, ks = p["gap"], p["stiffness"]
        return lambda t, d, v, z: -ks * d + ks * np.sign(d) * max(abs(d) - gap, 0), None
    if name == "hysteresis":
        ks, zy = p["stiffness"], p["yield_force"]
        power = {"bouc_wen_1": 1, "bouc_wen_2": 2, "jenkins": 400}[form]
        return (
            lambda t, d, v, z: z - ks * d,
            lambda v, z: (
                ks * v * (1 - min(abs(z / zy), 1.01) ** power * (0.5 + 0.5 * np.sign(v * z)))
            ),
        )
    if name == "stiffness_drift":
        return lambda t, d, v, z: TWO_STOREY.stiffnesses[1] * p["rate"] * t * d, None
    if name == "quadratic_drag":
        return lambda t, d, v, z: p["coefficient"] * v * abs(v), None
    if name in ("breathing_gap", "moving_stop"):
        return lambda t, d, v, z: with_gap(name, p, t, d), None
    if name == "magnet":
        c, g, power = p["force"], p["gap"], p["exponent"]
        return lambda t, d, v, z: -c * (1 / (1 - d / g) ** power - 1 - power * d / g), None
    if name.endswith("_spring"):
        shape = {"tanh": np.tanh, "sine": np.sin, "exponential": lambda x: np.exp(x) - 1 - x}
        curve = shape[name.removesuffix("_spring")]
        return lambda t, d, v, z: p["stiffness"] * p["width"] * curve(d / p["width"]), None
    return lambda t, d, v, z: 0.0, None


def with_gap(name, p, t, d):
    """Return the force of a play or a stop whose gap opens and closes."""
    gap = p["gap"] * (1 + p["opening"] * np.sin(2 * np.pi * t / p["period"] + p["phase"]))
    beyond = max(abs(d) - gap, 0.0) * np.sign(d)
    return p["stiffness"] * (max(beyond, 0.0) if name == "moving_stop" else beyond - d)


@pytest.mark.parametrize(("name", "place", "parameters", "form"), CASES)
def test_every_law_agrees_with_scipy(name, place, parameters, form):
    mechanism = Mechanism(name, place, tuple(parameters.items()), form)
    system = build(TWO_STOREY, mechanism)
    n = len(system.mass)
    held, slip = law(name, parameters, form)
    direction = np.zeros(n)
    if place.startswith("storey") or name == "quadratic_drag":
        direction[mechanism.index] = 1.0
        if place == "storey2":
            direction[0] = -1.0

    def rate(t, y):
        q, v, z = y[:n], y[n : 2 * n], y[2 * n]
        d, dv = direction @ q, direction @ v
        load = np.append(pull(t), np.zeros(n - 2)) - direction * held(t, d, dv, z)
        a = (load - system.stiffness @ q - system.damping @ v) / system.mass
        return np.concatenate([v, a, [slip(dv, z) if slip else 0.0]])

    steps = int(SECONDS * FINE_HZ)
    times = np.arange(steps + 1) / FINE_HZ
    _, states = simulate(system, np.array([pull(t) for t in times]), 1 / FINE_HZ)
    stiff = name == "coulomb_friction" or form == "jenkins"
    truth = solve_ivp(
        rate, (0, SECONDS), np.zeros(2 * n + 1), method="LSODA" if stiff else "DOP853",
        rtol=1e-9, atol=1e-12, t_eval=times[::64], max_step=1 / 64,
    )  # fmt: skip
    difference = states[::64, :2] - truth.y[:2].T
    error = np.sqrt(np.sum(difference**2) / np.sum(truth.y[:2] ** 2))
    assert error < TOLERANCE.get(name, 1e-6)


SECOND_LAWS = {
    "cubic_stiffness": ("storey1", {"stiffness": 4e6}, ""),
    "hysteresis": ("storey1", {"stiffness": 200.0, "yield_force": 0.3}, "bouc_wen_1"),
    "bumper": ("storey2", {"gap": -0.0015, "stiffness": 5000.0}, ""),
    "mass": ("floor2", {"change": 0.2}, ""),
    "base_compliance": ("ground", {"stiffness": 2e4, "damping": 8.0}, ""),
}


@pytest.mark.parametrize("name", SECOND_LAWS)
def test_two_effects_at_once_agree_with_scipy(name):
    place, parameters, form = SECOND_LAWS[name]
    other = Mechanism(name, place, tuple(parameters.items()), form)
    rub = Mechanism("coulomb_friction", "storey1", (("force", 0.1),))
    system = build(TWO_STOREY, other, rub)
    n = len(system.mass)
    held, slip = law(name, parameters, form)
    at = np.eye(n)[other.index] - (np.eye(n)[0] if place == "storey2" else 0)
    rubs = np.eye(n)[0] - (np.eye(n)[2] if name == "base_compliance" else 0)

    def rate(t, y):
        q, v, z = y[:n], y[n : 2 * n], y[2 * n]
        load = np.append(pull(t), np.zeros(n - 2)) - at * held(t, at @ q, at @ v, z)
        load -= rubs * 0.1 * np.tanh(rubs @ v / 2e-6)
        a = (load - system.stiffness @ q - system.damping @ v) / system.mass
        return np.concatenate([v, a, [slip(at @ v, z) if slip else 0.0]])

    assert_agrees(system, rate, 1e-3)


def test_another_axis_that_the_drift_drives_agrees_with_scipy():
    parameters = {"mass": 0.1, "frequency": 4.1, "damping_ratio": 0.01, "coupling": 4000.0}
    system = build(TWO_STOREY, Mechanism("cross_axis", "storey2", tuple(parameters.items())))
    apart = np.array([-1.0, 1.0, 0.0])

    def rate(t, y):
        q, v = y[:3], y[3:6]
        d = apart @ q
        load = np.append(pull(t), 4000.0 * d**2) + 2 * 4000.0 * d * q[2] * apart
        a = (load - system.stiffness @ q - system.damping @ v) / system.mass
        return np.concatenate([v, a, [0.0]])

    aside = assert_agrees(system, rate, 1e-6)
    assert np.abs(aside[:, 2]).max() > 1e-5


def assert_agrees(system, rate, tolerance):
    """Integrate both ways, compare the floors' displacements, and return the states."""
    times = np.arange(int(SECONDS * FINE_HZ) + 1) / FINE_HZ
    _, states = simulate(system, np.array([pull(t) for t in times]), 1 / FINE_HZ)
    start = np.zeros(2 * len(system.mass) + 1)
    truth = solve_ivp(
        rate, (0, SECONDS), start, method="LSODA", rtol=1e-9, atol=1e-12, t_eval=times[::64],
        max_step=1 / 64,
    )  # fmt: skip
    difference = states[::64, :2] - truth.y[:2].T
    error = np.sqrt(np.sum(difference**2) / np.sum(truth.y[:2] ** 2))
    assert error < tolerance
    return states


def test_a_stuck_storey_stays_stuck_and_slips_when_the_force_is_too_large():
    system = build(TWO_STOREY, Mechanism("coulomb_friction", "storey2", (("force", 2.0),)))
    forces = np.zeros((4096, 2))
    forces[:, 1] = np.linspace(0, 4.0, 4096)
    _, states = simulate(system, forces, 1 / FINE_HZ)
    drift = states[:, 1] - states[:, 0]
    slipping = np.flatnonzero(np.abs(drift) > 1e-12)[0]
    assert 1500 < slipping < 4096
    assert abs(drift[-1]) > 1e-5


def test_a_two_storey_frame_has_41_places():
    pairs = places(2)
    assert len(pairs) == len(set(pairs)) == 41
    assert ("sensor_swap", "acc_floor1+acc_floor2") in pairs
