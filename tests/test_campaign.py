from concurrent.futures import ThreadPoolExecutor
from threading import Event
from time import sleep

import pytest

from twin.campaign import campaign
from twin.errors import TwinError


def square(number):
    return {"square": number**2}


def test_an_executor_gives_what_the_loop_gives_in_the_order_of_the_tasks():
    tasks = {str(n): n for n in range(20)}
    with ThreadPoolExecutor(4) as executor:
        found = campaign(square, tasks, executor)
    assert found == campaign(square, tasks) == {str(n): {"square": n**2} for n in range(20)}
    assert list(found) == list(tasks)


def test_an_interrupted_campaign_does_the_rest_only(tmp_path):
    path, done = tmp_path / "results.jsonl", []

    def fragile(number):
        if number == 3 and len(done) == 3:
            raise KeyboardInterrupt
        done.append(number)
        return square(number)

    tasks = {str(n): n for n in range(5)}
    with pytest.raises(KeyboardInterrupt):
        campaign(fragile, tasks, results=path, identity="a")
    with path.open("a") as file:
        file.write('{"name": "3", "resu')  # cut off while it was written
    done.append("resumed")
    seen = []
    found = campaign(
        fragile, tasks, results=path, identity="a", progress=lambda n, of: seen.append((n, of))
    )
    assert done == [0, 1, 2, "resumed", 3, 4]
    assert found == campaign(square, tasks)
    assert seen == [(3, 5), (4, 5), (5, 5)]
    assert campaign(fragile, tasks, results=path, identity="a") == found
    assert done == [0, 1, 2, "resumed", 3, 4]


def test_the_results_of_another_campaign_are_refused(tmp_path):
    path = tmp_path / "results.jsonl"
    campaign(square, {"1": 1}, results=path, identity="a")
    with pytest.raises(TwinError, match=r"another campaign \(a\), this one is b"):
        campaign(square, {"1": 1}, results=path, identity="b")


@pytest.mark.parametrize("text", ["nothing\n", '{"x": 1}\n', "[]\n", "\n"])
def test_a_file_of_something_else_is_refused_and_kept(tmp_path, text):
    path = tmp_path / "results.jsonl"
    path.write_text(text)
    with pytest.raises(TwinError, match="no results of a campaign"):
        campaign(square, {"1": 1}, results=path)
    assert path.read_text() == text


def test_what_runs_beside_a_task_that_fails_is_kept(tmp_path):
    path, failed = tmp_path / "results.jsonl", Event()

    def fragile(number):
        if number == 1:
            failed.set()
            raise ValueError("task 1")
        assert failed.wait(20.0)
        sleep(0.2)  # the failure is known by then
        return square(number)

    tasks = {str(n): n for n in range(20)}
    with ThreadPoolExecutor(2) as executor, pytest.raises(ValueError, match="task 1"):
        campaign(fragile, tasks, executor, path, "a")
    kept = [line for line in path.read_text().splitlines() if "square" in line]
    assert '"name": "0"' in kept[0]
    assert len(kept) <= 2, "what waited is not begun"
