"""Format of the HDF5 files, and checksums over their content.

A file contains tables. Each row of a table may own a piece of other datasets (an edge its polyline). The row
states the piece's SHA-256, its last field is the SHA-256 of the row itself, and one over all tables and
attributes seals the file. So single motions can be read and verified without the others, and damage can be
located.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array

AnyArray = NDArray[Any]
Columns = Mapping[str, Sequence[Any] | AnyArray]  # field -> one value per row

TEXT = "text"  # fixed-length UTF-8, as wide as the longest text
NUMBER = "<f8"
INDEX = "<i8"

SEAL = "row_sha256"  # the last field of every table
SHA_LENGTH = 64  # characters, hexadecimal
MAX_TEXT = 4096  # bytes
MAX_ATTRIBUTE = 8 * 2**20  # bytes; a cell with two thousand obstacles takes less than 1 MiB


@dataclass(frozen=True)
class Table:
    """Description of one table.

    Attributes:
        fields: TEXT, NUMBER or INDEX by name of the field.
        pieces: Names of datasets (R, c) of numbers in which each row owns consecutive rows.
    """

    fields: Mapping[str, str]
    pieces: tuple[str, ...] = ()

    def row_type(self, widths: Mapping[str, int]) -> np.dtype[Any]:
        """Return the record type of a row in the file.

        Args:
            widths: Width in bytes of each TEXT field.

        Returns:
            The record type.
        """
        own = [(name, f"S{widths[name]}" if kind == TEXT else kind) for name, kind in self.fields.items()]
        owned = [entry for piece in self.pieces for entry in _piece_fields(piece)]
        return np.dtype([*own, *owned, (SEAL, f"S{SHA_LENGTH}")])


@dataclass(frozen=True)
class FileFormat:
    """A kind of file.

    Attributes:
        name: Name in messages.
        version: Version of the format.
        tables: Tables by name.
    """

    name: str
    version: int
    tables: Mapping[str, Table]

    @property
    def owners(self) -> dict[str, str]:
        """Table that owns the pieces of each dataset, by name of the dataset."""
        return {piece: name for name, table in self.tables.items() for piece in table.pieces}


@dataclass(frozen=True, eq=False)
class FileContent:
    """Content of a file.

    Attributes:
        fingerprint: Fingerprint of the cell that it is valid for.
        made: Provenance, JSON values.
        joint_names: The joints, in the order of the columns.
        tables: For each table, one value per row for each field.
        pieces: For each dataset, one array (r, c) per row of the table that owns it.
    """

    fingerprint: str
    made: Mapping[str, Any]
    joint_names: tuple[str, ...]
    tables: Mapping[str, Columns]
    pieces: Mapping[str, Sequence[Array]]


def piece_digest(rows: Array) -> str:
    """Compute the SHA-256 over shape and bytes of a piece.

    Args:
        rows: (r, c) the piece.

    Returns:
        Hexadecimal digits.
    """
    rows = np.ascontiguousarray(rows)
    digest = hashlib.sha256(f"{rows.shape}\n".encode())
    digest.update(rows.data)
    return digest.hexdigest()


def row_digests(table: AnyArray) -> list[bytes]:
    """Compute the SHA-256 of each row's bytes without the seal, which is the last field.

    Args:
        table: Records.

    Returns:
        One digest per row, hexadecimal.
    """
    size = table.dtype.itemsize
    whole = np.ascontiguousarray(table).tobytes()
    starts = range(0, len(whole), size)
    return [hashlib.sha256(whole[i : i + size - SHA_LENGTH]).hexdigest().encode() for i in starts]


def table_digest(table: AnyArray) -> str:
    """Compute the SHA-256 over type, shape and bytes of a table.

    Args:
        table: Records.

    Returns:
        Hexadecimal digits.
    """
    fields = [(name, table.dtype[name].str) for name in table.dtype.names or ()]
    digest = hashlib.sha256(f"{fields} {table.shape}\n".encode())
    digest.update(np.ascontiguousarray(table).tobytes())
    return digest.hexdigest()


class FileHeader:
    """Attributes of a stored file, read or recovered.

    Attributes:
        attributes: Attributes of the file.
    """

    attributes: Mapping[str, str]

    @property
    def fingerprint(self) -> str:
        """Fingerprint of the cell that the file is valid for."""
        return self.attributes["cell_fingerprint"]

    @cached_property
    def made(self) -> dict[str, Any]:
        """Provenance of the file, JSON values.

        Raises:
            ValueError: The file does not state it.
        """
        made = json.loads(self.attributes["made"])
        if not isinstance(made, dict):
            raise ValueError("made is no JSON object")
        return made

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints, in the order of the columns.

        Raises:
            ValueError: The file does not state them.
            TypeError: The file does not state them.
        """
        return tuple(str(name) for name in json.loads(self.attributes["joint_names"]))


def content_digest(attributes: Mapping[str, str]) -> str:
    """Compute the SHA-256 over all attributes, which include the digests of the tables.

    Args:
        attributes: Attributes of the file.

    Returns:
        Hexadecimal digits.
    """
    return hashlib.sha256(json.dumps(dict(attributes), sort_keys=True).encode()).hexdigest()


def _piece_fields(piece: str) -> list[tuple[str, str]]:
    """Fields for a row's piece: its first row, number of rows, and SHA-256."""
    return [(f"{piece}_first", INDEX), (f"{piece}_count", INDEX), (f"{piece}_sha256", f"S{SHA_LENGTH}")]
