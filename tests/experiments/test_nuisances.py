"""Instruments that misbehave: which cases, how they are scored, how the page shows them."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import csd

import twin
from experiments import nuisances
from experiments.concealed.mechanisms import SENSOR
from experiments.concealed.tables import combination_of
from experiments.instrument_faults import NUISANCES, STRENGTHS, Setting
from experiments.proof_sections import section

ALL = list(NUISANCES), list(STRENGTHS), 2, Path("kept")


def test_two_draws_are_84_cases_each_with_an_effect_of_its_own():
    sound, hidden = (nuisances.tasks(*ALL, effect) for effect in (False, True))
    assert len(sound) == len(hidden) == 84
    assert {t.table for t in sound.values()} == {"none"}
    assert len({t.number for t in sound.values()}) == 28
    assert len({t.number for t in hidden.values()}) == 84
    effects = [combination_of("single", t.number, nuisances.SEED)[0] for t in hidden.values()]
    assert not {name for name, _ in effects} & {*SENSOR, "sensor_swap"}
    assert len(set(effects)) == 28, "every structural mechanism at every place of two storeys"
    assert max(effects.count(e) for e in effects) == min(effects.count(e) for e in effects) == 3


def test_a_part_of_the_cases_are_those_of_the_whole():
    for effect in (False, True):
        whole = nuisances.tasks(*ALL, effect)
        part = nuisances.tasks(["gain"], [3.0], 2, Path("kept"), effect)
        assert list(part) == ["gain, 3", "gain, 3, draw 2"]
        assert part.items() <= whole.items()


@pytest.mark.parametrize("name", NUISANCES)
def test_a_nuisance_changes_its_channels_and_no_other(name):
    rng = np.random.default_rng(1)
    columns = {n: rng.standard_normal(4096) for n in ("force_floor1", "acc_floor1", "acc_floor2")}
    change, channels = NUISANCES[name]
    spoilt = change(columns, Setting(1.0, 256.0, np.random.default_rng(2)))
    assert {n for n in columns if not np.array_equal(spoilt[n], columns[n])} == set(channels)


def test_a_sound_rig_is_right_without_a_structural_finding():
    task = nuisances.tasks(*ALL, False)["hum, 1"]
    fault = ("sensor_hum", "acc_floor1")
    quiet = nuisances.score(task, [fault], [])
    assert (quiet["right"], quiet["named"], quiet["structural"]) == (True, True, 0)
    loud = nuisances.score(task, [fault, ("damping", "storey1")], [])
    assert (loud["right"], loud["structural"]) == (False, 1)
    noted = nuisances.score(task, [], ["acc_floor2 hums"])
    assert (noted["named"], noted["noted"]) == (False, True)


def test_an_effect_is_right_first_among_the_structural_findings():
    task = nuisances.tasks(*ALL, True)["hum, 1"]
    (effect,) = combination_of("single", task.number, nuisances.SEED)
    other = ("damping", "storey1") if effect[0] != "damping" else ("mass", "floor1")
    fault = ("sensor_hum", "acc_floor1")

    def scored(*places):
        result = nuisances.score(task, list(places), [])
        return result["right"], result["spurious"]

    assert scored(effect, fault) == scored(fault, effect) == (True, 0)
    assert scored(effect, other) == (True, 1)
    assert scored(other, effect) == (False, 1)
    assert scored(fault) == (False, 0)


def test_the_diagnosis_gets_spoilt_training_of_a_case_with_the_effect(tmp_path, monkeypatch):
    task = nuisances.tasks(["gain"], [3.0], 1, tmp_path, True)["gain, 3"]
    (effect,) = combination_of("single", task.number, nuisances.SEED)
    given = []

    def quick(model, train, test):
        given.append((train, test))
        finding = SimpleNamespace(mechanism=SimpleNamespace(name=effect[0]), location=effect[1])
        return SimpleNamespace(findings=[finding], notes=[], verdict="", seconds=1.2)

    monkeypatch.setattr(nuisances, "diagnose", quick)
    result = nuisances.work(task)
    assert (result["right"], result["concealed"]) == (True, " ".join(effect))
    (train, test), folder = given[0], tmp_path / "recordings" / f"case_{task.number:04d}"
    assert (len(train), len(test)) == (4, 2)
    clean = twin.read(folder / "train_1.csv")
    assert train[0].column("acc_floor2") == pytest.approx(1.09 * clean.column("acc_floor2"))
    assert train[0].column("acc_floor1") == pytest.approx(clean.column("acc_floor1"))


def test_the_page_shows_both_kinds_once_they_are_kept(tmp_path):
    path = tmp_path / "nuisances.json"
    common = {"said": "nothing", "named": False, "noted": True, "seconds": 3, "verdict": ""}
    nuisances.keep(path, "none", {
        "hum, 0.3": {**common, "structural": 0}, "hum, 3": {**common, "structural": 1},
        "hum, 3, draw 2": {**common, "structural": 0, "right": True},
    })  # fmt: skip
    hidden = {**common, "structural": 2, "concealed": "mass floor1", "right": True, "spurious": 1}
    nuisances.keep(path, "effect", {"gain, 1": hidden})
    assert "| gain, 1 | mass floor1 | nothing | yes | 1 | 3 |" in nuisances.table(
        {"gain, 1": hidden}, True
    )
    one, other = section("nuisances", nuisances.json.loads(path.read_text()))["tables"]
    assert one["rows"][0][1:] == ["1 of 1", "-", "1 of 2", "3 of 3"]
    assert "2 of 3" in one["title"]
    assert other["rows"][0][1:] == ["-", "1 of 1", "-", "0 of 1"]


def test_a_late_sensor_is_late_before_the_filter_and_noise_is_not(tmp_path, monkeypatch):
    task = nuisances.tasks(["late"], [3.0], 1, tmp_path, False)["late, 3"]
    given = []

    def quick(model, train, test):
        given.append((train, test))
        return SimpleNamespace(findings=[], notes=[], verdict="", seconds=1.2)

    monkeypatch.setattr(nuisances, "diagnose", quick)
    nuisances.work(task)
    (train, test), folder = given[0], tmp_path / "recordings" / f"none_{task.number:04d}"
    sound = [twin.read(folder / f"train_{i + 1}.csv") for i in range(len(train))]
    for faulty, clean in zip(train, sound, strict=True):
        assert faulty.column("acc_floor2") == pytest.approx(clean.column("acc_floor2"))
        x, late = clean.column("acc_floor1"), faulty.column("acc_floor1")
        f, cross = csd(x, late, clean.sampling_hz, nperseg=1024)
        here = np.argmax(np.abs(cross))
        assert -np.angle(cross[here]) / (2 * np.pi * f[here]) == pytest.approx(1.5e-3, rel=0.05)
    assert [t.source for t in test] == ["test_1.csv", "test_2.csv"]


def test_a_loose_sensor_rings_at_its_own_frequency():
    rate = 4096.0
    impulse = np.zeros(8192)
    impulse[0] = 1.0
    loose = NUISANCES["resonance"][0]({"acc_floor2": impulse}, Setting(1.0, rate, None))
    spectrum = np.abs(np.fft.rfft(loose["acc_floor2"]))
    assert np.argmax(spectrum) * rate / len(impulse) == pytest.approx(60, abs=1)
