"""Reads point clouds from NPY, NPZ and PLY files, with size limits and without unpickling."""

from __future__ import annotations

import io
from pathlib import Path
from zipfile import BadZipFile, ZipFile

import numpy as np

from pickcli.errors import InputError
from pickcli.files.bounded_reading import read_bytes
from pickcli.geometry import Array

MAX_BYTES = 64_000_000
MAX_POINTS = 1_000_000

# NumPy's names of PLY's types.
_TYPES = {
    **dict.fromkeys(("char", "int8"), "i1"),
    **dict.fromkeys(("uchar", "uint8"), "u1"),
    **dict.fromkeys(("short", "int16"), "i2"),
    **dict.fromkeys(("ushort", "uint16"), "u2"),
    **dict.fromkeys(("int", "int32"), "i4"),
    **dict.fromkeys(("uint", "uint32"), "u4"),
    **dict.fromkeys(("float", "float32"), "f4"),
    **dict.fromkeys(("double", "float64"), "f8"),
}
_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}


def read_points(path: Path) -> Array:
    """Read the points of a cloud.

    Args:
        path: An NPY file with an array (N, 3), an NPZ file with a single such array or one named ``points``,
            or a PLY file with the x, y and z of its vertices.

    Returns:
        (N, 3) m.

    Raises:
        InputError: The file cannot be read, has another format, or is damaged or too large.
    """
    readers = {".npy": _from_npy, ".npz": _from_npz, ".ply": _from_ply}
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"{path}: expected a cloud in {', '.join(readers)}; convert it")
    content = read_bytes(path, MAX_BYTES, "the scene names it as its cloud")
    try:
        points = reader(content)
    except (ValueError, LookupError, EOFError, OSError, BadZipFile, MemoryError) as error:
        kind = path.suffix[1:].upper()
        raise InputError(f"{path}: is no {kind} cloud that can be read: {error}; write it again") from None
    if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind not in "fiu":
        raise InputError(f"{path}: expected numbers of shape (N, 3), got {points.dtype} {points.shape}")
    if not 0 < len(points) <= MAX_POINTS:
        advice = "thin it out" if len(points) else "leave the cloud out of the scene, or write it again"
        raise InputError(f"{path}: has {len(points)} points; expected 1 to {MAX_POINTS}: {advice}")
    return np.ascontiguousarray(points, dtype=np.float64)


def _from_npy(content: bytes) -> Array:
    return np.asarray(np.load(io.BytesIO(content), allow_pickle=False))


def _from_npz(content: bytes) -> Array:
    with ZipFile(io.BytesIO(content)) as archive:
        size = sum(member.file_size for member in archive.infolist())
    if size > MAX_BYTES:
        raise ValueError(f"it unpacks to {size} bytes, expected {MAX_BYTES} at most")
    with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
        names = list(arrays)
        if "points" not in names and len(names) != 1:
            raise ValueError(f"expected an array called 'points', got {', '.join(names)}")
        return np.asarray(arrays["points" if "points" in names else names[0]])


def _from_ply(content: bytes) -> Array:
    head, end, body = content.partition(b"end_header\n")
    lines = [line.split() for line in head.decode("ascii").splitlines()]
    if not end or lines[0] != ["ply"]:
        raise ValueError("its header is not that of a PLY file")
    form = next((line[1] for line in lines if line[:1] == ["format"]), "")
    n_points, properties = _vertices(lines)
    if n_points > MAX_POINTS:
        raise ValueError(f"it has {n_points} points, expected {MAX_POINTS} at most")
    names = [name for _, name in properties]
    if missing := [axis for axis in "xyz" if axis not in names]:
        raise ValueError(f"its vertices have no {' and no '.join(missing)}")
    if form == "ascii":
        rows = [line.split() for line in body.splitlines()[:n_points]]
        if len(rows) < n_points:  # cut off: what is missing would count as free
            raise ValueError(f"it has {len(rows)} of the {n_points} points that its header states")
        return np.array(rows, dtype=float).reshape(n_points, len(names))[:, list(map(names.index, "xyz"))]
    fields = [(name, _ORDERS[form] + _TYPES[kind]) for kind, name in properties]
    vertices = np.frombuffer(body, dtype=fields, count=n_points)
    return np.column_stack([vertices[axis] for axis in "xyz"]).astype(float)


def _vertices(lines: list[list[str]]) -> tuple[int, list[tuple[str, str]]]:
    """Number of vertices, which must come first, and type and name of each of their properties."""
    starts = [i for i, line in enumerate(lines) if line[:1] == ["element"]]
    if not starts or lines[starts[0]][1] != "vertex":
        raise ValueError("its vertices do not come first")
    last = starts[1] if len(starts) > 1 else len(lines)
    properties = [line for line in lines[starts[0] + 1 : last] if line[:1] == ["property"]]
    if any(line[1] == "list" for line in properties):
        raise ValueError("its vertices have lists")
    return int(lines[starts[0]][2]), [(line[1], line[2]) for line in properties]
