"""What is offered: at a slide that no spring holds, and of instruments what has a model."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_support import rng, tones
from shaken_support import chain, ground, shaken

from twin.diagnosis.beginning import added, moved_to
from twin.diagnosis.candidates import motions, scales_of
from twin.diagnosis.hypothesis import Hypothesis
from twin.diagnosis.offer import offer
from twin.diagnosis.prepare import prepare
from twin.estimation.likelihood import passes
from twin.mechanisms.mechanism import ChannelFault
from twin.mechanisms.stiffness import Stiffness
from twin.model import Twin
from twin.recording import Recording

RATE = 100.0


def pushed(twin, seed):
    force = tones(2048, RATE, seed, 20.0)
    fine = np.interp(np.arange(2048 * 10) / 10, np.arange(2048), force)
    moved = twin.simulate({"force": fine}, 10 * RATE, len(fine)).columns["position"][::10]
    columns = {"force": force, "position": moved + 1e-6 * rng(seed).standard_normal(2048)}
    units = {"force": "force [N]", "position": "position [m]"}
    return Recording.build(RATE, {units[n]: x for n, x in columns.items()}, f"push{seed}.csv")


def offered(twin):
    problem = prepare(twin, [pushed(twin, 1)], [pushed(twin, 2)], 1.0, 1.0).train
    blank = Hypothesis(problem)
    z = np.zeros(len(blank.unknowns))
    found = offer(problem, {"force": "force", "position": "disp"})
    return {c.label for c in found(motions(problem, blank, z), passes(blank, z))}


@pytest.mark.parametrize("name", ["hysteresis", "clearance"])
def test_a_spring_slips_or_has_play_only_where_one_is(name):
    slide = Twin.load("drive")
    assert (name, "slide") not in offered(slide)
    assert (name, "slide") in offered(slide.including(Stiffness("slide", 5e3)))


def test_dry_friction_of_a_slide_is_offered_once():
    rubbing = [label for label in offered(Twin.load("drive")) if "friction" in label[0]]
    assert rubbing == [("coulomb_friction", "slide")]


def test_every_instrument_that_is_offered_has_a_model_on_a_shaken_structure_too():
    masses, stiffnesses = np.array([1.0, 1.0]), np.array([400.0, 300.0])
    waves = [ground(8.0, RATE, seed, 1.0) for seed in (1, 2)]
    read = [shaken(masses, stiffnesses, [0.3, 0.3], wave, RATE, f"shaken{i}.csv")
            for i, wave in enumerate(waves)]  # fmt: skip
    ready = prepare(chain(masses, stiffnesses), read[:1], read[1:])
    problem = ready.train
    blank = Hypothesis(problem)
    z = np.zeros(len(blank.unknowns))
    moved = motions(problem, blank, z)
    here = replace(blank, scales=scales_of(problem, moved))
    found = offer(problem, ready.kinds)(moved, passes(blank, z))
    assert ("sensor_crosstalk", "acc_floor1+acc_floor2") in {c.label for c in found}
    for candidate in found:
        if isinstance(candidate.starts[0], ChannelFault):
            grown = added(here, candidate, candidate.starts[0])
            assert grown.assemble(moved_to(grown, here, z, candidate.starts[0]))
