"""A campaign that is killed again and again loses nothing and counts nothing twice."""

import json
import multiprocessing
import random
import shutil
import signal
import time
from pathlib import Path

import pytest
import quick_campaign

from experiments.concealed.kept import mend, read_kept
from twin.errors import TwinError

KILLS = 60
"""More than that many times nobody is killed."""


def server():
    """Return where processes start that have all imported already."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["quick_campaign"])
    return context


def state(out):
    """Return how far a campaign is: that changes with every step of it."""
    files = ("sealed/digests.jsonl", "sealed/manifest.json", "results.jsonl", "summary.json")
    sizes = [(out / name).stat().st_size for name in files if (out / name).exists()]
    folders = [out / "recordings", out / "sealed", out / "diagnoses"]
    return [*sizes, *(len(list(f.rglob("*"))) for f in folders if f.exists())]


def killed_after_some_steps(context, out, rng):
    """Kill a campaign at a random moment within its next steps; False once it has ended."""
    before, process = state(out), context.Process(target=quick_campaign.main, args=(out,))
    process.start()
    steps = rng.randrange(1, 30)
    while process.is_alive() and steps:
        now = state(out)
        steps -= now != before
        before = now
        time.sleep(0.003)
    time.sleep(rng.uniform(0, 0.02))
    process.kill()
    process.join()
    assert process.exitcode in (0, -signal.SIGKILL)
    return process.exitcode != 0


def lines(path):
    return [json.loads(line) for line in path.read_text().splitlines()]


def test_killed_at_random_nothing_is_lost_and_nothing_counted_twice(tmp_path):
    whole, out = tmp_path / "whole", tmp_path / "killed"
    expected = quick_campaign.main(whole)
    rng = random.Random(1)
    kills, context = 0, server()
    while kills < KILLS and killed_after_some_steps(context, out, rng):
        kills += 1
        for path in (out / "diagnoses").glob("case*.json"):
            json.loads(path.read_text())  # nothing half-written has a diagnosis' name
        if kills == 5:
            out = Path(shutil.move(out, tmp_path / "elsewhere"))  # as to another machine
    assert kills >= 3
    found = quick_campaign.main(out)
    assert found == expected
    for name in ("sealed/digests.jsonl", "results.jsonl"):
        names = [entry["name"] for entry in lines(out / name)[1:]]
        assert sorted(names) == sorted(expected)
    for path in (*whole.glob("sealed/*_*.json"), *whole.glob("recordings/*/*.csv")):
        assert path.read_bytes() == (out / path.relative_to(whole)).read_bytes()
    sums = [json.loads((f / "sealed/manifest.json").read_text())["sha256"] for f in (whole, out)]
    assert sums[0] == sums[1]
    assert not [p for p in out.rglob(".part-*") if p.parent.parent.name != "recordings"]


@pytest.mark.parametrize("cut", [0.02, 0.3, 0.7, 0.99])
@pytest.mark.parametrize("name", ["sealed/digests.jsonl", "results.jsonl"])
def test_a_half_written_line_is_done_again(tmp_path, name, cut):
    expected = quick_campaign.main(tmp_path, {"none": 2})
    path = tmp_path / name
    content = path.read_bytes()
    path.write_bytes(content[: int(cut * len(content))])
    assert quick_campaign.main(tmp_path, {"none": 2}) == expected
    assert len(lines(path)) == 3


def test_a_truth_without_its_digest_is_written_again(tmp_path):
    expected = quick_campaign.main(tmp_path, {"none": 2})
    path = tmp_path / "sealed" / "digests.jsonl"
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:2]))
    (tmp_path / "sealed" / "none_0002.json").write_text("half")
    assert quick_campaign.main(tmp_path, {"none": 2}) == expected


def test_another_truth_than_that_of_the_manifest_is_refused(tmp_path):
    quick_campaign.main(tmp_path, {"none": 1})
    path = tmp_path / "sealed" / "manifest.json"
    manifest = json.loads(path.read_text())
    manifest["sha256"]["none_0001"] = "0" * 64
    path.write_text(json.dumps(manifest))
    with pytest.raises(TwinError, match="another truth was written for none_0001"):
        quick_campaign.main(tmp_path, {"none": 1})
    path.write_text("{")
    with pytest.raises(TwinError, match="no manifest of a campaign"):
        quick_campaign.main(tmp_path, {"none": 1})


def test_mending_keeps_whole_lines_and_only_those(tmp_path):
    path = tmp_path / "lines.jsonl"
    mend(path)
    assert not path.exists()
    for content, left in ((b"a\nb\nc", b"a\nb\n"), (b"a\n", b"a\n")):
        path.write_bytes(content)
        mend(path)
        assert path.read_bytes() == left
    path.write_bytes(b"a")
    mend(path)
    assert not path.exists()
    path.write_text('{"verdict"')
    assert read_kept(path) is None
