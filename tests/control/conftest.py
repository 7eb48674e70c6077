import pytest
from absorber_support import PAPER_FRAME

from twin.control.absorber import DesignModel, with_pendulum
from twin.control.bare import without_pendulum
from twin.control.lqg import lqg
from twin.control.plant import Plant
from twin.frame import Pendulum
from twin.model import Twin


@pytest.fixture(scope="session")
def absorber_twin():
    return Twin.load("two_storey_absorber")


@pytest.fixture(scope="session")
def paper_model():
    """The paper's (50), (51), (53) and (56), the force on the first floor."""
    return DesignModel(with_pendulum(PAPER_FRAME, Pendulum()), "force_floor1")


@pytest.fixture(scope="session", params=["force_floor1", "force_ground", "acc_ground"])
def plant(request, absorber_twin):
    return Plant(absorber_twin, request.param)


@pytest.fixture(scope="session")
def floor_plant(absorber_twin):
    return Plant(absorber_twin, "force_floor1")


@pytest.fixture(scope="session")
def believed(absorber_twin):
    """The bare frame linearised, with the pendulum of (55)-(56)."""
    bare = without_pendulum(absorber_twin).second_order()
    return DesignModel(with_pendulum(bare, Pendulum()), "force_floor1")


@pytest.fixture(scope="session")
def controller(believed):
    return lqg(believed)
