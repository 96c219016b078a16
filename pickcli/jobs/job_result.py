"""Results of jobs: numbers and values, or the reason for their absence; serialised as bytes."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from pickcli.errors import Reason
from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class JobResult:
    """The outcome of a task.

    Attributes:
        values: JSON values.
        arrays: Arrays of float64 by name.
        reason: Why the task has no result, or None.
    """

    values: Mapping[str, Any] = field(default_factory=dict)
    arrays: Mapping[str, Array] = field(default_factory=dict)
    reason: Reason | None = None

    def to_bytes(self) -> bytes:
        """Serialise the record: one line of JSON, then the arrays in turn. Same content, same bytes.

        Returns:
            The bytes.
        """
        reason = self.reason
        head = {
            "values": dict(self.values),
            "arrays": [[name, list(array.shape)] for name, array in self.arrays.items()],
            "reason": None if reason is None else [reason.what, reason.where, reason.detail],
        }
        line = json.dumps(head, sort_keys=True, allow_nan=False).encode() + b"\n"
        return line + b"".join(np.ascontiguousarray(a, "<f8").tobytes() for a in self.arrays.values())

    @classmethod
    def of_bytes(cls, content: bytes) -> JobResult:
        """Read a record from bytes.

        Args:
            content: Bytes from ``to_bytes``.

        Returns:
            The record.

        Raises:
            ValueError: If the bytes are not a record.
        """
        try:
            return _parsed(content)
        except (ValueError, TypeError, KeyError, OverflowError, RecursionError) as error:
            raise ValueError(f"no record of a task: {error}") from None


def _parsed(content: bytes) -> JobResult:
    line, _, rest = content.partition(b"\n")
    head = json.loads(line)
    if not isinstance(head, dict):
        raise ValueError("it is no object")
    arrays: dict[str, Array] = {}
    for name, shape in head["arrays"]:
        size = math.prod(shape)
        if size < 0:
            raise ValueError(f"an array of shape {shape}")
        arrays[name] = np.frombuffer(rest, "<f8", size).reshape(shape).copy()
        rest = rest[8 * size :]
    if rest:
        raise ValueError("more bytes than numbers")
    if not isinstance(head["values"], dict):
        raise ValueError("its values are no object")
    return JobResult(head["values"], arrays, _reason(head["reason"]))


def _reason(parts: Any) -> Reason | None:
    if parts is None:
        return None
    what, where, detail = parts
    if not all(isinstance(part, str) for part in (what, where, detail)):
        raise ValueError("its reason is no text")
    return Reason(what, where, detail)
