"""Space of a place of which nothing is known: it is an obstacle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.geometry import Array, pose


@dataclass(frozen=True, eq=False)
class UnknownSpace:
    """Boxes that nobody has seen through, or in which something is that nobody recognised.

    Attributes:
        place: Name of the place.
        T_world_place: (4, 4) pose of its frame as it was seen.
        boxes: (N, 2, 3) m, lower and upper corners in that frame.
    """

    place: str
    T_world_place: Array
    boxes: Array

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """The boxes as bodies in the world."""
        return tuple(
            Body(
                f"unknown_{self.place}_{k}",
                Shape(ShapeKind.BOX, tuple((high - low).tolist())),
                np.asarray(self.T_world_place @ pose((low + high) / 2)),
            )
            for k, (low, high) in enumerate(self.boxes)
        )
