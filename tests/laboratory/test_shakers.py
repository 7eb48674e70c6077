import numpy as np
import pytest

from twin.errors import ExperimentError
from twin.laboratory.analyser import Analyser
from twin.laboratory.multisine import Multisine
from twin.laboratory.random_shaking import RandomShaking
from twin.laboratory.sweep import Sweep


def rng(seed=0):
    return np.random.default_rng(seed)


def rms(x):
    return np.sqrt(np.mean(x**2))


def share_outside(x, rate_hz, low, high):
    power = np.abs(np.fft.rfft(x * np.hanning(len(x)))) ** 2
    frequency = np.fft.rfftfreq(len(x), 1 / rate_hz)
    return power[(frequency < low) | (frequency > high)].sum() / power.sum()


def test_random_shaking_has_the_level_and_the_band_asked_for():
    base = Analyser().time_base()
    force = RandomShaking(rms_n=2.5, band_hz=(1.0, 10.0)).history(base, rng())
    running = force[base.running()]
    assert rms(running) == pytest.approx(2.5, rel=1e-3)
    assert share_outside(running, base.rate_hz, 0.9, 10.1) < 1e-6
    assert 3 < np.abs(running).max() / 2.5 < 5  # the crest of Gaussian noise


def test_random_shaking_is_flat_in_its_band():
    base = Analyser(duration_s=2000.0).time_base()
    force = RandomShaking(band_hz=(2.0, 10.0)).history(base, rng())[base.running()]
    power = np.abs(np.fft.rfft(force)) ** 2
    frequency = np.fft.rfftfreq(len(force), 1 / base.rate_hz)
    octants = [
        power[(frequency >= low) & (frequency < low + 1)].mean() for low in np.arange(2.0, 10.0)
    ]
    # 2000 lines to a hertz: the mean of their powers varies by 2.2 %
    assert np.max(octants) / np.min(octants) < 1.2


def test_random_shaking_starts_with_the_record_unless_it_settles_before():
    base = Analyser().time_base()
    assert np.all(RandomShaking().history(base, rng())[base.time < 0] == 0)
    settled = Analyser().time_base(settle_s=3.0)
    force = RandomShaking(rms_n=1.0).history(settled, rng())
    assert np.all(force[settled.time < -3.0] == 0)
    assert rms(force[(settled.time > -3) & (settled.time < 0)]) > 0.5


def test_a_finer_simulation_sees_the_same_shaker():
    coarse = Analyser(physics_hz=1024.0).time_base()
    fine = Analyser(physics_hz=4096.0).time_base()
    on_coarse = RandomShaking().history(coarse, rng(3))
    on_fine = RandomShaking().history(fine, rng(3))[:: fine.factor // coarse.factor]
    both = min(len(on_coarse), len(on_fine))
    assert np.allclose(on_fine[:both], on_coarse[:both], atol=1e-10)


def test_a_burst_starts_and_ends_at_zero_and_leaves_time_to_ring_down():
    base = Analyser().time_base()
    force = RandomShaking(rms_n=1.0, burst=0.5).history(base, rng())
    assert np.all(force[(base.time <= 0) | (base.time >= 16.0)] == 0)
    assert np.abs(force[np.abs(base.time - 0.01) < 0.01]).max() < 0.01
    assert np.abs(force[np.abs(base.time - 15.99) < 0.01]).max() < 0.01
    assert rms(force[(base.time > 2) & (base.time < 14)]) == pytest.approx(1.0, rel=0.1)


def test_every_period_of_a_multisine_is_the_same():
    analyser = Analyser(duration_s=32.0)
    base = analyser.time_base(settle_s=4.0)
    force = Multisine(rms_n=3.0, periods=4).history(base, rng())
    inside = force[(base.time >= 0) & (base.time < 32)].reshape(4, -1)
    assert np.array_equal(inside[0], inside[3])
    assert rms(inside[0]) == pytest.approx(3.0, rel=1e-12)
    recorded = analyser.sample(force, base).reshape(4, -1)
    assert np.abs(recorded - recorded[0]).max() < 1e-12 * np.abs(recorded).max()


def test_a_recorded_multisine_has_equal_lines_in_its_band_and_nothing_between():
    analyser = Analyser(duration_s=32.0)
    base = analyser.time_base(settle_s=1.0)
    multisine = Multisine(rms_n=1.0, band_hz=(1.0, 12.0), periods=2)
    spectrum = np.abs(np.fft.rfft(analyser.sample(multisine.history(base, rng()), base))) / 512
    lines = multisine.excited_lines(1024, 32.0) * 2
    assert lines[0] == 32
    assert lines[-1] == 384
    assert spectrum[lines] == pytest.approx(np.sqrt(2 / len(lines)), rel=2e-5)
    assert np.delete(spectrum, lines).max() < 1e-9


def test_the_lines_of_a_multisine_can_be_chosen():
    base = Analyser().time_base()
    multisine = Multisine(rms_n=1.0, periods=1, lines=(33, 65, 97))
    period = multisine.history(base, rng())[-base.first : -base.first + 1024 * base.factor]
    assert set(np.flatnonzero(np.abs(np.fft.rfft(period)) > 1)) == {33, 65, 97}


def test_another_seed_gives_other_phases():
    base = Analyser().time_base()
    one, other = (Multisine().history(base, rng(seed)) for seed in (0, 1))
    assert np.corrcoef(one, other)[0, 1] < 0.5


@pytest.mark.parametrize("law", ["linear", "logarithmic"])
def test_a_sweep_runs_from_the_first_to_the_last_frequency(law):
    base = Analyser(duration_s=64.0).time_base()
    force = Sweep(rms_n=2.0, band_hz=(1.0, 8.0), law=law).history(base, rng())
    assert np.all(force[(base.time < 0) | (base.time > 64)] == 0)
    crossings = base.time[1:][(force[1:] > 0) & (force[:-1] <= 0)]
    frequency = 1 / np.diff(crossings)
    middle = (crossings[1:] + crossings[:-1]) / 2 / 64
    expected = 1 + 7 * middle if law == "linear" else 8**middle
    assert np.abs(frequency / expected - 1).max() < 0.02
    assert force.max() == pytest.approx(2 * np.sqrt(2), rel=1e-3)
    assert rms(force[(base.time > 0) & (base.time < 64)]) == pytest.approx(2.0, rel=0.01)


@pytest.mark.parametrize(
    ("kind", "wrong", "message"),
    [
        (RandomShaking, {"rms_n": 0.0}, "RMS level of a shaker must be a positive"),
        (RandomShaking, {"band_hz": (5.0, 2.0)}, "not from 5 to 2"),
        (RandomShaking, {"band_hz": (-1.0, 2.0)}, "not from -1 to 2"),
        (RandomShaking, {"burst": 1.5}, "share of the record"),
        (Multisine, {"periods": 0}, "at least one period, not 0"),
        (Multisine, {"lines": (0, 2)}, "whole numbers from 1"),
        (Multisine, {"lines": ()}, "whole numbers from 1"),
        (Sweep, {"law": "square"}, "no 'square' sweep; there are linear, logarithmic"),
        (Sweep, {"law": "logarithmic", "band_hz": (0.0, 3.0)}, "cannot start at 0 Hz"),
        (Sweep, {"rms_n": np.inf}, "RMS level of a shaker must be a positive"),
    ],
)
def test_a_shaker_that_cannot_be_is_refused(kind, wrong, message):
    with pytest.raises(ExperimentError, match=message):
        kind(**wrong)


@pytest.mark.parametrize(
    ("multisine", "message"),
    [
        (Multisine(periods=5), "5 periods do not fit a record of 1024 samples"),
        (Multisine(periods=1024), "do not fit"),
        (Multisine(band_hz=(2.01, 2.02), periods=32), "no line of a multisine with lines every 1"),
        (Multisine(band_hz=(1.0, 20.0)), "line at 20 Hz is not below the Nyquist frequency 16 Hz"),
        (Multisine(lines=(200,)), "line at 25 Hz is not below"),
    ],
)
def test_a_multisine_that_does_not_fit_the_record_is_refused(multisine, message):
    with pytest.raises(ExperimentError, match=message):
        multisine.history(Analyser().time_base(), rng())


def test_a_band_without_a_frequency_in_it_is_refused():
    base = Analyser(duration_s=1.0).time_base()
    with pytest.raises(ExperimentError, match=r"fills the band from 1.01 to 1.02 Hz"):
        RandomShaking(band_hz=(1.01, 1.02)).history(base, rng())
    with pytest.raises(ExperimentError, match=r"fills the band from 1 to 600 Hz"):
        RandomShaking(band_hz=(1.0, 600.0)).history(base, rng())
