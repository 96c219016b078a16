"""Compact arrays over time in JSON: rounded to a stated resolution and stored as differences."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Any

import numpy as np

from pickcli.geometry import Array

_TYPES = (("i1", np.int8), ("i2", np.int16), ("i4", np.int32))


def packed(values: Array, resolution: float) -> dict[str, Any]:
    """Pack an array as JSON values, with an error of at most half of the resolution.

    Args:
        values: (N,) or (N, k), finite.
        resolution: Unit to whose multiples elements are rounded.

    Returns:
        ``type`` of the integers (``i1``, ``i2`` or ``i4``, little-endian), ``shape``, ``unit`` (the
        resolution) and ``data``: base64 of the differences along the first axis, starting from 0.
    """
    rows = np.asarray(values, dtype=np.float64)
    rounded = np.round(rows / resolution).astype(np.int64)
    steps = np.diff(rounded, axis=0, prepend=np.zeros_like(rounded[:1]))
    name, kind = next(
        (name, kind) for name, kind in _TYPES if np.abs(steps).max(initial=0) <= np.iinfo(kind).max
    )
    data = steps.astype(np.dtype(kind).newbyteorder("<")).tobytes()
    return {
        "type": name,
        "shape": list(rows.shape),
        "unit": resolution,
        "data": base64.b64encode(data).decode(),
    }


def unpacked(values: Mapping[str, Any]) -> Array:
    """Unpack an array from its JSON values.

    Args:
        values: As returned by ``packed``.

    Returns:
        The array, of the stated shape.

    Raises:
        KeyError: One of the values is missing.
        ValueError: The number or type of elements differs from what is stated.
    """
    kind = dict(_TYPES)[values["type"]]
    steps = np.frombuffer(base64.b64decode(values["data"]), dtype=np.dtype(kind).newbyteorder("<"))
    rows = steps.reshape(values["shape"]).cumsum(axis=0, dtype=np.int64)
    return np.asarray(rows * float(values["unit"]))
