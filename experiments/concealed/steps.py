"""The three steps of a case, each with only what it may know: conceal, diagnose, open."""

from __future__ import annotations

import json
import shutil
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from twin.errors import TwinError
from twin.files import write_whole

from .case import case_name, generate
from .guard import guarded
from .kept import read_kept
from .reference import reference
from .score import score
from .seal import open_seal
from .structures.cases import reference_of
from .tables import STRUCTURES

Diagnose = Callable[..., dict[str, Any]]
"""diagnose(model, train, test, out, seed) -> the JSON of ``twin diagnose``."""

TOLERANCE = 0.004
"""What a diagnosis is told of the drawing: a little more than rigs are off by (``MASS_SPREAD``)."""

STARTING = ("twin.diagnosis.pipeline",)
"""What starts a process when it is imported (MuJoCo's window library asks for its own version)."""

KEPT = ("verdict", "findings", "alternatives", "fit", "fit_ahead", "seconds", "error", "made_with")
SEEN = (
    "table", "model", "effects", "expected", "mechanism", "location", "parameters", "form",
    "noise", "style", "effect_over_noise", "evidence",
)  # fmt: skip


@dataclass(frozen=True)
class Concealing:
    """A case to generate."""

    table: str
    number: int
    seed: int
    recordings: Path
    sealed: Path


@dataclass(frozen=True)
class Blind:
    """A case to diagnose: no seed, no truth, and no number beyond the name of its folder.

    Attributes:
        recordings: folder of the case's recordings.
        model: a shipped model's name, or a file of that folder.
        kept: where the diagnosis goes.
        refused: what may not be read meanwhile.
        until: the Unix time after which it is not started [s].
        made_with: versions, stored with the diagnosis.
        diagnose: a function of a module; None is that of ``twin diagnose``.
    """

    recordings: Path
    model: str
    kept: Path
    refused: tuple[Path, ...]
    until: float = float("inf")
    made_with: Mapping[str, str] = field(default_factory=dict)
    diagnose: Diagnose | None = None


@dataclass(frozen=True)
class Opening:
    """A case that is diagnosed, to open and to score."""

    truth: Path
    digest: str
    recordings: Path
    kept: Path


def conceal(task: Concealing) -> dict[str, Any]:
    """Generate a case; return the SHA-256 of its truth and the model that is handed out.

    On one thread of BLAS: with more, the last digits change, and the SHA-256 with them.
    """
    with threadpool_limits(1, "blas"):
        digest = generate(task.number, task.seed, task.recordings, task.sealed, task.table)
    path = task.sealed / f"{case_name(task.number, task.table)}.json"
    return {"sha256": digest, "model": open_seal(path, digest)["model"]}


def diagnose_blind(task: Blind) -> dict[str, Any]:
    """Diagnose a case under guard and store what was found; a failure is stored, too.

    The diagnosis gets copies in a folder whose name says nothing. Returns whether it was done: a
    case is left alone once the time is up.
    """
    if time.time() > task.until:
        return {"done": False}
    found = {**_diagnosed(task), "made_with": dict(task.made_with)}
    text = json.dumps(found, indent=1) + "\n"
    write_whole(task.kept, lambda part: part.write_text(text))
    return {"done": True}


def open_and_score(task: Opening) -> dict[str, Any]:
    """Open the seal of a case whose diagnosis is stored, and score.

    Raises:
        TwinError: there is no diagnosis yet, or the truth is not the one that was sealed.
    """
    diagnosis = read_kept(task.kept)
    if diagnosis is None:
        raise TwinError(f"{task.kept}: no diagnosis: the seal stays closed")
    truth = open_seal(task.truth, task.digest)
    in_structure = truth["table"] in STRUCTURES
    reached = reference_of(truth) if in_structure else reference(truth, task.recordings)
    return {
        "truth": {key: truth[key] for key in SEEN if key in truth},
        "diagnosis": {key: diagnosis[key] for key in KEPT if key in diagnosis},
        "reference": reached,
        "score": score(truth, diagnosis, reached),
    }


def of_the_command() -> Diagnose:
    """Return the diagnosis of ``twin diagnose``.

    Raises:
        TwinError: there is none.
    """
    try:
        module = import_module("twin.cli.diagnose")
    except ImportError as error:
        raise TwinError(f"there is no diagnosis to test ({error})") from None
    return partial(module.diagnose_files, tolerance=TOLERANCE)


def _diagnosed(task: Blind) -> dict[str, Any]:
    diagnose = task.diagnose or of_the_command()
    for name in STARTING:
        import_module(name)
    began = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="twin-") as name:
        folder = Path(shutil.copytree(task.recordings, Path(name) / "case"))
        given = folder / task.model
        model = str(given) if given.is_file() else task.model
        train, test = sorted(folder.glob("train_*.csv")), sorted(folder.glob("test_*.csv"))
        found: dict[str, Any]
        with guarded(*task.refused, task.recordings.parent) as attempts:
            try:
                found = diagnose(model, train, test, None, 0)
            except Exception as error:  # whatever it is, the case counts as a miss
                found = {"error": f"{type(error).__name__}: {error}"}
    if attempts:  # even where the diagnosis swallowed the refusal
        found = {"error": f"SealedError: refused while diagnosing: {attempts[0]}"}
    return {"seconds": time.perf_counter() - began, **found}
