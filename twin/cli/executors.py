"""Where many pieces of work run: the options of the commands that have them, and the pool."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from typing import Annotated

import typer

from twin.errors import TwinError

Workers = Annotated[
    int, typer.Option("--workers", min=0, help="Processes; 0 for as many as there are cores.")
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        "--scheduler", metavar="ADDRESS", help="A Dask cluster that sees the folder of --out."
    ),
]


@contextmanager
def executor_of(workers: int, scheduler: str | None) -> Iterator[Executor]:
    """Give a pool of processes, or that of a Dask cluster."""
    if scheduler is None:
        # one thread of linear algebra a process, in the children and before they load it
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        # spawn: a fork would copy the progress bar's thread in whatever state it is
        with ProcessPoolExecutor(workers or os.cpu_count(), get_context("spawn")) as executor:
            yield executor
        return
    try:
        from distributed import Client
    except ImportError:
        raise TwinError(
            "--scheduler needs Dask: pip install 'frame-twin[cluster]', or leave it out"
        ) from None
    try:
        client = Client(scheduler, timeout=10)
    except (OSError, TimeoutError, ValueError) as error:
        raise TwinError(f"--scheduler {scheduler}: no Dask cluster there ({error})") from None
    with client:
        yield client.get_executor()
