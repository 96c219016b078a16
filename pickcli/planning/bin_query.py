"""One pick as seen inside its bin: what every grasp of the target shares."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.cartesian.corridor import Corridor, corridors
from pickcli.cell.robot import PivotState
from pickcli.cell.scene import PlacedItem, Scene
from pickcli.cell.station import Bin
from pickcli.collision.checker import SceneChecker
from pickcli.collision.ghost import Ghost
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse
from pickcli.planning.context import Planner
from pickcli.planning.exit import planned_corridors
from pickcli.planning.settings import Neighbours
from pickcli.seeds import derived_seed


@dataclass(frozen=True, eq=False)
class BinQuery:
    """One pick as seen inside its bin."""

    planner: Planner
    scene: Scene
    cell_bin: Bin
    target: PlacedItem
    neighbours: Neighbours

    @cached_property
    def T_world_bin(self) -> Array:
        """Pose of the bin frame where the pod really stands."""
        return np.asarray(self.scene.T_world_pod @ self.cell_bin.T_pod_bin)

    @cached_property
    def T_bin_item(self) -> Array:
        """Pose of the target in the bin frame."""
        return np.asarray(inverse(self.T_world_bin) @ self.target.T_world_item)

    @cached_property
    def ignored(self) -> frozenset[str]:
        """Neighbours that are left out of the collision model."""
        if self.neighbours is Neighbours.AVOID:
            return frozenset()
        here = self.scene.in_location(self.cell_bin.name)
        return frozenset(i.id for i in here if i.id != self.target.id)

    @cached_property
    def uncertainty(self) -> float:
        """How far any point of the target may be from where its pose says, m."""
        return self.scene.noise.bound(self.target.item)

    @cached_property
    def touching(self) -> frozenset[str]:
        """Everything within the clearance of the target at rest: its support, walls and neighbours."""
        touching: frozenset[str] = frozenset()
        at_rest = np.zeros(5)
        while not (ghost := self.ghost(touching)).is_free(at_rest):
            near = ghost.clearance(at_rest).b
            if near in touching:
                break
            touching |= {near}
        return touching

    @cached_property
    def empty(self) -> dict[PivotState, SceneChecker]:
        """Checkers of the empty tool by pivot state."""
        return {
            pivot: self.planner.checker(self.scene, pivot, without=self.ignored)
            for pivot in (PivotState.STRAIGHT, PivotState.DOWN)
        }

    @cached_property
    def meeting(self) -> dict[PivotState, SceneChecker]:
        """The same, where the cup may touch the target, and come near the floor that a thin one lies on."""
        near = frozenset({self.target.id}) | (self.touching & frozenset(self.cell_bin.floor))
        return {
            pivot: self.planner.checker(self.scene, pivot, without=self.ignored, touching=near)
            for pivot in (PivotState.STRAIGHT, PivotState.DOWN)
        }

    def ghost(self, touching: frozenset[str] = frozenset()) -> Ghost:
        """The target by itself, displaced along the bin's axes."""
        if touching not in self._ghosts:
            self._ghosts[touching] = Ghost(
                self.planner.model, self.scene, self.target.item, self.target.T_world_item,
                self.T_world_bin[:3, :3], self.uncertainty, self.ignored | {self.target.id}, touching,
            )  # fmt: skip
        return self._ghosts[touching]

    @cached_property
    def _ghosts(self) -> dict[frozenset[str], Ghost]:
        """Those made so far, by what they may touch."""
        return {}

    @cached_property
    def corridors(self) -> tuple[Corridor, ...] | Reason:
        """The ways out for the target by itself: simple ones, else planned ones."""
        shape = self.target.item.shape.inflated(self.uncertainty)
        first = self.planner.settings.lift_contact
        leaving, carrying = self.ghost(self.touching), self.ghost()
        simple = corridors(self.cell_bin, self.T_bin_item, shape, leaving, carrying, first)
        if not isinstance(simple, Reason):
            return simple
        seed = derived_seed(0, "exit", self.target.id)
        return planned_corridors(self.T_bin_item, shape, leaving, carrying, first, seed) or simple
