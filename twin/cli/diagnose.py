"""``twin diagnose``: what physics a twin lacks, and the twin that has it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from twin.cli.common import (
    Json,
    Out,
    Rerun,
    Seed,
    check_folder,
    check_json_target,
    console,
    folder,
    made,
    watched,
    write_json,
)
from twin.errors import TwinError

if TYPE_CHECKING:
    from twin.diagnosis.result import Diagnosis
    from twin.provenance import Provenance
    from twin.recording import Recording

DEFAULT_FOLDER = Path("twin-diagnosis")
TWIN_FILE = "explained_twin.xml"


def register(app: typer.Typer) -> None:
    """Add the command."""
    example = (
        "Example: `twin diagnose two_storey_lumped --train hits/hammer_floor1_01.csv "
        "hits/hammer_floor1_02.csv --test hits/hammer_floor1_03.csv --out found`"
    )
    app.command("diagnose", epilog=example)(diagnose)


def diagnose(
    model: Annotated[str, typer.Argument(help="MJCF file, or a shipped model's name.")],
    train: Annotated[
        list[Path], typer.Option("--train", metavar="FILE...", help="Recordings to explain.")
    ],
    test: Annotated[
        list[Path], typer.Option("--test", metavar="FILE...", help="Unseen recordings.")
    ],
    tolerance: Annotated[
        float | None,
        typer.Option(
            "--tolerance", min=0.01, max=100.0,
            help="How well masses and stiffnesses of the model are known [%]; by default what "
            "the recordings show, 1 at least.",
        ),
    ] = None,
    damping_tolerance: Annotated[
        float | None,
        typer.Option(
            "--damping-tolerance", min=0.1, max=500.0,
            help="How well its dampings are known [%]; 10 by default.",
        ),
    ] = None,
    added_mass: Annotated[
        list[str] | None,
        typer.Option(
            "--added-mass", metavar="FILE:PLACE=KG",
            help="Mass that was bolted on for a recording; repeat.",
        ),
    ] = None,
    unknown_parameters: Annotated[
        bool,
        typer.Option(
            "--unknown-parameters",
            help="The model's masses, stiffnesses and dampings are not known: identify them first.",
        ),
    ] = False,
    out: Out = None,
    seed: Seed = 0,
    json: Json = None,
    rerun: Rerun = False,
) -> None:  # fmt: skip
    """Say where recordings and twin differ, what physics was left out, and model it.

    The recordings after --train calibrate the twin, locate the mismatch and identify its law. Those
    after --test are kept for validation: the extended twin only predicts them. Writes the extended
    twin as MJCF, the diagnosis as JSON, an HTML report and one Rerun recording.
    """
    check_json_target(json)
    terminal = console(json)
    target = check_folder(out or DEFAULT_FOLDER)
    masses = masses_of(added_mass or [], [*train, *test])
    from rich.status import Status

    from twin.diagnosis.result import as_json
    from twin.view.diagnosis_tables import print_diagnosis

    with watched(rerun) as viewer:
        with Status("reading", console=terminal) as status:

            def tell(message: str) -> None:
                status.update(message)
                if viewer is not None:
                    viewer.tell(message)

            result = run(
                model, train, test, seed, tell, _share(tolerance), _share(damping_tolerance),
                masses, unknown_parameters,
                (lambda recording: None) if viewer is None else viewer.show,
            )  # fmt: skip
            path = result.explained.export(target / TWIN_FILE)
            document = as_json(result, str(path))
            write_json(document, str(target / "diagnosis.json"))
            tell("drawing")
            files = _show(result, target, made([model, *train, *test], seed))
            if viewer is not None:
                from twin.view.diagnosis_rrd import log_diagnosis

                log_diagnosis(viewer.stream, result, viewer.stream.send_blueprint)
        print_diagnosis(terminal, result)
        written = [path, target / "diagnosis.json", *files]
        terminal.print(f"written: {', '.join(str(p) for p in written)}")
        write_json(document, json)


def _show(result: Diagnosis, target: Path, origin: Provenance) -> list[Path]:
    from twin.view.diagnosis_rrd import write_diagnosis_rrd
    from twin.view.page.diagnosis import write_report

    report, recording = target / "diagnosis.html", target / "diagnosis.rrd"
    write_report(result, report, origin)
    write_diagnosis_rrd(result, recording)
    return [report, recording]


def run(
    model: str,
    train: Sequence[Path],
    test: Sequence[Path],
    seed: int = 0,
    tell: Callable[[str], None] = lambda message: None,
    tolerance: float | None = None,
    damping_tolerance: float | None = None,
    added_mass: Mapping[str, Mapping[str, float]] | None = None,
    unknown: bool = False,
    seen: Callable[[Recording], None] = lambda recording: None,
) -> Diagnosis:
    """Read model and recordings and diagnose; ``seen`` is told of each recording first."""
    from twin.diagnosis.pipeline import diagnose as whole
    from twin.formats import read_recording
    from twin.model import Twin

    twin = Twin.load(model)
    known, unseen = ([read_recording(path) for path in paths] for paths in (train, test))
    for recording in (*known, *unseen):
        seen(recording)
    return whole(
        twin,
        known,
        unseen,
        tolerance=tolerance,
        damping_tolerance=damping_tolerance,
        added_mass=added_mass,
        unknown=unknown,
        seed=seed,
        tell=tell,
    )


def _share(percent: float | None) -> float | None:
    return None if percent is None else percent / 100


def diagnose_files(
    model: str, train: list[Path], test: list[Path], out: Path | None = None, seed: int = 0,
    tolerance: float | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Diagnose files and return the JSON of the contract; the twin is written where ``out`` is."""
    from twin.diagnosis.result import as_json

    result = run(model, train, test, seed, tolerance=tolerance)
    path = None
    if out is not None:
        path = str(result.explained.export(folder(out) / TWIN_FILE))
    return as_json(result, path)


def masses_of(options: Sequence[str], files: Sequence[Path]) -> dict[str, dict[str, float]]:
    """Read "FILE:floor2=0.5" options: recording's source -> place -> mass [kg].

    Raises:
        TwinError: an option that cannot be read, or a file that is not among the recordings.
    """
    out: dict[str, dict[str, float]] = {}
    names = {str(path): path for path in files} | {path.name: path for path in files}
    for option in options:
        file, _, rest = option.rpartition(":")
        place, _, value = rest.partition("=")
        try:
            mass = float(value)
            if not isfinite(mass):
                raise ValueError
        except ValueError:
            raise TwinError(
                f"--added-mass {option}: expected FILE:PLACE=KG, as in test.csv:floor2=0.5"
            ) from None
        if file not in names:
            raise TwinError(
                f"--added-mass {option}: '{file}' is no recording of this diagnosis; "
                f"there are {', '.join(sorted(p.name for p in files))}"
            )
        out.setdefault(names[file].name, {})[place] = mass
    return out
