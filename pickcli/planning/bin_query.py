"""One pick as seen inside its bin: what every grasp of the target shares."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.cartesian.corridor import Corridor
from pickcli.cell.station import Bin
from pickcli.cell.tool import ToolState
from pickcli.collision.allowed_contacts import AllowedContacts
from pickcli.collision.free_flyer import FreeItem, FreeItemChecker, FreeToolChecker
from pickcli.collision.stage_contacts import CupPress, PickContacts
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse
from pickcli.grasping.cup_press import cup_press, overtravel
from pickcli.motion.plan import Grasp
from pickcli.planning.pick_settings import Neighbours
from pickcli.planning.planning_context import Planner
from pickcli.planning.stages.extraction import WaysOut
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.scene.solid_overlap import TOUCH
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
    def _ignored(self) -> frozenset[str]:
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
    def blockers(self) -> tuple[Reason, ...]:
        """Items that would fall or roll away if the target went, what must be cleared first at the head."""
        supports = self.contacts.supports
        lying = supports.lying_on(self.target.id)
        return tuple(
            Reason(
                "rests on the target" if name in lying else "falls without the target", "lift",
                f"{name} would fall or roll away", name,
            )
            for name in supports.falling(self.target.id)
            if name not in self._ignored
        )  # fmt: skip

    @cached_property
    def contradictions(self) -> tuple[Reason, ...]:
        """What the target overlaps with, as its pose says, deeper than poses may be off."""
        bound = {placed.id: self.scene.noise.bound(placed.item) for placed in self.scene.items}
        pod_error = self.scene.pod_error.bound(self._from_axis)
        found = []
        for name, c in self.contacts.near.items():
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
    def contacts(self) -> PickContacts:
        """Who may touch whom, stage by stage."""
        first = self.planner.settings.lift_contact
        return PickContacts(self.scene, self.target, frozenset(self.cell_bin.floor), self._ignored, first)

    def press(self, grasp: Grasp) -> CupPress:
        """How the cup is pressed on the target."""
        tool, excess = self.planner.cell.robot.tool, self.planner.model.cup_excess
        return cup_press(grasp, tool, self.scene.noise, self.target.T_world_item[:3, :3], excess)

    def tips(self, grasp: Grasp) -> bool:
        """Whether a cup from above tips the target, because it presses beside what carries it.

        Its other end rises then, towards the lance, and hardly any tipped face seals. What can roll is no
        matter of balance: it rolls wherever the cup meets it.
        """
        if grasp.kind != "top-down" or self.target.can_roll:
            return False
        tip = self.target.T_world_item @ grasp.T_item_tip
        tool = self.planner.cell.robot.tool
        press = tool.cup_stiffness * overtravel(grasp, tool, self.scene.noise)
        return not self.contacts.supports.stays_under(self.target.id, press * tip[:3, 2], tip[:3, 3])

    def tool(self, tool_state: ToolState, contacts: AllowedContacts) -> FreeToolChecker:
        """The empty tool by itself."""
        key = tool_state, contacts
        if key not in self._tools:
            axes = self.T_world_bin[:3, :3]
            self._tools[key] = FreeToolChecker(self.planner.model, self.scene, tool_state, axes, contacts)
        return self._tools[key]

    @cached_property
    def _tools(self) -> dict[tuple[ToolState, AllowedContacts], FreeToolChecker]:
        """Those made so far."""
        return {}

    @cached_property
    def ways_out(self) -> WaysOut:
        """The ways out of the bin for the target."""
        shape = self.target.item.shape.inflated(self.uncertainty)
        first, seed = self.planner.settings.lift_contact, derived_seed(self.seed, "exit", self.target.id)
        contacts = self.contacts
        beside = tuple(self._flying(alone) for alone in contacts.rolling_along())
        leaving = self._flying(contacts.item_while_lifting(), beside)
        carrying = self._flying(contacts.while_carrying())
        return WaysOut(
            self.cell_bin, self.T_world_bin, self.T_bin_item, shape, leaving, carrying, first, seed
        )

    @property
    def corridors(self) -> tuple[Corridor, ...] | Reason:
        """The ways out for the target by itself, the shortest first; or why there is none."""
        return self.ways_out.corridors

    def _flying(self, contacts: AllowedContacts, beside: tuple[FreeItemChecker, ...] = ()) -> FreeItemChecker:
        """The target by itself, displaced along the bin's axes."""
        axes = self.T_world_bin[:3, :3]
        free = FreeItem(self.target.item, self.target.T_world_item, axes, self.uncertainty)
        return FreeItemChecker(self.planner.model, self.scene, free, contacts, beside)
