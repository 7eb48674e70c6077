"""Write docs/mechanisms.md, the catalogue of mechanisms, from their own files.

python docs/catalogue.py
"""

from __future__ import annotations

import sys
from inspect import getdoc
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from twin.estimation.laws import memory_along
from twin.mechanisms import vocabulary
from twin.mechanisms.mechanism import ChannelFault, Disturbance, Law, Mechanism
from twin.mechanisms.surroundings import Surroundings

HERE = Path(__file__).parent
SECONDS, RATE_HZ, TONE_HZ, AMPLITUDE = 4.0, 500.0, 1.0, 2e-3
ON = {
    "drift": "a relative motion (joint, tendon)",
    "motion": "an absolute motion (body, site)",
    "body": "a body",
    "base": "the base",
    "channel": "a channel",
    "channels": "two channels",
    "actuator": "a joint that a motor drives",
}
FAMILIES = (
    ("Laws: forces that are not linear", Law),
    ("Changes of the structure", None),
    ("Forces that nobody measured", Disturbance),
    ("Instruments and motors", ChannelFault),
)


def family(cls: type[Mechanism]) -> type[Mechanism] | None:
    """Return the family a mechanism is listed under."""
    kinds = (Law, Disturbance, ChannelFault)
    return next((kind for kind in kinds if issubclass(cls, kind)), None)


def motion() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return time, drift and rate of a vibration that grows."""
    time = np.arange(0, SECONDS, 1 / RATE_HZ)
    size = AMPLITUDE * time / SECONDS
    drift = size * np.sin(2 * np.pi * TONE_HZ * time)
    return time, drift, np.gradient(drift, time)


def example(cls: type[Mechanism]) -> Mechanism | None:
    """Return a mechanism as a fit would begin with it."""
    time, drift, rate = motion()
    around = Surroundings(
        500.0, 0.3, 1.0, 1.0, 0.3, drift, rate, drift, (2.0, 7.0), SECONDS, RATE_HZ, (3.0,)
    )
    del time
    found = cls.starts("storey1", around)
    return found[0] if found else None


def picture(law: Law, path: Path) -> None:
    """Draw a law's force against the drift and against the rate of a growing vibration."""
    from matplotlib.figure import Figure

    time, drift, rate = motion()
    z = memory_along(law.compiled, np.array(law.numbers), drift)
    force = law.force(drift, rate, z, time) + 0 * drift
    figure = Figure(figsize=(6.4, 2.4), layout="constrained")
    for ax, x, name in zip(
        figure.subplots(1, 2, sharey=True), (1e3 * drift, 1e3 * rate),
        ("drift [mm]", "rate [mm/s]"), strict=True,
    ):  # fmt: skip
        ax.plot(x, force, color="#D55E00", lw=1.2)
        ax.set_xlabel(name)
        ax.grid(alpha=0.3)
    figure.axes[0].set_ylabel("force [N]")
    figure.savefig(path, dpi=100, metadata={"Software": None})


def entry(cls: type[Mechanism]) -> str:
    """Return a mechanism's part of the page."""
    module = sys.modules[cls.__module__].__doc__ or ""
    gist = module.strip().split("\n")[0]
    text = getdoc(cls) or ""
    said = text.split("\nAttributes:")[0].split("\nSource:")[0].strip()
    lines = [f"### `{cls.name}`", "", gist, "", said, "", f"Sits on {ON[cls.on]}. "
             f"Verdict: `{cls.verdict}`. Reference: {cls.reference}.", ""]  # fmt: skip
    if cls.parameters:
        lines += ["| parameter | unit | meaning |", "|---|---|---|"]
        lines += [f"| `{n}` | {p.unit} | {p.meaning} |" for n, p in cls.parameters.items()]
        lines.append("")
    if issubclass(cls, Law):
        lines += [f"![{cls.name} against drift and rate](mechanisms/{cls.name}.png)", ""]
    if cls.mjcf:
        lines += [f"In the exported MJCF: {cls.mjcf}.", ""]
    return "\n".join(lines)


def page() -> str:
    """Return the page as Markdown."""
    everything = vocabulary()
    parts = [
        "# Mechanisms",
        "",
        f"The {len(everything)} mechanisms that a diagnosis can name, written from their own files "
        "by `python docs/catalogue.py`. Pictures: a vibration of 1 Hz that grows to 2 mm, with the "
        "parameters a fit would begin with.",
        "",
    ]
    for title, kind in FAMILIES:
        members = [cls for cls in everything.values() if family(cls) is kind]
        parts += [f"## {title}", "", *(entry(cls) for cls in members)]
    return "\n".join(parts).rstrip() + "\n"


def main() -> None:
    """Write the page and the pictures of the laws."""
    folder = HERE / "mechanisms"
    folder.mkdir(exist_ok=True)
    for cls in vocabulary().values():
        law = example(cls) if issubclass(cls, Law) else None
        if isinstance(law, Law):
            picture(law, folder / f"{cls.name}.png")
    (HERE / "mechanisms.md").write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
