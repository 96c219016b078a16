"""Convex pieces of a mesh file, cached."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pickcli.errors import InputError
from pickcli.files.derived_cache import content_key, derived
from pickcli.geometry import Array
from pickcli.meshes.mesh_file import parse_triangles, read_mesh_bytes

_VERSION = "1"  # version of the algorithm; increase it with every change


def mesh_pieces(path: Path, scale: tuple[float, ...]) -> tuple[Array, ...]:
    """Find a few convex polyhedra that contain the mesh in a file.

    Args:
        path: The file.
        scale: (3,) factors on x, y and z.

    Returns:
        The corners (V, 3) of each polyhedron, in m in the frame of the mesh.

    Raises:
        InputError: The file cannot be read, is not a mesh, or the mesh is flat.
    """
    content = read_mesh_bytes(path)

    def derive() -> list[list[list[float]]]:
        from pickcli.meshes.convex_pieces import convex_pieces  # slow to import: scipy

        try:
            return [piece.tolist() for piece in convex_pieces(parse_triangles(path, content, scale))]
        except ValueError as error:
            raise InputError(f"{path}: {error}") from None

    key = content_key(_VERSION, path.suffix.lower(), repr(tuple(scale)), content)
    return tuple(np.array(piece) for piece in derived("meshes", key, derive))
