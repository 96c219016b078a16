"""Which points of a tote are touched, and in which order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.calibration.tote_shape import ToteFace, ToteShape
from pickcli.errors import InputError
from pickcli.geometry import Array

LEAST_TOUCHES, MOST_TOUCHES, DEFAULT_TOUCHES = 6, 10, 8
N_FIRST = 3  # touches of two walls, which fix x, y and yaw
APART = 0.6  # of half of a wall's length, from its middle to each of two touches
RIM_APART = 0.5  # the same on the rim
DEPTH = 0.05  # m under the rim, at which walls are touched
ROOM = 0.002  # m that the lip has on the rim beside it, at least
RIMS = 3


@dataclass(frozen=True, eq=False)
class TouchPoint:
    """A point of the tote that is to be touched by the middle of the lip.

    Attributes:
        name: Of the face, with its number among the touches: "2 wall left".
        face: The face.
        point: (3,) m in the tote's frame.
    """

    name: str
    face: ToteFace
    point: Array


def touch_points(shape: ToteShape, n: int, lip_radius: float) -> tuple[TouchPoint, ...]:
    """Choose the points: walls first, as they tell where the narrow rim is.

    Two on a long wall and one on a short one fix x, y and yaw, three on the rim height and tilt (the 3-2-1
    principle of fixtures). Each further one, on the other walls, is a check of these.

    Args:
        shape: The tote.
        n: Number of touches.
        lip_radius: m, of the cup.

    Returns:
        The points in the order in which they are touched; the first ``N_FIRST`` fix x, y and yaw.

    Raises:
        InputError: The number is out of range, or walls or rim have no room for the lip.
    """
    if not LEAST_TOUCHES <= n <= MOST_TOUCHES:
        raise InputError(f"--touches {n}: expected {LEAST_TOUCHES} to {MOST_TOUCHES}")
    (a, b), (c, d) = shape.long_sides, shape.short_sides
    walls = [(a, -APART), (a, APART), (c, 0.0), (b, 0.0), (d, 0.0), (b, APART), (b, -APART)]
    chosen = [_on(shape.walls[side], share, DEPTH) for side, share in walls[: n - RIMS]]
    low = min(face.width for face in shape.walls.values())
    if low < DEPTH + lip_radius + ROOM:
        raise InputError(f"the tote is {1e3 * low:.0f} mm deep: too flat for the lip to touch its walls")
    wide = [side for side, rim in shape.rims.items() if rim.width >= 2.0 * (lip_radius + ROOM)]
    opposite = next((pair for pair in ((c, d), (a, b)) if set(pair) <= set(wide)), None)
    if opposite is None:
        raise InputError(
            f"the rim of the tote has no two opposite sides as wide as the lip ({2e3 * lip_radius:.0f} mm), "
            "on which its height could be touched"
        )
    first, second = (shape.rims[side] for side in opposite)
    chosen += [_on(first, -RIM_APART), _on(first, RIM_APART), _on(second, 0.0)]
    return tuple(TouchPoint(f"{i} {face.name}", face, p) for i, (face, p) in enumerate(chosen, start=1))


def _on(face: ToteFace, share: float, depth: float = 0.0) -> tuple[ToteFace, Array]:
    """Return a point of a face at a share of its half length from its middle, and m under its upper edge."""
    return face, np.asarray(face.middle + share * face.half_length * face.along - [0.0, 0.0, depth])
