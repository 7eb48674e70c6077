"""Is the evidence right, and are probabilities made of it? Simulation-based calibration.

    python experiments/evidence_calibration.py [--draws N] [--weights N] [--workers N]

A mechanism, its place, its parameters, the twin's and the noise levels are drawn from the priors of
the diagnosis (Talts et al. 2018), a recording of 1,500 samples is simulated with the very model,
and every candidate is fitted. Two figures come out: how far Laplace's evidence is from importance
sampling about the optimum, and whether of the diagnoses stated at 80 % four in five are right.
Writes experiments/results/evidence_calibration.json.
"""

from __future__ import annotations

import argparse
import json
import sys
import warnings
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from twin.diagnosis.beginning import added, moved_to, start_of  # noqa: E402
from twin.diagnosis.candidates import Candidate, priors_of, scales_of, surroundings  # noqa: E402
from twin.diagnosis.hypothesis import Hypothesis  # noqa: E402
from twin.diagnosis.measured import Measured  # noqa: E402
from twin.diagnosis.motion import Motion  # noqa: E402
from twin.diagnosis.problem import Problem  # noqa: E402
from twin.estimation.fit import Fit, fit  # noqa: E402
from twin.estimation.kalman import gains, open_loop  # noqa: E402
from twin.estimation.likelihood import evaluate  # noqa: E402
from twin.estimation.model import Trial  # noqa: E402
from twin.estimation.passing import run  # noqa: E402
from twin.estimation.system import sampled  # noqa: E402
from twin.mechanisms import vocabulary  # noqa: E402
from twin.model import Twin  # noqa: E402

SAMPLES, RATE_HZ, NOISE = 1500, 256.0, 0.02
"""Of each recording; noise as a share of each channel's RMS value."""

OFFERED = (
    ("cubic_stiffness", "storey1"), ("cubic_stiffness", "storey2"),
    ("coulomb_friction", "storey1"), ("coulomb_friction", "storey2"),
    ("quadratic_drag", "floor1"), ("quadratic_drag", "floor2"),
)  # fmt: skip
"""Mechanisms and places that are drawn and diagnosed, beside nothing at all."""

BEYOND = 100.0
"""Times the nominal RMS value that nobody could record: a frame that buckles is drawn again."""

WIDER = 1.15
"""Width of the sampling density, in deviations of Laplace's: its tails cover the posterior's."""

BINS = (0.0, 0.6, 0.9, 0.99, 1.0)
"""Of stated probabilities."""


def nominal(seed: int) -> tuple[Problem, Motion]:
    """Return the two-storey frame under a random force, and its motion without any fault."""
    rng = np.random.default_rng(seed)
    model = Twin.load("two_storey_lumped").linear(("force_floor2",), ("acc_floor1", "acc_floor2"))
    spectrum = np.fft.rfft(rng.normal(size=SAMPLES))
    spectrum[np.fft.rfftfreq(SAMPLES, 1 / RATE_HZ) > 25] = 0
    u = np.fft.irfft(spectrum, SAMPLES)[:, None]
    levels = np.ones(2), NOISE * np.sqrt(np.mean(u**2, axis=0))
    first = Measured("recording", u, np.zeros((SAMPLES, 2)), levels[1], levels[0])
    n = len(model.coordinates)
    blank = Problem(model, (first,), RATE_HZ, 0.01, 0.3, ("linear",), np.ones((1, n)))
    h = Hypothesis(blank)
    here = h.assemble(np.zeros(len(h.unknowns)))
    plant = sampled(here.systems[0], 1 / RATE_HZ, here.steps, here.held)
    passed = run(here, here.trials[0], plant, open_loop(gains(plant, here.noises[0])))
    q, v = passed.x[:, :n], passed.x[:, n : 2 * n]
    output = NOISE * np.sqrt(np.mean(passed.e**2, axis=0))
    recording = replace(first, output_noise=output)
    problem = replace(blank, recordings=(recording,), scale=np.sqrt(np.mean(q**2, axis=0))[None])
    return problem, Motion(q, v, np.gradient(v, 1 / RATE_HZ, axis=0))


def candidates(problem: Problem, motion: Motion) -> list[Candidate]:
    out = []
    for name, place in OFFERED:
        starts = tuple(vocabulary()[name].starts(place, surroundings(problem, [motion], place)))
        out.append(Candidate(starts, priors_of(starts)))
    return out


def simulated(hypothesis: Hypothesis, z: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Return outputs drawn from a hypothesis at values z of its unknowns, (samples, m)."""
    here = hypothesis.assemble(z)
    system, noise, trial = here.systems[0], here.noises[0], here.trials[0]
    held = rng.normal(size=(len(trial.y), len(noise.held))) * noise.held
    values = {u.name: u.value(float(x)) for u, x in zip(hypothesis.unknowns, z, strict=True)}
    latent = np.zeros((len(trial.y), len(hypothesis.ports)))
    for j, port in enumerate(hypothesis.ports):
        kept = np.exp(-2 * np.pi * values[f"discrepancy {port} frequency"] * trial.step_s)
        level = values[f"discrepancy {port}"]
        latent[0, j] = level * rng.normal()
        for k in range(1, len(latent)):
            latent[k, j] = kept * latent[k - 1, j]
            latent[k, j] += level * np.sqrt(1 - kept**2) * rng.normal()
    E, F = system.E[:, : latent.shape[1]], system.F[:, : latent.shape[1]]
    driven = replace(system, B=np.hstack([system.B, system.W, E]),
                     D=np.hstack([system.D, system.V, F]))  # fmt: skip
    all_held = np.concatenate([here.held, np.ones(held.shape[1], bool), np.zeros(len(E.T), bool)])
    plant = sampled(driven, trial.step_s, 4 * here.steps, all_held)
    before = np.linalg.cholesky(noise.start + 1e-30 * np.eye(len(system.A))) @ rng.normal(
        size=len(system.A)
    )
    before[2 * len(hypothesis.problem.model.coordinates) :] = 0.0  # the latent force is an input
    u = np.hstack([trial.u, held, latent])
    gain = open_loop(gains(sampled(system, trial.step_s, 1, here.held), noise))
    passed = run(replace(here, systems=(driven,), held=all_held),
                 Trial(u, u, np.zeros_like(trial.y), trial.step_s), plant, gain,
                 x0=before)  # fmt: skip
    return -passed.e + noise.output * rng.normal(size=passed.e.shape)


def fitted(nothing: Hypothesis, blank: Fit, candidate: Candidate, scales) -> Fit | None:
    """Return the candidate's fit from that of its first guesses that is likeliest."""
    h = replace(nothing, scales=scales)
    best: tuple[float, Hypothesis, np.ndarray] | None = None
    for start in candidate.starts:
        for strength in (1.0, 0.1, 10.0):
            grown = added(h, candidate, start.scaled(strength))
            z = moved_to(grown, nothing, blank.z, start.scaled(strength))
            z = z + start_of(grown)
            try:
                value = evaluate(grown, z, derivatives=False).log_likelihood
            except np.linalg.LinAlgError:
                continue
            if best is None or value > best[0]:
                best = value, grown, z
    if best is None:
        return None
    try:
        return fit(best[1], best[2], most=40)
    except np.linalg.LinAlgError:
        return None


def by_sampling(found: Fit, weights: int, rng: np.random.Generator) -> tuple[float, float]:
    """Return the log evidence by importance sampling, and the effective number of samples."""
    root = WIDER * np.linalg.cholesky(found.covariance)
    p = len(found.z)
    logs = np.full(weights, -np.inf)
    for k in range(weights):
        x = rng.normal(size=p)
        z = found.z + root @ x
        try:
            value = evaluate(found.model, z, derivatives=False).log_likelihood
        except np.linalg.LinAlgError:
            continue
        density = -0.5 * x @ x - np.sum(np.log(np.diag(root)))
        logs[k] = value - 0.5 * z @ z - density
    top = np.max(logs)
    w = np.exp(logs - top)
    # the factors of 2 pi of prior and density cancel, as in Laplace's formula
    return float(top + np.log(np.mean(w))), float(np.sum(w) ** 2 / np.sum(w**2))


def drawn(seed: int, weights: int) -> dict:
    """Return one draw: what it was, what was stated, and both evidences of the two finalists."""
    rng = np.random.default_rng([19, seed])
    problem, motion = nominal(seed)
    offered = candidates(problem, motion)
    scales = scales_of(problem, [motion])
    nothing = Hypothesis(problem, scales=scales)
    which = int(rng.integers(len(offered) + 1))
    truth = nothing
    if which < len(offered):
        truth = added(nothing, offered[which], offered[which].starts[0])
    y = np.full((SAMPLES, 2), np.inf)
    while not np.all(np.abs(y) < BEYOND * problem.recordings[0].output_noise / NOISE):
        y = simulated(truth, rng.normal(size=len(truth.unknowns)), rng)
    problem = replace(problem, recordings=(replace(problem.recordings[0], y=y),))
    nothing = Hypothesis(problem, scales=scales)
    blank = fit(nothing, start_of(nothing), most=40)
    fits = [fitted(nothing, blank, c, scales) for c in offered] + [blank]
    evidence = np.array([-np.inf if f is None else f.log_evidence for f in fits])
    stated = np.exp(evidence - np.max(evidence))
    stated /= np.sum(stated)
    names = [" ".join(label) for label in OFFERED] + ["nothing"]
    first, second = np.argsort(-evidence)[:2]
    finalists = []
    for index in (first, second):
        found = fits[index]
        if found is not None:
            value, effective = by_sampling(found, weights, rng)
            finalists.append({"name": names[index], "code": found.code, "effective": effective,
                              "laplace_less_sampling": found.log_evidence - value})  # fmt: skip
    return {"truth": names[which], "stated": names[first], "probability": float(stated[first]),
            "of_the_truth": float(stated[which]), "finalists": finalists}  # fmt: skip


def table(draws: list[dict], weights: int) -> dict:
    """Return the two figures as numbers."""
    every = [f for d in draws for f in d["finalists"]]
    # a sampled evidence of few effective samples is no reference
    told = [f for f in every if f["effective"] >= 0.1 * weights]
    gaps = np.abs([f["laplace_less_sampling"] for f in told])
    p = np.array([d["probability"] for d in draws])
    right = np.array([d["truth"] == d["stated"] for d in draws], float)
    rows, error = [], 0.0
    for low, high in pairwise(BINS):
        inside = (p > low) & (p <= high)
        if inside.any():
            rows.append({"from": low, "to": high, "draws": int(inside.sum()),
                         "stated": float(p[inside].mean()),
                         "right": float(right[inside].mean())})  # fmt: skip
            error += inside.mean() * abs(p[inside].mean() - right[inside].mean())
    out = {
        "draws": len(draws), "finalists": len(every), "sampled_well": len(told),
        "within_half_a_nat": float(np.mean(gaps <= 0.5)) if len(gaps) else None,
        "median_gap_nat": float(np.median(gaps)) if len(gaps) else None,
        "largest_gap_nat": float(np.max(gaps)) if len(gaps) else None,
        "expected_calibration_error": float(error), "right": float(right.mean()), "bins": rows,
    }  # fmt: skip
    return out


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--draws", type=int, default=40)
    parser.add_argument("--weights", type=int, default=200)
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    draws: list[dict] = []
    with ProcessPoolExecutor(given.workers) as pool:
        for done in as_completed([pool.submit(quietly, s, given.weights)
                                  for s in range(given.draws)]):  # fmt: skip
            draws.append(done.result())
            last = draws[-1]
            gaps = ", ".join(f"{f['laplace_less_sampling']:+.2f}" for f in last["finalists"])
            print(f"{last['seed']}: {last['truth']}; stated {last['stated']} at "
                  f"{last['probability']:.3f}; Laplace less sampling {gaps} nat",
                  flush=True)  # fmt: skip
            draws.sort(key=lambda d: d["seed"])
            result = {"weights": given.weights, "summary": table(draws, given.weights)}
            path = ROOT / "experiments" / "results" / "evidence_calibration.json"
            path.write_text(json.dumps(result | {"each": draws}, indent=1) + "\n")
    print(json.dumps(result["summary"], indent=1))


def quietly(seed: int, weights: int) -> dict:
    """Return one draw; a step of a fit that leads nowhere warns, and is not taken."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return {"seed": seed} | drawn(seed, weights)


if __name__ == "__main__":
    main()
