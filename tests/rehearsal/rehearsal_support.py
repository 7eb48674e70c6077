"""Small plans on small frames."""

from copy import deepcopy

from twin.rehearsal.plan import plan_of

SHAKEN = {
    "kind": "shaker", "at": "floor2", "level": 1.0, "band_hz": [0.5, 12], "duration_s": 8,
    "rate_hz": 64, "use": "train",
}  # fmt: skip
TABLE = {
    "tolerance": 0.01,
    "noise": {"acc": 0.005, "force": 0.005},
    "recordings": [SHAKEN, {**SHAKEN, "level": 0.6}, {**SHAKEN, "level": 0.7, "use": "test"}],
    "conceal": {"mechanisms": ["coulomb_friction"], "places": ["storey1", "storey2"]},
}


def table(**changes):
    """The keys of a plan, some of them changed."""
    return {**deepcopy(TABLE), **changes}


def plan(**changes):
    """A plan that conceals friction in a two-storey frame, some keys changed."""
    return plan_of(table(**changes))
