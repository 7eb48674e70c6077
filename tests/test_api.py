"""The public interface: the examples of its docstrings run, and results show themselves."""

import doctest
import importlib
import json
import subprocess
import sys

import numpy as np
import pytest

import twin
import twin.api
from twin.errors import TwinError


@pytest.fixture(scope="module")
def hit():
    return twin.hammer_test("two_storey_lumped")


@pytest.fixture(scope="module")
def found(hit):
    return twin.identify(hit)


NOUNS = (
    *(
        "channel",
        "errors",
        "frame.design",
        "modal",
        "model.twin",
        "model.from_sysid",
        "place",
        "recording",
    ),
    *("second_order", "state_space"),
)


@pytest.mark.parametrize("name", ["twin", "twin.api", *(f"twin.{noun}" for noun in NOUNS)])
def test_every_example_in_the_docstrings_runs(name):
    module = importlib.import_module(name)
    result = doctest.testmod(module, optionflags=doctest.IGNORE_EXCEPTION_DETAIL)
    assert result.attempted
    assert not result.failed


def test_every_public_name_is_there_and_has_an_example():
    assert set(twin.__all__) <= set(dir(twin))
    verbs = {name for name in twin.__all__ if getattr(twin, name).__module__ == "twin.api"}
    assert verbs == {
        *("read", "hammer_test", "shaker_test", "identify", "diagnose", "design_controller")
    }
    for name in twin.__all__:
        assert ">>>" in getattr(twin, name).__doc__, name
    with pytest.raises(AttributeError, match="module 'twin' has no attribute 'sing'; it has"):
        twin.sing()


def test_importing_is_quick_and_loads_nothing_that_draws():
    code = (
        "import time; begin = time.process_time(); import sys, twin; dir(twin);"
        "late = {'matplotlib', 'rerun', 'jinja2', 'mujoco', 'numba', 'scipy', 'numpy'};"
        "print(time.process_time() - begin, *(late & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    seconds, *loaded = done.stdout.split()
    assert float(seconds) < 0.3
    assert not loaded


def test_the_verbs_load_nothing_that_draws():
    code = (
        "import sys, twin; twin.Twin, twin.FrameDesign, twin.read, twin.identify, twin.diagnose;"
        "print(*({'matplotlib', 'rerun', 'jinja2', 'pint'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


def test_the_types_come_with_the_package():
    from importlib.resources import files

    assert (files("twin") / "py.typed").is_file()


def test_a_test_of_the_interface_is_that_of_the_command(hit, tmp_path):
    command = [sys.executable, "-m", "twin", "test", "hammer", "--model", "two_storey_lumped"]
    subprocess.run([*command, "--out", tmp_path], check=True, capture_output=True)
    (written,) = tmp_path.glob("*.csv")
    assert np.array_equal(twin.read(written).data, hit.data)


def test_files_and_recordings_may_be_mixed(hit, found, tmp_path):
    path = hit.save(tmp_path / "hit.csv")
    again = twin.identify([path])
    np.testing.assert_allclose(again.modal.natural_freq, found.modal.natural_freq, rtol=1e-9)


def test_nouns_and_results_print_in_a_few_short_lines(hit, found):
    design = twin.FrameDesign()
    for thing in (hit, found, twin.Twin.of(design), twin.Twin.load("two_storey_absorber")):
        text = repr(thing)
        assert len(text) < 2000
        assert max(map(len, text.splitlines())) < 140
        html = thing._repr_html_()
        assert html.count("<tr>") == len(list(thing._rows()))
    assert "mode 1" in repr(found)
    assert "1.948" in repr(found)
    assert "input" in repr(hit)


def test_names_from_files_cannot_break_the_notebook():
    odd = twin.Recording.build(1.0, {"<b>&</b> [m]": [0.0, 1.0]})
    assert "<b>&</b>" not in odd._repr_html_()
    assert "&lt;b&gt;" in odd._repr_html_()


def test_results_draw_and_list_themselves(hit, found):
    for thing in (hit, found, twin.Twin.load("two_storey_lumped")):
        figure = thing.plot()
        assert figure.get_axes()
        # a notebook that never imported pyplot shows it all the same
        assert figure._repr_png_().startswith(b"\x89PNG")
        json.dumps(thing.to_dict(), allow_nan=False)
    assert found.to_dict()["modes"][0]["frequency_hz"] == found.modal.natural_freq[0]
    assert hit.to_dict()["channels"]["acc_floor1 [m/s^2]"][3] == hit.column("acc_floor1")[3]


def test_results_save_themselves_and_name_what_they_cannot_be(hit, found, tmp_path):
    assert twin.read(hit.save(tmp_path / "hit.h5")).names == hit.names
    assert json.loads(found.save(tmp_path / "found.json").read_text())["modes"]
    model = twin.Twin.load("two_storey_lumped")
    assert twin.Twin.load(model.save(tmp_path / "m.xml")).floors == model.floors
    with pytest.raises(TwinError, match=r"a Twin is not written as '\.csv'; \.xml, \.json are"):
        model.save(tmp_path / "m.csv")
    assert not (tmp_path / "m.csv").exists()


def test_a_controller_is_designed_printed_and_written(tmp_path):
    controller = twin.design_controller(known_input="force_floor1", rate_hz=64)
    assert repr(controller).startswith("controller of ")
    assert "64 Hz" in repr(controller)
    assert controller.save(tmp_path / "c.c").read_text()
    assert controller.to_dict()["matrices"]["A"]
    with pytest.raises(TwinError, match="no figure of its own"):
        controller.plot()


@pytest.mark.parametrize(
    ("value", "std", "text"),
    [
        (1.9488404, 4.1e-5, "1.948840 ± 0.000041"),
        (1.182, 0.02, "1.182 ± 0.020"),
        (518.6, 12.0, "519 ± 12"),
        (3.0, 0.0, "3"),
        (3.0, float("nan"), "3"),
    ],
)
def test_a_value_has_the_digits_that_its_deviation_leaves(value, std, text):
    from twin.presentable import with_deviation

    assert with_deviation(value, std) == text
