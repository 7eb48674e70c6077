"""What a rehearsal says: a table of limits, and the same as plain types."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from twin.errors import TwinError
from twin.files import write_whole
from twin.presentable import Presentable

Status = Literal["verified", "predicted", "not_found", "never"]

WORDS: dict[Status, str] = {
    "verified": "verified",
    "predicted": "predicted",
    "not_found": "not found so large",
    "never": "at no size",
}


@dataclass(frozen=True)
class Try:
    """One diagnosis of a concealed effect.

    Attributes:
        size: in the effect's unit; None for what has no size.
        found: whether mechanism and place stood first.
        said: what stood first instead, or the error in words.
        seconds: that the diagnosis took [s].
    """

    size: float | None
    found: bool
    said: str
    seconds: float


@dataclass(frozen=True)
class Limit:
    """From which size on an effect is found.

    Attributes:
        mechanism, place: of the effect.
        unit: of the sizes.
        predicted: the size from which it is to be expected, or None for no size at all.
        limit: the size from which it is found: the predicted one, or what diagnoses made of it;
            None where it is found at no size, or has none.
        share: the limit as a share, and of what, or None.
        status: what the limit rests on.
        mistaken_for: what it was, or is most easily, taken for below the limit; empty for nothing.
        shrinks: whether a stronger effect has a smaller number, as a level that clips has.
        times: the limit as a multiple of the effect's reference; None where there is no limit.
        tries: the diagnoses.
    """

    mechanism: str
    place: str
    unit: str
    predicted: float | None
    limit: float | None
    share: tuple[float, str] | None
    status: Status
    mistaken_for: str
    times: float | None
    shrinks: bool
    tries: tuple[Try, ...] = ()

    @property
    def in_words(self) -> str:
        """The limit with its unit."""
        if self.status == "never":
            return "-"
        if self.status == "not_found":
            size, beyond = self.tries[-1].size, "below" if self.shrinks else "above"
            return "-" if size is None else f"{beyond} {size:.3g} {self.unit}".rstrip()
        if self.limit is None:
            return "present"
        return f"{'at most ' if self.shrinks else ''}{self.limit:.3g} {self.unit}".rstrip()

    @property
    def share_in_words(self) -> str:
        """The share in per cent, and of what."""
        return "" if self.share is None else f"{100 * self.share[0]:.2g} % of {self.share[1]}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain types."""
        return {
            "mechanism": self.mechanism,
            "location": self.place,
            "unit": self.unit,
            "predicted": self.predicted,
            "limit": self.limit,
            "share": None if self.share is None else self.share[0],
            "share_of": None if self.share is None else self.share[1],
            "status": self.status,
            "mistaken_for": self.mistaken_for,
            "times": self.times,
            "tries": [
                {"size": t.size, "found": t.found, "said": t.said, "seconds": t.seconds}
                for t in self.tries
            ],
        }


@dataclass(frozen=True, repr=False)
class Rehearsal(Presentable):
    """The limits of a test plan on a twin.

    Attributes:
        source: the twin.
        limits: one for every mechanism and place.
        seed: of recordings and noise.
        recordings: how many the plan has.
    """

    source: str
    limits: tuple[Limit, ...]
    seed: int
    recordings: int

    def _title(self) -> str:
        return f"rehearsal on {self.source}: {len(self.limits)} effects"

    def _rows(self) -> Iterator[tuple[str, str]]:
        for limit in self.limits:
            words = [limit.in_words, limit.share_in_words, WORDS[limit.status]]
            if limit.mistaken_for:
                words.append(f"below: {limit.mistaken_for}")
            yield f"{limit.mechanism} at {limit.place}", ", ".join(filter(None, words))

    def to_dict(self) -> dict[str, Any]:
        """Return plain types."""
        return {
            "model": self.source,
            "seed": self.seed,
            "recordings": self.recordings,
            "limits": [limit.to_dict() for limit in self.limits],
        }

    def save(self, path: str | Path) -> Path:
        """Write this as JSON, whole or not at all, and return the path.

        Raises:
            TwinError: another suffix, or a failing disk.
        """
        file = Path(path)
        if file.suffix.lower() != ".json":
            raise TwinError(f"{file}: a rehearsal is written as .json, not as '{file.suffix}'")
        text = json.dumps(self.to_dict(), indent=1, allow_nan=False) + "\n"
        return write_whole(file, lambda part: part.write_text(text, encoding="utf-8"))
