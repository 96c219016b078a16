"""Targets of a grasp search, and the candidates that it finds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Grasp


@dataclass(frozen=True)
class CandidateSet:
    """Grasp candidates for one item.

    Attributes:
        grasps: Candidates, best first.
        rejected: Why others were dropped.
    """

    grasps: tuple[Grasp, ...]
    rejected: tuple[Reason, ...]


@dataclass(frozen=True, eq=False)
class GraspTarget:
    """An item to be grasped at its current pose.

    Attributes:
        id: Id of the item in its scene.
        item: Kind of the item, with its shape and mass.
        T_entry_item: (4, 4) its pose in the entry frame of its place, x pointing inwards.
        place: Place of the item.
    """

    id: str
    item: Item
    T_entry_item: Array
    place: Place

    @property
    def R_level_item(self) -> Array:
        """(3, 3) orientation of the item in a frame whose z axis points up."""
        return np.asarray(self.place.T_place_entry[:3, :3] @ self.T_entry_item[:3, :3])
