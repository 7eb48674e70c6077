"""Diagnoses made by hand, from simulations of two known twins: no estimator takes part."""

from functools import lru_cache

import numpy as np

from twin.diagnosis.errors_of_runs import Errors, Fits
from twin.diagnosis.result import (
    Detection,
    Diagnosis,
    Finding,
    ForcePicture,
    NextExperiment,
    Trace,
)
from twin.mechanisms import vocabulary
from twin.model import Twin

RATE = 128.0
SAMPLES = 1024
OUTPUTS = ("acc_floor1", "acc_floor2")
HOSTILE = "<script>alert(1)</script> $x_1^{ [red] | & \udcff \u4e00.csv"
MECHANISMS = vocabulary()
CUBIC = MECHANISMS["cubic_stiffness"]("storey1", 6e5)
SLIP = MECHANISMS["hysteresis"]("storey1", 400.0, 2.0, 2.0, 400.0)


def shaken(twin: Twin, force: np.ndarray) -> tuple[np.ndarray, dict]:
    motion = twin.simulate({"force_floor1": force}, RATE, SAMPLES)
    return np.column_stack([motion.columns[name] for name in OUTPUTS]), motion.columns


def trace_of(name, role, level, seed, nominal, explained):
    rng = np.random.default_rng(seed)
    force = level * np.convolve(rng.standard_normal(SAMPLES + 7), np.ones(8) / 8, "valid")
    before, _ = shaken(nominal, force)
    after, columns = shaken(explained, force)
    noise = 0.01 * after.std(axis=0) * rng.standard_normal(after.shape)
    trace = Trace(
        name, role, RATE, ("force_floor1",), OUTPUTS, force[:, None], after + noise,
        1.1 * before, before, after, after + 0.3 * noise,
    )  # fmt: skip
    return trace, columns["disp_floor1"] - columns["disp_floor1"][0]


def nrmse(traces, name):
    error = sum(np.sum((getattr(t, name) - t.measured) ** 2) for t in traces)
    return float(np.sqrt(error / sum(np.sum(t.measured**2) for t in traces)))


def picture_of(drift, law):
    rate = np.gradient(drift, 1 / RATE)
    rng = np.random.default_rng(5)
    grid = np.linspace(drift.min(), drift.max(), 61)
    zero = np.zeros(())
    if not law.memory:
        latent, cycle = law.force(drift, rate, zero, zero), None
    else:
        memory, along = np.zeros(law.memory), []
        for last, now in zip(np.concatenate([[0.0], drift[:-1]]), drift, strict=True):
            memory = law.remember(memory, np.asarray(last), np.asarray(now))
            along.append(float(law.force(np.asarray(now), zero, memory.sum(), zero)))
        latent = np.array(along)
        cycle = np.column_stack([drift, latent])[256:384]
    shown = None if cycle is not None else law.force(grid, 0 * grid, zero, zero)
    noisy = latent + 0.1 * latent.std() * rng.standard_normal(len(latent))
    std = None if shown is None else 0.02 * np.abs(shown) + 0.02 * np.abs(shown).max()
    return ForcePicture("storey1", drift, rate, noisy, grid, shown, std, cycle)


@lru_cache(maxsize=2)
def diagnosis(law=CUBIC) -> Diagnosis:
    nominal = Twin.load("two_storey_lumped")
    explained = nominal.including(law)
    tests = (
        ("hard.csv", "train", 8.0, 1),
        ("soft.csv", "train", 2.0, 2),
        (HOSTILE, "test", 8.0, 3),
        ("hammer_9.csv", "test", 5.0, 4),
    )
    drawn = [trace_of(*test, nominal, explained) for test in tests]
    traces = tuple(trace for trace, _ in drawn)

    def errors(role):
        mine = [t for t in traces if t.role == role]
        return Errors(*(nrmse(mine, n) for n in ("nominal", "calibrated", "explained")), 0.0098)

    def ahead(e):
        return Errors(0.6 * e.nominal, 0.4 * e.calibrated, 0.99 * e.noise_floor, e.noise_floor)

    fit = Fits(errors("train"), errors("test"))
    other = MECHANISMS["bumper"]("storey1", 2e3, 0.004)
    strength = next(iter(law.values))
    detection = tuple(
        Detection(name, p, excess, (0.4, float("nan")), 1.95, np.array([[3.0, excess], [0.8, 1.2]]))
        for name, p, excess in (("acc_floor1", 0.0, 14.2), ("acc_floor2", 3e-9, 5.3))
    )
    return Diagnosis(
        verdict="missing_physics",
        findings=(Finding(law, {strength: 0.012 * law.values[strength]}, 0.93),),
        alternatives=(
            Finding(other, {"stiffness": 40.0, "gap": 2e-4}, 0.0699, -2.6),
            Finding(MECHANISMS["coulomb_friction"]("storey2", 0.1), {"force": 0.02}, 1e-9, -406.0),
        ),
        calibration=(Finding(MECHANISMS["mass"]("floor2", 0.0031), {"change": 0.0012}, 0.6),),
        fit=fit,
        fit_ahead=Fits(ahead(fit.train), ahead(fit.test)),
        where={
            "storey1": 1432.0, "storey2": 212.5, "ground": -0.4, "floor1": 640.0, "floor2": 31.0,
        },
        detection=detection,
        screening=(
            (law.name, "storey1", 1390.0), ("bumper", "storey1", 1100.0),
            ("quadratic_stiffness", "storey1", 400.0), ("coulomb_friction", "storey2", 90.0),
            ("sensor_gain", "acc_floor1", 14.0), ("sensor_swap", "acc_floor1+acc_floor2", -3.0),
        ),
        force=(picture_of(drawn[0][1], law),),
        traces=traces,
        nominal=nominal,
        calibrated=nominal,
        explained=explained,
        next_experiment=NextExperiment(
            (f"{law.name} at storey1", "bumper at storey1"),
            "twin test shaker --model two_storey_lumped --at floor1 --kind sweep --level 12",
            "Only the bumper leaves small drifts as they are.",
            41.3,
            (("sweep at floor1, level 12", 41.3), ("hammer at floor2", 6.0)),
        ),
        notes=(f"{HOSTILE} was resampled from 500 Hz to 128 Hz",),
        seconds=48.2,
        steps={"calibrate": 12.0, "screen": 9.5, "confirm": 26.7},
    )  # fmt: skip


def consistent() -> Diagnosis:
    """Nothing found: every optional part is empty."""
    full = diagnosis()
    same = Errors(0.02, 0.0101, 0.0101, 0.0098)
    return Diagnosis(
        "consistent", (), (), (), Fits(same, same), Fits(same, same), {}, (), (), (),
        full.traces, full.nominal, full.calibrated, full.calibrated,
    )  # fmt: skip
