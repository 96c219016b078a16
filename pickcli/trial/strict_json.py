"""JSON from outside, read strictly: every error names file, line and column and says what to do.

The standard library parses; a second pass over the accepted text only notes where every key and value
stands, so that errors of meaning are as exact as errors of syntax.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

from pickcli.errors import InputError
from pickcli.files.bounded_reading import read_bytes
from pickcli.files.file_kind import FileKind

MAX_BYTES = 1_000_000  # an official order has about 3 kB
MAX_DEPTH = 32

Place: TypeAlias = tuple[str | int, ...]

_TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[{}\[\],:]|[^\s{}\[\],:"]+')


@dataclass(frozen=True, eq=False)
class Document:
    """A parsed text that remembers where everything stands.

    value: what ``json.loads`` gives
    where: name of the text in messages
    """

    value: Any
    where: str
    text: str = field(repr=False)
    keys: dict[Place, int] = field(repr=False)  # offset of every key by its path
    values: dict[Place, int] = field(repr=False)  # offset of every value by its path

    def at(self, *place: str | int) -> str:
        """``file:line:column`` of the value at a path."""
        return _position(self.where, self.text, self.values.get(place, 0))

    def at_key(self, *place: str | int) -> str:
        """``file:line:column`` of the key at the end of a path."""
        return _position(self.where, self.text, self.keys.get(place, 0))


def read_json(path: Path, wanted: FileKind | None = None) -> Document:
    """Read a JSON file. Raises InputError for what is not a regular, small, well-formed JSON file.

    wanted: the kind that the file should be of; None for any
    """
    return parse_json(read_bytes(path, MAX_BYTES, "give the path of a JSON file", wanted), str(path))


def parse_json(data: bytes, where: str) -> Document:
    """Parse bytes (UTF-8 JSON; duplicate keys, NaN and deep nesting are refused). Raises InputError."""
    if len(data) > MAX_BYTES:
        raise InputError(f"{where}: larger than {MAX_BYTES} bytes; this cannot be an order")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{where}: byte {error.start} is not UTF-8; save the file as UTF-8") from error
    value = _loads(text, where)
    keys, values = _places(text, where)
    return Document(value, where, text, keys, values)


def _loads(text: str, where: str) -> Any:
    def refuse(constant: str) -> Any:
        raise ValueError(f"{constant} is not JSON")

    try:
        return json.loads(text, parse_constant=refuse)
    except json.JSONDecodeError as error:
        at = f"{where}:{error.lineno}:{error.colno}"
        raise InputError(f"{at}: not JSON: {_advice(text, error)}") from error
    except RecursionError as error:
        raise InputError(f"{where}: nested deeper than {MAX_DEPTH} levels") from error
    except ValueError as error:
        raise InputError(f"{where}: {error}; remove it") from error


def _advice(text: str, error: json.JSONDecodeError) -> str:
    """What is wrong at the place of a syntax error, and what to do about it."""
    rest, before = text[error.pos :], text[: error.pos].rstrip()
    if not rest.strip():
        return "the text ends too early; the file is truncated or a closing bracket is missing"
    if rest.startswith(("//", "/*", "#")):
        return "JSON has no comments; delete them"
    if word := re.match(r"[A-Za-z_]\w*", rest):
        return f'{word.group()[:60]} must stand in double quotes: "{word.group()[:60]}"'
    if rest.startswith("'"):
        return "single quotes are not JSON; use double quotes"
    if rest[0] in ",]}" and (before.endswith(",") or "trailing comma" in error.msg):
        return "a comma with nothing after it; delete the comma"
    if rest[0] in "{[" and before.endswith(","):
        return f"{rest[0]!r} where a key was expected; the object before it lacks its closing '}}'"
    if "delimiter" in error.msg:
        return f"expected a {error.msg.split()[1]} before {rest[:12]!r}; check commas and brackets before it"
    return f"{error.msg.lower()}, got {rest[:12]!r}; check commas and brackets before it"


def _places(text: str, where: str) -> tuple[dict[Place, int], dict[Place, int]]:
    """Offsets of keys and values by path, of a text that is known to be JSON."""
    keys: dict[Place, int] = {}
    values: dict[Place, int] = {}
    path: list[str | int] = []
    is_object: list[bool] = []
    awaits_key = False
    for match in _TOKEN.finditer(text):
        token, offset = match.group(), match.start()
        if token in "}]":
            path.pop()
            is_object.pop()
            awaits_key = False
        elif token == ",":
            awaits_key = is_object[-1]
            if not awaits_key:
                path[-1] = int(path[-1]) + 1
        elif awaits_key:
            path[-1] = json.loads(token)
            if (place := tuple(path)) in keys:
                at = _position(where, text, offset)
                raise InputError(f"{at}: the key {str(path[-1])[:60]!r} stands twice; keep one")
            keys[place] = offset
            awaits_key = False
        elif token != ":":
            values[tuple(path)] = offset
            if token in "{[":
                awaits_key = token == "{"
                is_object.append(awaits_key)
                path.append("" if awaits_key else 0)
                if len(path) > MAX_DEPTH:
                    at = _position(where, text, offset)
                    raise InputError(f"{at}: nested deeper than {MAX_DEPTH} levels")
    return keys, values


def _position(where: str, text: str, offset: int) -> str:
    line = text.count("\n", 0, offset) + 1
    column = offset - text.rfind("\n", 0, offset)
    return f"{where}:{line}:{column}"
