"""An MJCF document in the making: elements with every digit of their numbers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

Value = str | float | Iterable[float]


def _number(value: float) -> str:
    """Fifteen significant digits, all that are sure to be the same on any machine."""
    value = float(value)
    if value == int(value) and abs(value) < 1e15:
        return str(int(value))
    return f"{value:.15g}"


def text_of(value: Value) -> str:
    """Return an attribute's text: a word as it is, numbers separated by blanks."""
    if isinstance(value, str):
        return value
    if isinstance(value, Iterable):
        return " ".join(_number(v) for v in value)
    return _number(value)


def add(parent: Element, tag: str, **attributes: Value) -> Element:
    """Append an element to ``parent``; a trailing underscore in an attribute is dropped."""
    written = {name.rstrip("_"): text_of(value) for name, value in attributes.items()}
    return ElementTree.SubElement(parent, tag, written)


def comment(parent: Element, text: str) -> None:
    """Append a comment to ``parent``."""
    parent.append(ElementTree.Comment(f" {text} "))


SECTIONS = (
    "compiler",
    "option",
    "statistic",
    "visual",
    "asset",
    "worldbody",
    "deformable",
    "tendon",
    "equality",
    "actuator",
    "sensor",
)


@dataclass(frozen=True)
class Document:
    """The sections of an MJCF file, in the order in which they are written."""

    root: Element

    @classmethod
    def new(cls, name: str) -> Document:
        """Return a document with empty sections."""
        root = Element("mujoco", {"model": name})
        for section in SECTIONS:
            add(root, section)
        return cls(root)

    def section(self, name: str) -> Element:
        """Return one of the sections."""
        found = self.root.find(name)
        assert found is not None, name
        return found

    def text(self) -> str:
        """Return the XML, indented, empty sections left out, ending in a newline."""
        root = ElementTree.fromstring(
            ElementTree.tostring(self.root),
            ElementTree.XMLParser(target=ElementTree.TreeBuilder(insert_comments=True)),
        )
        for child in list(root):
            if not child.attrib and not len(child):
                root.remove(child)
        ElementTree.indent(root)
        return ElementTree.tostring(root, encoding="unicode") + "\n"
