"""EMPS, a real slide on a ball screw: simulated, recorded, read, inspected and identified.

The twin ``drive`` has one slide joint, a motor's force, viscous friction and no spring; its mass
and friction are round numbers that the recording replaces. The force was recorded in a closed
position loop and is the input all the same: the inverse model
F = M a + Fv v + Fc sign(v) + offset is linear in its parameters, its residual noise of the force.

    python -m experiments.emps --data ../shared/data/emps/DATA_EMPS.csv

Source: Janot, Gautier and Brunot, Data set and reference models of EMPS, 2019: mass 95.1 kg,
viscous 203.5 N s/m, Coulomb 20.4 N, offset -3.16 N.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, decimate, sosfiltfilt

from twin.formats import read_recording, write_recording
from twin.instruments import Instrument
from twin.laboratory import Analyser, Experiment, RandomShaking, run
from twin.model import Twin
from twin.recording import Recording

Array = NDArray[np.float64]

DATA = Path(__file__).parents[1].parent / "shared" / "data" / "emps" / "DATA_EMPS.csv"
PUBLISHED = {"mass": 95.1, "viscous": 203.5, "coulomb": 20.4, "offset": -3.16}
POSITION_HZ = 100.0
"""Corner of the position's filter: five times the loop's bandwidth, which is about 20 Hz."""
FORCE_HZ = 20.0
"""Corner of the filter that all columns pass before they are thinned out."""
STANDS = 0.002
"""Below this speed the sign of the friction is not known: such samples are left out [m/s]."""


@dataclass(frozen=True)
class Identified:
    """Parameters of the inverse model.

    Attributes:
        values: mass [kg], viscous [N s/m], coulomb [N], offset [N].
        std: their standard deviations.
        left: NRMSE of the force that is not explained.
    """

    values: Mapping[str, float]
    std: Mapping[str, float]
    left: float

    def as_json(self) -> dict[str, Any]:
        """Return plain types."""
        return {"values": dict(self.values), "std": dict(self.std), "left": self.left}


def inverse_model(recording: Recording, dry: bool = True) -> Identified:
    """Return the parameters by least squares on the inverse model.

    Args:
        recording: with ``force`` and ``position``.
        dry: with Coulomb friction and an offset besides mass and viscous friction.
    """
    rate = recording.sampling_hz
    corner = min(POSITION_HZ, 0.2 * rate)
    smooth = sosfiltfilt(butter(4, corner, fs=rate, output="sos"), recording.column("position"))
    v = np.gradient(smooth) * rate
    a = np.gradient(v) * rate
    columns = {"mass": a, "viscous": v}
    if dry:
        columns |= {"coulomb": np.sign(v), "offset": np.ones(len(v))}
    step = max(1, int(rate / (4 * FORCE_HZ)))
    keep = _thinned(np.abs(v), step) > STANDS
    keep[: round(0.1 * len(keep) / recording.duration_s) + 2] = False
    regressors = np.column_stack([_thinned(x, step) for x in columns.values()])[keep]
    force = _thinned(recording.column("force"), step)[keep]
    found, *_ = np.linalg.lstsq(regressors, force, rcond=None)
    rest = force - regressors @ found
    variance = float(rest @ rest) / (len(rest) - len(found))
    covariance = variance * np.linalg.inv(regressors.T @ regressors)
    return Identified(
        dict(zip(columns, map(float, found), strict=True)),
        dict(zip(columns, map(float, np.sqrt(np.diag(covariance))), strict=True)),
        float(np.sqrt(np.mean(rest**2) / np.mean(force**2))),
    )


def _thinned(values: Array, step: int) -> Array:
    return np.asarray(decimate(values, step, ftype="fir") if step > 1 else values)


def virtual(folder: Path, seed: int = 0) -> Path:
    """Shake the twin, record it as a file, and return its path."""
    excitation = RandomShaking(60.0, (0.2, 5.0))
    encoder = Instrument(bits=None, noise_std=1e-6)
    test = Experiment(
        excitation,
        "force",
        Analyser(1000.0, 30.0),
        instruments={"disp": encoder, "force": Instrument(noise_fraction=0.005)},
    )
    return write_recording(run(test, Twin.load("drive"), seed), folder / "drive_virtual.csv")


def inspected(model: str = "drive") -> dict[str, Any]:
    """Return the ports of the twin, its base and its rigid mode."""
    linear = Twin.load(model).linear(("force",), ("position",))
    squares = np.linalg.eigvals(np.linalg.solve(linear.M, linear.K)).real
    return {
        "ports": list(linear.ports),
        "bodies": {name: body.mass for name, body in linear.bodies.items()},
        "modes_hz": [float(f) for f in np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)],
    }


def arguments(description: str) -> argparse.Namespace:
    """Return where the recording is and where results go; that folder is made."""
    parser = argparse.ArgumentParser(description=description.splitlines()[0])
    parser.add_argument("--data", type=Path, default=DATA)
    parser.add_argument("--out", type=Path, default=Path("emps"))
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    return given


def main() -> None:
    """Run from the command line."""
    given = arguments(__doc__)
    found: dict[str, Any] = {"model": inspected()}
    found["virtual"] = inverse_model(read_recording(virtual(given.out)), dry=False).as_json()
    if given.data.exists():
        recording = read_recording(given.data)
        found["recording"] = {
            "channels": [channel.title for channel in recording.channels],
            "sampling_hz": recording.sampling_hz,
            "duration_s": recording.duration_s,
        }
        found["published"] = PUBLISHED
        found["measured"] = inverse_model(recording).as_json()
        found["measured_linear"] = inverse_model(recording, dry=False).as_json()
    else:
        found["skipped"] = f"{given.data}: no such file; the recording is not part of the project"
    text = json.dumps(found, indent=1) + "\n"
    (given.out / "emps.json").write_text(text, encoding="utf-8")
    print(text)


if __name__ == "__main__":
    main()
