import re

import numpy as np
import pytest
from scipy import signal, stats

from twin.errors import ExperimentError, ModelError
from twin.instruments import Instrument
from twin.laboratory import (
    Analyser,
    Earthquake,
    Experiment,
    Hammer,
    Multisine,
    RandomShaking,
    Sweep,
    run,
    settling_time,
)
from twin.laboratory.experiment import stream
from twin.mechanisms import vocabulary
from twin.model import Twin

IDEAL = Instrument(bits=None)
SHORT = Analyser(duration_s=4.0)
TIME = np.arange(0, 3, 0.01)
QUAKE = Earthquake(np.sin(np.pi * TIME / 3) ** 2 * np.sin(2 * np.pi * 2.2 * TIME), 100.0)


@pytest.fixture(scope="module")
def frame():
    return Twin.load("two_storey_lumped")


def ideal(excitation, at="floor1", analyser=SHORT, **options):
    instruments = {"acc": IDEAL, "force": IDEAL, "disp": IDEAL}
    return Experiment(excitation, at, analyser, instruments=instruments, **options)


def reference(experiment, frame, finer=8):
    """Force and accelerations by exact discretisation and on a finer grid: no MuJoCo anywhere."""
    base = experiment.time_base()
    rng = stream(0, 0, f"excitation {experiment.excitation.kind}")
    samples = experiment.excitation.history(base, rng)
    samples[0] = 0  # at rest
    fine_index = np.arange((base.samples - 1) * finer + 1) / finer
    force = np.interp(fine_index, np.arange(base.samples), samples)
    rig = frame.released() if experiment.at == "ground" else frame
    model = rig.second_order().acceleration_response((experiment.at,))
    step = 1 / (base.rate_hz * finer)
    *exact, _ = signal.cont2discrete((model.A, model.B, model.C, model.D), step, method="foh")
    _, acceleration, _ = signal.dlsim(signal.dlti(*exact, dt=step), force[:, None])
    places = rig.second_order().coordinates
    columns = {f"acc_{place}": acceleration[:, i] for i, place in enumerate(places)}
    columns[experiment.inputs(frame)[0]] = force
    rate = base.rate_hz * finer
    reach = round(0.5 * rate)
    window = ("kaiser", signal.kaiser_beta(104.0))
    taps = signal.firwin(2 * reach + 1, 16.0, window=window, fs=rate)
    centres = (-base.first + np.arange(base.record_samples) * base.factor) * finer
    padded = {name: np.pad(x, reach) for name, x in columns.items()}
    windows = {name: [x[c : c + len(taps)] for c in centres] for name, x in padded.items()}
    return {name: np.array([taps @ w for w in rows]) for name, rows in windows.items()}


def error(measured, true):
    return np.sqrt(np.mean((measured - true) ** 2) / np.mean(true**2))


@pytest.mark.parametrize(
    ("excitation", "at"),
    [
        (Hammer(), "floor1"),
        (Hammer(width_s=0.012, delay_s=0.61), "floor2"),
        (RandomShaking(band_hz=(0.5, 12.0), burst=0.6), "ground"),
    ],
)
def test_the_whole_chain_agrees_with_an_exact_solution_on_a_finer_grid(frame, excitation, at):
    experiment = ideal(excitation, at, Analyser(duration_s=8.0))
    recording = run(experiment, frame)
    expected = reference(experiment, frame)
    assert set(recording.names) == set(expected)
    # What straight lines leave above half the physics rate aliases only where the force acts.
    worst = {experiment.inputs(frame)[0]: 1e-5, f"acc_{at}": 2e-4}
    for name in recording.names:
        assert error(recording.column(name), expected[name]) < worst.get(name, 1e-5), name


def test_the_hammers_impulse_is_in_the_record_whatever_the_pulse_is_shorter_than(frame):
    hammer = Hammer(width_s=0.008, peak_n=20.0)
    force = run(ideal(hammer), frame).column("force_floor1")
    assert np.sum(force) / 32 == pytest.approx(hammer.impulse, rel=4e-3)
    assert 2 < force.max() < 5  # 20 N for 8 ms, seen in 16 Hz


def test_the_record_of_a_hammer_test_begins_at_rest(frame):
    recording = run(ideal(Hammer()), frame)
    assert np.abs(recording.data[0]).max() < 1e-6 * np.abs(recording.data).max()


def test_a_test_on_a_floor_records_its_force_and_every_floor(frame):
    assert run(Experiment(Hammer(), "floor2", SHORT), frame).names == (
        "force_floor2",
        "acc_floor1",
        "acc_floor2",
    )


def test_a_shaker_at_the_ground_frees_it_and_its_load_cell_measures_what_enters(frame):
    recording = run(ideal(Sweep(rms_n=1.0, band_hz=(1.0, 10.0)), "ground"), frame)
    assert recording.names == ("force_ground", "acc_ground", "acc_floor1", "acc_floor2")
    assert recording.inputs == ("force_ground",)
    assert np.sqrt(np.mean(recording.column("force_ground") ** 2)) == pytest.approx(1, rel=0.05)


def test_an_earthquake_gives_a_shake_table_recording(frame):
    recording = run(ideal(QUAKE), frame)
    assert recording.names == ("acc_ground", "acc_floor1", "acc_floor2")
    assert recording.inputs == ("acc_ground",)
    sampled = np.interp(recording.time, TIME, QUAKE.acceleration, right=0.0)
    assert error(recording.column("acc_ground"), sampled) < 2e-3


def test_an_earthquake_shakes_the_floors_as_the_relative_equation_of_motion_says(frame):
    recording = run(ideal(QUAKE), frame)
    model = frame.second_order()
    rate = 3200.0
    ground = np.interp(np.arange(4 * 3200) / rate, TIME, QUAKE.acceleration, right=0.0)
    inertia = -np.outer(ground, model.M.sum(axis=1))
    response = model.acceleration_response(model.coordinates)
    *exact, _ = signal.cont2discrete(
        (response.A, response.B, response.C, response.D), 1 / rate, method="foh"
    )
    _, relative, _ = signal.dlsim(signal.dlti(*exact, dt=1 / rate), inertia)
    absolute = (relative + ground[:, None])[::100]
    # straight lines between the 100 Hz samples here, a band-limited signal there: 0.2 % at 2.2 Hz
    assert error(recording.matrix(("acc_floor1", "acc_floor2")), absolute) < 5e-3


def test_a_settled_multisine_repeats_itself_in_every_response(frame):
    wait = settling_time(frame)
    analyser = Analyser(duration_s=8.0)
    recording = run(ideal(Multisine(periods=2), "floor2", analyser, settle_s=wait), frame)
    first, second = recording.data.reshape(2, 128, -1)
    assert np.abs(second - first).max() < 1e-3 * np.abs(first).max()
    unsettled = run(ideal(Multisine(periods=2), "floor2", analyser), frame)
    first, second = unsettled.data.reshape(2, 128, -1)
    assert np.abs(second - first).max() > 0.1 * np.abs(first).max()


def test_the_settling_time_is_that_of_the_slowest_mode(frame):
    poles = frame.modes().poles
    assert np.exp(-settling_time(frame, 0.01) * np.min(-poles.real)) == pytest.approx(0.01)


def test_the_same_seed_gives_the_same_recording_bit_for_bit(frame):
    experiment = Experiment(
        RandomShaking(), "ground", SHORT, instruments={"acc": Instrument(noise_fraction=0.01)}
    )
    first, again = (run(experiment, frame, seed=5) for _ in range(2))
    assert np.array_equal(first.data, again.data)
    assert not np.array_equal(first.data, run(experiment, frame, seed=6).data)
    assert not np.array_equal(first.data, run(experiment, frame, seed=5, repetition=1).data)


def test_a_channel_more_does_not_change_the_others(frame):
    noisy = {"acc": Instrument(noise_fraction=0.01), "disp": Instrument(noise_fraction=0.01)}
    few = Experiment(Hammer(), "floor1", SHORT, ("force_floor1", "acc_floor2"), noisy)
    more = Experiment(
        Hammer(),
        "floor1",
        SHORT,
        ("disp_floor2", "acc_floor1", "force_floor1", "acc_floor2"),
        noisy,
    )
    few, more = run(few, frame), run(more, frame)
    assert np.array_equal(few.data, more.matrix(few.names))


def test_noise_is_the_fraction_of_each_channels_rms_and_independent_between_channels(frame):
    long = Analyser(duration_s=32.0)
    clean = run(ideal(Hammer(), analyser=long), frame)
    noisy = Experiment(
        Hammer(),
        "floor1",
        long,
        instruments={"acc": Instrument(noise_fraction=0.01, bits=None), "force": IDEAL},
    )
    noise = run(noisy, frame, seed=1).data - clean.data
    assert np.all(noise[:, 0] == 0)
    low, high = stats.chi2.interval(0.9999, 1024)
    for column in (1, 2):
        std = 0.01 * np.sqrt(np.mean(clean.data[:, column] ** 2))
        assert low < np.sum(noise[:, column] ** 2) / std**2 < high
    assert abs(np.corrcoef(noise[:, 1], noise[:, 2])[0, 1]) < 0.13


def test_a_channels_own_instrument_wins_over_its_kinds(frame):
    instruments = {"acc": IDEAL, "acc_floor2": Instrument(full_scale=0.5)}
    recording = run(Experiment(Hammer(), "floor1", SHORT, instruments=instruments), frame)
    clipped = np.count_nonzero(np.abs(run(ideal(Hammer()), frame).column("acc_floor2")) > 0.5)
    assert recording.notes == (f"acc_floor2 was clipped at 0.5 m/s^2 in {clipped} of 128 samples",)
    assert np.abs(recording.column("acc_floor2")).max() == 0.5


def test_progress_runs_up_to_one(frame):
    shares = []
    run(Experiment(Hammer(), "floor1", Analyser(duration_s=16.0)), frame, progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert len(shares) > 1


def test_a_pendulums_angle_is_read_by_its_encoder():
    recording = run(Experiment(Hammer(), "floor1", SHORT), Twin.load("two_storey_absorber"))
    assert recording.names[-1] == "angle_pendulum"
    counts = recording.column("angle_pendulum") / (2 * np.pi / 2**16)
    assert np.allclose(counts, np.round(counts), atol=1e-9)
    assert len(set(counts)) > 20


def test_a_place_that_is_not_there_is_refused_with_those_that_are(frame):
    with pytest.raises(
        ExperimentError, match="no 'floor3' to act on; there is ground, floor1, flo"
    ):
        run(Experiment(Hammer(), "floor3", SHORT), frame)


def test_a_channel_that_is_not_measured_is_refused_with_those_that_are(frame):
    experiment = Experiment(Hammer(), "floor1", SHORT, ("force_floor1", "angle_pendulum"))
    with pytest.raises(
        ExperimentError, match=r"nothing measures 'angle_pendulum'.*acc_floor1, acc"
    ):
        run(experiment, frame)
    odd = Experiment(Hammer(), "floor1", SHORT, instruments={"velocity": IDEAL})
    with pytest.raises(ExperimentError, match=r"'velocity', which is no kind .*acc, vel"):
        run(odd, frame)


def test_a_ground_that_cannot_slide_cannot_be_shaken(frame):
    fixed = re.sub(r"<equality>.*?</equality>", "", frame.mjcf, flags=re.DOTALL)
    fixed = re.sub(r'<joint name="ground"[^>]*/>', "", fixed)
    fixed = re.sub(r'<motor name="force_ground"[^>]*/>', "", fixed)
    with pytest.raises(ModelError, match="cannot be released"):
        run(Experiment(RandomShaking(), "ground", SHORT), Twin(fixed, "fixed"))


def test_where_dry_friction_jumps_the_record_is_that_of_a_finer_simulation(frame):
    rubbed = frame.including(vocabulary()["coulomb_friction"]("storey2", 0.3))
    shaking = RandomShaking(1.0, (0.5, 12.0))
    errors = {}
    fine = run(ideal(shaking, analyser=Analyser(128.0, 4.0, physics_hz=65536.0)), rubbed)
    for rate in (None, 1024.0):
        seen = run(ideal(shaking, analyser=Analyser(128.0, 4.0, physics_hz=rate)), rubbed)
        errors[rate] = error(seen.column("acc_floor1"), fine.column("acc_floor1"))
    assert errors[None] < 1e-3
    assert errors[1024.0] > 3 * errors[None]
