"""One pick as seen inside its bin: what every grasp of the target shares."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.cartesian.corridor import Corridor
from pickcli.cell.robot import ToolState
from pickcli.cell.station import Bin
from pickcli.collision.allowed_contacts import NO_CONTACTS, AllowedContacts
from pickcli.collision.checker import SceneChecker
from pickcli.collision.free_flyer import FreeItemChecker, FreeToolChecker
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse
from pickcli.grasping.surfaces import flat_normal, tilt_on
from pickcli.motion.plan import Grasp
from pickcli.planning.pick_settings import Neighbours
from pickcli.planning.planning_context import NONE, Planner
from pickcli.planning.ways_out import WaysOut
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.scene.solid_overlap import TOUCH
from pickcli.scene.supports import SolidContact, Supports, supports_of
from pickcli.seeds import derived_seed

PRESS = 0.001  # m that the bellows are pressed at least
SLIP = 0.001  # m that the target may go deeper into what it touches than it lies: lines are only nearly so
ALONE_SLIP = 0.0005  # the same for the target by itself, which leaves the arm the rest
TURNED = 0.5  # of how far a pose that is off in angle leads deeper over the first stretch


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
    def contradictions(self) -> tuple[Reason, ...]:
        """What the target overlaps with, as its pose says, deeper than poses may be off."""
        bound = {placed.id: self.scene.noise.bound(placed.item) for placed in self.scene.items}
        pod_error = self.scene.pod_error.bound(self._from_axis)
        found = []
        for name, c in self.near.items():
            explained = TOUCH + self.uncertainty + bound.get(name, pod_error)
            if -c.gap > explained:
                deep = f"{-1e3 * c.gap:.1f} mm inside {name}, {1e3 * explained:.1f} explained; look again"
                blamed = name if name in bound else ""
                found.append(Reason("poses contradict each other", "at rest", deep, blamed))
        return tuple(found)

    @cached_property
    def _from_axis(self) -> float:
        """How far from the pod's z axis any point of the target may be, m."""
        p = (inverse(self.scene.T_world_pod) @ self.target.T_world_item)[:2, 3]
        return float(np.linalg.norm(p)) + float(np.linalg.norm(self.target.item.shape.extents)) / 2

    @cached_property
    def near(self) -> Mapping[str, SolidContact]:
        """Everything within the clearance of the target at rest: its support, walls and neighbours."""
        floor = frozenset(self.cell_bin.floor)
        found = {c.b: c for c in self.supports.near(self.target.id, self.flying.margin, floor)}
        # An item near the bend rests on either side of it; one that hangs in the air on neither.
        limit = self.flying.margin + self.uncertainty
        off_floor = floor if all(found[name].gap >= limit for name in floor) else frozenset()
        return {name: c for name, c in found.items() if name not in self.ignored | off_floor}

    @property
    def touching(self) -> frozenset[str]:
        """Names of what is within the clearance of the target at rest."""
        return frozenset(self.near)

    def _given_way(self, slip: float) -> dict[str, Array]:
        """By name, how far (3,) what is near counts as moved out of the target's way.

        Two solids do not overlap: where their poses say so, by no more than both may be off, one of them is
        elsewhere. slip: m that the target may go deeper than that, or come nearer to what it is clear of and
        still touch it, on a way that follows a line only nearly
        """
        turned = TURNED * self.scene.noise.angle * self.planner.settings.lift_contact
        return {name: max(0.0, slip + turned - c.gap) * c.normal for name, c in self.near.items()}

    def leaving(self, grasp: Grasp) -> AllowedContacts:
        """What target and cup may touch over the first stretch of the lift, and how deep."""
        item = self._given_way(SLIP)
        pressed, met = self._pressed(grasp), self.met(grasp.face)
        cup = {name: pressed if name in met else np.zeros(3) for name in item}
        return AllowedContacts.of(item, cup)

    def overtravel(self, grasp: Grasp) -> float:
        """How far in m the cup is pressed beyond the surface, so that all of it meets the item."""
        tool, noise = self.planner.cell.robot.tool, self.scene.noise
        aside = float(np.linalg.norm(np.cross(grasp.T_item_tip[:3, 3], grasp.T_item_tip[:3, 2])))
        # How far the surface under the cup may be along the tool axis from where its pose says.
        # The side of a tilted cup that is farther away must meet it as well.
        least = noise.position + noise.angle * aside + PRESS + self._lag(grasp)
        return min(least, 0.75 * tool.cup_stroke)

    def tips(self, grasp: Grasp) -> bool:
        """Whether a cup from above tips the target, because it presses beside what carries it.

        Its other end rises then, towards the lance, and hardly any tipped face seals. What can roll is no
        matter of balance: it rolls wherever the cup meets it.
        """
        if grasp.kind != "top-down" or self.target.can_roll:
            return False
        tip = self.target.T_world_item @ grasp.T_item_tip
        press = self.planner.cell.robot.tool.cup_stiffness * self.overtravel(grasp)
        return not self.supports.stays_under(self.target.id, press * tip[:3, 2], tip[:3, 3])

    def _lag(self, grasp: Grasp) -> float:
        """How much later in m than its middle the far side of a tilted cup meets the face."""
        tilt = tilt_on(grasp.face, grasp.T_item_tip)
        return self.planner.cell.robot.tool.cup_radius * float(np.sin(tilt))

    def _pressed(self, grasp: Grasp) -> Array:
        """(3,) m in the world: how far what the cup is pressed on counts as moved out of its way."""
        axis = self.target.T_world_item[:3, :3] @ grasp.T_item_tip[:3, 2]
        by = self.overtravel(grasp) + self._lag(grasp) + self.planner.model.cup_excess + SLIP
        return np.asarray(by * axis)

    @cached_property
    def empty(self) -> dict[ToolState, SceneChecker]:
        """Checkers of the empty tool by tool state."""
        return {
            tool_state: self.planner.checker(self.scene, tool_state, without=self.ignored)
            for tool_state in (ToolState.STRAIGHT, ToolState.DOWN)
        }

    def met(self, face: str) -> frozenset[str]:
        """What the cup may touch at contact on a face: the target, and what a thin one lies on."""
        if face not in self._met:
            behind = {name for name in self.near if self._is_behind(name, face)}
            floor = self.touching & frozenset(self.cell_bin.floor)
            self._met[face] = frozenset({self.target.id}) | floor | behind
        return self._met[face]

    @cached_property
    def _met(self) -> dict[str, frozenset[str]]:
        """Those asked for so far."""
        return {}

    def _is_behind(self, name: str, face: str) -> bool:
        """Whether all of a solid lies behind a flat face of the target: only through it can it be met."""
        outward = flat_normal(face)
        if outward is None:
            return False
        solids = self.supports.solids
        k, other = solids.names.index(self.target.id), solids.names.index(name)
        across = self.target.T_world_item[:3, :3] @ outward
        target, width = solids.half_widths(np.array([k, other]), np.tile(across, (2, 1, 1)))[:, 0]
        return bool(across @ (solids.T[other, :3, 3] - solids.T[k, :3, 3]) + width <= target)

    def meeting(self, grasp: Grasp) -> SceneChecker:
        """A checker of the empty tool where the cup may touch what it meets."""
        met = AllowedContacts.of(cup=dict.fromkeys(self.met(grasp.face), self._pressed(grasp)))
        return self.planner.checker(self.scene, grasp.tool_state, without=self.ignored, touching=met)

    def tool(
        self, tool_state: ToolState, touching: frozenset[str] = NONE, without: frozenset[str] = NONE
    ) -> FreeToolChecker:
        """The empty tool by itself. touching: names that the cup may touch. without: ids of items, gone."""
        key = tool_state, touching, without
        if key not in self._tools:
            axes, gone = self.T_world_bin[:3, :3], self.ignored | without
            self._tools[key] = FreeToolChecker(
                self.planner.model, self.scene, tool_state, axes, gone, touching
            )
        return self._tools[key]

    @cached_property
    def _tools(self) -> dict[tuple[ToolState, frozenset[str], frozenset[str]], FreeToolChecker]:
        """Those made so far."""
        return {}

    @cached_property
    def flying(self) -> FreeItemChecker:
        """The target by itself, displaced along the bin's axes; it may touch nothing."""
        return self._flying(NO_CONTACTS, self.ignored | {self.target.id})

    @cached_property
    def ways_out(self) -> WaysOut:
        """The ways out of the bin for the target."""
        shape = self.target.item.shape.inflated(self.uncertainty)
        first, seed = self.planner.settings.lift_contact, derived_seed(self.seed, "exit", self.target.id)
        alone = self._leaving_alone, self.flying
        return WaysOut(self.cell_bin, self.T_world_bin, self.T_bin_item, shape, *alone, first, seed)

    @property
    def corridors(self) -> tuple[Corridor, ...] | Reason:
        """The ways out for the target by itself, the shortest first; or why there is none."""
        return self.ways_out.corridors

    @cached_property
    def _leaving_alone(self) -> FreeItemChecker:
        """The target where it may touch what it is near to, but not push what would roll along with it."""
        rolling = [p.id for p in self.scene.items if p.id in self.touching and p.can_roll]
        standing = {b.name for b in self.scene.cell.pod.bodies} & self.touching
        others = frozenset(p.id for p in self.scene.items)
        ground = AllowedContacts.anyhow(standing)
        beside = tuple(self._flying(ground, others - {name}) for name in rolling)
        touching = AllowedContacts.of(item=self._given_way(ALONE_SLIP))
        return self._flying(touching, self.ignored | {self.target.id}, beside)

    def _flying(
        self, touching: AllowedContacts, without: frozenset[str], beside: tuple[FreeItemChecker, ...] = ()
    ) -> FreeItemChecker:
        return FreeItemChecker(
            self.planner.model, self.scene, self.target.item, self.target.T_world_item,
            self.T_world_bin[:3, :3], self.uncertainty, without, touching, beside,
        )  # fmt: skip
