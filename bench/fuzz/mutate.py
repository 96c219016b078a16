"""Ways to break a file: of values that hang together as JSON does, of text, and of bytes."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np

NUMBERS = (
    0, -0.0, 1, -1, 0.5, 1e-9, -1e-9, 1e-300, 5e-324, 1e3, -1e3, 180.0, 1e6, 1e9, 1e18, 1e100, 1e154, 1e300,
    1e308, -1e308, 2**31, 2**32, 2**53 + 1, 2**63, 10**30, 10**400, True, False, None,
)  # fmt: skip
TEXTS = (
    "", " ", "x", "x" * 300, "x" * 100_000, "\x00", "\x1b[2J", "\ud800", "\U0001f4e6", "../../../etc/passwd",
    "/dev/zero", "nan", "1e999", "-inf", "null", "bin_A", "tote", "home", "=cmd()", "%s%n", "{}", "${HOME}",
    "\ufb01", "\u0130", "\u202e", "a#2",
)  # fmt: skip
TOKENS = (
    b"NaN", b"Infinity", b"-", b"1e999", b"9" * 5000, b"{", b"}", b"[", b"]", b",", b":", b'"', b"\\u0000",
    b"\\ud800", b"\xff\xfe", b"\x00", b"&a", b"*a", b"!!python/object:os.system", b"<!DOCTYPE", b"<<: ",
    b"---\n", b"\t", b"\r", b"[" * 500, b"{" * 500, b"'", b"<x>" * 200, b"yes", b"0x10", b"1_000", b"12:30",
)  # fmt: skip
AGAIN = 0.35  # chance that a file is broken in one more way


def mutated_value(value: Any, rng: np.random.Generator) -> Any:
    """A copy of a JSON value with a few things in it changed, anywhere."""
    value = json.loads(json.dumps(value))
    value = _changed(value, rng)
    while rng.random() < AGAIN:
        value = _changed(value, rng)
    return value


def _changed(value: Any, rng: np.random.Generator) -> Any:
    """One place of a value changed: walked to by chance, near the top or far below."""
    if isinstance(value, (dict, list)) and len(value) and rng.random() < 0.85:
        keys = list(value) if isinstance(value, dict) else range(len(value))
        key = keys[int(rng.integers(len(keys)))]
        if rng.random() < 0.75:
            value[key] = _changed(value[key], rng)
        else:
            _rearranged(value, key, rng)
        return value
    return _other(value, rng)


def _rearranged(value: Any, key: Any, rng: np.random.Generator) -> None:
    """A container with an entry more, less, or elsewhere."""
    how = int(rng.integers(4))
    if how == 0:
        del value[key]
    elif isinstance(value, dict):
        name = TEXTS[int(rng.integers(len(TEXTS)))] if how == 1 else f"{key}_"
        value[name] = value[key] if how < 3 else value.pop(key)
    elif how == 1:
        value[:] = (value * 400)[:2000]
    elif how == 2:
        value.insert(int(rng.integers(len(value) + 1)), json.loads(json.dumps(value[key])))
    else:
        value.reverse()


def _other(value: Any, rng: np.random.Generator) -> Any:
    """Something else in place of a value: often of its own kind."""
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if is_number and abs(value) < 1e300 and rng.random() < 0.6:
        return value * float(rng.choice([-1.0, 0.0, 1e-3, 0.5, 1.01, 2.0, 57.3, 1e3, 1e6]))
    if isinstance(value, str) and len(value) and rng.random() < 0.4:
        at = int(rng.integers(len(value)))
        return value[:at] + chr(int(rng.integers(32, 0x250))) + value[at + 1 :]
    pool: tuple[Any, ...] = (NUMBERS, TEXTS, ([], {}, [[]], [1e300] * 3, {"": None}))[
        int(rng.choice(3, p=[0.6, 0.3, 0.1]))
    ]
    return pool[int(rng.integers(len(pool)))]


def as_json(value: Any) -> bytes:
    """The text of a value, whatever it holds (numbers that are not finite too)."""
    return json.dumps(value).encode("utf-8", "surrogatepass")


def mutated_bytes(content: bytes, rng: np.random.Generator) -> bytes:
    """Bytes with a few places changed."""
    content = _BYTES[int(rng.integers(len(_BYTES)))](content, rng)
    while rng.random() < AGAIN:
        content = _BYTES[int(rng.integers(len(_BYTES)))](content, rng)
    return content


def _flipped(content: bytes, rng: np.random.Generator) -> bytes:
    changed = bytearray(content)
    for _ in range(int(rng.integers(1, 9))):
        if changed:
            changed[int(rng.integers(len(changed)))] ^= 1 << int(rng.integers(8))
    return bytes(changed)


def _cut(content: bytes, rng: np.random.Generator) -> bytes:
    return content[: int(rng.integers(len(content) + 1))]


def _without(content: bytes, rng: np.random.Generator) -> bytes:
    a, b = _stretch(content, rng)
    return content[:a] + content[b:]


def _doubled(content: bytes, rng: np.random.Generator) -> bytes:
    a, b = _stretch(content, rng)
    return content[:b] + content[a:b] * int(rng.integers(1, 4)) + content[b:]


def _with_token(content: bytes, rng: np.random.Generator) -> bytes:
    at = int(rng.integers(len(content) + 1))
    return content[:at] + TOKENS[int(rng.integers(len(TOKENS)))] + content[at:]


def _with_number(content: bytes, rng: np.random.Generator) -> bytes:
    """Another number in place of one: text stays well-formed more often than not."""
    starts = [
        i for i in range(1, len(content)) if content[i : i + 1].isdigit() and not content[i - 1 : i].isdigit()
    ]
    if not starts:
        return content
    a = starts[int(rng.integers(len(starts)))]
    b = a
    while b < len(content) and content[b : b + 1] in b"0123456789.eE+-":
        b += 1
    number = NUMBERS[int(rng.integers(len(NUMBERS)))]
    return content[:a] + str(number).encode() + content[b:]


def _stretch(content: bytes, rng: np.random.Generator) -> tuple[int, int]:
    a = int(rng.integers(len(content) + 1))
    return a, min(len(content), a + int(rng.integers(1, 200)))


_BYTES: tuple[Callable[[bytes, np.random.Generator], bytes], ...] = (
    _flipped, _cut, _without, _doubled, _with_token, _with_number, _with_number,
)  # fmt: skip
