"""The end of ``twin demo``: a rig with a concealed effect, and a twin that finds it."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from twin.cli.common import made

MODEL = "two_storey_lumped"
STIFFNESS = 2e6
"""Of the concealed cubic spring in the first storey [N/m^3]."""
RATE_HZ, DURATION_S, NOISE = 256.0, 10.0, 0.005
BAND_HZ = (0.5, 12.0)


def find_concealed(target: Path, terminal: Console, seed: int) -> None:
    """Record three tests on the rig, diagnose them with the bare model, and write what is found."""
    from twin.diagnosis.pipeline import diagnose
    from twin.files import folder
    from twin.formats import write_recording
    from twin.instruments import Instrument
    from twin.laboratory import Analyser, Experiment, Hammer, RandomShaking, perform
    from twin.mechanisms.cubic_stiffness import CubicStiffness
    from twin.model import Twin
    from twin.view.diagnosis_rrd import write_diagnosis_rrd
    from twin.view.diagnosis_tables import print_diagnosis
    from twin.view.page.diagnosis import write_report

    folder(target)
    bare = Twin.load(MODEL)
    rig = bare.including(CubicStiffness("storey1", STIFFNESS))
    instruments = {kind: Instrument(noise_fraction=NOISE) for kind in ("acc", "force")}
    analyser = Analyser(RATE_HZ, DURATION_S)
    tests = {
        "train_1.csv": Experiment(Hammer(peak_n=10.0), "floor1", analyser, None, instruments),
        "train_2.csv": Experiment(
            RandomShaking(0.3, BAND_HZ), "floor2", analyser, None, instruments
        ),
        "unseen.csv": Experiment(
            RandomShaking(0.2, BAND_HZ), "floor1", analyser, None, instruments
        ),
    }
    with terminal.status("recording a rig in which something is concealed"):
        recordings = [
            perform(test, rig, seed + number).recording
            for number, test in enumerate(tests.values())
        ]
    paths = [
        write_recording(recording, target / name)
        for name, recording in zip(tests, recordings, strict=True)
    ]
    with terminal.status("diagnosing") as status:
        found = diagnose(bare, recordings[:2], recordings[2:], seed=seed, tell=status.update)
        paths.append(found.explained.export(target / "explained_twin.xml"))
        paths.append(write_report(found, target / "diagnosis.html", made(paths[:3], seed)))
        paths.append(write_diagnosis_rrd(found, target / "diagnosis.rrd"))
    print_diagnosis(terminal, found)
    terminal.print(f"written: {', '.join(str(p) for p in paths)}")
