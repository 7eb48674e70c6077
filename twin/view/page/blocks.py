"""What a report is made of: sections of paragraphs, tables, commands and plots."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar

from twin.provenance import Provenance


@dataclass(frozen=True)
class Text:
    """A paragraph."""

    kind: ClassVar[str] = "text"
    text: str


@dataclass(frozen=True)
class Command:
    """A line for a shell."""

    kind: ClassVar[str] = "command"
    text: str


@dataclass(frozen=True)
class Items:
    """A list of sentences."""

    kind: ClassVar[str] = "items"
    items: Sequence[str]


@dataclass(frozen=True)
class Table:
    """A table; a cell's lines are kept."""

    kind: ClassVar[str] = "table"
    headers: Sequence[str]
    rows: Sequence[Sequence[str]]


@dataclass(frozen=True)
class Plot:
    """A figure that can be zoomed.

    Attributes:
        figure: data and layout as plotly takes them.
        caption: what is seen, in a sentence.
        keys: (name, colour) of what is drawn; clicking one hides it.
        link: plots of one name zoom their x axes together.
        wide: whether it takes the page's whole width.
        signs: letters such as "●" or "╌╌" for names that share their colour with others.
        pick: a command that frequencies of clicked points are appended to; nothing can be chosen
            without.
    """

    kind: ClassVar[str] = "plot"
    figure: Mapping[str, Any]
    caption: str
    keys: Sequence[tuple[str, str]] = ()
    link: str = ""
    wide: bool = True
    signs: Mapping[str, str] = field(default_factory=dict)
    pick: str = ""


Block = Text | Command | Items | Table | Plot


@dataclass(frozen=True)
class Section:
    """A heading and what stands under it; ``folded`` ones open at a click."""

    title: str
    blocks: Sequence[Block] = ()
    folded: bool = False


@dataclass(frozen=True)
class Page:
    """A report.

    Attributes:
        title: the result in one sentence.
        lead: a sentence below it.
        sections: in order.
        made: where it comes from.
    """

    title: str
    lead: str
    sections: Sequence[Section]
    made: Provenance
    language: str = field(default="en")
