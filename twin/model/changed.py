"""A mapping whose values are changed when they are asked for.

A model with one more coordinate has every port and body on one more column; the estimate makes such
models by the thousand and asks each for one or two of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Generic, TypeVar

Value = TypeVar("Value")


class Changed(Mapping[str, Value], Generic[Value]):
    """The values of another mapping, each changed once, at its first use.

    Args:
        source: the other mapping.
        change: returns a value's replacement.
        new: values that come after them, as they are.
    """

    def __init__(
        self,
        source: Mapping[str, Value],
        change: Callable[[Value], Value],
        new: Mapping[str, Value] | None = None,
    ) -> None:
        self._source, self._change, self._new = source, change, dict(new or {})
        self._known = dict(self._new)

    def __getitem__(self, name: str) -> Value:
        if name not in self._known:
            self._known[name] = self._change(self._source[name])
        return self._known[name]

    def __contains__(self, name: object) -> bool:
        return name in self._new or name in self._source

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys([*self._source, *self._new]))

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def __reduce__(self) -> tuple[type[dict[str, Value]], tuple[dict[str, Value]]]:
        """Be copied to other processes as a plain dictionary: a change need not be able to."""
        return dict, (dict(self),)
