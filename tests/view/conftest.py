"""An identification made by hand: no simulator and no estimator takes part."""

import numpy as np
import pytest

from twin.identification.result import Identification
from twin.modal import ModalModel
from twin.recording import Recording
from twin.second_order import SecondOrderModel
from twin.state_space import StateSpace

OUTPUTS = ("acc_floor1", "acc_floor2")
RATE = 32.0
SAMPLES = 1024


def paper_frame(stiffness: float = 518.6) -> SecondOrderModel:
    M = np.diag([0.65, 1.55])
    K = stiffness * np.array([[2.0, -1.0], [-1.0, 1.0]])
    return SecondOrderModel(M, 0.28 * M + 3e-5 * K, K, ("floor1", "floor2"))


def accelerations(model: SecondOrderModel, places=("floor1",)) -> StateSpace:
    return model.acceleration_response(places).held(1 / RATE)


def build_identification(truth: SecondOrderModel, seed: int = 0) -> Identification:
    rng = np.random.default_rng(seed)
    force = np.zeros((SAMPLES, 1))
    force[4:6, 0] = 8.0, 2.0
    clean = accelerations(truth).simulate(force)
    noisy = clean + 0.01 * clean.std(axis=0) * rng.standard_normal(clean.shape)
    found = paper_frame(518.6 * 1.0001)
    modal = found.modes()
    recording = Recording.build(
        RATE,
        {"force_floor1": force[:, 0], "acc_floor1": noisy[:, 0], "acc_floor2": noisy[:, 1]},
        "hammer.csv",
    )
    system = accelerations(found)
    return Identification(
        modal=ModalModel(
            modal.natural_freq,
            modal.damping_ratio,
            modal.mode_shape,
            OUTPUTS,
            natural_freq_std=np.array([4e-5, 2e-5]),
            damping_ratio_std=np.array([2e-5, 3e-6]),
        ),
        state_space=system,
        singular_values=np.array([41.0, 40.2, 3.1, 3.0, *np.geomspace(0.05, 0.01, 20)]),
        order=4,
        second_order=found,
        alpha=0.28,
        beta=3e-5,
        inputs=("force_floor1",),
        outputs=OUTPUTS,
        sampling_hz=RATE,
        route="maximum likelihood from OKID/ERA",
        recordings=(recording,),
        predicted=(system.simulate(force),),
        natural_freq_bound=np.array([3.9e-5, 1.9e-5]),
        damping_ratio_bound=np.array([1.9e-5, 2.9e-6]),
        notes=("The force is held between samples.",),
    )


@pytest.fixture(scope="session")
def truth() -> SecondOrderModel:
    return paper_frame()


@pytest.fixture(scope="session")
def identification(truth) -> Identification:
    return build_identification(truth)
