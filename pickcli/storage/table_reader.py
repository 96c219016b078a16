"""Verified reading: tables when a file is opened, pieces when they are read."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pickcli.errors import InputError, StaleError
from pickcli.geometry import Array
from pickcli.storage.safe_open import Dataset, open_datasets, opened, read_attributes
from pickcli.storage.table_format import (
    AnyArray,
    FileFormat,
    FileHeader,
    content_digest,
    piece_digest,
    table_digest,
)


@dataclass(frozen=True)
class StoredFile(FileHeader):
    """An open file with verified tables. Pieces are verified when they are read.

    Attributes:
        kind: Format of the file.
        attributes: Attributes by name.
        tables: Records by table.
        datasets: Datasets of the pieces.
        seal: SHA-256 over the whole content.
    """

    kind: FileFormat
    attributes: Mapping[str, str]
    tables: Mapping[str, AnyArray]
    datasets: Mapping[str, Dataset]
    seal: str

    def texts(self, table: str, field: str) -> tuple[str, ...]:
        """Return a TEXT column.

        Args:
            table: Name of the table.
            field: Name of the column.

        Returns:
            One text per row.
        """
        return tuple(bytes(text).decode() for text in self.tables[table][field])

    def piece(self, name: str, row: int) -> Array:
        """Read the piece that a row owns.

        Args:
            name: Name of the dataset.
            row: Index of the row in the table that owns the dataset.

        Returns:
            (r, c).

        Raises:
            ValueError: The piece is damaged.
        """
        owner = self.tables[self.kind.owners[name]][row]
        first, count = int(owner[f"{name}_first"]), int(owner[f"{name}_count"])
        dataset = self.datasets[name]
        if not 0 <= first <= first + count <= len(dataset):
            raise ValueError(f"{name} of row {row} lie outside of the data")
        rows: Array = dataset.rows(first, count)
        if piece_digest(rows) != bytes(owner[f"{name}_sha256"]).decode():
            raise ValueError(f"{name} {first} to {first + count} are not what their SHA-256 says")
        return rows

    def pieces(self, name: str) -> tuple[Array, AnyArray]:
        """Read all pieces of a dataset.

        Args:
            name: Name of the dataset.

        Returns:
            All pieces in sequence (R, c), and the offset of each of K (K + 1,).

        Raises:
            ValueError: A piece is damaged, or there are gaps between pieces.
        """
        owner = self.tables[self.kind.owners[name]]
        rows: Array = self.datasets[name].read()
        offsets = np.append(owner[f"{name}_first"], len(rows)).astype(np.int64)
        if offsets[0] != 0 or not np.array_equal(offsets[:-1] + owner[f"{name}_count"], offsets[1:]):
            raise ValueError(f"{name} are not divided among their owners")
        digests = owner[f"{name}_sha256"].tolist()
        for k, digest in enumerate(digests):
            if piece_digest(rows[offsets[k] : offsets[k + 1]]).encode() != digest:
                raise ValueError(f"{name} {offsets[k]} to {offsets[k + 1]} are not what their SHA-256 says")
        return rows, offsets


@contextmanager
def stored_file(path: Path, kind: FileFormat, fingerprint: str | None = None) -> Iterator[StoredFile]:
    """Open a file for reading and verify its tables.

    Args:
        path: The file.
        kind: Expected format.
        fingerprint: Fingerprint of the cell that it must be made for; None for any.

    Yields:
        The open file.

    Raises:
        InputError: The file is missing or of another format.
        DamagedError: The file is damaged; also raised while it is being read.
        StaleError: It has another version of the format, or was made for another cell.
    """
    with opened(path) as file:
        attributes = read_attributes(file)
        _check_kind(path, kind, attributes)
        _check_fingerprint(path, kind, attributes.get("cell_fingerprint", ""), fingerprint)
        seal = attributes.pop("content_sha256", "")
        if seal != content_digest(attributes):
            raise ValueError("its description is not what its SHA-256 says")
        datasets = open_datasets(file, kind, path.stat().st_size)
        tables = {name: datasets[name].read() for name in kind.tables}
        digests = json.loads(attributes["tables_sha256"])
        for name, table in tables.items():
            if table_digest(table) != digests[name]:
                raise ValueError(f"the table {name} is not what its SHA-256 says")
        yield StoredFile(kind, attributes, tables, {name: datasets[name] for name in kind.owners}, seal)


def _check_kind(path: Path, kind: FileFormat, attributes: Mapping[str, str]) -> None:
    found, version = attributes.get("format"), attributes.get("version")
    if found != kind.name:
        raise InputError(
            f"{path}: expected a {kind.name}, found {found or 'a foreign HDF5 file'}; name another"
        )
    if version != str(kind.version):
        raise StaleError(
            f"{path}: {kind.name} of version {version}, this is version {kind.version}; build it again"
        )


def _check_fingerprint(path: Path, kind: FileFormat, found: str, expected: str | None) -> None:
    if expected is not None and found != expected:
        raise StaleError(
            f"{path}: this {kind.name} was made for a cell with fingerprint {found[:16]}, "
            f"the cell in use has {expected[:16]}; build it again or use the cell that it belongs to"
        )
