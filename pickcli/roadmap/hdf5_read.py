"""Reading HDF5 files that may be damaged or hostile.

A file can point elsewhere (links, virtual and external data) and declare terabytes in a few kB. Everything
that a file of ours never has is refused before any data is read: groups, links to elsewhere, virtual or
external data, filters but the checksum, unknown names, types and sizes.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py

from pickcli.errors import DamagedError, InputError, StaleError
from pickcli.roadmap.hdf5_format import (
    ANY_WIDTH,
    TEXT,
    AnyArray,
    Column,
    Content,
    Format,
    array_digest,
    content_digest,
)

MAX_FILE = 512 * 2**20  # bytes
MAX_DATASET = 256 * 2**20  # bytes that one dataset may declare
MAX_ATTRIBUTE = 60 * 2**10  # bytes
MAX_NAMES = 64

# What h5py and our own checks raise on bytes that are not what was written.
_SYMPTOMS = (
    OSError,
    RuntimeError,
    LookupError,
    ValueError,
    TypeError,
    ArithmeticError,
    MemoryError,
    SystemError,
)


def read_content(
    path: Path, kind: Format, fingerprint: str | None = None, without: Collection[str] = ()
) -> Content:
    """Read and check a file; with ``fingerprint``, only if it was made for that cell.

    without: datasets that are checked for shape but not read
    Raises InputError for a missing file or one of another kind, DamagedError for bytes that are not those
    written, StaleError for another version or cell.
    """
    with opened(path) as file:
        attributes = read_attributes(file)
        _check_kind(path, kind, attributes)
        _check_fingerprint(path, kind, attributes.get("cell_fingerprint", ""), fingerprint)
        if attributes.pop("content_sha256", "") != content_digest(attributes):
            raise ValueError("its description is not what its SHA-256 says")
        arrays = _read_arrays(file, kind, json.loads(attributes["arrays_sha256"]), without)
        return Content(attributes["cell_fingerprint"], json.loads(attributes["made"]), arrays)


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """The file open for reading; whatever goes wrong while it is read becomes a DamagedError."""
    _check_readable(path)
    try:
        with h5py.File(path, "r", locking=False) as file:
            yield file
    except _SYMPTOMS as error:
        cause = str(error).split("\n")[0][:200] or type(error).__name__
        raise DamagedError(f"{path}: damaged ({cause}); delete it and build it again") from None


def read_attributes(file: Any) -> dict[str, str]:
    """The file's attributes: short fixed-length strings, nothing else. Raises ValueError."""
    if len(file.attrs) > MAX_NAMES:
        raise ValueError("too many attributes")
    found = {}
    for name in file.attrs:
        attribute = file.attrs.get_id(name)
        if attribute.dtype.kind != "S" or attribute.shape != () or attribute.dtype.itemsize > MAX_ATTRIBUTE:
            raise ValueError(f"attribute {name} is no short string")
        found[name] = bytes(file.attrs[name]).decode()
    return found


def _check_readable(path: Path) -> None:
    try:
        if not path.is_file():
            what = "is not a regular file" if path.exists() else "no such file"
            raise InputError(f"{path}: {what}; build it first, or name another")
        if path.stat().st_size > MAX_FILE:
            raise InputError(f"{path}: larger than {MAX_FILE >> 20} MB, so no file of ours; name another")
        with open(path, "rb"):
            pass
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from None


def _check_kind(path: Path, kind: Format, attributes: Mapping[str, str]) -> None:
    found, version = attributes.get("format"), attributes.get("version")
    if found != kind.name:
        raise InputError(
            f"{path}: expected a {kind.name}, found {found or 'a foreign HDF5 file'}; name another"
        )
    if version != str(kind.version):
        raise StaleError(
            f"{path}: {kind.name} of version {version}, this is version {kind.version}; build it again"
        )


def _check_fingerprint(path: Path, kind: Format, found: str, expected: str | None) -> None:
    if expected is not None and found != expected:
        raise StaleError(
            f"{path}: this {kind.name} was made for a cell with fingerprint {found[:16]}, "
            f"the cell in use has {expected[:16]}; build it again or use the cell that it belongs to"
        )


def _read_arrays(
    file: Any, kind: Format, digests: Mapping[str, str], without: Collection[str]
) -> dict[str, AnyArray]:
    """The datasets of the format, every one of them checked before any is read."""
    names = sorted(file.keys()) if len(file) <= MAX_NAMES else []
    if names != sorted(kind.columns):
        raise ValueError(f"it holds {', '.join(names) or 'nothing'}, not what a {kind.name} does")
    for name in names:
        if type(file.get(name, getlink=True)) is not h5py.HardLink:
            raise ValueError(f"{name} is a link to elsewhere")
        if file.get(name, getclass=True) is not h5py.Dataset:
            raise ValueError(f"{name} is no dataset")
        _check_dataset(name, file[name], kind.columns[name])
    arrays = {name: file[name][...] for name in names if name not in without}
    for name, array in arrays.items():
        if array_digest(array) != digests[name]:
            raise ValueError(f"{name} is not what its SHA-256 says")
    return arrays


def _check_dataset(name: str, dataset: Any, column: Column) -> None:
    """Refuse data that lies elsewhere, unknown filters, and types, shapes and sizes that are not ours."""
    properties = dataset.id.get_create_plist()
    filters = [properties.get_filter(i)[0] for i in range(properties.get_nfilters())]
    if dataset.is_virtual or dataset.external or filters != [h5py.h5z.FILTER_FLETCHER32]:
        raise ValueError(f"{name} has data elsewhere, or filters that are not ours")
    dtype = dataset.dtype
    if dtype.str != column.dtype and not (column.dtype == TEXT and dtype.kind == "S"):
        raise ValueError(f"{name} holds {dtype}, not {column.dtype}")
    widths = dataset.shape[1:]
    if len(widths) != (column.width is not None) or (column.width not in (None, ANY_WIDTH, *widths)):
        raise ValueError(f"{name} has the shape {dataset.shape}")
    if dataset.size * dtype.itemsize > MAX_DATASET:
        raise ValueError(f"{name} declares more than {MAX_DATASET >> 20} MB")
