"""The study of identified structures: the model's modes, and what counts as within."""

import numpy as np

from experiments import structures_identified as study


def test_the_models_modes_in_the_band_are_those_that_are_asked_for():
    frequencies, ratios = study.true_modes("rotated_sensors")
    np.testing.assert_allclose(frequencies, [3.364, 4.485, 9.837, 13.115], atol=1e-3)
    np.testing.assert_allclose(ratios, [0.01, 0.008, 0.008, 0.008], rtol=1e-5)
    assert len(study.true_modes("cantilever")[0]) == 2


def test_a_mode_that_is_not_found_is_not_within():
    results = {
        "cantilever 1": {"frequency": [0.5, None], "damping": [3.5, None], "spurious": 1},
        "cantilever 2": {"error": "no order stands out"},
    }
    lines = study.table(results).splitlines()
    assert lines[2].startswith("| cantilever | 3.303 | 2 | 1 | 1 of 2 | 0 of 2 |")
    assert "spurious 1, failed 1" in lines[-1]
