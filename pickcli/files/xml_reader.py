"""XML read safely by the standard library's expat: no DTD, bounded size and depth, every element's line."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from pickcli.errors import InputError
from pickcli.files.bounded_reading import read_text
from pickcli.files.file_kind import URDF

MAX_BYTES = 10_000_000
MAX_DEPTH = 64


@dataclass(eq=False)
class Element:
    """One element: tag, attributes, children, and where it starts."""

    path: Path
    line: int
    tag: str
    attributes: dict[str, str]
    children: list[Element] = field(default_factory=list)

    def error(self, text: str) -> InputError:
        """An error that names this element's place and, if it has one, its name."""
        name = f" {self.attributes['name']!r}" if "name" in self.attributes else ""
        return InputError(f"{self.path}:{self.line}: <{self.tag}>{name}: {text}")

    def all(self, tag: str) -> list[Element]:
        """The children with that tag."""
        return [child for child in self.children if child.tag == tag]

    def optional(self, tag: str) -> Element | None:
        """The only child with that tag, or None. Raises InputError if there are several."""
        found = self.all(tag)
        if len(found) > 1:
            raise found[1].error(f"stands twice in <{self.tag}>; keep one")
        return found[0] if found else None

    def one(self, tag: str) -> Element:
        """The only child with that tag. Raises InputError if there is none."""
        found = self.optional(tag)
        if found is None:
            raise self.error(f"has no <{tag}>; add it")
        return found

    def text(self, attribute: str) -> str:
        """An attribute. Raises InputError if it is missing or empty."""
        value = self.attributes.get(attribute, "").strip()
        if not value:
            raise self.error(f"attribute {attribute!r} is missing; add it")
        return value

    def numbers(self, attribute: str, n: int) -> tuple[float, ...]:
        """An attribute of ``n`` finite numbers. Raises InputError."""
        text = self.text(attribute)
        try:
            values = tuple(float(part) for part in text.split())
        except ValueError:
            values = ()
        if len(values) != n or not all(map(math.isfinite, values)):
            raise self.error(f"{attribute}: expected {n} finite number{'s' * (n > 1)}, got {text!r}")
        return values

    def number(self, attribute: str) -> float:
        """An attribute that is one finite number. Raises InputError."""
        return self.numbers(attribute, 1)[0]


def read_xml(path: Path) -> Element:
    """The root element of an XML file. Raises InputError."""
    text = read_text(path, MAX_BYTES, wanted=URDF)
    parser = expat.ParserCreate()
    top = Element(path, 1, "", {})
    open_elements = [top]

    def start(tag: str, attributes: dict[str, str]) -> None:
        element = Element(path, parser.CurrentLineNumber, tag, attributes)
        if len(open_elements) > MAX_DEPTH:
            raise element.error(f"nested deeper than {MAX_DEPTH} levels")
        open_elements[-1].children.append(element)
        open_elements.append(element)

    def end(tag: str) -> None:
        open_elements.pop()

    def doctype(name: str, system: str | None, public: str | None, internal: bool) -> None:
        raise InputError(f"{path}:{parser.CurrentLineNumber}: a DOCTYPE is not allowed; remove it")

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.StartDoctypeDeclHandler = doctype
    try:
        parser.Parse(text.encode("utf-8"), True)
    except expat.ExpatError as error:
        raise InputError(f"{path}:{error.lineno}:{error.offset + 1}: not XML: {error}") from None
    return top.children[0]
