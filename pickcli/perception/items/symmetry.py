"""Differences of poses of items whose shapes look alike from several sides."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from itertools import product

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, pose, rotation_angle, rotation_axis_angle
from pickcli.scene.scene import PoseNoise

SAME_SIDE = 0.002  # m by which two sides of a box may differ and still be taken for each other


@cache
def symmetries(shape: Shape) -> tuple[Array, ...]:
    """List the rotations of a shape onto itself, of a cylinder only those that turn it over.

    Args:
        shape: A box, cylinder or sphere.

    Returns:
        Rotations (3, 3) in the shape's frame. The group of a box has 4, 8 or 24 of them by how many of its
        sides are equal, within ``SAME_SIDE``.
    """
    if shape.kind is ShapeKind.SPHERE:
        return (np.eye(3),)
    if shape.kind is ShapeKind.CYLINDER:
        return np.eye(3), np.diag([1.0, -1.0, -1.0])
    return tuple(
        R for R in _cube_rotations()
        if np.allclose(np.abs(R) @ shape.extents, shape.extents, atol=SAME_SIDE)
    )  # fmt: skip


def unlikeness(shape: Shape) -> float:
    """Compute by how much sides differ that may be taken for each other.

    Args:
        shape: A box, cylinder or sphere.

    Returns:
        m by which the surface is elsewhere if two of them are exchanged; 0 where none are but equal ones.
    """
    if shape.kind is not ShapeKind.BOX:
        return 0.0
    return max(_exchange(shape, S) for S in symmetries(shape))


def turn_between(shape: Shape, R: Array, R_true: Array) -> float:
    """Compute the least angle between two orientations of a shape.

    Args:
        shape: The shape.
        R: (3, 3).
        R_true: (3, 3).

    Returns:
        rad; turns that the shape does not show count as none.
    """
    if shape.kind is ShapeKind.SPHERE:
        return 0.0
    if shape.kind is ShapeKind.CYLINDER:
        return float(np.arccos(np.clip(abs(R[:, 2] @ R_true[:, 2]), 0.0, 1.0)))
    return min(rotation_angle(R.T @ R_true @ S) for S in symmetries(shape))


def faced_as(shape: Shape, T: Array, T_faced: Array) -> Array:
    """Turn a pose so that the shape does not show it, but its faces are those of another pose.

    Args:
        shape: The shape.
        T: (4, 4) a pose of it.
        T_faced: (4, 4) a pose with the right faces.

    Returns:
        (4, 4) of all poses that look like the first one that with the least turn to the second.
    """
    R, R_faced = T[:3, :3], T_faced[:3, :3]
    if shape.kind is ShapeKind.SPHERE:
        turned = R_faced
    elif shape.kind is ShapeKind.CYLINDER:
        turned = min(
            (_rolled(R @ S, R_faced) for S in symmetries(shape)), key=lambda each: _turn(each, R_faced)
        )
    else:
        turned = min((R @ S for S in symmetries(shape)), key=lambda each: _turn(each, R_faced))
    return pose(T[:3, 3], R=turned)


def _rolled(R: Array, R_faced: Array) -> Array:
    """The orientation (3, 3), rolled about its own z to be as near to another as that makes it."""
    between = R.T @ R_faced
    roll = np.arctan2(between[1, 0] - between[0, 1], between[0, 0] + between[1, 1])
    return np.asarray(R @ rotation_axis_angle(np.eye(3)[2], float(roll)))


def _turn(R: Array, R_other: Array) -> float:
    return float(rotation_angle(R.T @ R_other))


def error_of(shape: Shape, T: Array, T_true: Array) -> PoseNoise:
    """Compute by how much a pose is off, symmetries aside.

    Args:
        shape: The shape.
        T: (4, 4) a pose of it.
        T_true: (4, 4) its true pose.

    Returns:
        The errors, as they are compared with bounds.
    """
    shift = float(np.linalg.norm(T[:3, 3] - T_true[:3, 3]))
    turn = turn_between(shape, T[:3, :3], T_true[:3, :3])
    return PoseNoise(shift, turn, displacement_between(shape, T, T_true))


def displacement_between(shape: Shape, T: Array, T_true: Array) -> float:
    """Compute by how much the surface of a shape is off, symmetries aside.

    Args:
        shape: The shape.
        T: (4, 4) a pose of it.
        T_true: (4, 4) its true pose.

    Returns:
        m, so much that the shape at one pose, grown by it, contains the shape at the other.
    """
    corners = np.array(list(product((-0.5, 0.5), repeat=3))) * shape.extents
    shift, seen = T[:3, 3] - T_true[:3, 3], corners @ T[:3, :3].T
    if shape.kind is ShapeKind.SPHERE:
        return float(np.linalg.norm(shift))
    return min(
        float(np.linalg.norm(seen - corners @ R.T + shift, axis=1).max()) + unlike
        for R, unlike in _alike(shape, T[:3, :3], T_true[:3, :3])
    )


def _alike(shape: Shape, R: Array, R_true: Array) -> Iterator[tuple[Array, float]]:
    """Orientations (3, 3) that look like the true one, and m by which the surface differs there."""
    for S in symmetries(shape):
        if shape.kind is ShapeKind.CYLINDER:
            turn = np.cross((R_true @ S)[:, 2], R[:, 2])
            sine, cosine = float(np.linalg.norm(turn)), float((R_true @ S)[:, 2] @ R[:, 2])
            axis = turn / sine if sine > 0.0 else np.eye(3)[0]
            yield rotation_axis_angle(axis, np.arctan2(sine, cosine)).T @ R, 0.0
        else:
            yield R_true @ S, _exchange(shape, S)


def _exchange(shape: Shape, S: Array) -> float:
    """By how much (m) corners of a box are elsewhere if it is turned by one of its symmetries (3, 3)."""
    return float(np.linalg.norm(np.abs(S) @ shape.extents - shape.extents)) / 2


@cache
def _cube_rotations() -> tuple[Array, ...]:
    quarter = [np.round(rotation_axis_angle(axis, np.pi / 2)) for axis in np.eye(3)]
    found = [np.eye(3)]
    for R in found:
        for turn in quarter:
            if not any(np.array_equal(turn @ R, other) for other in found):
                found.append(turn @ R)
    return tuple(found)
