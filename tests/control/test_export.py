import ctypes
import shutil
import subprocess

import numpy as np
import pytest
from scipy import io

from twin.control.closed_loop import Schedule, run
from twin.control.excitation import WorstCase
from twin.control.export import export, matrices, settings
from twin.control.lqg import lqg


class Compiled:
    """The C file in the place of the Python controller; it remembers by how much they differ."""

    def __init__(self, library, controller):
        self.c, self.python, self.limited = library, controller.start(), 0
        self.c.controller_reset()
        self.given, self.expected = [], []
        self._estimate = (ctypes.c_double * len(controller.estimates))()

    def switch(self, on):
        self.c.controller_switch(int(on))
        self.python.switch(on)

    def step(self, y, f):
        u = ctypes.c_double()
        pointer = ctypes.POINTER(ctypes.c_double)
        y = np.ascontiguousarray(y, float)
        self.c.controller_step(y.ctypes.data_as(pointer), ctypes.c_double(f), ctypes.byref(u))
        self.given.append(u.value)
        self.expected.append(self.python.step(y, f))
        return u.value

    def estimate(self):
        self.c.controller_estimate(self._estimate)
        return np.array(self._estimate)


@pytest.fixture
def library(tmp_path, controller):
    compiler = shutil.which("gcc")
    if compiler is None:
        pytest.skip("no gcc here to compile the C file with")
    export(controller, tmp_path)
    flags = ["-Wall", "-Wextra", "-std=c99", "-pedantic", "-Werror", "-O2", "-shared", "-fPIC"]
    target = tmp_path / "controller.so"
    done = subprocess.run(
        [compiler, *flags, tmp_path / "controller.c", "-o", target],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return ctypes.CDLL(str(target))


def test_the_c_file_controls_the_frame_as_python_does(library, floor_plant, controller):
    compiled = Compiled(library, controller)
    outcome = run(floor_plant, controller, WorstCase(), Schedule(16.0, 4.0), steps=compiled)
    given, expected = np.array(compiled.given), np.array(compiled.expected)
    assert np.abs(given).max() > 1e-3
    assert np.abs(given - expected).max() <= 1e-12 * np.abs(expected).max()
    assert not given[: 4 * 32].any()
    alone = run(floor_plant, controller, WorstCase(), Schedule(16.0, 4.0))
    assert outcome.estimated == pytest.approx(alone.estimated, abs=1e-9)


def test_the_c_file_keeps_soft_start_and_limit(library, controller):
    compiled = Compiled(library, controller)
    compiled.switch(True)
    rng = np.random.default_rng(0)
    for _ in range(400):
        compiled.step(100 * rng.normal(size=3), rng.normal())
    given, expected = np.array(compiled.given), np.array(compiled.expected)
    assert np.abs(given).max() == controller.torque_limit
    assert np.abs(given - expected).max() <= 1e-12 * controller.torque_limit
    compiled.switch(False)
    assert compiled.step(np.ones(3), 0.0) == 0.0
    again = Compiled(library, controller)
    assert not again.estimate().any()
    assert again.step(np.ones(3), 0.0) == 0.0


def test_the_c_file_includes_nothing(tmp_path, controller):
    export(controller, tmp_path)
    assert "#include" not in (tmp_path / "controller.c").read_text()


def test_mat_and_csv_give_every_bit_back(tmp_path, controller):
    paths = export(controller, tmp_path, "absorber")
    assert {path.suffix for path in paths} == {".mat", ".csv", ".c"}
    back = io.loadmat(tmp_path / "absorber.mat")
    for name, values in matrices(controller).items():
        assert np.array_equal(back[name], np.reshape(getattr(controller, name), values.shape))
        table = np.loadtxt(tmp_path / f"absorber_{name}.csv", delimiter=",", ndmin=2)
        assert np.array_equal(table, values)
    lines = (tmp_path / "absorber_settings.csv").read_text().splitlines()
    there = dict(line.split(",") for line in lines)
    for name, value in settings(controller).items():
        assert back[name].item() == value == float(there[name])
    assert there["y2"] == back["measurements"][0, 2].item() == "angle_pendulum"
    assert there["known_input"] == "force_floor1"


def test_a_controller_without_soft_start_compiles(tmp_path, believed):
    compiler = shutil.which("gcc")
    if compiler is None:
        pytest.skip("no gcc here to compile the C file with")
    export(lqg(believed, ramp_s=0.0), tmp_path)
    flags = ["-Wall", "-Wextra", "-std=c99", "-Werror", "-fsyntax-only"]
    subprocess.run([compiler, *flags, tmp_path / "controller.c"], check=True)
