"""Envelopes of the poses before a grasp: where the open hand stands around an object.

Source: Krug et al., RA-L 2016, section III-A, Fig. 3. An envelope is of the flange that carries the hand: its
z axis is the approach, its x axis points upwards.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.grasping.envelope import Alignment, Envelope
from pickcli.hand.belt_hand import BeltHand
from pickcli.hand.hand_urdf import pad_offset
from pickcli.kernel import SurfaceKind

REACH = 0.08  # m from the palm to the middle of an object: so far out that fingers need not open wide
NEAR = 0.005  # m either way of it
BESIDE = 0.012  # m from an object to the pads that are to close on it, if it is in the middle
HIGH = 0.004  # m either way of the middle of the height
FACING = 0.05  # rad either way, by which the approach to a box is off its face
CONE = np.radians(2.0)  # of approach and upward axis
UP, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


def aperture(hand: BeltHand, shape: Shape) -> float:
    """Return how far the fingers open for an object.

    Args:
        hand: The hand.
        shape: Its shape: an upright cylinder, or a box.

    Returns:
        rad of the closing motor, at which both pads are ``BESIDE`` off it anywhere in its envelope.
    """
    half, base, depth = float(shape.extents[:2].max()) / 2, hand.fingers.base / 2, REACH - NEAR
    if shape.kind is ShapeKind.BOX:  # whose near corners are nearer to the palm, and turned aside
        half, depth = half * (1.0 + FACING), depth - half
    # The distance of the middle from a pad that leans outwards by a: base cos a + depth sin a - offset.
    wanted = (half + BESIDE + pad_offset(hand)) / np.hypot(base, depth)
    leaning = np.arcsin(np.clip(wanted, 0.0, 1.0)) - np.arctan2(base, depth)
    return -min(float(leaning), hand.fingers.widest)


def object_envelopes(hand: BeltHand, shape: Shape) -> tuple[Envelope, ...]:
    """Return the envelopes of a single object that stands upright.

    Args:
        hand: The hand.
        shape: The object's shape: an upright cylinder, or a box.

    Returns:
        One around a cylinder, or one for each side of a box, in the frame of the object.
    """
    around: tuple[tuple[str, float, float], ...] = (("side", -np.pi, np.pi),)
    if shape.kind is ShapeKind.BOX:
        faces = zip(("+x", "+y", "-x", "-y"), np.arange(4) * np.pi / 2, strict=True)
        around = tuple((name, middle - FACING, middle + FACING) for name, middle in faces)
    far = REACH + hand.palm.depth
    return tuple(
        Envelope(
            name, SurfaceKind.CYLINDER, np.eye(4),
            np.array([low, -HIGH, far - NEAR]), np.array([high, HIGH, far + NEAR]),
            CONE, Alignment(UP, Z, CONE),
        )
        for name, low, high in around
    )  # fmt: skip
