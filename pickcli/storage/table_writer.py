"""Crash-safe and reproducible writing of HDF5 files: equal content gives equal bytes.

The file is built in memory in the latest format, whose headers have checksums, and then written atomically: a
full disk is an error instead of a crash of the library, and a kill leaves the old file. Data are contiguous,
with SHA-256 instead of HDF5's own checksums: these detect more, and identify the damaged data.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from pickcli.errors import InputError
from pickcli.files.atomic_write import write_bytes
from pickcli.geometry import Array
from pickcli.storage.header_backup import with_backup
from pickcli.storage.table_format import (
    MAX_ATTRIBUTE,
    SEAL,
    TEXT,
    AnyArray,
    FileContent,
    FileFormat,
    Table,
    content_digest,
    piece_digest,
    row_digests,
    table_digest,
)


def write_content(path: Path, kind: FileFormat, content: FileContent, replace: bool = True) -> None:
    """Write a file atomically: after a crash or with a full disk the old file is intact.

    Args:
        path: The file.
        kind: Its format.
        content: The content.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written.
    """
    write_bytes(path, to_bytes(kind, content), replace)


def to_bytes(kind: FileFormat, content: FileContent) -> bytes:
    """Build the bytes of a file, as a pure function of its content.

    Args:
        kind: The format.
        content: The content.

    Returns:
        The bytes, including the header backup.

    Raises:
        InputError: An attribute is too long.
    """
    n = len(content.joint_names)
    tables = {name: _sealed(table, content, name) for name, table in kind.tables.items()}
    pieces = {name: _stacked(content.pieces[name], n) for name in kind.owners}
    attributes = {
        "format": kind.name,
        "version": str(kind.version),
        "cell_fingerprint": content.fingerprint,
        "joint_names": json.dumps(content.joint_names),
        "made": json.dumps(content.made, sort_keys=True),
        "tables_sha256": json.dumps({name: table_digest(table) for name, table in tables.items()}),
    }
    attributes["content_sha256"] = content_digest(attributes)
    for name, text in attributes.items():  # only readable files are written
        if len(text.encode()) > MAX_ATTRIBUTE:
            raise InputError(
                f"{name} takes over {MAX_ATTRIBUTE >> 20} MB; make names and descriptions shorter"
            )
    return _image(attributes, tables | pieces)


def _sealed(table: Table, content: FileContent, name: str) -> AnyArray:
    """Build a table with offsets and digests of the pieces, and the row seals.

    Raises ValueError for columns of different lengths.
    """
    columns = {f: _column(kind, content.tables[name][f]) for f, kind in table.fields.items()}
    for piece in table.pieces:
        columns |= _places(piece, content.pieces[piece])
    counts = {len(column) for column in columns.values()}
    if len(counts) != 1:
        raise ValueError(f"the columns of {name} are not equally long")
    widths = {field: columns[field].dtype.itemsize for field, kind in table.fields.items() if kind == TEXT}
    rows = np.zeros(counts.pop(), table.row_type(widths))
    for field, values in columns.items():
        rows[field] = values
    rows[SEAL] = row_digests(rows)
    return rows


def _column(kind: str, values: Sequence[Any] | AnyArray) -> AnyArray:
    if kind != TEXT:
        return np.asarray(values)
    encoded = [str(value).encode() for value in values]
    return np.array(encoded, dtype=f"S{max([1, *map(len, encoded)])}")


def _places(piece: str, parts: Sequence[Array]) -> dict[str, AnyArray]:
    """Offset, length and digest of each row's piece."""
    counts = np.array([len(part) for part in parts], dtype=np.int64)
    return {
        f"{piece}_first": np.cumsum(counts) - counts,
        f"{piece}_count": counts,
        f"{piece}_sha256": np.array([piece_digest(part) for part in parts], dtype="S"),
    }


def _stacked(parts: Sequence[Array], n_columns: int) -> Array:
    return np.ascontiguousarray(np.concatenate(parts)) if len(parts) else np.zeros((0, n_columns))


def _image(attributes: dict[str, str], datasets: dict[str, AnyArray]) -> bytes:
    """The HDF5 file, followed by the header backup."""
    with h5py.File("memory", "w", driver="core", backing_store=False, libver="latest") as file:
        for name, text in attributes.items():
            file.attrs[name] = np.bytes_(text.encode())
        for name, array in datasets.items():
            file.create_dataset(name, data=array, track_times=False)
        file.flush()
        places = [_place(file[name]) for name in datasets]
        return with_backup(bytes(file.id.get_file_image()), places)


def _place(dataset: Any) -> tuple[int, int]:
    """Place of a contiguous dataset's data: first byte, number of bytes."""
    return (dataset.id.get_offset() or 0, dataset.id.get_storage_size())
