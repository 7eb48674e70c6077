"""Which engine diagnoses: that of lumped chains, or the general one.

The chain's engine condenses a model onto one displacement a floor and names nothing that the model
already holds. Whatever does not fit that without loss goes to the general engine.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Literal, get_args

from twin.contract import check_names
from twin.errors import ModelError, TwinError, available
from twin.model import Twin
from twin.model.contents import nonlinear_elements
from twin.place import split_channel
from twin.recording import Recording

if TYPE_CHECKING:
    from twin.diagnosis.result import Diagnosis

Engine = Literal["auto", "chain", "general"]


def is_lumped_chain(twin: Twin, recordings: Sequence[Recording]) -> bool:
    """Return whether nothing is lost where floors are all that moves, along x.

    The model has the chain's names, no freedom besides its floors (and a pendulum's), nothing in it
    that is not linear, and the recordings' channels are the chain's.
    """
    model = twin.compile()
    try:
        check_names(model, twin.source)
        if twin.linearisation().condensed or nonlinear_elements(model):
            return False
    except ModelError:
        return False
    return all(split_channel(name) is not None for r in recordings for name in r.names)


def diagnose(
    twin: Twin,
    train: Sequence[Recording],
    test: Sequence[Recording],
    tolerance: float | None = None,
    damping_tolerance: float | None = None,
    added_mass: Mapping[str, Mapping[str, float]] | None = None,
    unknown: bool = False,
    seed: int = 0,
    tell: Callable[[str], None] = lambda message: None,
    engine: Engine = "auto",
) -> Diagnosis:
    """Say where recordings and twin differ, what physics was left out, and give the twin with it.

    Args:
        twin: the model as it stands.
        train: recordings to explain.
        test: recordings on which the result is shown; nothing before that reads them.
        tolerance: prior deviation of masses and stiffnesses, as a share; the engine's own without.
        damping_tolerance: the same for the dampings.
        added_mass: source of a recording -> place -> mass bolted on for it [kg].
        unknown: the model's numbers are not known.
        seed: of the draws for the noise floor.
        tell: is told each step.
        engine: "chain", "general", or "auto": the chain's wherever nothing is lost by it.

    Raises:
        RecordingError: recordings that cannot be used.
        ModelError: a model that cannot be.
        TwinError: no such engine.
    """
    if engine not in get_args(Engine):
        raise TwinError(f"no engine '{engine}'; there are {available(get_args(Engine))}")
    chain = engine == "chain" or (engine == "auto" and is_lumped_chain(twin, [*train, *test]))
    if chain:
        from twin.diagnosis.base import DAMPING_TOLERANCE, TOLERANCE
        from twin.diagnosis.diagnose import diagnose as whole
    else:
        from twin.engine.pipeline import diagnose as whole
        from twin.engine.prepare import DAMPING_TOLERANCE, TOLERANCE
    return whole(
        twin,
        train,
        test,
        tolerance=TOLERANCE if tolerance is None else tolerance,
        damping_tolerance=DAMPING_TOLERANCE if damping_tolerance is None else damping_tolerance,
        added_mass=added_mass,
        unknown=unknown,
        seed=seed,
        tell=tell,
    )
