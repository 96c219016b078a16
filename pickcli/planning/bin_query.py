"""One pick as seen inside its bin: what every grasp of the target shares."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.cartesian.corridor import Corridor
from pickcli.cell.robot import PivotState
from pickcli.cell.scene import PlacedItem, Scene
from pickcli.cell.station import Bin
from pickcli.cell.supports import Supports, supports_of
from pickcli.collision.checker import SceneChecker
from pickcli.collision.ghost import Ghost
from pickcli.collision.tool_ghost import ToolGhost
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse
from pickcli.grasping.surfaces import flat_normal
from pickcli.motion.plan import Grasp
from pickcli.planning.context import NONE, Planner
from pickcli.planning.settings import Neighbours
from pickcli.planning.ways_out import WaysOut
from pickcli.seeds import derived_seed


@dataclass(frozen=True, eq=False)
class BinQuery:
    """One pick as seen inside its bin."""

    planner: Planner
    scene: Scene
    cell_bin: Bin
    target: PlacedItem
    neighbours: Neighbours
    seed: int = 0

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
    def supports(self) -> Supports:
        """Which item rests on which in the scene."""
        return supports_of(self.scene)

    @cached_property
    def blockers(self) -> tuple[Reason, ...]:
        """Items that would fall or roll away if the target went, what must be cleared first at the head."""
        lying = self.supports.lying_on(self.target.id)
        return tuple(
            Reason(
                "rests on the target" if name in lying else "falls without the target", "lift",
                f"{name} would fall or roll away", name,
            )
            for name in self.supports.falling(self.target.id)
            if name not in self.ignored
        )  # fmt: skip

    @cached_property
    def touching(self) -> frozenset[str]:
        """Everything within the clearance of the target at rest: its support, walls and neighbours."""
        touching: frozenset[str] = frozenset()
        at_rest = np.zeros(6)
        while not (ghost := self.ghost(touching)).is_free(at_rest):
            near = ghost.clearance(at_rest).b
            if near in touching:
                break
            touching |= self._parts_of_floor(near)
        return touching

    def _parts_of_floor(self, name: str) -> frozenset[str]:
        """A body, or all of the floor if it is part of that: an item near the bend rests on either side."""
        floor = frozenset(self.cell_bin.floor)
        return floor if name in floor else frozenset({name})

    @cached_property
    def empty(self) -> dict[PivotState, SceneChecker]:
        """Checkers of the empty tool by pivot state."""
        return {
            pivot: self.planner.checker(self.scene, pivot, without=self.ignored)
            for pivot in (PivotState.STRAIGHT, PivotState.DOWN)
        }

    def met(self, face: str) -> frozenset[str]:
        """What the cup may touch at contact on a face: the target, and what a thin one lies on."""
        if face not in self._met:
            under = {p.id for p in self.scene.items if p.id in self.touching and self._is_under(p, face)}
            floor = self.touching & frozenset(self.cell_bin.floor)
            self._met[face] = frozenset({self.target.id}) | floor | under
        return self._met[face]

    @cached_property
    def _met(self) -> dict[str, frozenset[str]]:
        """Those asked for so far."""
        return {}

    def _is_under(self, other: PlacedItem, face: str) -> bool:
        """Whether all of an item lies behind a flat face of the target: only through it can it be met."""
        outward = flat_normal(face)
        if outward is None:
            return False
        T_target_other = inverse(self.target.T_world_item) @ other.T_world_item
        reach = other.item.shape.reach(outward[None] @ T_target_other[:3, :3])[0]
        height = np.abs(outward) @ self.target.item.shape.extents / 2
        return bool(outward @ T_target_other[:3, 3] + reach <= height)

    def meeting(self, grasp: Grasp) -> SceneChecker:
        """A checker of the empty tool where the cup may touch what it meets."""
        met = self.met(grasp.face)
        return self.planner.checker(self.scene, grasp.pivot, without=self.ignored, touching=met)

    def tool(
        self, pivot: PivotState, touching: frozenset[str] = NONE, without: frozenset[str] = NONE
    ) -> ToolGhost:
        """The empty tool by itself. touching: names that the cup may touch. without: ids of items, gone."""
        key = pivot, touching, without
        if key not in self._tools:
            axes, gone = self.T_world_bin[:3, :3], self.ignored | without
            self._tools[key] = ToolGhost(self.planner.model, self.scene, pivot, axes, gone, touching)
        return self._tools[key]

    @cached_property
    def _tools(self) -> dict[tuple[PivotState, frozenset[str], frozenset[str]], ToolGhost]:
        """Those made so far."""
        return {}

    def ghost(self, touching: frozenset[str] = NONE) -> Ghost:
        """The target by itself, displaced along the bin's axes."""
        if touching not in self._ghosts:
            self._ghosts[touching] = self._ghost(touching, self.ignored | {self.target.id})
        return self._ghosts[touching]

    @cached_property
    def _ghosts(self) -> dict[frozenset[str], Ghost]:
        """Those made so far, by what they may touch."""
        return {}

    @cached_property
    def ways_out(self) -> WaysOut:
        """The ways out of the bin for the target."""
        shape = self.target.item.shape.inflated(self.uncertainty)
        first, seed = self.planner.settings.lift_contact, derived_seed(self.seed, "exit", self.target.id)
        ghosts = self._leaving, self.ghost()
        return WaysOut(self.cell_bin, self.T_world_bin, self.T_bin_item, shape, *ghosts, first, seed)

    @property
    def corridors(self) -> tuple[Corridor, ...] | Reason:
        """The ways out for the target by itself, the shortest first; or why there is none."""
        return self.ways_out.corridors

    @cached_property
    def _leaving(self) -> Ghost:
        """The target where it may touch what it is near to, but not push what would roll along with it."""
        rolling = [
            p.id
            for p in self.scene.items
            if p.id in self.touching and p.item.can_roll(p.T_world_item[:3, :3])
        ]
        standing = {b.name for b in self.scene.cell.pod.bodies} & self.touching
        others = frozenset(p.id for p in self.scene.items)
        beside = tuple(self._ghost(frozenset(standing), others - {name}) for name in rolling)
        return self._ghost(self.touching, self.ignored | {self.target.id}, beside)

    def _ghost(
        self, touching: frozenset[str], without: frozenset[str], beside: tuple[Ghost, ...] = ()
    ) -> Ghost:
        return Ghost(
            self.planner.model, self.scene, self.target.item, self.target.T_world_item,
            self.T_world_bin[:3, :3], self.uncertainty, without, touching, beside,
        )  # fmt: skip
