"""A whole diagnosis of small rigs: what is concealed is found, and predicted."""

import numpy as np
import pytest
from diagnosis_support import concealed, lumped, recorded

from twin.diagnosis.pipeline import diagnose
from twin.diagnosis.result import as_json
from twin.model import Twin


@pytest.fixture(scope="module")
def cubic():
    def law(d, v):
        return 4e5 * d**3

    b = np.array([1.0, 0.0])
    return diagnose(
        lumped(), [concealed(law, b, seed) for seed in (1, 2)], [concealed(law, b, 3, scale=0.8)]
    )


def test_a_cubic_spring_is_named_alone_at_its_place_with_its_strength(cubic):
    assert cubic.verdict == "missing_physics"
    (finding,) = cubic.findings
    assert (finding.mechanism.name, finding.location) == ("cubic_stiffness", "storey1")
    assert finding.mechanism.values["stiffness"] == pytest.approx(4e5, rel=0.03)
    assert 0.9 < finding.probability < 1.0
    assert finding.explained > 0.9


def test_what_was_found_is_predicted_to_the_noise_on_a_stronger_test(cubic):
    test = cubic.fit.test
    assert test.explained < 1.3 * test.noise_floor
    assert test.explained < 0.3 * test.calibrated


def test_the_explained_twin_moves_in_mujoco_as_predicted(cubic):
    assert any(m.name == "cubic_stiffness" for m in cubic.explained.mechanisms)
    assert "cubic_stiffness" in cubic.explained.mjcf_of()
    assert isinstance(cubic.explained, Twin)


def test_the_document_has_what_the_contract_asks_for(cubic):
    document = as_json(cubic, None)
    assert document["verdict"] == "missing_physics"
    assert document["findings"][0]["explained"] == cubic.findings[0].explained
    assert all(a["delta_log_evidence"] < 0 for a in document["alternatives"])


def test_nothing_concealed_is_consistent():
    found = diagnose(lumped(), [recorded(lumped(), s) for s in (1, 2)], [recorded(lumped(), 3)])
    assert found.verdict == "consistent"
    assert found.findings == ()
    assert found.fit.test.explained < 1.2 * found.fit.test.noise_floor
