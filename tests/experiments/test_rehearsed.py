"""The study of the rehearsal's limits: what is drawn, concealed and counted."""

import numpy as np

import experiments.rehearsed as study_room
from experiments.rehearsed import PLAN, TIMES, drawn, study
from twin.model import Twin
from twin.rehearsal.plan import plan_of
from twin.rehearsal.result import Limit


def limit(mechanism, place, times=1.0):
    return Limit(mechanism, place, "N", 1.0, 1.0, None, "predicted", "", times, False)


def test_every_mechanism_is_drawn_as_often_and_none_without_a_limit():
    limits = tuple(limit(m, f"storey{i}") for m in "abc" for i in range(4))
    limits += (limit("a", "roof", None), limit("d", "roof", None))
    picked = drawn(limits, 9, np.random.default_rng(1))
    assert [sum(p.mechanism == m for p in picked) for m in "abcd"] == [3, 3, 3, 0]
    assert len({(p.mechanism, p.place) for p in picked}) == 9
    assert all(p.times is not None for p in picked)
    assert picked == drawn(limits, 9, np.random.default_rng(1))


def test_effects_are_concealed_at_half_again_their_limit_and_counted(monkeypatch, tmp_path):
    asked = []

    def stub(case):
        asked.append(case)
        right = case.mechanism.place == "storey1"
        return {"findings": [[case.mechanism.name, "storey1"]] if right else [], "seconds": 1.0}

    monkeypatch.setattr(study_room, "diagnosed", stub)
    table = {**PLAN, "conceal": {"mechanisms": ["coulomb_friction"]}}
    table["recordings"] = [{**r, "at": "floor2", "duration_s": 8} for r in PLAN["recordings"]]
    twin, plan = Twin.load("two_storey_lumped"), plan_of(table)
    found = study(twin, plan, 2, None, tmp_path / "kept.jsonl")
    assert (found["found"], found["of"]) == (1, 2)
    assert len({case.seed for case in asked}) == 2
    limits = study_room.rehearse(twin, plan, seed=study_room.SEED).limits
    for case in asked:
        (own,) = (x for x in limits if x.place == case.mechanism.place)
        assert np.isclose(case.mechanism.values["force"], TIMES * own.limit)
    study(twin, plan, 2, None, tmp_path / "kept.jsonl")
    assert len(asked) == 2
