"""Many pieces of work on any executor, resumable from a file of results."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from concurrent.futures import Executor, Future, as_completed
from pathlib import Path
from typing import Any, TypeVar

from twin.errors import TwinError

Task = TypeVar("Task")
Result = dict[str, Any]


def campaign(
    work: Callable[[Task], Result],
    tasks: Mapping[str, Task],
    executor: Executor | None = None,
    results: Path | None = None,
    identity: str = "",
    progress: Callable[[int, int], None] | None = None,
) -> dict[str, Result]:
    """Do the work on every task that has no result yet.

    Args:
        work: gives a result of plain types; a function of a module, so that processes find it.
        tasks: by name; the name stands for all that decides the result.
        executor: where it runs: a process pool, Dask's; None runs one after the other, here.
        results: file of results, one JSON object a line, appended to as they come; what it holds
            is not done again. None keeps nothing.
        identity: of the campaign; a file that belongs to another one is refused.
        progress: told how many are done, of how many.

    Returns:
        The results by name, in the order of ``tasks``, whatever order they came in.

    Raises:
        TwinError: the file belongs to another campaign, or cannot be read or written.
    """
    done = _read(results, identity) if results is not None else {}
    waiting = {name: task for name, task in tasks.items() if name not in done}
    found = {name: done[name] for name in tasks if name in done}

    def keep(name: str, result: Result) -> None:
        found[name] = result
        if results is not None:
            _append(results, {"name": name, "result": result})
        if progress is not None:
            progress(len(found), len(tasks))

    if progress is not None:
        progress(len(found), len(tasks))
    if executor is None:
        for name, task in waiting.items():
            keep(name, work(task))
    else:
        futures: dict[Future[Result], str] = {
            executor.submit(work, task): name for name, task in waiting.items()
        }
        failed: Exception | None = None
        try:
            for future in as_completed(futures):
                if failed is not None and future.cancelled():
                    continue
                try:
                    keep(futures[future], future.result())
                except Exception as error:  # what runs beside it is kept, what waits is not begun
                    failed = failed or error
                    for other in futures:
                        other.cancel()
        finally:
            for future in futures:
                future.cancel()
        if failed is not None:
            raise failed
    return {name: found[name] for name in tasks}


def _read(path: Path, identity: str) -> dict[str, Result]:
    """Return the results in a file; start the file where there is none."""
    if not path.exists():
        _append(path, {"campaign": identity})
        return {}
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise TwinError(f"{path}: cannot read these results ({error})") from None
    lines = text.split("\n")
    whole, last = lines[:-1], lines[-1]  # an interruption may have cut the last line off
    try:
        entries = [json.loads(line) for line in whole]
        theirs = entries[0]["campaign"]
        found = {entry["name"]: entry["result"] for entry in entries[1:]}
    except (ValueError, KeyError, IndexError, TypeError):
        raise TwinError(f"{path}: no results of a campaign") from None
    if theirs != identity:
        raise TwinError(
            f"{path}: holds the results of another campaign ({theirs}), this one is {identity}; "
            "remove the file or choose another folder"
        )
    if last:
        path.write_text("\n".join(whole) + "\n", encoding="utf-8")
    return found


def _append(path: Path, entry: dict[str, Any]) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("a", encoding="utf-8") as file:
            file.write(json.dumps(entry, allow_nan=False) + "\n")
    except OSError as error:
        raise TwinError(f"{path}: cannot write ({error.strerror})") from None
