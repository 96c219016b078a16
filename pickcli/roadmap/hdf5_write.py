"""Writing HDF5 files that survive crashes and are the same bytes for the same content.

The file is built in memory in the latest format, whose headers carry checksums as our datasets do, and is
then written like any other bytes: a full disk is an error instead of a crash of the library, a kill leaves
the old file.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from pickcli.cell.atomic import write_bytes
from pickcli.roadmap.hdf5_format import AnyArray, Content, Format, array_digest, content_digest

_CHUNK = 2**16  # bytes, about; each chunk has one checksum


def write_content(path: Path, kind: Format, content: Content) -> None:
    """Write a file whole or not at all. Raises InputError if the place cannot be written."""
    write_bytes(path, to_bytes(kind, content))


def to_bytes(kind: Format, content: Content) -> bytes:
    """The file's bytes, a pure function of the content."""
    arrays = {name: np.ascontiguousarray(content.arrays[name]) for name in sorted(kind.columns)}
    attributes = {
        "format": kind.name,
        "version": str(kind.version),
        "cell_fingerprint": content.fingerprint,
        "made": json.dumps(content.made, sort_keys=True),
        "arrays_sha256": json.dumps({name: array_digest(array) for name, array in arrays.items()}),
    }
    attributes["content_sha256"] = content_digest(attributes)
    with h5py.File("memory", "w", driver="core", backing_store=False, libver="latest") as file:
        for name, text in attributes.items():
            file.attrs[name] = np.bytes_(text.encode())
        for name, array in arrays.items():
            _write_dataset(file, name, array)
        file.flush()
        return bytes(file.id.get_file_image())


def _write_dataset(file: Any, name: str, array: AnyArray) -> None:
    bytes_per_row = max(1, array.itemsize * int(np.prod(array.shape[1:], dtype=int)))
    n_rows = min(max(1, _CHUNK // bytes_per_row), max(1, len(array)))
    file.create_dataset(
        name,
        data=array,
        maxshape=(max(1, len(array)), *array.shape[1:]),
        chunks=(n_rows, *array.shape[1:]),
        fletcher32=True,
        track_times=False,
    )
