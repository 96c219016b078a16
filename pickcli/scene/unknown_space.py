"""Space of a place of which nothing is known: it is an obstacle."""

from __future__ import annotations

from dataclasses import dataclass, field
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
        unrecognised: (M, 2, 3) m, alike: where something is that nobody recognised, or may be.
            It may rest on the items that it touches, or hold them.
    """

    place: str
    T_world_place: Array
    boxes: Array
    unrecognised: Array = field(default_factory=lambda: np.zeros((0, 2, 3)))

    @property
    def is_empty(self) -> bool:
        """Whether all of the place is known."""
        return not len(self.boxes) and not len(self.unrecognised)

    @cached_property
    def bodies(self) -> tuple[Body, ...]:
        """The boxes as bodies in the world."""
        return self._bodies("unknown", self.boxes)

    @cached_property
    def unrecognised_bodies(self) -> tuple[Body, ...]:
        """What nobody recognised as bodies in the world."""
        return self._bodies("unrecognised", self.unrecognised)

    def _bodies(self, kind: str, boxes: Array) -> tuple[Body, ...]:
        return tuple(
            Body(
                f"{kind}_{self.place}_{k}",
                Shape(ShapeKind.BOX, tuple((high - low).tolist())),
                np.asarray(self.T_world_place @ pose((low + high) / 2)),
            )
            for k, (low, high) in enumerate(boxes)
        )
