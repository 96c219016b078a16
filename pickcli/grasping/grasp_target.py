"""Targets of a grasp search, and the candidates that it finds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.cell.tool import ToolState
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Grasp
from pickcli.scene.scene import PoseNoise

EXACT = PoseNoise()


@dataclass(frozen=True, eq=False)
class GraspBatch:
    """N grasps of one item on one face in one state of the tool, as arrays: most of them are never tried.

    Attributes:
        item: Id of the item in its scene.
        face: Face of the item's shape (see ``Grasp``).
        tool_state: State of the tool that the grasps are made with.
        kinds: (N,) "frontal", "top-down" or "side".
        T_item_tip: (N, 4, 4) tool frame in the item frame.
        scores: (N,) the smaller the better.
        loads: (N, 5) moment, pull, shear, twist and load ratio at rest (see ``Grasp``).
        envelope: Name of the envelope in which a region query found them; empty for fixed candidates.
    """

    item: str
    face: str
    tool_state: ToolState
    kinds: NDArray[np.character]
    T_item_tip: Array
    scores: Array
    loads: Array
    envelope: str = ""

    def select(self, which: NDArray[np.bool_]) -> GraspBatch:
        """Return a part of the grasps.

        Args:
            which: (N,) True for each grasp that is kept.

        Returns:
            These, in their order.
        """
        of_each = self.kinds[which], self.T_item_tip[which], self.scores[which], self.loads[which]
        return GraspBatch(self.item, self.face, self.tool_state, *of_each, self.envelope)

    def __getitem__(self, k: int) -> Grasp:
        """Return one grasp.

        Args:
            k: Its index.

        Returns:
            The grasp.
        """
        kind, score, loads = str(self.kinds[k]), float(self.scores[k]), self.loads[k].tolist()
        how = kind, self.face, self.tool_state, self.T_item_tip[k]
        return Grasp(self.item, *how, score, *loads, envelope=self.envelope)

    def __len__(self) -> int:
        """Return N."""
        return len(self.kinds)


@dataclass(frozen=True, eq=False)
class CandidateSet:
    """Grasp candidates for one item.

    Attributes:
        batches: The candidates.
        rejected: Why others were dropped.
    """

    batches: tuple[GraspBatch, ...]
    rejected: tuple[Reason, ...] = ()

    def select(self, which: Sequence[NDArray[np.bool_]]) -> CandidateSet:
        """Return a part of the candidates.

        Args:
            which: For each batch (N,) True for each grasp that is kept.

        Returns:
            These, with the same reasons against others, without empty batches.
        """
        parts = [batch.select(kept) for batch, kept in zip(self.batches, which, strict=True) if kept.any()]
        return CandidateSet(tuple(parts), self.rejected)

    @cached_property
    def grasps(self) -> tuple[Grasp, ...]:
        """All candidates, best first."""
        found = [batch[k] for batch in self.batches for k in range(len(batch))]
        return tuple(sorted(found, key=lambda grasp: grasp.score))


@dataclass(frozen=True, eq=False)
class GraspTarget:
    """An item to be grasped at its current pose.

    Attributes:
        id: Id of the item in its scene.
        item: Kind of the item, with its shape and mass.
        T_entry_item: (4, 4) its pose in the entry frame of its place, x pointing inwards.
        place: Place of the item.
        noise: Bounds of the error of its pose.
    """

    id: str
    item: Item
    T_entry_item: Array
    place: Place
    noise: PoseNoise = EXACT

    @property
    def way_in(self) -> Array:
        """(3,) unit vector in the item's frame: the direction of the way into its place."""
        return np.asarray(self.T_entry_item[:3, :3].T @ (1.0, 0.0, 0.0))

    @property
    def R_level_item(self) -> Array:
        """(3, 3) orientation of the item in a frame whose z axis points up."""
        return np.asarray(self.place.T_place_entry[:3, :3] @ self.T_entry_item[:3, :3])
