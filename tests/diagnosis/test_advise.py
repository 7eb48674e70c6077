"""Where a lost stiffness ties with P-Delta, a mass bolted on tells them apart."""

from types import SimpleNamespace

import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin.diagnosis import judging
from twin.diagnosis.advise import next_experiment
from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.prepare import prepare
from twin.diagnosis.refining import refined
from twin.mechanisms import vocabulary

ALL = vocabulary()


def test_the_added_mass_is_the_test_that_separates_gravity_from_a_softer_spring():
    rig = lumped().including(ALL["stiffness"]("storey1", -80.0))
    records = [recorded(rig, seed, 0.6, 8.0) for seed in (1, 2)]
    bench = prepare(lumped(), records[:1], records[1:]).train
    base = base_hypothesis(bench.model)
    spring, weight = (
        refined(bench, [base.including(m)], 1e-3)
        for m in (ALL["stiffness"]("storey1", -70.0), ALL["p_delta"]("storey1", 1.1, 0.3))
    )
    assert abs(spring.bic - weight.bic) < 10
    advice = next_experiment(bench, spring, weight, "two_storey_lumped")
    assert advice is not None
    assert "--added-mass floor" in advice.command
    assert advice.expected_log_odds > 20
    plain = [gain for words, gain in advice.options if "added" not in words]
    assert np.all(np.array(plain) < 0.2 * advice.expected_log_odds)


@pytest.mark.parametrize("unnamed", [True, False])
def test_the_advice_is_on_a_tie_of_what_was_kept(monkeypatch, unnamed):
    def stage(*bics):
        return SimpleNamespace(fits=tuple(SimpleNamespace(bic=bic) for bic in bics))

    clear, tied, left_over = stage(-900.0, -100.0), stage(-500.0, -499.0), stage(-3.0, -2.9)
    monkeypatch.setattr(judging, "probability_over", lambda best, other: 0.99)
    monkeypatch.setattr(judging, "next_experiment", lambda *given: given[1:3])

    def advised(*stages, kept):
        best = SimpleNamespace(hypothesis=SimpleNamespace(found=("a finding",) * kept))
        named = best if unnamed else None
        found = SimpleNamespace(named=named, best=best, stages=stages, bench=None)
        return judging.advice(found, "two_storey_lumped", 0)

    assert advised(clear, tied, stage(), kept=2) == (None if unnamed else tied.fits)
    assert advised(clear, left_over, kept=1) is None
    assert advised(stage(), kept=0) is None
