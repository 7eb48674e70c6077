"""A plan is read from TOML and JSON; what is wrong is one line that names the key."""

import json

import pytest
from rehearsal_support import SHAKEN, plan, table

from twin.errors import TwinError
from twin.rehearsal.plan import Noise, plan_of, read_plan


def test_toml_and_json_say_the_same(tmp_path):
    (tmp_path / "plan.json").write_text(json.dumps(table()))
    rows = "\n".join(
        "[[recordings]]\n" + "\n".join(f"{k} = {json.dumps(v)}" for k, v in entry.items())
        for entry in table()["recordings"]
    )
    (tmp_path / "plan.toml").write_text(
        "tolerance = 0.01\n[noise]\nacc = 0.005\nforce = 0.005\n[conceal]\n"
        'mechanisms = ["coulomb_friction"]\nplaces = ["storey1", "storey2"]\n' + rows
    )
    assert read_plan(tmp_path / "plan.json") == read_plan(tmp_path / "plan.toml") == plan()


def test_noise_is_a_share_or_in_the_channels_unit():
    made = plan(noise={"acc": 0.01, "acc_floor2": {"std": 0.2, "share": 0.0}})
    assert made.noise == {"acc": Noise(0.01, 0.0), "acc_floor2": Noise(0.0, 0.2)}


def test_a_recording_can_be_repeated():
    made = plan(recordings=[{**SHAKEN, "repeat": 3}, {**SHAKEN, "use": "test"}])
    assert [test.use for test in made.recordings] == ["train"] * 3 + ["test"]


WRONG = {
    "recordings[1].level": {"recordings": [{**SHAKEN, "level": -1}]},
    "recordings[1].duration_s": {"recordings": [{**SHAKEN, "duration_s": "long"}]},
    "recordings[2].rate_hz": {"recordings": [SHAKEN, {**SHAKEN, "rate_hz": float("nan")}]},
    "recordings[1].kind": {"recordings": [{**SHAKEN, "kind": "push"}]},
    "recordings[1].use": {"recordings": [{**SHAKEN, "use": "both"}]},
    "recordings[1].at": {"recordings": [{k: v for k, v in SHAKEN.items() if k != "at"}]},
    "recordings[1].band_hz": {"recordings": [{**SHAKEN, "band_hz": [12, 0.5]}]},
    "recordings[1].repeat": {"recordings": [{**SHAKEN, "repeat": 0}]},
    "recordings[1].lenght": {"recordings": [{**SHAKEN, "lenght": 3}]},
    "recordings[1].ground": {"recordings": [{**SHAKEN, "ground": ["x"]}]},
    "recordings[2]": {"recordings": [SHAKEN, 3]},
    "recordings: none has use = 'test'": {"recordings": [SHAKEN]},
    "recordings: expected": {"recordings": []},
    "tolerance": {"tolerance": 0},
    "sensors": {"sensors": [1]},
    "noise.acc.share": {"noise": {"acc": -0.1}},
    "noise.acc.sd": {"noise": {"acc": {"sd": 0.1}}},
    "conceal.mechanisms": {"conceal": {"mechanisms": ["gremlin"]}},
    "conceal.sizes.mass": {"conceal": {"sizes": {"mass": [0.2, 0.1]}}},
    "conceal.values.clearance.slack": {"conceal": {"values": {"clearance": {"slack": 1}}}},
    "colour": {"colour": "red"},
}


@pytest.mark.parametrize("key", WRONG)
def test_the_error_names_the_key(key):
    with pytest.raises(TwinError) as error:
        plan_of(table(**WRONG[key]), "plan.toml")
    assert str(error.value).startswith(f"plan.toml: {key}")
    assert "\n" not in str(error.value)


def test_a_file_that_is_neither_is_told(tmp_path):
    (tmp_path / "plan.toml").write_text("recordings = [")
    for name, words in (("plan.toml", "neither TOML"), ("none.toml", "cannot read")):
        with pytest.raises(TwinError, match=words):
            read_plan(tmp_path / name)
