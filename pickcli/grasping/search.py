"""Effort of the grasp search: few grasps by default, many if no other was found."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np

from pickcli.geometry import Array, rotation_axis_angle

WAYS_IN = np.array(
    [[-1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]]
)  # outward, entry frame


class ToolRoll(NamedTuple):
    """A roll of the tool: its rotation about the axis of approach.

    Attributes:
        x_target: (3,) direction in the entry frame in which the tool's x axis points.
        off: rad, deviation from the usual direction.
    """

    x_target: Array
    off: float


@dataclass(frozen=True)
class Search:
    """Parameters of the search on every face.

    Attributes:
        n_random: Number of random places besides the centre.
        grid: Number of places along each side of a flat face, its edges included.
        fan: rad, deviations from straight about both axes, for approaches to curved faces.
        yaws: rad, of the lance away from the bin's axis, over an item.
        pitches: rad, of the lance beside an item, positive if it rises towards the mouth.
        tilts: Tilts of the cup off the face's normal, as shares of the tool's maximum, besides the least that
            clears the lip.
        quarters: Whether a lance from above is also turned by quarter turns, not only by half turns: so the
            cup can be tilted to every side, and the wrist has more branches.
    """

    n_random: int
    grid: int
    fan: tuple[float, ...]
    yaws: tuple[float, ...]
    pitches: tuple[float, ...]
    tilts: tuple[float, ...]
    quarters: bool

    def rolls(self, kind: str, is_from_above: bool = False, has_quarters: bool = False) -> list[ToolRoll]:
        """Return the turns about the cup's axis that are tried for one kind of grasp.

        Args:
            kind: "frontal", "top-down" or "side".
            is_from_above: Whether the way in leads down.
            has_quarters: Whether a lance from above is turned by quarter turns in any search.

        Returns:
            The rolls, the usual one first.
        """
        if kind == "frontal":
            # flange x down, as in the named poses in front of the bins; or up, for the wrist's other branch
            found = [ToolRoll(np.array([0.0, 0.0, z]), 0.0) for z in (-1.0, 1.0)]
            if is_from_above and (self.quarters or has_quarters):
                found += [ToolRoll(np.array([0.0, y, 0.0]), 0.0) for y in (-1.0, 1.0)]
            return found
        # the lance lies across the cup's axis and leaves the cup along +x of the tool frame
        if kind == "top-down":
            return [ToolRoll(-np.array([np.cos(a), np.sin(a), 0.0]), abs(a)) for a in self.yaws]
        found = [ToolRoll(np.array([-np.cos(a), 0.0, np.sin(a)]), abs(a)) for a in self.pitches]
        if is_from_above:
            found += [
                ToolRoll(np.array([-np.cos(a), np.sin(a), 0.0]), abs(a)) for a in self.pitches if a != 0.0
            ]
        return found

    @cached_property
    def outward(self) -> Array:
        """(M, 3) normals in the entry frame to approach curved faces: each way in and a fan about it."""
        return np.array([_turned_off(*aim) for aim in product(WAYS_IN, self.fan, self.fan)])


def _turned_off(toward: Array, a: float, b: float) -> Array:
    """Rotate a direction (3,) about the two axes of the entry that are across it."""
    i = int(np.argmax(np.abs(toward)))
    across = np.eye(3)[(i + 1) % 3], np.eye(3)[(i + 2) % 3]
    return np.asarray(rotation_axis_angle(across[0], a) @ rotation_axis_angle(across[1], b) @ toward)


def _degrees(*angles: float) -> tuple[float, ...]:
    return tuple(float(np.radians(a)) for a in angles)


USUAL = Search(
    n_random=6, grid=0, fan=(0.0,),
    yaws=_degrees(0, 15, -15, 30, -30), pitches=_degrees(0, 10, 20, 30, -10), tilts=(),
    quarters=False,
)  # fmt: skip
WIDE_SEARCH = Search(
    n_random=0, grid=5, fan=_degrees(0, 14, -14, 28, -28),
    yaws=_degrees(0, 8, -8, 16, -16, 24, -24, 32, -32), pitches=_degrees(0, 8, 16, 24, 32, -8),
    tilts=(-1.0, -0.5, 0.0, 0.5, 1.0), quarters=True,
)  # fmt: skip
