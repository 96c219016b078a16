"""Integrity scan: reads every byte of a file, and reports damaged and intact parts."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import h5py

from pickcli.errors import DamagedError, InputError, StaleError
from pickcli.geometry import Array
from pickcli.storage.header_backup import RestoredFile, full_length, restored
from pickcli.storage.safe_open import (
    SYMPTOMS,
    Dataset,
    cause_of,
    check_readable,
    open_datasets,
    read_attributes,
)
from pickcli.storage.table_format import (
    SEAL,
    AnyArray,
    FileFormat,
    FileHeader,
    content_digest,
    piece_digest,
    row_digests,
    table_digest,
)


@dataclass(frozen=True)
class DamagedBlock:
    """A damaged block.

    Attributes:
        where: Part of the file.
        lost: Content that cannot be recovered from the file, "" if nothing.
    """

    where: str
    lost: str = ""


@dataclass(frozen=True, eq=False)
class IntactRow:
    """An intact row with its pieces.

    Attributes:
        row: A record of the table.
        pieces: Arrays (r, c) by dataset.
    """

    row: Any
    pieces: Mapping[str, Array]


@dataclass(frozen=True, eq=False)
class IntegrityReport(FileHeader):
    """Damaged and intact content of a file.

    Attributes:
        kind: Format of the file.
        attributes: Verified attributes, without the seal itself.
        seal: Original ``content_sha256`` of the file.
        damage: Damaged blocks.
        cut_off: Where the file is truncated, "" if it is not.
        intact: Intact rows by table.
    """

    kind: FileFormat
    attributes: Mapping[str, str]
    seal: str
    damage: tuple[DamagedBlock, ...]
    cut_off: str
    intact: Mapping[str, Sequence[IntactRow]]

    @property
    def is_whole(self) -> bool:
        """Whether nothing is lost."""
        return not any(damage.lost for damage in self.damage)


def scan_integrity(path: Path, kinds: Sequence[FileFormat]) -> IntegrityReport:
    """Read every byte of a file and compare all checksums.

    Args:
        path: The file.
        kinds: Formats that it may have.

    Returns:
        Damaged and intact content.

    Raises:
        InputError: The file is missing or of another format.
        StaleError: The file has another version of the format.
        DamagedError: Both the file's structure and its backup are damaged, so that nothing can be read.
    """
    check_readable(path)
    content = path.read_bytes()
    found, length = restored(content), full_length(content)
    cut_off = "" if length is None else f"cut off at byte {len(content)} of at least {length}"
    try:
        with h5py.File(io.BytesIO(found.image), "r") as file:
            attributes = read_attributes(file)
            seal = attributes.pop("content_sha256", "")
            kind = _kind(path, attributes, kinds)
            if seal != content_digest(attributes):
                raise ValueError("its description is not what its SHA-256 says")
            datasets = open_datasets(file, kind, len(found.image))
            return replace(_survey(found, kind, attributes, seal, datasets), cut_off=cut_off)
    except SYMPTOMS as error:
        raise DamagedError(
            f"{path}: damaged beyond repair ({cut_off or cause_of(error)}): neither its directory nor "
            "the backup can be used; build it again"
        ) from None


def _kind(path: Path, attributes: Mapping[str, str], kinds: Sequence[FileFormat]) -> FileFormat:
    name, version = attributes.get("format"), attributes.get("version")
    kind = next((kind for kind in kinds if kind.name == name), None)
    if kind is None:
        wanted = " or ".join(kind.name for kind in kinds)
        raise InputError(f"{path}: expected a {wanted}, found {name or 'a foreign HDF5 file'}; name another")
    if version != str(kind.version):
        raise StaleError(
            f"{path}: {kind.name} of version {version}, this is version {kind.version}; build it again"
        )
    return kind


def _survey(
    found: RestoredFile,
    kind: FileFormat,
    attributes: Mapping[str, str],
    seal: str,
    datasets: Mapping[str, Dataset],
) -> IntegrityReport:
    damage = [] if found.has_directory else [DamagedBlock("directory")]
    damage += [] if found.has_backup else [DamagedBlock("backup of the directory")]
    digests = json.loads(attributes["tables_sha256"])
    intact: dict[str, list[IntactRow]] = {}
    for name in kind.tables:
        table = datasets[name].read()
        intact[name] = []
        n_before = len(damage)
        for row in _rows(kind, name, table, datasets):
            (damage if isinstance(row, DamagedBlock) else intact[name]).append(row)  # type: ignore[arg-type]
        if len(damage) == n_before and table_digest(table) != digests[name]:
            damage.append(DamagedBlock(f"order of the rows of {name}", name))
    return IntegrityReport(kind, attributes, seal, tuple(damage), "", intact)


def _rows(
    kind: FileFormat, name: str, table: AnyArray, datasets: Mapping[str, Dataset]
) -> Iterator[IntactRow | DamagedBlock]:
    """Yield every row of a table, or its damage."""
    for k, (row, digest) in enumerate(zip(table, row_digests(table), strict=True)):
        if row[SEAL] != digest:
            yield DamagedBlock(f"row {k} of {name}", _row_text(kind, name, row) + " (if its name is right)")
            continue
        pieces = {piece: _piece(row, piece, datasets[piece]) for piece in kind.tables[name].pieces}
        broken = [piece for piece, rows in pieces.items() if rows is None]
        if broken:
            yield DamagedBlock(f"{' and '.join(broken)} of row {k} of {name}", _row_text(kind, name, row))
        else:
            yield IntactRow(row, {piece: rows for piece, rows in pieces.items() if rows is not None})


def _piece(row: Any, name: str, dataset: Dataset) -> Array | None:
    first, count = int(row[f"{name}_first"]), int(row[f"{name}_count"])
    if not 0 <= first <= first + count <= len(dataset):
        return None
    rows: Array = dataset.rows(first, count)
    return rows if piece_digest(rows) == bytes(row[f"{name}_sha256"]).decode() else None


def _row_text(kind: FileFormat, name: str, row: Any) -> str:
    """Describe a row by its texts and indices, as far as they can be read."""
    fields = [field for field, type_ in kind.tables[name].fields.items() if type_ != "<f8"]
    values = (row[field] for field in fields)
    texts = (v.decode(errors="replace") if isinstance(v, bytes) else str(v) for v in values)
    return f"{name}: {', '.join(text for text in texts if text)}"
