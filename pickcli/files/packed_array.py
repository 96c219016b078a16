"""Compact arrays in JSON: those over time rounded and stored as differences, others exactly."""

from __future__ import annotations

import base64
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array

_LEVEL = 1  # of zlib: others take several times as long for a tenth less
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


def deflated(values: NDArray[Any]) -> dict[str, Any]:
    """Compress an array as JSON values, exactly.

    Args:
        values: Numbers of any shape.

    Returns:
        ``type`` of the elements (as numpy writes it), ``shape`` and ``data``: base64 of the elements in the
        order of C, compressed by zlib.
    """
    data = zlib.compress(np.ascontiguousarray(values).tobytes(), _LEVEL)
    return {
        "type": values.dtype.str,
        "shape": list(values.shape),
        "data": base64.b64encode(data).decode(),
    }


def inflated(values: Mapping[str, Any]) -> NDArray[Any]:
    """Restore an array from its JSON values.

    Args:
        values: As returned by ``deflated``.

    Returns:
        The array, of the stated type and shape.

    Raises:
        KeyError: One of the values is missing.
        ValueError: The number of elements differs from what is stated.
    """
    data = zlib.decompress(base64.b64decode(values["data"]))
    return np.frombuffer(data, dtype=np.dtype(values["type"])).reshape(values["shape"]).copy()
