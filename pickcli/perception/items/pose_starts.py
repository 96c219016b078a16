"""Starts of the search for an item: where it could be, by what was measured and by what was not."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import label

from pickcli.cell.place import Room
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array

_LEVEL = 0.85  # vertical part of the normal of a surface that is level
_YAWS = np.arange(4) * np.pi / 4
_ALONG_RAY = 0.06  # m of depth between starts for what has no depth
_LEAST_PIXELS = 12  # of a part of the picture


def spread_points(points: Array, spacing: float, most: int) -> list[int]:
    """Choose points that are far from each other: each the farthest from those before.

    Args:
        points: (N, 3).
        spacing: That each is from all before at least.
        most: Number of points at most.

    Returns:
        Indices.
    """
    if not len(points):
        return []
    x, y, z = np.ascontiguousarray(points.T)
    chosen, squares = [int(np.argmin(x))], np.full(len(points), np.inf)
    while True:
        last = chosen[-1]
        np.minimum(squares, (x - x[last]) ** 2 + (y - y[last]) ** 2 + (z - z[last]) ** 2, out=squares)
        farthest = int(np.argmax(squares))
        if len(chosen) >= most or squares[farthest] <= spacing**2:
            return chosen
        chosen.append(farthest)


def face_starts(shape: Shape, seeds: Array, normals: Array, room: Room) -> Array:
    """Put each face of a shape on measured points, as steep as the surface there.

    Of the directions in the face one is level; on a level surface it has each of four yaws. Every pose is
    tried with the face's middle on the point, and slid down or up along the face to the floor.

    Args:
        shape: The shape.
        seeds: (S, 3) m in the place's frame.
        normals: (S, 3) of the surface there, towards the camera.
        room: The place's room.

    Returns:
        (N, 4, 4) poses in the place's frame.
    """
    found = [np.zeros((0, 4, 4))]
    is_level = np.abs(normals[:, 2]) > _LEVEL
    for points, n, is_top in (
        (seeds[~is_level], normals[~is_level], False),
        (seeds[is_level], normals[is_level], True),
    ):
        if not len(points):
            continue
        for h in _level_directions(n, is_top):
            for R, reach in _frames(shape, n, h):
                at = points - reach * n
                found.append(_poses(R, at))
                if not is_top:
                    found.append(_poses(R, _on_floor(shape, R, at, n, room)))
    return np.concatenate(found)


def blind_starts(shape: Shape, eye: Array, rays: Array, room: Room) -> Array:
    """Put a shape on the floor at several distances along rays whose depth was not measured.

    Args:
        shape: The shape.
        eye: (3,) m, the camera's centre in the place's frame.
        rays: (S, 3) directions.
        room: The place's room.

    Returns:
        (N, 4, 4) poses in the place's frame; each ray goes through the height of the shape at its middle.
    """
    found = [np.zeros((0, 4, 4))]
    rays = rays[rays[:, 0] > 0.0]
    x = np.arange(room.x_range[0] + _ALONG_RAY / 2, room.x_range[1], _ALONG_RAY)
    points = (eye + (x[:, None, None] - eye[0]) / rays[None, :, :1] * rays[None]).reshape(-1, 3)
    points = points[(points[:, 1] > room.y_range[0]) & (points[:, 1] < room.y_range[1])]
    floor = room.floor_at(points[:, 0])
    for R, half in _lying(shape):
        through = (points[:, 2] > floor) & (points[:, 2] < floor + 2.0 * half[2])
        at = points[through].copy()
        at[:, 2] = floor[through] + half[2]
        found += [_poses(np.broadcast_to(_yawed(yaw) @ R, (len(at), 3, 3)), at) for yaw in _yaws(shape, half)]
    return np.concatenate(found)


def part_starts(shape: Shape, eye: Array, rays: Array, is_part: Array, room: Room) -> Array:
    """Put a shape on parts of a picture: their middle and main direction, as seen on the floor.

    Args:
        shape: The shape.
        eye: (3,) m, the camera's centre in the place's frame.
        rays: (height, width, 3) rays of all pixels in the place's frame.
        is_part: (height, width) pixels that may show it.
        room: The place's room.

    Returns:
        (N, 4, 4) poses in the place's frame, lying in every way along the parts and across.
    """
    labels, n_parts = label(is_part)
    found = [np.zeros((0, 4, 4))]
    for part in range(1, n_parts + 1):
        own = rays[labels == part]
        if len(own) < _LEAST_PIXELS:
            continue
        for R, half in _lying(shape):
            z = room.floor_back + half[2]
            down = own[own[:, 2] < -1e-3]
            points = eye + (z - eye[2]) / down[:, 2:] * down
            points = points[(points[:, 0] > room.x_range[0]) & (points[:, 0] < room.x_range[1])]
            if len(points) < _LEAST_PIXELS:
                continue
            middle, spread = points.mean(axis=0), np.cov(points[:, :2].T)
            direction = np.linalg.eigh(spread)[1][:, -1]
            at = np.array([[*middle[:2], float(room.floor_at(middle[0])) + half[2]]])
            yaw = float(np.arctan2(direction[1], direction[0]))
            found += [_poses((_yawed(yaw + turn) @ R)[None], at) for turn in (0.0, np.pi / 2)]
    return np.concatenate(found)


def _lying(shape: Shape) -> list[tuple[Array, Array]]:
    """Orientations with one of the shape's axes upwards, and half extents along the place's axes."""
    stand = np.eye(3)
    lie = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])  # z of the shape along x
    on_edge = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # y of the shape up or down
    n = {ShapeKind.SPHERE: 1, ShapeKind.CYLINDER: 2}.get(shape.kind, 3)
    return [(R, shape.reach(R)) for R in (stand, lie, on_edge)[:n]]


def _yaws(shape: Shape, half: Array) -> Array:
    is_round = shape.kind is ShapeKind.SPHERE or (shape.kind is ShapeKind.CYLINDER and half[0] == half[1])
    return _YAWS[:1] if is_round else _YAWS


def _yawed(yaw: float) -> Array:
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _level_directions(n: Array, is_top: bool) -> list[Array]:
    """Directions (S, 3) in the surfaces, of length 1: the level one, or several."""
    if not is_top:
        level = np.cross([0.0, 0.0, 1.0], n)
        return [level / np.linalg.norm(level, axis=1, keepdims=True)]
    found = []
    for yaw in _YAWS:
        level = np.array([np.cos(yaw), np.sin(yaw), 0.0]) - (n @ [np.cos(yaw), np.sin(yaw), 0.0])[:, None] * n
        found.append(level / np.linalg.norm(level, axis=1, keepdims=True))
    return found


def _frames(shape: Shape, n: Array, h: Array) -> list[tuple[Array, float]]:
    """Orientations (S, 3, 3) with a face across n and an axis along h, and how far the face is out."""
    half, other = shape.extents / 2, np.cross(n, h)
    if shape.kind is ShapeKind.SPHERE:
        return [(np.broadcast_to(np.eye(3), (len(n), 3, 3)), float(half[0]))]
    if shape.kind is ShapeKind.CYLINDER:
        return [
            (np.stack([h, other, n], axis=-1), float(half[2])),
            (np.stack([n, -other, h], axis=-1), float(half[0])),
            (np.stack([n, h, other], axis=-1), float(half[0])),
        ]
    found = []
    for face in range(3):
        a, b = (face + 1) % 3, (face + 2) % 3
        for first, second in ((h, other), (other, -h)):
            R = np.empty((len(n), 3, 3))
            R[:, :, face], R[:, :, a], R[:, :, b] = n, first, second
            found.append((R, float(half[face])))
    return found


def _on_floor(shape: Shape, R: Array, at: Array, n: Array, room: Room) -> Array:
    """Positions (S, 3) slid along the faces until the shapes rest on the floor."""
    along = np.array([0.0, 0.0, 1.0]) - n[:, 2:] * n
    drop = at[:, 2] - shape.reach(R)[:, 2] - room.floor_at(at[:, 0])
    return np.asarray(at - (drop / np.maximum(along[:, 2], 0.25))[:, None] * along)


def _poses(R: Array, at: Array) -> Array:
    T = np.zeros((len(at), 4, 4))
    T[:, :3, :3], T[:, :3, 3], T[:, 3, 3] = R, at, 1.0
    return T
