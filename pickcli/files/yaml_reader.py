"""YAML read safely: plain values with the line and column of each, all mistakes collected.

Works on the event stream of PyYAML, so size and depth are bounded before anything is built. Aliases,
tags, several documents and duplicate keys are refused. Plain scalars follow YAML 1.2: ``1e-3`` is a
number; what 1.1 would quietly turn into something else (``no``, ``12:30``, ``010``, ``1_000``) is an
error that says what to write instead.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from math import inf, isfinite
from pathlib import Path
from typing import Any, TypeAlias

import yaml

from pickcli.errors import InputError
from pickcli.files.bounded_reading import read_text
from pickcli.files.file_kind import FileKind
from pickcli.files.json_reader import refuse_bad_syntax
from pickcli.name_suggestion import shortened

MAX_BYTES = 1_000_000
MAX_DEPTH = 32
BYTE_ORDER_MARK = "\ufeff"
MOST_TOLD = 20  # mistakes in one message

Key: TypeAlias = tuple[str | int, ...]  # where a value stands: names of mappings, indices of lists

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # only its parser is used, which does not recurse
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


@dataclass(frozen=True)
class Problem:
    """One mistake in a file.

    Attributes:
        line: Counted from 1.
        column: Counted from 1.
        text: What is wrong and what to do about it.
        path: The other file that it stands in; None for the one that is read.
    """

    line: int
    column: int
    text: str
    path: Path | None = None


@dataclass
class Source:
    """A file's values and where each of them stands.

    Attributes:
        path: The file.
        data: Its values: mappings, lists, texts, numbers, switches and None.
        key_marks: Line and column, from 1, of the key of each entry of a mapping.
        value_marks: Line and column, from 1, of each value.
        origins: File, line and column of each value that was taken from another file.
        problems: Mistakes noted so far.
        n_untold: Number of mistakes that were found but are not told one by one.
    """

    path: Path
    data: Any = None
    key_marks: dict[Key, tuple[int, int]] = field(default_factory=dict)
    value_marks: dict[Key, tuple[int, int]] = field(default_factory=dict)
    origins: dict[Key, tuple[Path, int, int]] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    n_untold: int = 0  # mistakes that were found but will not be told one by one

    @property
    def is_full(self) -> bool:
        """Whether as many mistakes are noted as will be told: no hint is worth its time any more."""
        return len(self.problems) > MOST_TOLD

    def add(self, key: Key, text: str) -> None:
        """Note a mistake.

        Args:
            key: Where the value stands; the nearest parent that stands in the file is told.
            text: What is wrong and what to do about it.
        """
        path, line, column = self.place(key)
        self.problems.append(Problem(line, column, f"{name_of(key)}: {text}" if key else text, path))

    def stated(self, key: Key) -> Key:
        """Where a value stands in the file, if it is told to stand elsewhere.

        Args:
            key: Of the value.

        Returns:
            The same key, unless the file is seen by a part of it.
        """
        return key

    def place(self, key: Key) -> tuple[Path | None, int, int]:
        """Where a value stands, or its nearest parent that does.

        Args:
            key: Of the value.

        Returns:
            The file, None for this one, and line and column from 1.
        """
        while key and key not in self.key_marks and key not in self.value_marks and key not in self.origins:
            key = key[:-1]
        here = self.key_marks.get(key) or self.value_marks.get(key) or (1, 1)
        return self.origins.get(key) or (None, *here)

    def check(self) -> None:
        """Refuse the file if any mistake was noted.

        Raises:
            InputError: With all mistakes noted so far, in the order of the file.
        """
        if self.problems:
            ordered = sorted(set(self.problems), key=lambda p: (str(p.path or ""), p.line, p.column, p.text))
            lines = [f"{p.path or self.path}:{p.line}:{p.column}: {p.text}" for p in ordered[:MOST_TOLD]]
            more = len(ordered) + self.n_untold - len(lines)
            raise InputError("\n".join(lines + [f"{self.path}: and {more} more"] * (more > 0)))


def name_of(key: Key) -> str:
    """Write a key as it stands in messages: ``("rows", 0, "lip_top")`` as ``rows[0].lip_top``.

    Args:
        key: Where a value stands.

    Returns:
        The text.
    """
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in key)
    return text.removeprefix(".")


def quoted(name: str) -> str:
    """Write a name as YAML has it: in quotes where it is no plain word or means something else, as `no` does.

    Args:
        name: Any text.

    Returns:
        A scalar that ``parse_yaml`` reads as this text.
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
    """Read values and marks of a YAML file, or of a JSON file, which is YAML too.

    Args:
        path: The file; what is named `.json` must be JSON and nothing else.
        wanted: The kind that the file should be of; None for any.
        is_json: Whether it must be JSON whatever its name.
        tags: Tags that are passed over; they make nothing of a value.

    Returns:
        The values with their places.

    Raises:
        InputError: With every mistake found and its place.
    """
    return parse_yaml(read_text(path, MAX_BYTES, wanted=wanted), path, is_json, tags)


def parse_yaml(text: str, path: Path, is_json: bool = False, tags: Collection[str] = ()) -> Source:
    """Read a YAML or JSON text as ``read_yaml`` reads a file.

    Args:
        text: The text.
        path: The file whose content it is or would be; `.json` asks for JSON.
        is_json: Whether it must be JSON whatever its name.
        tags: Tags that are passed over; they make nothing of a value.

    Returns:
        The values with their places.

    Raises:
        InputError: With every mistake found and its place.
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
        raise InputError(f"{path}: not YAML: {error}") from None
    source.check()
    return source


def _cure(error: yaml.MarkedYAMLError, text: str) -> str:
    """What to do about a text that is not YAML: what is wrong often stands before the place of the error."""
    mark, begin = error.problem_mark or error.context_mark, error.context_mark
    lines = _LINE_BREAK.split(text)
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

# JSON writes what lies beyond 16 bits as two escapes, which YAML does not know.
_SURROGATES = re.compile(r"(?<!\\)((?:\\\\)*)\\u([dD][89abAB][0-9a-fA-F]{2})\\u([dD][c-fC-F][0-9a-fA-F]{2})")


def _without_tabs_around(json: str) -> str:
    """JSON without tabs before and after its value, where YAML has none."""
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
        """The only document of the stream."""
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
        """The value that starts with ``event`` and stands at ``key``."""
        if isinstance(event, yaml.AliasEvent) or event.anchor is not None:
            self.refuse(event, "anchors and aliases are not allowed; write the value out")
        if event.tag is not None and event.tag != "!" and event.tag not in self.tags:
            self.refuse(event, f"tag {event.tag} is not allowed; leave it out")
        if len(key) > MAX_DEPTH:
            self.refuse(event, f"nested deeper than {MAX_DEPTH} levels")
        self.source.value_marks[key] = _place(event)
        if isinstance(event, yaml.ScalarEvent):
            return self.scalar(event, key)
        if isinstance(event, yaml.SequenceStartEvent):
            return self.sequence(key)
        return self.mapping(key)

    def sequence(self, key: Key) -> list[Any]:
        """A list, its start event already taken."""
        values: list[Any] = []
        while not isinstance(event := next(self.stream), yaml.SequenceEndEvent):
            values.append(self.node(event, (*key, len(values))))
        return values

    def mapping(self, key: Key) -> dict[str, Any]:
        """A mapping with text keys, its start event already taken."""
        values: dict[str, Any] = {}
        while not isinstance(event := next(self.stream), yaml.MappingEndEvent):
            if not isinstance(event, yaml.ScalarEvent):
                self.refuse(event, "expected a name as key")
            name, inner = event.value, (*key, event.value)
            if name in values:
                self.note(event, f"{name_of(inner)}: stands twice; keep one")
            self.source.key_marks[inner] = _place(event)
            values[name] = self.node(next(self.stream), inner)
        return values

    def scalar(self, event: Any, key: Key) -> Any:
        """Text, number, switch or nothing, by the rules of YAML 1.2."""
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
        """A number that is no short integer; one that is too large is a mistake."""
        value = float(event.value)
        if not isfinite(value):
            got = f"{shortened(event.value)} ({len(event.value)} characters)"
            self.note(event, f"{name_of(key)}: expected a number, got {got}, which is too large; correct it")
        return value

    def note(self, event: Any, text: str) -> None:
        """Collect a mistake and go on."""
        self.source.problems.append(Problem(*_place(event), text))

    def refuse(self, event: Any, text: str) -> None:
        """Stop reading: what follows cannot be trusted."""
        line, column = _place(event)
        raise InputError(f"{self.source.path}:{line}:{column}: {text}")


def _place(event: Any) -> tuple[int, int]:
    return event.start_mark.line + 1, event.start_mark.column + 1
