"""Laws that are nearly in the vocabulary: integrated, drawn, and the share a name explains."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from experiments.concealed import case as cases
from experiments.concealed import near
from experiments.concealed.case import from_truth, generate, moved
from experiments.concealed.integrator import parts_of, simulate
from experiments.concealed.mechanisms import NEAR, NEAREST, Mechanism, build
from experiments.concealed.near_laws import SLIDERS
from experiments.concealed.nearest import Port, explained_share, port_of
from experiments.concealed.plans import FINE_HZ
from experiments.concealed.reference import reference
from experiments.concealed.rig import TWO_STOREY
from experiments.concealed.score import score
from experiments.concealed.seal import open_seal
from experiments.concealed.summary import numbers_of

SECONDS = 0.6
KNOTS = np.arange(0.0, 2.01, 1 / 64)
VALUES = np.random.default_rng(3).normal(size=(len(KNOTS), 2)) * [1.5, 1.0]
LAWS = {
    "stribeck_friction": {"breakaway": 0.2, "force": 0.12, "velocity": 0.004},
    "smooth_friction": {"force": 0.3, "velocity": 5e-5},
    "dahl_friction": {"stiffness": 2e4, "force": 0.3},
    "lugre_friction": {
        "stiffness": 1e4, "damping": 3.0, "force": 0.12, "breakaway": 0.2, "velocity": 0.004,
    },
    "damped_bumper": {"gap": -0.0015, "stiffness": 5000.0, "damping": 5.0},
    "hertz_bumper": {"gap": 0.001, "stiffness": 2e5},
    "power_spring": {"stiffness": 6e5, "exponent": 1.7},
    "iwan_slip": {"stiffness": 200.0, "yield_force": 0.3, "exponent": 2.0},
}  # fmt: skip
"""The stiffest that are drawn are less stiff."""

TOLERANCE = {
    "stribeck_friction": 5e-6, "smooth_friction": 2e-5, "dahl_friction": 1e-4,
    "damped_bumper": 5e-5, "hertz_bumper": 2e-5, "iwan_slip": 1e-4,
}  # fmt: skip
"""Relative error of the displacements; scipy's Stribeck friction is smoothed over 2e-6 m/s."""


def pull(t):
    return np.array([np.interp(t, KNOTS, VALUES[:, i]) for i in range(2)])


def written_again(name, p):
    """Return the force of (d, v, z) and dz/dt of (v, z)."""
    if name == "stribeck_friction":
        return lambda d, v, z: np.tanh(v / 2e-6) * steady(p, v), lambda v, z: 0 * z
    if name == "smooth_friction":
        return lambda d, v, z: p["force"] * np.tanh(v / p["velocity"]), lambda v, z: 0 * z
    if name == "dahl_friction":
        return lambda d, v, z: z[0], lambda v, z: p["stiffness"] * (v - abs(v) * z / p["force"])
    if name == "lugre_friction":
        rate = lambda v, z: v - abs(v) * p["stiffness"] * z / steady(p, v)  # noqa: E731
        return lambda d, v, z: p["stiffness"] * z[0] + p["damping"] * rate(v, z)[0], rate
    if name == "damped_bumper":
        depth = lambda d: max(p["gap"] - d, 0)  # noqa: E731
        return (
            lambda d, v, z: -p["stiffness"] * depth(d) * max(1 - p["damping"] * v, 0),
            lambda v, z: 0 * z,
        )
    if name == "hertz_bumper":
        return lambda d, v, z: p["stiffness"] * max(d - p["gap"], 0) ** 1.5, lambda v, z: 0 * z
    if name == "power_spring":
        return lambda d, v, z: p["stiffness"] * np.sign(d) * abs(d) ** 2.7, lambda v, z: 0 * z
    shares = ((np.arange(SLIDERS) + 0.5) / SLIDERS) ** p["exponent"]
    most = p["yield_force"] * shares / shares.sum()
    return (
        lambda d, v, z: z.sum() - p["stiffness"] * d,
        lambda v, z: p["stiffness"] / SLIDERS * v * ((np.abs(z) < most) | (z * v < 0)),
    )


def steady(p, v):
    return p["force"] + (p["breakaway"] - p["force"]) * np.exp(-((v / p["velocity"]) ** 2))


@pytest.mark.parametrize("name", LAWS)
def test_every_law_agrees_with_scipy_on_the_campaigns_grid(name):
    parameters = LAWS[name]
    system = build(TWO_STOREY, Mechanism(name, "storey2", tuple(parameters.items())))
    held, rate_of = written_again(name, parameters)
    apart = np.array([-1.0, 1.0])

    def rate(t, y):
        q, v, z = y[:2], y[2:4], y[4:]
        load = pull(t) - apart * held(apart @ q, apart @ v, z)
        a = (load - system.stiffness @ q - system.damping @ v) / system.mass
        return np.concatenate([v, a, rate_of(apart @ v, z)])

    truth = solve_ivp(
        rate, (0, SECONDS), np.zeros(4 + (SLIDERS if name == "iwan_slip" else 1)),
        method="DOP853" if name == "iwan_slip" else "LSODA", rtol=1e-9, atol=1e-12,
        t_eval=np.arange(0, SECONDS, 1 / 64), max_step=1 / 64,
    )  # fmt: skip
    times = np.arange(int(SECONDS * FINE_HZ) + 1) / FINE_HZ
    _, states = simulate(system, np.array([pull(t) for t in times]), 1 / FINE_HZ)
    found = states[: -1 : round(FINE_HZ / 64), :2]
    error = np.sqrt(np.sum((found - truth.y[:2].T) ** 2) / np.sum(truth.y[:2] ** 2))
    assert error < TOLERANCE.get(name, 1e-6)


def test_a_law_that_the_grid_cannot_follow_gets_parts_of_its_steps():
    stiff = build(
        TWO_STOREY, Mechanism("smooth_friction", "storey1", tuple(LAWS["smooth_friction"].items()))
    )
    rate = 0.3 / 5e-5 / TWO_STOREY.masses[0]
    assert parts_of(stiff, 1 / FINE_HZ) == np.ceil(2 * rate / FINE_HZ)
    assert parts_of(build(TWO_STOREY), 1.0) == 1


def test_friction_of_stribeck_holds_to_its_breakaway_and_slides_with_less():
    rub = Mechanism("stribeck_friction", "storey1", tuple(LAWS["stribeck_friction"].items()))
    system = build(TWO_STOREY, rub)
    forces = np.zeros((8192, 2))
    forces[:, 0] = np.linspace(0, 0.3, 8192)
    _, states = simulate(system, forces, 1 / FINE_HZ)
    first = np.flatnonzero(np.abs(states[:, 0]) > 1e-12)[0]
    assert forces[first, 0] == pytest.approx(0.2, abs=1e-3)


@pytest.mark.parametrize("name", ["stribeck_friction", "damped_bumper", "iwan_slip"])
def test_what_acted_at_the_port_is_the_law_on_the_true_motion(name):
    case = cases.draw_case(np.random.default_rng(4), "case", ((name, "storey2"),), "near")
    test = case.training[0]
    run = moved(case, test)
    port = port_of(case.rig, case.mechanism, [test], [run])
    held, _ = written_again(name, dict(case.mechanism.parameters))
    take = slice(0, None, 40)
    if name == "stribeck_friction":
        sliding = np.abs(port.rate) > 1e-4
        expected = np.array([held(0, v, 0) for v in port.rate[sliding][take]])
        assert port.force[sliding][take] == pytest.approx(expected, abs=1e-9)
        assert np.abs(port.force).max() <= case.mechanism["breakaway"] * (1 + 1e-6)
    elif name == "damped_bumper":
        side = np.sign(case.mechanism["gap"])
        assert np.all(side * port.force > -1e-9)
        assert np.all(np.abs(port.force[side * port.drift < 0]) < 1e-9)
    else:
        sliders = run[2][::4, 4:].sum(axis=1) - case.mechanism["stiffness"] * port.drift
        assert port.force == pytest.approx(sliders, abs=1e-9)


def test_a_name_explains_its_own_law_and_a_part_of_another():
    time = np.arange(8192) / 1024
    drift = 0.004 * np.sin(2 * np.pi * 2 * time) * np.exp(-time / 6)
    rate = np.gradient(drift, time)

    def share(name, force):
        return explained_share(Mechanism(name, "storey1"), Port(force, drift, rate, time == 0))

    assert share("smooth_friction", 0.1 * np.sign(rate)) == pytest.approx(1, abs=1e-3)
    assert share("hertz_bumper", -3e3 * np.maximum(-drift - 0.001, 0)) == pytest.approx(1, abs=2e-3)
    assert share("power_spring", 5e6 * drift**3) == pytest.approx(1, abs=1e-6)
    viscous = 2.0 * rate
    # least squares of c v on sign(v) leaves sqrt(1 - mean(|v|)^2 / mean(v^2)) of it
    left = np.sqrt(1 - np.mean(np.abs(rate)) ** 2 / np.mean(rate**2))
    assert share("smooth_friction", viscous) == pytest.approx(1 - left, abs=0.01)


def test_slip_explains_the_loop_of_bouc_and_wen():
    case = cases.draw_case(np.random.default_rng(4), "case", (("hysteresis", "storey2"),))
    test = case.training[0]
    port = port_of(case.rig, case.mechanism, [test], [moved(case, test)])
    assert explained_share(Mechanism("iwan_slip", "storey2"), port) > 0.97


def test_a_case_says_what_its_nearest_name_explains(tmp_path, monkeypatch):
    draw = cases.draw_plan
    monkeypatch.setattr(
        cases, "draw_plan", lambda *a: tuple(replace(t, duration_s=8.0) for t in draw(*a))
    )
    digest = generate(3, 2, tmp_path, tmp_path / "sealed", table="near")
    truth = open_seal(tmp_path / "sealed" / "near_0003.json", digest)
    assert truth["mechanism"] in NEAR
    assert truth["expected"] == "missing_physics"
    assert near.NEARLY < truth["evidence"]["explained"] < 1
    assert from_truth(truth).truth(3, 2) == truth


@pytest.mark.parametrize("name", ["lugre_friction", "iwan_slip"])
def test_the_true_model_reaches_the_noise_with_what_its_laws_keep(tmp_path, monkeypatch, name):
    draw = cases.draw_plan
    monkeypatch.setattr(
        cases, "draw_plan", lambda *a: tuple(replace(t, duration_s=6.0) for t in draw(*a))
    )
    monkeypatch.setattr(cases, "combination_of", lambda *a: ((name, "storey1"),))
    digest = generate(1, 5, tmp_path, tmp_path / "sealed", table="near")
    truth = open_seal(tmp_path / "sealed" / "near_0001.json", digest)
    assert reference(truth, tmp_path)["fit_ahead"] < 3 * truth["noise"]


def test_every_near_law_has_a_nearest_name():
    assert set(NEAREST) == set(NEAR) == set(LAWS)


TRUTH = {
    "table": "near", "mechanism": "dahl_friction", "location": "storey2", "parameters": {},
    "effects": [{"mechanism": "dahl_friction", "location": "storey2", "parameters": {}}],
    "expected": "missing_physics", "evidence": {"explained": 0.8},
}  # fmt: skip


def said(verdict, *pairs, explained=0.75):
    findings = [
        {
            "mechanism": m,
            "location": p,
            "parameters": {},
            "probability": 0.9,
            "explained": explained,
        }
        for m, p in pairs
    ]
    return score(TRUTH, {"verdict": verdict, "findings": findings, "alternatives": []}, {})


def test_the_nearest_name_or_unexplained_there_is_right():
    friction, generic = ("coulomb_friction", "storey2"), ("restoring_force", "storey2")
    right = said("missing_physics", friction)
    assert (right["right"], right["besides"], right["stated"]) == (True, 0, [[0.9, True]])
    assert right["share_error"] == pytest.approx(0.05)
    assert said("unexplained", generic)["right"]
    later = said("unexplained", ("mass", "floor1"), generic)
    assert (later["right"], later["first_right"], later["besides"]) == (True, False, 1)
    assert not said("missing_physics", generic)["right"]
    assert not said("missing_physics", ("coulomb_friction", "storey1"))["right"]
    assert not said("missing_physics", ("damping", "storey2"), friction)["right"]
    assert said("missing_physics", friction, ("damping", "storey1"))["besides"] == 1


def test_the_summary_counts_companions_and_shares():
    friction = ("coulomb_friction", "storey2")
    scores = [
        said("missing_physics", friction), said("missing_physics", friction, ("mass", "floor1")),
        said("missing_physics", friction, explained=0.6),
        said("missing_physics", friction, explained=None),
    ]  # fmt: skip
    found = numbers_of(scores)
    assert (found["spurious"]["count"], found["spurious"]["of"]) == (1, 4)
    assert (found["share_near"]["count"], found["share_near"]["of"]) == (2, 3)
