"""Safe YAML reader: plain values with the line and column of each, and all mistakes collected.

Based on the event stream of PyYAML, so that size and depth are bounded before anything is built. Aliases,
tags, several documents and duplicate keys are refused. Plain scalars follow YAML 1.2: ``1e-3`` is a number.
Values that YAML 1.1 would convert silently (``no``, ``12:30``, ``010``, ``1_000``) are errors with advice.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from math import inf, isfinite
from pathlib import Path
from typing import Any

import yaml

from pickcli.errors import InputError
from pickcli.files.bounded_reading import read_text
from pickcli.files.file_kind import FileKind
from pickcli.files.json_reader import refuse_bad_syntax
from pickcli.files.source import Key, Problem, Source, name_of
from pickcli.name_suggestion import shortened

MAX_BYTES = 4_000_000  # a scene as cameras believe it has up to 1.5 MB of unknown space
MAX_DEPTH = 32
BYTE_ORDER_MARK = "\ufeff"

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # used only as a parser, which is not recursive
_INT = re.compile(r"[-+]?(0|[1-9][0-9]*)")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|(0|[1-9][0-9]*)(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_TRAPS = (
    (re.compile(r"None"), "null or text", "write null, or quote it"),
    (re.compile(r"True|False"), "a switch or text", "write true or false in small letters, or quote it"),
    (re.compile(r"yes|no|on|off", re.IGNORECASE), "a switch or a word", "write true or false, or quote it"),
    (re.compile(r"[-+]?[0-9]+(:[0-9]+)+"), "a number or text", "quote it, or write one number"),
    (re.compile(r"[-+]?0[0-9]+(\.[0-9]*)?"), "a number", "write it without leading zeros"),
    (re.compile(r"[-+]?0[oxb][0-9a-fA-F]+"), "a decimal number", "write it in decimal, or quote it"),
    (re.compile(r"[-+]?[0-9][0-9_]*_[0-9_.]*"), "a number", "leave out the underscores"),
    (re.compile(r"[-+]?\.(inf|nan)", re.IGNORECASE), "a finite number", "write a finite number"),
    (re.compile(r"[0-9]{4}-[0-9]{1,2}-[0-9]{1,2}"), "a date or text", "quote it"),
)  # fmt: skip


def quoted(name: str) -> str:
    """Format a name for YAML: quoted if it is not a plain word or would be converted, as `no`.

    Args:
        name: Any text.

    Returns:
        A scalar that ``parse_yaml`` reads as the same text.
    """
    is_word = name.replace("_", "a").isalnum() and name[0].isalpha() and name != "None"
    style = None if is_word else '"'
    dumped = yaml.safe_dump(
        [name], default_style=style, default_flow_style=True, width=inf, allow_unicode=True
    )
    return str(dumped)[1:-2]


def read_yaml(
    path: Path, wanted: FileKind | None = None, is_json: bool = False, tags: Collection[str] = ()
) -> Source:
    """Read values and positions of a YAML or JSON file.

    Args:
        path: The file; with the suffix `.json` it must be JSON.
        wanted: Expected kind of file; None for any.
        is_json: Whether it must be JSON with any suffix.
        tags: Tags that are ignored.

    Returns:
        The values with their positions.

    Raises:
        InputError: With every mistake and its position.
    """
    return parse_yaml(read_text(path, MAX_BYTES, wanted=wanted), path, is_json, tags)


def parse_yaml(text: str, path: Path, is_json: bool = False, tags: Collection[str] = ()) -> Source:
    """Parse a YAML or JSON text in the same way as ``read_yaml``.

    Args:
        text: The text.
        path: The file of the text, for messages; with the suffix `.json` it must be JSON.
        is_json: Whether it must be JSON with any suffix.
        tags: Tags that are ignored.

    Returns:
        The values with their positions.

    Raises:
        InputError: With every mistake and its position.
    """
    source = Source(path)
    text = text.removeprefix(BYTE_ORDER_MARK)
    if is_json or path.suffix.lower() == ".json":
        refuse_bad_syntax(text, str(path))
        text = _without_tabs_around(text)
    events = _Events(source, _SURROGATES.sub(_character, text), tags)
    try:
        source.data = events.document()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
        what = f"not YAML: {error.problem or error.context}; {_cure(error, text)}"
        raise InputError(f"{path}:{line}:{column}: {what}") from None
    except yaml.YAMLError as error:
        raise InputError(f"{path}{_unprintable(text) or f': not YAML: {error}'}") from None
    source.check()
    return source


def _unprintable(text: str) -> str:
    """Position and advice for the first character that YAML does not allow; "" without one."""
    found = yaml.reader.Reader.NON_PRINTABLE.search(text)
    if found is None:
        return ""
    lines = _LINE_BREAK.split(text[: found.start()])
    what = f"the control character U+{ord(found[0]):04X} is not allowed; delete it"
    return f":{len(lines)}:{len(lines[-1]) + 1}: {what}"


def _cure(error: yaml.MarkedYAMLError, text: str) -> str:
    """Advice on a text that is not YAML; the mistake is often before the reported position."""
    mark, begin = error.problem_mark or error.context_mark, error.context_mark
    lines = _LINE_BREAK.split(text)
    if conflict := [i for i, line in enumerate(lines) if line.startswith("<<<<<<< ")]:
        return f"a conflict of git begins in line {conflict[0] + 1}; resolve it"
    here = "".join(lines[mark.line : mark.line + 1]) if mark else ""
    if mark and "\t" in here[: mark.column + 1]:
        return "indent with spaces, not tabs"
    if mark and (
        found := [i for i in range(mark.line + 1) if "\N{NO-BREAK SPACE}" in "".join(lines[i : i + 1])]
    ):
        return f"there is a no-break space in line {found[-1] + 1}; write a usual one"
    if begin is not None and "flow" in (error.context or ""):
        return f"is a comma missing, or the bracket of line {begin.line + 1}, column {begin.column + 1} open?"
    if begin is None or mark is None or begin.line >= mark.line:
        return "is a bracket open, or the file cut off?"
    return "is the line indented as those beside it, or a bracket open, or the file cut off?"


_LINE_BREAK = re.compile("\r\n|[\n\r\x85\u2028\u2029]")  # as YAML counts lines

# JSON writes characters beyond 16 bits as two escapes, which YAML does not support.
_SURROGATES = re.compile(r"(?<!\\)((?:\\\\)*)\\u([dD][89abAB][0-9a-fA-F]{2})\\u([dD][c-fC-F][0-9a-fA-F]{2})")


def _without_tabs_around(json: str) -> str:
    """JSON without tabs before and after its value, which YAML does not allow."""
    body = json.strip()
    return json[: json.index(body)].replace("\t", " ") + body


def _character(match: re.Match[str]) -> str:
    high, low = int(match[2], 16), int(match[3], 16)
    return match[1] + chr(0x10000 + ((high - 0xD800) << 10) + (low - 0xDC00))


class _Events:
    """Builds plain values from the event stream, one call per node, depth bounded."""

    def __init__(self, source: Source, text: str, tags: Collection[str] = ()) -> None:
        self.source, self.tags = source, tags
        self.stream: Iterator[Any] = yaml.parse(text, Loader=_LOADER)

    def document(self) -> Any:
        """Read the only document of the stream."""
        next(self.stream)  # stream start
        if isinstance(next(self.stream), yaml.StreamEndEvent):
            raise InputError(f"{self.source.path}:1:1: the file is empty")
        data = self.node(next(self.stream), ())
        next(self.stream)  # document end
        event = next(self.stream)
        if not isinstance(event, yaml.StreamEndEvent):
            self.refuse(event, "a second document; one file holds one")
        return data

    def node(self, event: Any, key: Key) -> Any:
        """Read the value at ``key`` that starts with ``event``."""
        if isinstance(event, yaml.AliasEvent) or event.anchor is not None:
            self.refuse(event, "anchors and aliases are not allowed; write the value out")
        if event.tag is not None and event.tag != "!" and event.tag not in self.tags:
            advice = "write the angle in rad" if event.tag == "!degrees" else "leave it out"  # xacro's tag
            self.refuse(event, f"tag {event.tag} is not allowed; {advice}")
        if len(key) > MAX_DEPTH:
            self.refuse(event, f"nested deeper than {MAX_DEPTH} levels")
        self.source.value_positions[key] = _place(event)
        if isinstance(event, yaml.ScalarEvent):
            return self.scalar(event, key)
        if isinstance(event, yaml.SequenceStartEvent):
            return self.sequence(key)
        return self.mapping(key)

    def sequence(self, key: Key) -> list[Any]:
        """Read a list after its start event."""
        values: list[Any] = []
        while not isinstance(event := next(self.stream), yaml.SequenceEndEvent):
            values.append(self.node(event, (*key, len(values))))
        return values

    def mapping(self, key: Key) -> dict[str, Any]:
        """Read a mapping with text keys after its start event."""
        values: dict[str, Any] = {}
        while not isinstance(event := next(self.stream), yaml.MappingEndEvent):
            if not isinstance(event, yaml.ScalarEvent):
                self.refuse(event, "expected a name as key")
            name, inner = event.value, (*key, event.value)
            if name in values:
                self.note(event, f"{name_of(inner)}: stands twice; keep one")
            self.source.key_positions[inner] = _place(event)
            values[name] = self.node(next(self.stream), inner)
        return values

    def scalar(self, event: Any, key: Key) -> Any:
        """Convert a scalar to text, number, switch or None by the rules of YAML 1.2."""
        text: str = event.value
        if not event.implicit[0]:
            return text
        if text in ("", "~", "null"):
            return None
        if text in ("true", "false"):
            return text == "true"
        if _INT.fullmatch(text) and len(text) < 20:
            return int(text)
        if _FLOAT.fullmatch(text):
            return self.number(event, key)
        for pattern, expected, advice in _TRAPS:
            if pattern.fullmatch(text):
                self.note(event, f"{name_of(key)}: expected {expected}, got {shortened(text)}; {advice}")
                return None
        return text

    def number(self, event: Any, key: Key) -> float:
        """Convert a number other than a short integer; one that is too large is a mistake."""
        value = float(event.value)
        if not isfinite(value):
            got = f"{shortened(event.value)} ({len(event.value)} characters)"
            self.note(event, f"{name_of(key)}: expected a number, got {got}, which is too large; correct it")
        return value

    def note(self, event: Any, text: str) -> None:
        """Report a mistake and continue."""
        self.source.problems.append(Problem(*_place(event), text))

    def refuse(self, event: Any, text: str) -> None:
        """Stop reading after a mistake that makes the rest meaningless."""
        line, column = _place(event)
        raise InputError(f"{self.source.path}:{line}:{column}: {text}")


def _place(event: Any) -> tuple[int, int]:
    return event.start_mark.line + 1, event.start_mark.column + 1
