import os
import subprocess
import sys

import numpy as np
import pytest

from twin.frame import SHIPPED, FrameDesign, Pendulum, Storey, to_mjcf, write_models
from twin.model import Twin
from twin.model_files import shipped, shipped_names


def test_the_files_that_come_with_the_package_are_what_the_builder_writes(tmp_path):
    written = write_models(tmp_path)
    assert sorted(path.stem for path in written) == sorted(SHIPPED) == list(shipped_names())
    for path in written:
        assert path.read_bytes() == shipped(path.stem).read_bytes()


def test_the_files_do_not_depend_on_how_linear_algebra_rounds(tmp_path):
    # Another kernel of OpenBLAS rounds differently; other libraries ignore the variable.
    plain = {**os.environ, "OPENBLAS_CORETYPE": "Nehalem"}
    command = [sys.executable, "-m", "twin.frame", str(tmp_path)]
    subprocess.run(command, env=plain, check=True, capture_output=True)
    for name in SHIPPED:
        assert (tmp_path / f"{name}.xml").read_bytes() == shipped(name).read_bytes()


@pytest.mark.parametrize("pendulum", [None, Pendulum()])
@pytest.mark.parametrize("kind", ["lumped", "pseudo_rigid"])
@pytest.mark.parametrize("storeys", [1, 3, 10])
def test_frames_of_any_height_compile_and_move(storeys, kind, pendulum):
    design = FrameDesign((Storey(0.3),) * storeys, kind, pendulum=pendulum)
    twin = Twin.of(design)
    assert twin.floors == tuple(f"floor{n}" for n in range(1, storeys + 1))
    modes = twin.modes()
    assert modes.outputs == twin.floors + (("pendulum",) if pendulum else ())
    assert len(modes.natural_freq) == storeys + bool(pendulum)
    motion = twin.simulate({f"force_floor{storeys}": np.ones(50)}, 500, 50)
    assert motion.columns[f"disp_floor{storeys}"][-1] > 0
    assert motion.columns["acc_floor1"].shape == (50,)


@pytest.mark.parametrize("kind", ["lumped", "pseudo_rigid", "hinge_chain"])
def test_a_compiled_frame_weighs_what_its_design_does(kind):
    design = FrameDesign(kind=kind, pendulum=Pendulum())
    mass = Twin.of(design).released().compile().body_mass.sum()
    assert mass == pytest.approx(design.total_mass, rel=1e-12)


def test_a_frame_with_fast_modes_gets_a_shorter_step():
    slow = Twin.of(FrameDesign()).compile().opt.timestep
    fast = Twin.of(FrameDesign((Storey(0.65, second_moment=1e-8),))).compile().opt.timestep
    assert slow == 0.001
    assert fast <= 0.5e-3
    assert round(0.001 / fast, 9).is_integer()


def test_geometry_has_no_mass():
    twin = Twin.load("two_storey_absorber")
    bare = "\n".join(line for line in twin.mjcf.splitlines() if "<geom " not in line)
    np.testing.assert_array_equal(Twin(bare).second_order().M, twin.second_order().M)


def test_the_text_names_the_model():
    assert '<mujoco model="tower">' in to_mjcf(FrameDesign.tall(2), "tower")
