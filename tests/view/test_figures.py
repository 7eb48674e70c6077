import numpy as np
import pytest

from twin.view import figures

DRAWN = {
    "time": (figures.time_histories, 3),
    "frf": (figures.frequency_responses, 2),
    "singular values": (figures.singular_values, 1),
    "stabilisation": (figures.stabilisation_diagram, 2),
}


@pytest.mark.parametrize("name", DRAWN)
def test_every_axis_has_a_name_with_a_unit_or_a_plain_quantity(identification, name):
    draw, count = DRAWN[name]
    axes = draw(identification).axes
    assert len(axes) == count
    for ax in axes:
        assert ax.get_ylabel()
    assert axes[-1].get_xlabel()


def test_the_measured_and_the_re_simulated_output_are_drawn_as_they_are(identification):
    ax = figures.time_histories(identification).axes[1]
    lines = {line.get_label(): line.get_ydata() for line in ax.lines}
    recording = identification.recordings[0]
    np.testing.assert_array_equal(lines["measured"], recording.column("acc_floor1"))
    np.testing.assert_array_equal(lines["re-simulated"], identification.predicted[0][:, 0])


def test_the_identified_frf_is_that_of_the_model_at_its_resonance(identification):
    ax = figures.frequency_responses(identification).axes[0]
    line = next(x for x in ax.lines if x.get_label() == "acc_floor1 identified")
    freq, size = (np.asarray(v) for v in line.get_data())
    peak = identification.modal.natural_freq[0]
    at = int(np.argmin(np.abs(freq - peak)))
    assert freq[at] == peak
    exact = identification.state_space.frequency_response(np.array([peak]))[0, 0, 0]
    assert size[at] == pytest.approx(abs(exact), rel=1e-9)


def test_kept_singular_values_are_as_many_as_the_order(identification):
    ax = figures.singular_values(identification).axes[0]
    kept = next(x for x in ax.lines if x.get_label() == "kept")
    assert len(kept.get_xdata()) == 4


def test_mode_shapes_state_amplitude_and_phase_of_every_floor(identification):
    texts = [t.get_text() for ax in figures.modes(identification).axes for t in ax.texts]
    assert len(texts) == 6
    assert any(t.startswith("1.000") for t in texts)


def test_a_figure_is_written_whole(identification, tmp_path):
    path = figures.save(figures.singular_values(identification), tmp_path / "s.png")
    assert path.read_bytes().startswith(b"\x89PNG")
    assert [p.name for p in tmp_path.iterdir()] == ["s.png"]


def test_the_phase_of_a_mode_shape_has_one_writing():
    assert [figures._degrees(v) for v in (1.0, -1.0, -1 - 1e-17j, 1j, 1 - 1e-9j, 0.0)] == [
        0, 180, 180, 90, 0, 0,
    ]  # fmt: skip
