"""Where a lost stiffness ties with P-Delta, a mass bolted on tells them apart."""

import numpy as np
from diagnosis_support import lumped, recorded

from twin.diagnosis.advise import next_experiment
from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.prepare import prepare
from twin.diagnosis.refining import refined
from twin.physics import mechanisms

ALL = mechanisms()


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
