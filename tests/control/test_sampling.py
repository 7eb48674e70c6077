import numpy as np
import pytest

from twin.control.perturbation import Perturbation
from twin.control.plant import frame_frequencies
from twin.control.sampling import Converters
from twin.errors import ModelError
from twin.instruments import Instrument
from twin.model import Twin


def test_converters_give_what_the_instruments_give():
    """The same noise, range and steps as ``Instrument.digitise`` for a whole record."""
    instruments = {
        "acc_floor1": Instrument(full_scale=1.0, bits=6, noise_std=0.2),
        "angle": Instrument(full_scale=np.pi, bits=16),
        "force": Instrument(bits=None, noise_std=0.3),
    }
    names = ("acc_floor1", "angle_pendulum", "force_floor1")
    true = np.random.default_rng(0).uniform(-0.9, 0.9, (4000, 3))
    converters = Converters(names, instruments, len(true), seed=0)
    read = np.array([converters.read(k, row) for k, row in enumerate(true)])
    assert np.abs(read[:, 0] * 32 - np.round(read[:, 0] * 32)).max() == 0
    assert np.abs(read[:, 0]).max() == 1.0
    assert converters.clipped[0] > 0
    assert not converters.clipped[1:].any()
    assert np.abs(read[:, 1] - true[:, 1]).max() <= np.pi / 2**16 * (1 + 1e-9)
    assert np.std(read[:, 2] - true[:, 2]) == pytest.approx(0.3, rel=0.05)
    inside = np.abs(true[:, 0]) < 0.3
    assert np.std((read - true)[inside, 0]) == pytest.approx(
        np.hypot(0.2, 1 / 32 / 12**0.5), rel=0.06
    )


def test_a_perturbation_scales_storeys_and_floors(absorber_twin):
    model = Twin.load("two_storey_lumped").compile()
    stiffness, mass = model.jnt_stiffness.copy(), model.body_mass.copy()
    Perturbation((1.1, 0.8), (1.3, 0.7)).apply(model)
    joints = [model.joint(f"storey{i}").id for i in (1, 2)]
    bodies = [model.body(f"floor{i}").id for i in (1, 2)]
    assert model.jnt_stiffness[joints] / stiffness[joints] == pytest.approx([1.1, 0.8])
    assert model.body_mass[bodies] / mass[bodies] == pytest.approx([1.3, 0.7])
    flexible = absorber_twin.compile()
    Perturbation((1.1, 0.8)).apply(flexible)
    names = [f"hinge{i}_{j}" for i in (1, 2) for j in (1, 2)]
    ratio = [
        flexible.joint(n).stiffness[0] / absorber_twin.compile().joint(n).stiffness[0]
        for n in names
    ]
    assert ratio == pytest.approx([1.1, 1.1, 0.8, 0.8])


def test_drawn_perturbations_stay_within_their_spread():
    rng = np.random.default_rng(0)
    drawn = [Perturbation.drawn(2, 0.05, rng) for _ in range(300)]
    factors = np.array([(*d.stiffness, *d.mass) for d in drawn])
    assert np.abs(factors - 1).max() <= 0.05
    assert np.abs(factors - 1).max() > 0.045
    assert np.abs(np.corrcoef(factors.T) - np.eye(4)).max() < 0.2


def test_a_storey_without_a_spring_is_refused():
    mjcf = Twin.load("two_storey_lumped").mjcf.replace("stiffness=", "ref=")
    model = Twin(mjcf).compile()
    with pytest.raises(ModelError, match="storey1 has no spring"):
        Perturbation((1.1,)).apply(model)


def test_the_frames_modes_are_told_from_pendulum_and_suspension(plant):
    bare = {"force_ground": (2.308, 5.908)}.get(plant.known_input, (1.7236, 5.7741))
    found = frame_frequencies(plant.linear().structure)
    assert found == pytest.approx(bare, rel=0.02)
    assert len(frame_frequencies(plant.linear().structure, 1)) == 1
