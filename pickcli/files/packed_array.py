"""Arrays over time as few bytes of JSON: rounded to a stated resolution, as differences in time."""

from __future__ import annotations

import base64
from collections.abc import Mapping
from typing import Any

import numpy as np

from pickcli.geometry import Array

_TYPES = (("i1", np.int8), ("i2", np.int16), ("i4", np.int32))


def packed(values: Array, resolution: float) -> dict[str, Any]:
    """An array as JSON values, each element off by half of the resolution at most.

    Args:
        values: (N,) or (N, k), finite.
        resolution: What elements are rounded to multiples of, in their unit.

    Returns:
        ``type`` of the integers (``i1``, ``i2`` or ``i4``, little-endian), ``shape``, ``unit`` (the
        resolution) and ``data``: base64 of the differences along the first axis, the first row from 0.
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


def unpacked(told: Mapping[str, Any]) -> Array:
    """An array from its JSON values.

    Args:
        told: As ``packed`` makes them.

    Returns:
        The array, of the shape that is stated.

    Raises:
        KeyError: If one of the values is missing.
        ValueError: If there are more or fewer elements than are stated, or of another type.
    """
    kind = dict(_TYPES)[told["type"]]
    steps = np.frombuffer(base64.b64decode(told["data"]), dtype=np.dtype(kind).newbyteorder("<"))
    rows = steps.reshape(told["shape"]).cumsum(axis=0, dtype=np.int64)
    return np.asarray(rows * float(told["unit"]))
