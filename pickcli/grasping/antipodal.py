"""Grasps for two fingers: pairs of opposite places on an item, with the pads flat on both of them.

A pinch is antipodal if the line between its contacts lies inside the friction cones at both (V.-D. Nguyen,
"Constructing force-closure grasps", IJRR 7(3), 1988). Here that line is the normal at both: opposite faces of
a box or ends of a cylinder, or the ends of a diameter of a round side. On a round side a pad touches a strip
as wide as the compliance of its rubber allows (``GIVES_WAY``).

An item may stand off from where it is seen by the bounds of its pose error. Closing fingers centre it between
them, but do not turn it flat: friction on both pads locks an item that is wider than a pad over the
coefficient, and the floor holds one that stands. So its centre may be off along the pads, the pads rest on
other parts of it, and where they stand askew only their middle touches on both sides.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.cell.tools.pinch_limits import PinchLimits
from pickcli.geometry import Array, cross, perpendiculars, pose, rotation_axis_angle
from pickcli.scene.scene import PoseNoise

MAX_TILT = np.radians(30.0)  # between the way in and the tool's axis
SHARES = (1.0, 0.75, 0.5)  # of a pad's sides, tried if not all of it is on a face
LEAST_SHARE = 0.25  # of a pad's sides that stays on the face with every error of the pose
GIVES_WAY = 0.0003  # m that rubber is compressed: a low estimate
YAWS = np.radians(np.arange(0.0, 360.0, 30.0))  # about the approach axis, for shapes symmetric about it
EDGE_ROUNDING = 1e-9  # m beyond an edge that count as on it


@dataclass(frozen=True, eq=False)
class Pinch:
    """Two opposite places on an item.

    Attributes:
        face: Pinched face: "x", "y" or "z" for the flat faces across that axis, "mantle" or "sphere".
        T_item_tip: (4, 4) tool frame in the item's, midway between both places.
        width: m between them.
    """

    face: str
    T_item_tip: Array
    width: float


def pinches(
    shape: Shape,
    pad: tuple[float, float],
    way_in: Array,
    fan: Iterable[float],
    grid: int,
    rng: np.random.Generator,
    n_random: int,
) -> Iterator[Pinch]:
    """Generate the pinches of a shape that are approached roughly along a direction.

    Args:
        shape: Shape of the item.
        pad: (a, b) m, sides of the pads along x and z of the tool frame.
        way_in: (3,) unit vector in the item frame, direction of the hand's approach.
        fan: rad, turns about the axis of closing that are tried.
        grid: Number of places along each side of the pinched faces, besides their middle and near edge.
        rng: Source of random places.
        n_random: Number of random places for each pair of faces.

    Yields:
        The pinches, of any width, also wider than the fingers open.
    """
    for face, y, z, half_x, half_z in _lines(shape, way_in):
        straight = _frame(y, z)  # places lie along its axes, however the hand is turned about y
        for angle in fan:
            R = _frame(y, rotation_axis_angle(y, angle) @ z)
            for u, v in _places(half_x - pad[0] / 2, half_z - pad[1] / 2, grid, rng, n_random):
                for R_flipped in (R, R * (-1.0, -1.0, 1.0)):
                    T = pose(u * straight[:, 0] + v * straight[:, 2], R=R_flipped)
                    if patch(shape, face, T, pad) is not None:
                        yield Pinch(face, T, width_of(shape, face))


def pinch_turns(shape: Shape, way_in: Array, fan: Iterable[float]) -> Array:
    """Return in which orientations fingers take a shape, wherever on it.

    Args:
        shape: Shape of the item.
        way_in: (3,) unit vector in the item frame, direction of the hand's approach.
        fan: rad, turns about the axis of closing that are tried.

    Returns:
        (K, 3, 3) axes of the tool frame in the item's: those of all ``pinches``.
    """
    turns, angles = [], tuple(fan)
    for _, y, z, _, _ in _lines(shape, way_in):
        for angle in angles:
            R = _frame(y, rotation_axis_angle(y, angle) @ z)
            turns += [R, R * (-1.0, -1.0, 1.0)]
    return np.array(turns).reshape(-1, 3, 3)


def width_of(shape: Shape, face: str) -> float:
    """Return the distance between the places of a pinch.

    Args:
        shape: Shape of the item.
        face: Pinched face.

    Returns:
        m.
    """
    if face in ("mantle", "sphere"):
        return 2.0 * shape.size[0]
    return float(shape.extents["xyz".index(face)])


def flattened(face: str, T_item_tip: Array) -> Array:
    """Turn and move fingers a little, so that their pads close flat on a face.

    Args:
        face: Pinched face.
        T_item_tip: (4, 4) tool frame in the item's, roughly there.

    Returns:
        (4, 4) the tool frame with its y axis along the normal of both pads' places, midway between them.
    """
    R, middle = T_item_tip[:3, :3], T_item_tip[:3, 3]
    if face == "sphere":
        return pose((0.0, 0.0, 0.0), R=R)
    if face == "mantle":
        y, middle = R[:, 1] * (1.0, 1.0, 0.0), middle * (0.0, 0.0, 1.0)
    else:
        across = np.eye(3)["xyz".index(face)]
        y, middle = R[:, 1] * across, middle * (1.0 - across)
    y /= np.linalg.norm(y)
    z = R[:, 2] - (R[:, 2] @ y) * y
    return pose(middle, R=_frame(y, z / np.linalg.norm(z)))


def patch(
    shape: Shape, face: str, T_item_tip: Array, pad: tuple[float, float], off: float = 0.0
) -> tuple[float, float] | None:
    """Return the part of each pad that lies on the item.

    Args:
        shape: Shape of the item.
        face: Pinched face.
        T_item_tip: (4, 4) tool frame in the item's.
        pad: (a, b) m, sides of the pads along x and z of the tool frame.
        off: m by which the pads may be beside that place, in any direction along them.

    Returns:
        Sides in m along x and z of a rectangle about the middle of the pad, all of it on the item; None if
        less than half of either side is, with a place that is off ``LEAST_SHARE``.
    """
    R, middle = T_item_tip[:3, :3], T_item_tip[:3, 3]
    sides = np.array(pad)
    if face == "sphere":
        on_pad = np.minimum(sides - 2.0 * off, _strip(shape.size[0]))  # wherever on the pads its middle is
        return (*on_pad.tolist(),) if on_pad.min() > 0.0 else None
    if face == "mantle":
        k = _along_axis(T_item_tip)
        sides[1 - k] = min(sides[1 - k] - 2.0 * off, _strip(shape.size[0]))
        if sides[1 - k] <= 0.0:
            return None
    corners = np.array([*product((-0.5, 0.5), repeat=2)])
    for share in (*SHARES, LEAST_SHARE) if off > 0.0 else SHARES:
        at = middle + (corners * (share * sides + 2.0 * off)) @ R[:, [0, 2]].T
        if _all_on(shape, face, at):
            return float(share * sides[0]), float(share * sides[1])
    return None


def limits_of(
    gripper: ParallelGripper, shape: Shape, face: str, T_item_tip: Array, noise: PoseNoise
) -> PinchLimits | None:
    """Return the limits of the pads on an item within the error of its pose, by the part that touches.

    Args:
        gripper: The gripper.
        shape: Shape of the item.
        face: Pinched face.
        T_item_tip: (4, 4) tool frame in the item's.
        noise: Bounds of the error of the item's pose.

    Returns:
        The limits; None if within that error the pads may be beside the item, or so askew that no part of
        them touches on both sides.
    """
    turned = noise.angle * float(np.linalg.norm(T_item_tip[:3, 3]))  # m that it moves what is pinched
    touching = patch(shape, face, T_item_tip, gripper.pad, noise.position + turned)
    if touching is None:
        return None
    sides = np.minimum(touching, _askew_patch(shape, face, T_item_tip, gripper.pad, noise.angle))
    if sides.min() <= 0.0:
        return None
    stray = _stray(face, T_item_tip, noise.position, turned)
    return PinchLimits(gripper.limits.force, gripper.limits.friction, (sides[0], sides[1]), stray)


def _stray(face: str, T_item_tip: Array, moved: float, turned: float) -> tuple[float, float, float]:
    """Return m along x, y and z of the tool frame from an item's centre to where it is thought over the pads.

    Args:
        face: Pinched face.
        T_item_tip: (4, 4) tool frame in the item's.
        moved: m that the item's centre may be off.
        turned: m that the part between the pads may be off from it, as the item is turned.
    """
    if face == "sphere":  # touched where its centre is
        return 0.0, 0.0, 0.0
    if face != "mantle":
        return moved, turned, moved
    # Touched along a line that goes with its axis.
    return (moved, turned, turned) if _along_axis(T_item_tip) == 0 else (turned, turned, moved)


def _askew_patch(shape: Shape, face: str, T_item_tip: Array, pad: tuple[float, float], angle: float) -> Array:
    """Return the sides (2,) m of what touches of both pads if they stand askew on the item; <= 0 for nothing.

    Turned by an angle (rad) about one side, a pad stands off by up to that times half of its other side. The
    compliance that is left bounds how far from its middle it touches, and how wide on a round side.
    """
    if face == "sphere" or angle == 0.0:
        return np.full(2, np.inf)
    sides = 2.0 * GIVES_WAY / angle - np.array(pad)
    if face == "mantle":
        k = _along_axis(T_item_tip)
        sides[1 - k] = _strip(shape.size[0], max(0.0, GIVES_WAY - angle * pad[k] / 2))
    return np.asarray(sides)


def _strip(radius: float, gives_way: float = GIVES_WAY) -> float:
    """Return the width in m of a pad's contact with a round side: a chord as deep as the rubber yields."""
    return float(2.0 * np.sqrt(2.0 * radius * gives_way))


def _along_axis(T_item_tip: Array) -> int:
    """Return which side of a pad, 0 for x and 1 for z, lies along the axis of a cylinder."""
    return int(np.argmax(np.abs(T_item_tip[2, [0, 2]])))


def _lines(shape: Shape, way_in: Array) -> Iterator[tuple[str, Array, Array, float, float]]:
    """Yield, for everything that can be pinched: name, closing axis, approach axis, and half its sides.

    The sides are along x and z of the tool frame, through the item's centre.
    """
    if shape.kind is ShapeKind.SPHERE:
        across = -perpendiculars(way_in)[0]  # the sign only decides which of two equal pinches comes first
        for yaw in YAWS[: len(YAWS) // 2]:
            y = rotation_axis_angle(way_in, yaw) @ across
            yield "sphere", y, way_in, 0.0, 0.0
        return
    is_box = shape.kind is ShapeKind.BOX
    half = shape.extents / 2
    if not is_box:
        yield from _round_mantle(shape, way_in)
        half = half * (np.sqrt(0.5), np.sqrt(0.5), 1.0)  # the square inscribed in the ends
    for k in range(3) if is_box else (2,):
        y = np.eye(3)[k]
        z = way_in - (way_in @ y) * y
        if abs(way_in @ y) > np.sin(MAX_TILT):
            continue
        z /= np.linalg.norm(z)
        yield "xyz"[k], y, z, _through(cross(y, z), half), _through(z, half)


def _round_mantle(shape: Shape, way_in: Array) -> Iterator[tuple[str, Array, Array, float, float]]:
    """Yield the mantle of a cylinder, approached from the side across its axis, or from an end along it."""
    axis, half_length = np.array([0.0, 0.0, 1.0]), shape.size[1] / 2
    along = float(way_in @ axis)
    if abs(along) <= np.sin(MAX_TILT):
        z = way_in - along * axis
        z /= np.linalg.norm(z)
        yield "mantle", cross(z, axis), z, half_length, 0.0
    if abs(along) >= np.cos(MAX_TILT):
        for yaw in YAWS[: len(YAWS) // 2]:
            yield "mantle", np.array([np.cos(yaw), np.sin(yaw), 0.0]), np.sign(along) * axis, 0.0, half_length


def _places(
    half_x: float, half_z: float, grid: int, rng: np.random.Generator, n_random: int
) -> list[tuple[float, float]]:
    """Return positions of the pads' middle along x and z: the centre, near the edge of approach, and more."""
    u, v = max(0.0, half_x), max(0.0, half_z)
    chosen = [(0.0, 0.0), (0.0, -v / 2), (0.0, -v)]
    shares = np.linspace(-1.0, 1.0, grid) if grid else np.zeros(0)
    chosen += [(float(i * u), float(j * v)) for i, j in product(shares, shares)]
    chosen += [(float(i * u), float(j * v)) for i, j in rng.uniform(-1.0, 1.0, (n_random, 2))]
    return list(dict.fromkeys(chosen))


def _frame(y: Array, z: Array) -> Array:
    """Return (3, 3) axes of a tool that closes along y and approaches along z."""
    return np.column_stack([cross(y, z), y, z])


def _through(direction: Array, half: Array) -> float:
    """Return how far in m a line from the centre of a box (half extents) stays inside of it."""
    return float((half / np.maximum(np.abs(direction), EDGE_ROUNDING)).min())


def _all_on(shape: Shape, face: str, points: Array) -> bool:
    """Whether points (N, 3) in the middle plane of a pinch lie under both of its faces."""
    if face == "mantle":
        return bool((np.abs(points[:, 2]) <= shape.size[1] / 2 + EDGE_ROUNDING).all())
    if shape.kind is ShapeKind.CYLINDER:
        return bool((np.linalg.norm(points[:, :2], axis=1) <= shape.size[0] + EDGE_ROUNDING).all())
    across = [i for i in range(3) if i != "xyz".index(face)]
    return bool((np.abs(points[:, across]) <= shape.extents[across] / 2 + EDGE_ROUNDING).all())
