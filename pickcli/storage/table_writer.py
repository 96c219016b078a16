"""Writing HDF5 files that survive crashes and are the same bytes for the same content.

The file is built in memory in the latest format, whose headers carry checksums, and is then written like
any other bytes: a full disk is an error instead of a crash of the library, a kill leaves the old file. Data
lie contiguous and carry SHA-256 instead of HDF5's own checksums: these find more, and say whose data it was.
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
from pickcli.storage.header_backup import with_spare
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
    """Write a file in one step: a kill or a full disk leaves the old file or none.

    Args:
        path: The file.
        kind: Its format.
        content: What it will hold.
        replace: Whether a file that exists may be replaced.

    Raises:
        InputError: If the file cannot be written.
    """
    write_bytes(path, to_bytes(kind, content), replace)


def to_bytes(kind: FileFormat, content: FileContent) -> bytes:
    """The bytes of a file, a pure function of its content.

    Args:
        kind: The format.
        content: What the file will hold.

    Returns:
        The bytes, header backup included.

    Raises:
        InputError: If an attribute is too long to be stored.
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
    for name, text in attributes.items():  # what cannot be read is not written
        if len(text.encode()) > MAX_ATTRIBUTE:
            raise InputError(
                f"{name} takes over {MAX_ATTRIBUTE >> 20} MB; make names and descriptions shorter"
            )
    return _image(attributes, tables | pieces)


def _sealed(table: Table, content: FileContent, name: str) -> AnyArray:
    """A table as it lies in the file, with the places and digests of the pieces, and its seals.

    Raises ValueError for columns of different length.
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
    """Where each row's piece lies, and its digest."""
    counts = np.array([len(part) for part in parts], dtype=np.int64)
    return {
        f"{piece}_first": np.cumsum(counts) - counts,
        f"{piece}_count": counts,
        f"{piece}_sha256": np.array([piece_digest(part) for part in parts], dtype="S"),
    }


def _stacked(parts: Sequence[Array], n_columns: int) -> Array:
    return np.ascontiguousarray(np.concatenate(parts)) if len(parts) else np.zeros((0, n_columns))


def _image(attributes: dict[str, str], datasets: dict[str, AnyArray]) -> bytes:
    """The HDF5 file, and after its end the spare copy of what is not data."""
    with h5py.File("memory", "w", driver="core", backing_store=False, libver="latest") as file:
        for name, text in attributes.items():
            file.attrs[name] = np.bytes_(text.encode())
        for name, array in datasets.items():
            file.create_dataset(name, data=array, track_times=False)
        file.flush()
        places = [_place(file[name]) for name in datasets]
        return with_spare(bytes(file.id.get_file_image()), places)


def _place(dataset: Any) -> tuple[int, int]:
    """Where the data of a contiguous dataset lie: first byte, number of bytes."""
    return (dataset.id.get_offset() or 0, dataset.id.get_storage_size())
