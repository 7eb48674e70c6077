"""A whole diagnosis of a frame with a hardening storey, and what is told of it."""

import json
import re
from pathlib import Path

import jsonschema
import numpy as np
import pytest
from diagnosis_support import lumped, recorded

from twin import mechanisms
from twin.diagnosis.pipeline import diagnose
from twin.diagnosis.result import as_json
from twin.model import Twin

pytestmark = pytest.mark.filterwarnings("ignore::RuntimeWarning")  # as the command line does

SCHEMA = Path(__file__).parents[3] / "shared" / "contracts" / "diagnosis.schema.json"
REQUIRED = {
    "verdict", "findings", "alternatives", "fit", "fit_ahead", "twin", "next_experiment", "seconds",
}  # fmt: skip
CUBIC = mechanisms.vocabulary()["cubic_stiffness"]("storey1", 1e6)


@pytest.fixture(scope="module")
def told():
    """The steps that were told, and the diagnosis."""
    records = [recorded(lumped(CUBIC), seed, 0.6, 8.0) for seed in (1, 2, 3)]
    steps = []
    found = diagnose(lumped(), records[:2], records[2:], tell=steps.append)
    return steps, found


@pytest.fixture(scope="module")
def diagnosis(told):
    return told[1]


def test_a_hardening_storey_is_named_at_its_place_with_its_strength(diagnosis):
    assert diagnosis.verdict == "missing_physics"
    (finding,) = diagnosis.findings
    assert (finding.mechanism.name, finding.location) == ("cubic_stiffness", "storey1")
    assert diagnosis.place == "storey1"
    assert finding.mechanism.stiffness == pytest.approx(1e6, rel=0.01)
    assert 0 < finding.std["stiffness"] < 1e4
    assert finding.probability > 0.95
    assert max(diagnosis.where, key=diagnosis.where.get) in ("storey1", "floor1")
    assert ("cubic_stiffness", "storey1") in [c[:2] for c in diagnosis.screening[:5]]


def test_alternatives_are_less_probable_and_their_probabilities_leave_no_room(diagnosis):
    first = diagnosis.findings[0].probability
    assert diagnosis.alternatives
    assert all(a.probability <= first for a in diagnosis.alternatives)
    assert first + sum(a.probability for a in diagnosis.alternatives) < 1 + 1e-9
    assert all(a.delta_bic > 0 for a in diagnosis.alternatives)


def test_the_explained_twin_foresees_an_unseen_recording_to_near_its_noise(diagnosis):
    for fits in (diagnosis.fit, diagnosis.fit_ahead):
        for errors in (fits.train, fits.test):
            assert errors.explained < 2.5 * errors.noise_floor
            assert errors.explained < 0.05 * errors.calibrated
            assert errors.calibrated < errors.nominal


def test_the_twins_are_the_model_the_tolerances_and_the_finding(diagnosis):
    assert diagnosis.nominal.mechanisms == ()
    calibrated = {m.name for m in diagnosis.calibrated.mechanisms}
    assert calibrated <= {"stiffness", "damping", "mass"}
    explained = {(m.name, m.place): m for m in diagnosis.explained.mechanisms}
    found = explained["cubic_stiffness", "storey1"]
    assert found == diagnosis.findings[0].mechanism
    K, true = (t.second_order().K for t in (diagnosis.explained, lumped()))
    assert np.abs(K - true).max() < 0.01 * true.max()


def test_traces_are_the_recordings_beside_their_runs(diagnosis):
    assert [t.role for t in diagnosis.traces] == ["train", "train", "test"]
    assert [t.name for t in diagnosis.traces] == ["seed1.csv", "seed2.csv", "seed3.csv"]
    test = diagnosis.traces[2]
    assert test.outputs == ("acc_floor1", "acc_floor2")
    for run in (test.nominal, test.calibrated, test.explained, test.explained_ahead):
        assert run.shape == test.measured.shape == (1024, 2)
    error = np.sqrt(np.sum((test.explained - test.measured) ** 2) / np.sum(test.measured**2))
    assert error == pytest.approx(diagnosis.fit.test.explained, rel=1e-9)


def test_the_missing_force_is_drawn_along_the_drift(diagnosis):
    picture = diagnosis.force[0]
    assert picture.place == "storey1"
    true = 1e6 * picture.law_drift**3
    assert np.abs(picture.law - true).max() < 0.02 * np.abs(true).max()
    # the calibrated twin took up a linear part of it
    known = np.column_stack([picture.drift**3, picture.drift, picture.rate])
    shape, left = np.linalg.lstsq(known, picture.latent, rcond=None)[:2]
    assert shape[0] == pytest.approx(1e6, rel=0.4)
    assert left[0] < 0.4 * np.sum(picture.latent**2)


def test_steps_are_told_as_they_are_taken_and_timed(told):
    steps, found = told
    assert steps[0] == "reading the model (0 s)"
    fitted = re.compile(r"search step 1: fitting cubic_stiffness at storey1 \(\d+ of \d+\)")
    assert any(fitted.match(step) for step in steps)
    assert [step.rpartition(" (")[0] for step in steps] == list(found.steps)
    assert sum(found.steps.values()) <= found.seconds


def test_the_json_is_the_contracts(diagnosis, tmp_path):
    path = diagnosis.explained.export(tmp_path / "twin.xml")
    document = json.loads(json.dumps(as_json(diagnosis, str(path)), allow_nan=False))
    assert set(document) >= REQUIRED
    assert document["verdict"] == "missing_physics"
    finding = document["findings"][0]
    assert finding["mechanism"] == "cubic_stiffness"
    value = finding["parameters"]["stiffness"]
    assert value["unit"] == "N/m^3"
    assert value["value"] == diagnosis.findings[0].mechanism.stiffness
    assert set(document["fit"]["test"]) == {"nominal", "calibrated", "explained", "noise_floor"}
    again = Twin.load(document["twin"]).second_order().K
    np.testing.assert_allclose(again, diagnosis.explained.second_order().K, rtol=1e-6)


def test_the_json_validates(diagnosis):
    if not SCHEMA.exists():
        pytest.skip("the contract's schema is not beside this checkout")
    schema = json.loads(SCHEMA.read_text())
    jsonschema.validate(json.loads(json.dumps(as_json(diagnosis, None))), schema)
    assert set(schema["required"]) == REQUIRED
