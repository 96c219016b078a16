"""Safe opening of HDF5 files that may be damaged or malicious.

A file can refer to other files (links, virtual and external data) and declare terabytes in a few kB.
Everything that this program never writes is refused before any data is read: groups, links, virtual or
external data, filters, unknown names and types, and sizes larger than the file itself.
"""

from __future__ import annotations

import logging
import math
import os
import re
import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any, BinaryIO

import h5py
import numpy as np

from pickcli.errors import DamagedError, InputError
from pickcli.files.bounded_reading import refuse_special_file
from pickcli.files.file_kind import (
    PICTURE_MAGICS,
    STORE,
    STORE_END,
    kind_of,
    refuse_encoded,
    refuse_other_kind,
)
from pickcli.storage.header_backup import MAX_FILE
from pickcli.storage.table_format import MAX_ATTRIBUTE, MAX_TEXT, NUMBER, TEXT, AnyArray, FileFormat, Table

MAX_NAMES = 64
HEAD = 64  # bytes used to recognise a text
MAX_TEXT_READ = 2**20  # bytes of a text that are read to determine its kind

# Exceptions of h5py and of the checks here for damaged files.
SYMPTOMS = (
    OSError,
    RuntimeError,
    LookupError,
    ValueError,
    TypeError,
    ArithmeticError,
    MemoryError,
    SystemError,
)

_CUT_OFF = re.compile(r"truncated file: eof = (\d+).*stored_eof = (\d+)")  # message of HDF5
_log = logging.getLogger(__name__)


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """Open a file for reading; all errors while it is read become a DamagedError.

    Args:
        path: The file.

    Yields:
        The open ``h5py.File``.

    Raises:
        InputError: The file cannot be read (see ``check_readable``).
        DamagedError: Reading fails.
    """
    check_readable(path)
    try:
        with h5py.File(path, "r", locking=False) as file:
            _log.info("opened %s: %d bytes", path, path.stat().st_size)
            yield file
    except SYMPTOMS as error:
        raise damaged(path, cause_of(error)) from None


def cause_of(error: Exception) -> str:
    """Describe an exception in one short line.

    Args:
        error: The exception.

    Returns:
        The line.
    """
    if cut := _CUT_OFF.search(str(error)):
        return f"cut off at byte {cut[1]} of at least {cut[2]}"
    return str(error).split("\n")[0][:200] or type(error).__name__


def damaged(path: Path, cause: str) -> DamagedError:
    """Create the error for a damaged file.

    Args:
        path: The file.
        cause: The detected damage.

    Returns:
        The error, to be raised.
    """
    return DamagedError(
        f"{path}: damaged ({cause}); apc check {shlex.quote(str(path))} prints what is lost and whether it "
        "can be repaired, else build it again"
    )


def read_attributes(file: Any) -> dict[str, str]:
    """Read the attributes of a file, which must be short fixed-length strings.

    Args:
        file: Open ``h5py.File``.

    Returns:
        Attributes by name.

    Raises:
        ValueError: There are too many attributes, or one has another type.
    """
    # Uses the low-level h5a here and below: h5py's wrappers take twice as long, which delays every query.
    n_attributes = h5py.h5a.get_num_attrs(file.id)
    if n_attributes > MAX_NAMES:
        raise ValueError("too many attributes")
    found = {}
    for i in range(n_attributes):
        attribute = h5py.h5a.open(file.id, index=i)
        dtype = attribute.dtype
        if dtype.kind != "S" or attribute.shape != () or dtype.itemsize > MAX_ATTRIBUTE:
            raise ValueError(f"attribute {i} is no short string")
        text = np.empty((), dtype)
        attribute.read(text)
        found[attribute.name.decode()] = bytes(text[()]).decode()
    return found


def check_readable(path: Path) -> None:
    """Check before opening that a path can be a file written by this program.

    Args:
        path: The file.

    Raises:
        InputError: The path is missing, not a regular file, a text, larger than MAX_FILE, or not
            readable.
    """
    try:
        refuse_special_file(path, "build it first, or name another")
        with open(path, "rb") as file:
            if os.fstat(file.fileno()).st_size > MAX_FILE:
                raise InputError(
                    f"{path}: larger than {MAX_FILE >> 20} MB, which no file of this program is; name another"
                )
            head = file.read(HEAD)
            end = _last_bytes(file)
            text = head + file.read(MAX_TEXT_READ) if _is_text(head) else None
        refuse_encoded(path, head)
        if head.startswith(PICTURE_MAGICS):
            refuse_other_kind(path, head, STORE)
        if text is not None:
            refuse_other_kind(path, text, STORE, is_whole=len(text) < HEAD + MAX_TEXT_READ)
            raise InputError(f"{path}: is a text file, not a roadmap or trajectory database; name another")
        if kind_of(head + end) is not STORE:
            what = "neither begins nor ends like a roadmap or trajectory database" if head else "is empty"
            raise InputError(f"{path}: {what}; name another file, or build it")
    except FileNotFoundError:
        raise InputError(f"{path}: no such file; build it first, or name another") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None


def _last_bytes(file: BinaryIO) -> bytes:
    """Last bytes of a file, which mark a stored one; the file position is restored."""
    at = file.tell()
    file.seek(max(0, file.seek(0, os.SEEK_END) - len(STORE_END)))
    end = file.read()
    file.seek(at)
    return end


def _is_text(head: bytes) -> bool:
    """Whether a file begins like JSON or YAML, and so is not a damaged file of this program."""
    return len(head) > 0 and head.isascii() and b" ".join(head.split()).decode("ascii").isprintable()


@dataclass(frozen=True)
class Dataset:
    """A dataset whose type, shape and location have been checked.

    Attributes:
        id: Low-level HDF5 handle.
        dtype: Type of an element.
        shape: Shape of the dataset.
    """

    id: Any
    dtype: np.dtype[Any]
    shape: tuple[int, ...]

    def __len__(self) -> int:
        return self.shape[0]

    def read(self) -> AnyArray:
        """Read all rows.

        Returns:
            The rows.
        """
        return self.rows(0, len(self))

    def rows(self, first: int, count: int) -> AnyArray:
        """Read consecutive rows, which must exist.

        Args:
            first: Index of the first row.
            count: Number of rows.

        Returns:
            The rows.
        """
        rows = np.empty((count, *self.shape[1:]), self.dtype)
        if rows.size:
            space = self.id.get_space()
            space.select_hyperslab((first, *(0 for _ in self.shape[1:])), rows.shape)
            # Raw bytes, as rows of this type have the same size and layout, see _dataset.
            self.id.read(h5py.h5s.create_simple(rows.shape), space, rows, self.id.get_type())
        return rows


def open_datasets(file: Any, kind: FileFormat, n_bytes: int) -> dict[str, Dataset]:
    """Open the datasets of a file, after refusing everything that the file must not contain.

    No data are read before that.

    Args:
        file: Open ``h5py.File``.
        kind: Expected format.
        n_bytes: Size of the file.

    Returns:
        Datasets by name.

    Raises:
        ValueError: The file contains anything else.
    """
    names = sorted(file.keys()) if len(file) <= MAX_NAMES else []
    if names != sorted([*kind.tables, *kind.owners]):
        raise ValueError(f"it holds {', '.join(names) or 'nothing'}, not what a {kind.name} does")
    return {name: _dataset(file, name, kind.tables.get(name), n_bytes) for name in names}


def _dataset(file: Any, name: str, table: Table | None, n_bytes: int) -> Dataset:
    """Open a table or a dataset of pieces with its data in the file itself. Raises ValueError otherwise."""
    if file.id.links.get_info(name.encode()).type != h5py.h5l.TYPE_HARD:
        raise ValueError(f"{name} is a link to elsewhere")
    opened_id = h5py.h5o.open(file.id, name.encode())
    if not isinstance(opened_id, h5py.h5d.DatasetID):
        raise ValueError(f"{name} is no dataset")
    properties = opened_id.get_create_plist()
    contiguous = properties.get_layout() == h5py.h5d.CONTIGUOUS
    if not contiguous or properties.get_external_count() or properties.get_nfilters():
        raise ValueError(f"{name} has data elsewhere, chunks or filters")
    stored_type = opened_id.get_type()
    dataset = Dataset(opened_id, _numpy_type(stored_type.encode()), opened_id.shape)
    if stored_type.get_size() != dataset.dtype.itemsize:
        raise ValueError(f"{name} holds a type that numpy does not have")
    if math.prod(dataset.shape) * dataset.dtype.itemsize > n_bytes:
        raise ValueError(f"{name} declares more than the file holds")
    n_dimensions = 2 if table is None else 1
    if len(dataset.shape) != n_dimensions or not _is_type(dataset.dtype, table):
        raise ValueError(f"{name} holds {dataset.dtype} of shape {dataset.shape}")
    return dataset


@lru_cache(maxsize=64)
def _numpy_type(encoded: bytes) -> np.dtype[Any]:
    """Decode the type of rows from HDF5's serialized form; cached, as decoding takes ten times as long."""
    found: np.dtype[Any] = h5py.h5t.decode(encoded).dtype
    return found


def _is_type(found: np.dtype[Any], table: Table | None) -> bool:
    """Whether a type is that of a table's rows, with texts of any reasonable width, or of pieces."""
    return found.str == NUMBER if table is None else _is_row_type(found, table)


def _is_row_type(found: np.dtype[Any], table: Table) -> bool:
    """Whether a type is that of the table's rows, with texts of any reasonable width."""
    if found.names is None:
        return False
    texts = [field for field, kind in table.fields.items() if kind == TEXT and field in found.names]
    widths = dict.fromkeys(table.fields, 1) | {field: found[field].itemsize for field in texts}
    return all(0 < width <= MAX_TEXT for width in widths.values()) and found == table.row_type(widths)
