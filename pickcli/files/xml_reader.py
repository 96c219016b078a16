"""Safe XML reader based on expat: no DTD, bounded size and depth, with the line of every element."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from pickcli.errors import InputError
from pickcli.files.bounded_reading import read_text
from pickcli.files.file_kind import URDF, FileKind

MAX_BYTES = 10_000_000
MAX_DEPTH = 64


@dataclass(eq=False)
class Element:
    """One element of an XML file.

    Attributes:
        path: The file.
        line: Line of its start, counted from 1.
        tag: Its tag.
        attributes: Its attributes by name.
        children: Its child elements, in order.
    """

    path: Path
    line: int
    tag: str
    attributes: dict[str, str]
    children: list[Element] = field(default_factory=list)

    def error(self, text: str) -> InputError:
        """Create an error that states this element's position and, if it has one, its name.

        Args:
            text: The problem and advice.

        Returns:
            The error, to be raised.
        """
        name = f" {self.attributes['name']!r}" if "name" in self.attributes else ""
        return InputError(f"{self.path}:{self.line}: <{self.tag}>{name}: {text}")

    def all(self, tag: str) -> list[Element]:
        """Find the children with a tag.

        Args:
            tag: The tag.

        Returns:
            The children, in their order; empty if there are none.
        """
        return [child for child in self.children if child.tag == tag]

    def optional(self, tag: str) -> Element | None:
        """Find the only child with a tag.

        Args:
            tag: The tag.

        Returns:
            The child, or None if there is none.

        Raises:
            InputError: There are several.
        """
        found = self.all(tag)
        if len(found) > 1:
            raise found[1].error(f"stands twice in <{self.tag}>; keep one")
        return found[0] if found else None

    def one(self, tag: str) -> Element:
        """Find the only child with a tag, which must exist.

        Args:
            tag: The tag.

        Returns:
            The child.

        Raises:
            InputError: There is none, or there are several.
        """
        found = self.optional(tag)
        if found is None:
            raise self.error(f"has no <{tag}>; add it")
        return found

    def text(self, attribute: str) -> str:
        """Read an attribute.

        Args:
            attribute: Its name.

        Returns:
            Its text, without white space around it.

        Raises:
            InputError: It is missing or empty.
        """
        value = self.attributes.get(attribute, "").strip()
        if not value:
            raise self.error(f"attribute {attribute!r} is missing; add it")
        return value

    def numbers(self, attribute: str, n: int) -> tuple[float, ...]:
        """Read an attribute of several finite numbers.

        Args:
            attribute: Its name.
            n: Required number of numbers.

        Returns:
            The n numbers, in the unit of the file.

        Raises:
            InputError: It is missing, or not ``n`` finite numbers.
        """
        text = self.text(attribute)
        try:
            values = tuple(float(part) for part in text.split())
        except ValueError:
            values = ()
        if len(values) != n or not all(map(math.isfinite, values)):
            point = "; write a decimal point, no comma" if "," in text else ""
            raise self.error(f"{attribute}: expected {n} finite number{'s' * (n > 1)}, got {text!r}{point}")
        return values

    def number(self, attribute: str) -> float:
        """Read an attribute that is one finite number.

        Args:
            attribute: Its name.

        Returns:
            The number, in the unit of the file.

        Raises:
            InputError: It is missing, or not one finite number.
        """
        return self.numbers(attribute, 1)[0]


def read_xml(path: Path, wanted: FileKind = URDF) -> Element:
    """Read an XML file.

    Args:
        path: The file.
        wanted: Expected kind of file.

    Returns:
        Its root element.

    Raises:
        InputError: It cannot be read, is not XML, has a DOCTYPE or is nested too deeply.
    """
    text = read_text(path, MAX_BYTES, wanted=wanted)
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
        what = expat.ErrorString(error.code)
        hint = "; a tag is not closed, or the file is cut off" * (
            what in ("no element found", "mismatched tag")
        )
        raise InputError(f"{path}:{error.lineno}:{error.offset + 1}: not XML: {what}{hint}") from None
    return top.children[0]
