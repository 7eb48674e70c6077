"""The motion behind recordings that say nothing of part of it."""

from dataclasses import replace

import numpy as np
from diagnosis_support import TWO, error, exact_trial

from twin import mechanisms
from twin.diagnosis.base import base_hypothesis
from twin.diagnosis.bench import Bench
from twin.diagnosis.fitting import fit
from twin.diagnosis.motion import states

ALL = mechanisms.vocabulary()


def test_a_cut_off_channel_says_nothing_of_the_motion_beyond():
    whole = exact_trial(seed=1, noise=1e-3)
    level = 0.5 * float(np.std(whole.y[:, 1]))
    cut = replace(whole, y=np.column_stack([whole.y[:, 0], np.clip(whole.y[:, 1], -level, level)]))
    base = base_hypothesis(TWO)
    sound = fit(Bench(TWO, (whole,)), base, 1e-2, iterations=0)
    (true,) = states(Bench(TWO, (whole,)), sound)
    bench = Bench(TWO, (cut,))
    off = []
    for faults in ((), (ALL["sensor_clipping"]("acc_floor2", level),)):
        hypothesis = base.including(*faults) if faults else base
        found = fit(bench, hypothesis, 1e-2, iterations=0)
        off.append(error(states(bench, found)[0], true))
    assert off[0] > 0.2
    assert off[1] < 0.1 * off[0]
