"""P-Delta: the flexible frame with gravity diagnosed with the lumped twin, and the test that tells.

Weight above a storey takes stiffness from it. On one frame that cannot be told from a softer
storey; a mass bolted on changes the weight and not the spring.
Writes experiments/results/p_delta.json.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

from twin.diagnosis.pipeline import diagnose
from twin.diagnosis.result import Diagnosis
from twin.diagnosis.verdict import TIE
from twin.files import write_whole
from twin.instruments import Instrument
from twin.laboratory import Analyser, Experiment, Hammer, RandomShaking, perform
from twin.mechanisms.mass import Mass
from twin.model import Twin
from twin.recording import Recording

TARGET = Path(__file__).resolve().parent / "results" / "p_delta.json"
NOISE = 0.005
BAND_HZ = (0.5, 12.0)


def record(rig: Twin, excitation: Hammer | RandomShaking, floor: str, seed: int) -> Recording:
    """Record a test on the true frame at 256 Hz."""
    instruments = {kind: Instrument(noise_fraction=NOISE) for kind in ("acc", "force")}
    analyser = Analyser(256.0, 26.0, None)
    recording = perform(Experiment(excitation, floor, analyser, None, instruments), rig, seed)
    return replace(recording.recording, source=f"test {seed}")


def show(diagnosis: Diagnosis) -> None:
    """Print findings, what ties with them, and the advice."""
    print(f"verdict: {diagnosis.verdict}; error on an unseen recording "
          f"{100 * diagnosis.fit.test.explained:.2f} %")  # fmt: skip
    for finding in diagnosis.findings:
        print(f"  {finding.mechanism.name:12s} {finding.location:9s} "
              f"{finding.mechanism.values}  p = {finding.probability:.2f}")  # fmt: skip
    for other in diagnosis.alternatives:
        if other.mechanism.name in ("p_delta", "stiffness") and other.probability >= TIE:
            print(f"  or {other.mechanism.name} at {other.location}: "
                  f"BIC {other.delta_bic:+.1f}, p = {other.probability:.2f}")  # fmt: skip
    if diagnosis.next_experiment is not None:
        print(f"  next: {diagnosis.next_experiment.command}")
        print(f"  ({diagnosis.next_experiment.reason})")


def kept(diagnosis: Diagnosis) -> dict[str, Any]:
    """Return what was said, as plain types."""
    advice = diagnosis.next_experiment
    return {
        "verdict": diagnosis.verdict,
        "findings": [
            {"mechanism": f.mechanism.name, "location": f.location, "probability": f.probability}
            for f in diagnosis.findings
        ],
        "ties": [
            {"mechanism": f.mechanism.name, "location": f.location, "probability": f.probability,
             "delta_bic": f.delta_bic}
            for f in diagnosis.alternatives
            if f.mechanism.name in ("p_delta", "stiffness") and f.probability >= TIE
        ],
        "unseen_error": diagnosis.fit.test.explained,
        "next_experiment": advice.command if advice is not None else None,
    }  # fmt: skip


def main() -> None:
    """Diagnose without and with a recording of the frame with a mass added."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--to", type=Path, default=TARGET)
    given = parser.parse_args()
    rig, model = Twin.load("two_storey"), Twin.load("two_storey_lumped")
    train = [
        record(rig, Hammer(0.008, 2.0), "floor1", 1),
        record(rig, RandomShaking(0.05, BAND_HZ), "floor2", 2),
        record(rig, RandomShaking(0.1, BAND_HZ), "floor1", 3),
        record(rig, Hammer(0.008, 3.0), "floor2", 4),
    ]
    test = [record(rig, RandomShaking(0.07, BAND_HZ), "floor2", 7)]
    print("as it stands")
    first = diagnose(model, train, test)
    show(first)
    loaded = rig.including(Mass("floor2", 0.44))
    extra = record(loaded, RandomShaking(0.1, BAND_HZ), "floor1", 11)
    print("with 0.44 kg added to floor2 in one more recording")
    second = diagnose(model, [*train, extra], test, added_mass={extra.source: {"floor2": 0.44}})
    show(second)
    said = {"as it stands": kept(first), "with 0.44 kg added to floor2": kept(second)}
    text = json.dumps({"command": "python experiments/p_delta.py", "said": said}, indent=1) + "\n"
    write_whole(given.to, lambda part: part.write_text(text))
    names = [f.mechanism.name for f in second.findings]
    sys.exit(0 if "p_delta" in names else 1)


if __name__ == "__main__":
    main()
