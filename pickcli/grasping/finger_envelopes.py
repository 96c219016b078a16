"""Envelopes in which two fingers enclose an object, from every side from which they can.

Krug et al., RA-L 2016, section III-A: a cylinder is grasped from its side or from an end, spheres and boxes
alike; a union of envelopes is a tuple of them, of which one is chosen outside.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tool import Tool
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.geometry import Array, pose
from pickcli.grasping.envelope import Alignment, Envelope
from pickcli.kernel import SurfaceKind

CONE = np.radians(12.0)  # of fingers; as in the prototypes that envelopes were measured with
X, Y, Z = np.eye(3)


@dataclass(frozen=True)
class FingerReach:
    """What envelopes of two parallel fingers depend on.

    Attributes:
        depth: m, from the palm to the middle between the pads.
        pad: (a, b) m, sides of the pads along x and z of the tool frame.
        widest: m between the open pads.
        gap: m that the palm keeps from the object at least.
        cone: rad, half of the opening of both cones.
    """

    depth: float
    pad: tuple[float, float]
    widest: float
    gap: float = 0.005
    cone: float = CONE

    @classmethod
    def of(cls, tool: Tool, gripper: ParallelGripper, depth: float) -> FingerReach:
        """Take the figures of a cell's gripper.

        Args:
            tool: The tool.
            gripper: Its fingers.
            depth: m, from the palm to the middle between the pads.

        Returns:
            The figures.
        """
        return cls(depth, gripper.pad, max(tool.positions.values()))


def finger_envelopes(shape: Shape, fingers: FingerReach) -> tuple[Envelope, ...]:
    """Return the envelopes in which two fingers enclose a shape, the tool closing along its y axis.

    The palm stays off the surface, and the pads beside the shape: on round sides their middle within half of
    a pad of its axis or centre, at ends and flat faces at least half of a pad deep.

    Args:
        shape: The object's shape; not a hull.
        fingers: The fingers.

    Returns:
        The envelopes that no bound makes empty; () if the shape is too large for the fingers.
    """
    found: list[Envelope] = []
    if shape.kind is ShapeKind.CYLINDER:
        found += [*_sides(shape, fingers), *_ends(shape, fingers)]
    elif shape.kind is ShapeKind.SPHERE:
        found += _all_round(shape, fingers)
    else:
        found += _box(shape, fingers)
    return tuple(each for each in found if not each.why_empty())


def _sides(shape: Shape, fingers: FingerReach) -> Iterator[Envelope]:
    """Yield the side of a cylinder, the tool's x axis along the cylinder's or against it."""
    radius, length = shape.size
    if 2 * radius >= fingers.widest:
        return
    along = max(0.0, (length - fingers.pad[0]) / 2)
    near, far = _distances(radius, fingers)
    for name, sign in (("side", 1.0), ("side, turned over", -1.0)):
        yield Envelope(
            name, SurfaceKind.CYLINDER, np.eye(4),
            np.array([-np.pi, -along, near]), np.array([np.pi, along, far]),
            fingers.cone, Alignment(X, sign * Z, fingers.cone), fingers.depth, "mantle",
        )  # fmt: skip


def _ends(shape: Shape, fingers: FingerReach) -> Iterator[Envelope]:
    """Yield the ends of a cylinder, at which the tool rolls freely."""
    radius, length = shape.size
    if 2 * radius >= fingers.widest:
        return
    aside = (fingers.widest - 2 * radius) / 4
    deep = min(fingers.depth - fingers.gap, fingers.pad[1] / 2 + length)
    near, far = fingers.gap, max(fingers.gap, fingers.depth - fingers.pad[1] / 2)
    near = max(near, fingers.depth - deep)
    for name, outward in (("+z", Z), ("-z", -Z)):
        T = _facing(outward, X, length / 2)
        yield Envelope(
            name, SurfaceKind.PLANE, T, np.array([-aside, -aside, near]), np.array([aside, aside, far]),
            fingers.cone, None, fingers.depth, "mantle",
        )  # fmt: skip


def _all_round(shape: Shape, fingers: FingerReach) -> Iterator[Envelope]:
    radius = shape.size[0]
    if 2 * radius < fingers.widest:
        near, far = _distances(radius, fingers)
        bounds = np.array([[-np.pi, np.pi], [-np.pi / 2, np.pi / 2], [near, far]])
        yield Envelope(
            "sphere",
            SurfaceKind.SPHERE,
            np.eye(4),
            bounds[:, 0],
            bounds[:, 1],
            fingers.cone,
            None,
            fingers.depth,
            "sphere",
        )


def _box(shape: Shape, fingers: FingerReach) -> Iterator[Envelope]:
    """Yield each face of a box, with each pair of sides that the fingers close on, either way round."""
    half = shape.extents / 2
    for k in range(3):
        for sign in (1.0, -1.0):
            outward = sign * np.eye(3)[k]
            for closing in (i for i in range(3) if i != k and 2 * half[i] < fingers.widest):
                along = 3 - k - closing
                aside = (fingers.widest - 2 * half[closing]) / 4
                free = max(0.0, half[along] - fingers.pad[0] / 2)
                near = max(fingers.gap, fingers.depth - half[k] - fingers.pad[1] / 2)
                far = max(near, fingers.depth - fingers.pad[1] / 2)
                T = _facing(outward, np.eye(3)[along], half[k])
                low, high = np.array([-free, -aside, near]), np.array([free, aside, far])
                for way in (1.0, -1.0):
                    name = f"{'+' if sign > 0 else '-'}{'xyz'[k]}, closing along {'xyz'[closing]}"
                    aligned = Alignment(X, way * T[:3, 0], fingers.cone)
                    name += "" if way > 0 else ", turned over"
                    yield Envelope(
                        name, SurfaceKind.PLANE, T, low, high, fingers.cone, aligned, fingers.depth,
                        "xyz"[closing],
                    )  # fmt: skip


def _distances(radius: float, fingers: FingerReach) -> tuple[float, float]:
    """Return the least and the greatest distance in m of the palm from the middle of a round shape."""
    near = max(radius + fingers.gap, fingers.depth - fingers.pad[1] / 2)
    return near, max(near, fingers.depth + fingers.pad[1] / 2)


def _facing(outward: Array, x: Array, off: float) -> Array:
    """Return (4, 4) a plane's frame ``off`` m from the origin: z outward, x as given."""
    return pose(off * outward, R=np.column_stack([x, np.cross(outward, x), outward]))
