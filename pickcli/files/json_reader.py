"""Parses JSON texts, and reports syntax errors with position and advice."""

from __future__ import annotations

import json
import re
from collections import Counter
from typing import Any, NoReturn

from pickcli.errors import InputError
from pickcli.name_suggestion import shortened

MAX_DIGITS = 20  # of an integer
_CONSTANT = re.compile(r'"(?:[^"\\]|\\.)*"|(-?(?:NaN|Infinity))')
_YAML = re.compile(r"---|- |[A-Za-z_][\w ]*:(\s|$)")  # beginning of a YAML text
_PYTHON = {"None": "null", "True": "true", "False": "false"}


def parse_json(text: str, where: str) -> Any:
    """Parse a JSON text; refuses duplicate keys, NaN, deep nesting and overlong integers.

    Args:
        text: The text.
        where: Name of the file, for messages.

    Returns:
        The values, as returned by the standard library's ``json``.

    Raises:
        InputError: The syntax is wrong: with line and column.
    """

    def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        out = dict(pairs)
        if len(out) != len(pairs):
            twice = Counter(key for key, _ in pairs).most_common(1)[0][0]
            raise InputError(f"{where}: {shortened(twice)}: the key stands twice in one object; keep one")
        return out

    def integer(digits: str) -> int:
        if len(digits) > MAX_DIGITS:
            fault = f"{shortened(digits)} is a whole number of {len(digits)} digits"
            raise InputError(f"{where}: {fault}, at most {MAX_DIGITS} are read; correct it")
        return int(digits)

    return _loads(text, where, object_pairs_hook=unique, parse_int=integer)


def refuse_bad_syntax(text: str, where: str) -> None:
    """Refuse a text that is not JSON; values are not checked.

    Args:
        text: The text.
        where: Name of the file, for messages.

    Raises:
        InputError: The syntax is wrong: with line, column and advice.
    """
    _loads(text, where, parse_int=str, parse_float=str)


def _loads(text: str, where: str, **hooks: Any) -> Any:
    """Parse with the standard library, and add position and advice to its errors."""

    def constant(name: str) -> NoReturn:
        found = next(match for match in _CONSTANT.finditer(text) if match[1] == name)
        raise InputError(f"{_place(text, found.start(), where)}: {name} is not JSON; write a finite number")

    try:
        return json.loads(text, parse_constant=constant, **hooks)
    except json.JSONDecodeError as error:
        raise InputError(f"{_place(text, error.pos, where)}: not JSON: {_advice(text, error)}") from None
    except RecursionError:
        raise InputError(f"{where}: nested too deeply; is it the right file?") from None


def _place(text: str, at: int, where: str) -> str:
    """Position ``file:line:column`` of a character, both counted from 1."""
    return f"{where}:{text.count(chr(10), 0, at) + 1}:{at - text.rfind(chr(10), 0, at)}"


def _advice(text: str, error: json.JSONDecodeError) -> str:
    """Describe a syntax error, with advice."""
    rest, before = text[error.pos :], text[: error.pos].rstrip()
    if not text.strip():
        return "the file is empty"
    if not before and _YAML.match(rest):
        return "it looks like YAML; write it as JSON, with braces around it and keys in double quotes"
    if not rest.strip() or error.msg.startswith("Unterminated string"):
        return "the text ends too early; the file is cut off, or a quote or bracket is not closed"
    if rest.startswith(("//", "/*", "#")):
        return "JSON has no comments; delete them"
    if not before and rest[0] not in '"{[':
        return f"it begins with {rest[:12].split(chr(10))[0]!r}; is it the right file?"
    if word := re.match(r"[A-Za-z_]\w*", rest):
        return _advice_about(word.group())
    if rest[0].isdecimal() and re.search(r"\d,$", text[: error.pos]):
        return "a comma in a number, or a key without quotes; numbers have a decimal point"
    if number := re.match(r"\+|-?\.(?=\d)", rest):
        return "a number begins with a digit or -; " + (
            "leave out the +" if number.group() == "+" else "write 0 before the point"
        )
    if error.msg == "Extra data":
        return f"the text continues after its end with {rest[:12]!r}; one file holds one value"
    if rest.startswith("'"):
        return "single quotes are not JSON; use double quotes"
    if rest[0] in ",]}" and (before.endswith(",") or "trailing comma" in error.msg):
        return "a comma with nothing after it; delete the comma"
    if rest[0] in "{[" and before.endswith(","):
        return f"{rest[0]!r} where a key was expected; the object before it lacks its closing '}}'"
    if "delimiter" in error.msg:
        return f"expected a {error.msg.split()[1]} before {rest[:12]!r}; check commas and brackets before it"
    return f"{error.msg.lower()}, got {rest[:12]!r}; check commas and brackets before it"


def _advice_about(word: str) -> str:
    """Advice on a word without quotes."""
    if word in _PYTHON:
        return f"{word} is Python; JSON writes {_PYTHON[word]}"
    if word.lower() in _PYTHON.values():
        return f"JSON writes {word.lower()} in small letters, got {word}"
    return f'{shortened(word)} must stand in double quotes: "{shortened(word)}"'
