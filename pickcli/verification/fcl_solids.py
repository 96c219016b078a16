"""Exact shapes by python-fcl, and quick lower bounds of their distances. The only module that uses fcl."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import fcl
import numpy as np
from scipy.spatial import ConvexHull

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array
from pickcli.meshes.mesh_file import parse_triangles, read_mesh_bytes
from pickcli.verification.separation import corners, gap, overlap, separation

MAX_BALLS = 12
MAX_FCL_EXCESS = 5e-5  # m by which fcl's distance may exceed the gap along its own direction
_NEAREST_POINTS = fcl.DistanceRequest(enable_nearest_points=True)


class PosedGeometry:
    """A geometry that fcl can pose and test for contact.

    Args:
        geometry: The geometry as fcl has it.
    """

    def __init__(self, geometry: object) -> None:
        self._T = np.eye(4)
        self._object = fcl.CollisionObject(geometry, fcl.Transform())

    def place(self, T_world_shape: Array) -> None:
        """Put the geometry at a pose.

        Args:
            T_world_shape: (4, 4) of its own frame.
        """
        self._T = T_world_shape
        self._object.setTransform(fcl.Transform(T_world_shape[:3, :3], T_world_shape[:3, 3]))

    def meets(self, other: PosedGeometry) -> bool:
        """Whether fcl finds that this geometry touches or overlaps another one.

        Args:
            other: The other geometry.

        Returns:
            True if they do.
        """
        return bool(fcl.collide(self._object, other._object, fcl.CollisionRequest(), fcl.CollisionResult()))


class Surface(PosedGeometry):
    """The triangles of a mesh, with nothing inside. Its frame is that of the mesh.

    Args:
        path: The file of the mesh.
        scale: (3,) factors on x, y and z of the file.

    Raises:
        InputError: The file cannot be read, or is not a mesh.
    """

    def __init__(self, path: Path, scale: tuple[float, ...]) -> None:
        super().__init__(_triangles(path, scale))


class Solid(PosedGeometry):
    """A shape that fcl can pose and measure. Its frame is the shape's own.

    Args:
        shape: The shape.
    """

    def __init__(self, shape: Shape) -> None:
        super().__init__(_geometry(shape))
        self._shape = shape

    def distance(self, other: Solid) -> float:
        """Return a lower bound of the distance to another solid, normally exact.

        fcl's distance is not trusted: its search sometimes stops early, rarely centimetres too far. Its
        nearest points give a direction along which the gap is measured; if that gap is smaller than fcl's
        distance, the verifier's own search decides.

        Args:
            other: The other solid.

        Returns:
            m; 0 when they touch or overlap.
        """
        found = fcl.DistanceResult()
        distance = float(fcl.distance(self._object, other._object, _NEAREST_POINTS, found))
        if distance > 0.0:
            way = np.subtract(found.nearest_points[1], found.nearest_points[0])
            width = gap(self._shape, self._T, other._shape, other._T, way)
            if width >= distance - MAX_FCL_EXCESS:
                return max(0.0, width)
        return separation(self._shape, self._T, other._shape, other._T)

    def depth(self, other: Solid) -> float:
        """Return an upper bound of how deep two solids overlap.

        fcl decides whether they meet, and where. Its depth is centimetres too large for one pair in ten, and
        slightly too small for some.

        Args:
            other: The other solid.

        Returns:
            m; 0 when they do not overlap.
        """
        request = fcl.CollisionRequest(num_max_contacts=8, enable_contact=True)
        result = fcl.CollisionResult()
        fcl.collide(self._object, other._object, request, result)
        if not result.contacts:
            return 0.0
        normals = [np.asarray(contact.normal) for contact in result.contacts]
        return overlap(self._shape, self._T, other._shape, other._T, normals)[0]


@lru_cache(maxsize=64)
def _triangles(path: Path, scale: tuple[float, ...]) -> object:
    """Read a mesh as a hierarchy of bounding volumes of its triangles."""
    corners = parse_triangles(path, read_mesh_bytes(path), scale).reshape(-1, 3)
    faces = np.arange(len(corners)).reshape(-1, 3)
    hierarchy = fcl.BVHModel()
    hierarchy.beginModel(len(faces), len(corners))
    hierarchy.addSubModel(corners, faces)
    hierarchy.endModel()
    return hierarchy


def _geometry(shape: Shape) -> object:
    if shape.kind is ShapeKind.BOX:
        return fcl.Box(*shape.size)
    if shape.kind is ShapeKind.CYLINDER:
        return fcl.Cylinder(*shape.size)
    if shape.kind is ShapeKind.HULL:
        return _convex(shape)
    return fcl.Sphere(*shape.size)


@lru_cache(maxsize=256)
def _convex(shape: Shape) -> object:
    """Convert a hull to fcl: of each triangle the number of corners, then these in order, from outside."""
    points = corners(shape)
    hull = ConvexHull(points)
    triangles = hull.simplices.copy()
    a, b, c = (points[triangles[:, k]] for k in range(3))
    inwards = np.einsum("tk,tk->t", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    triangles[inwards] = triangles[inwards][:, ::-1]
    faces = np.column_stack([np.full(len(triangles), 3), triangles])
    return fcl.Convex(points, len(triangles), faces.ravel())


@dataclass(frozen=True, eq=False)
class CoveringSpheres:
    """Spheres whose union contains a shape.

    Attributes:
        centers: (K, 3) m in the shape's frame.
        radius: m.
    """

    centers: Array
    radius: float


@lru_cache(maxsize=256)
def cover(shape: Shape) -> CoveringSpheres:
    """Cover a shape with spheres in a row along the longest side of its bounding box.

    Args:
        shape: The shape.

    Returns:
        The spheres.
    """
    extents = shape.extents
    axis = int(np.argmax(extents))
    across = float(np.linalg.norm(np.delete(extents, axis)))
    if shape.kind is ShapeKind.SPHERE:
        return CoveringSpheres(np.zeros((1, 3)), shape.size[0])
    if shape.kind is ShapeKind.CYLINDER and axis == 2:
        across = 2 * shape.size[0]
    n = min(MAX_BALLS, int(np.ceil(extents[axis] / across)))
    piece = extents[axis] / n
    centers = np.zeros((n, 3))
    centers[:, axis] = (np.arange(n) + 0.5) * piece - extents[axis] / 2
    return CoveringSpheres(centers, float(np.hypot(piece, across)) / 2)


def distances_to_boxes(points: Array, T_world_box: Array, half: Array) -> Array:
    """Distances of points from boxes.

    Args:
        points: (..., 3) m in the world.
        T_world_box: (B, 4, 4) poses of the boxes.
        half: (B, 3) m, half extents.

    Returns:
        (..., B) m; 0 inside.
    """
    squared = np.zeros((*points.shape[:-1], len(half)))
    for axis in range(3):
        towards = T_world_box[:, :3, axis]
        outside = points @ towards.T
        outside -= np.einsum("bk,bk->b", towards, T_world_box[:, :3, 3])
        outside = np.maximum(0.0, np.abs(outside, out=outside) - half[:, axis])
        squared += np.square(outside, out=outside)
    return np.sqrt(squared)
