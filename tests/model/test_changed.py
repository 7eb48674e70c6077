"""A mapping that changes its values when they are asked for."""

import pickle

import pytest

from twin.model.changed import Changed


def test_it_is_the_mapping_with_every_value_changed_and_the_new_ones_as_they_are():
    there = Changed({"a": 1, "b": 2}, lambda v: 10 * v, {"c": 3})
    assert dict(there) == {"a": 10, "b": 20, "c": 3}
    assert list(there) == ["a", "b", "c"]
    assert len(there) == 3
    assert "c" in there
    assert "d" not in there
    with pytest.raises(KeyError):
        there["d"]


def test_a_value_is_changed_once_and_only_where_it_is_asked_for():
    asked = []
    there = Changed({"a": 1, "b": 2}, lambda v: asked.append(v) or -v)
    assert (there["b"], there["b"]) == (-2, -2)
    assert asked == [2]


def test_a_new_value_takes_the_place_of_one_of_the_same_name():
    there = Changed({"a": 1, "b": 2}, lambda v: 10 * v, {"a": 3})
    assert dict(there) == {"a": 3, "b": 20}
    assert len(there) == 2


def test_it_goes_to_another_process_as_what_it_holds():
    there = pickle.loads(pickle.dumps(Changed({"a": 1}, lambda v: v + 1, {"b": 5})))
    assert there == {"a": 2, "b": 5}
