"""The concealed cases' integrator against scipy at tight tolerance, one law after the other."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

pytest.importorskip("experiments.concealed", reason="experiments/ is not beside the tests")
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
CASES = [(name, *entry) for name, entry in LAWS.items()]
CASES += [
    ("hysteresis", "storey2", LAWS["hysteresis"][1], form) for form in ("bouc_wen_2", "jenkins")
]
TOLERANCE = {"coulomb_friction": 3e-4, "hysteresis": 1e-4, "bumper": 3e-4, "clearance": 2e-5}
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
    return lambda t, d, v, z: 0.0, None


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
