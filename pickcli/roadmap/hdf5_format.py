"""What our HDF5 files look like, and the checksum over what they hold."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

AnyArray = NDArray[Any]

TEXT = "S"  # fixed-length UTF-8, any length
ANY_WIDTH = -1  # as many columns as the robot has joints


@dataclass(frozen=True)
class Column:
    """What a dataset must be: "<f8", "<i8" or TEXT; ``width`` None for one dimension, else columns of two."""

    dtype: str
    width: int | None = None


@dataclass(frozen=True)
class Format:
    """A kind of file."""

    name: str
    version: int
    columns: Mapping[str, Column]


@dataclass(frozen=True, eq=False)
class Content:
    """What a file holds.

    fingerprint: of the cell that it is valid for
    made: how it was made, JSON values
    """

    fingerprint: str
    made: Mapping[str, Any]
    arrays: Mapping[str, AnyArray]


def array_digest(array: AnyArray) -> str:
    """SHA-256 over type, shape and bytes."""
    digest = hashlib.sha256(f"{array.dtype.str} {array.shape}\n".encode())
    digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()


def content_digest(attributes: Mapping[str, str]) -> str:
    """SHA-256 over all attributes, the digests of the arrays among them."""
    return hashlib.sha256(json.dumps(dict(attributes), sort_keys=True).encode()).hexdigest()
