"""Reads mesh files as triangles: STL (text or binary), OBJ and COLLADA. The only module that uses trimesh."""

from __future__ import annotations

import io
import logging
from pathlib import Path
from typing import Any

import numpy as np

from pickcli.errors import InputError
from pickcli.files.bounded_reading import read_bytes
from pickcli.geometry import Array

SUFFIXES = (".stl", ".obj", ".dae")
MAX_BYTES = 64_000_000
MAX_TRIANGLES = 1_000_000
MAX_EXTENT = 10.0  # m, largest link; larger meshes are in another unit


def read_mesh_bytes(path: Path) -> bytes:
    """Read the content of a mesh file.

    Args:
        path: The file; files that it refers to (textures, materials) are not read.

    Returns:
        Its bytes.

    Raises:
        InputError: It cannot be read, is too large, or its name does not end with one of ``SUFFIXES``.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"{path}: expected a mesh in {', '.join(SUFFIXES)}; convert it")
    return read_bytes(path, MAX_BYTES, "the URDF names it as a collision mesh")


def parse_triangles(path: Path, content: bytes, scale: tuple[float, ...]) -> Array:
    """Parse the triangles in the content of a mesh file.

    The unit stated in a COLLADA file is applied; its up axis is ignored, as in RViz.

    Args:
        path: The file, for its format and for messages.
        content: Its bytes.
        scale: (3,) factors on x, y and z.

    Returns:
        (T, 3, 3) m, corners of the triangles in the frame of the mesh.

    Raises:
        InputError: The content is not a mesh, has no or too many triangles, or is larger than any link.
    """
    triangles = _load(path, content) * np.asarray(scale)
    if not len(triangles):
        raise InputError(f"{path}: has no triangles; export the mesh again")
    if len(triangles) > MAX_TRIANGLES:
        raise InputError(f"{path}: has {len(triangles)} triangles; simplify it to {MAX_TRIANGLES} at most")
    if not np.isfinite(triangles).all():
        raise InputError(f"{path}: has corners that are not finite; export the mesh again")
    extent = float(np.ptp(triangles.reshape(-1, 3), axis=0).max())
    if extent > MAX_EXTENT:
        raise InputError(
            f"{path}: is {extent:.4g} m long, expected {MAX_EXTENT:g} m at most; lengths are in m: "
            'a mesh in mm needs scale="0.001 0.001 0.001" in the URDF'
        )
    return np.asarray(triangles, dtype=np.float64)


def _load(path: Path, content: bytes) -> Array:
    import trimesh  # slow to import; only for robots with meshes

    logging.getLogger("trimesh").setLevel(logging.ERROR)
    kind = path.suffix.lower().removeprefix(".")
    try:
        scene: Any = trimesh.load_scene(
            io.BytesIO(content), file_type=kind, process=False, allow_remote=False
        )
        mesh: Any = scene.to_mesh()
        metres = trimesh.units.unit_conversion(mesh.units, "meters") if mesh.units and kind == "dae" else 1.0
        return np.asarray(mesh.triangles) * metres
    except Exception as error:  # trimesh's readers may raise any exception
        raise InputError(f"{path}: is no {kind.upper()} mesh that can be read: {error}") from None
