"""The motion inside a bin for one grasp: key waypoints first, then every line, proven, or the reason.

Delft, section 2.2: (1) the grasp and the key waypoints are checked one after the other, (2) then each
linear segment; the first thing that fails discards the candidate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cartesian.corridor import LiftPoses
from pickcli.cartesian.key_waypoints import PickPoses
from pickcli.cartesian.line_following import Line, follow_line
from pickcli.cell.tool import ToolState
from pickcli.collision.attached_item import AttachedItem
from pickcli.collision.checker import SceneChecker
from pickcli.collision.stage_contacts import CupPress
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, inverse
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Grasp
from pickcli.planning.bin_query import BinQuery
from pickcli.planning.stages.extraction import Ways
from pickcli.planning.stages.tool_clearance import tool_ways_in, tool_ways_out


@dataclass(frozen=True, eq=False)
class InBin:
    """All lines of one grasp. Each starts where the one before ends; the configurations are exact."""

    grasp: Grasp
    held: AttachedItem
    preapproach: Line
    approach: Line
    contact: Line
    freed: Line  # first stretch of the lift
    lift: Line
    retreat: tuple[Line, ...]
    press: CupPress


def plan_in_bin(
    query: BinQuery, grasp: Grasp, rng: np.random.Generator, ways: Ways = Ways.FEW
) -> InBin | Failures:
    """The first solution for one grasp, over the branches and redundancy of the arm; or every reason.

    Args:
        query: The pick.
        grasp: Where the cup sits on the target.
        rng: Source of the arm's random seeds.
        ways: Out of the bin, among which one is chosen.
    """
    planner, where = query.planner, f"{grasp.kind} grasp on face {grasp.face}"
    if isinstance(query.corridors, Reason):
        return Failures.of(query.corridors)
    ways_in = tool_ways_in(query, grasp)
    if isinstance(ways_in, Reason):
        return Failures.of(ways_in.within(where))
    contact = ways_in[0].contact
    ways_out = tool_ways_out(query, grasp, contact, ways)
    if isinstance(ways_out, Reason):
        return Failures.of(ways_out.within(where))
    solutions = planner.arm.solve(contact, grasp.tool_state, _seeds(query, rng))
    if len(solutions) == 0:
        return Failures.of(Reason("no inverse-kinematics solution", f"{where}, contact", _place(contact)))
    lines = _Lines.of(query, grasp, contact, where)
    failures = Failures()
    for q_contact in solutions[: planner.settings.solutions_per_grasp]:
        if not lines.pressing.is_valid(q_contact):
            failures += lines.pressing.explain(q_contact).at(f"{where}, contact")
            continue
        way_in = lines.first_in(ways_in, q_contact)
        if isinstance(way_in, Failures):
            failures += way_in
            continue
        way_out = lines.first_out(ways_out, q_contact)
        if isinstance(way_out, Failures):
            failures += way_out
            continue
        return InBin(grasp, lines.held, *way_in, *way_out, press=lines.press)
    return failures


def _seeds(query: BinQuery, rng: np.random.Generator) -> Array:
    """The configuration in front of the bin, the same along the rail, and random ones."""
    arm, cell = query.planner.arm, query.planner.cell
    front = cell.configurations[query.cell_bin.name].q
    along = np.repeat(front[None], 4, axis=0)
    along[:, 0] = np.linspace(0.25, 1.0, 4)
    return np.vstack([front[None], along, arm.random_seeds(rng, 7)])


@dataclass(frozen=True, eq=False)
class _Lines:
    """What proves the lines of one grasp, stage by stage, and follows them.

    Attributes:
        arm: Kinematics of the arm.
        tool_state: State of the tool.
        contact: (4, 4) pose of the tool in the world when the cup is pressed on.
        press: How it is.
        held: The target in the cup.
        where: The grasp, as reasons call it.
        approaching: Of the empty tool in the bin.
        pressing: Of the empty tool at the target.
        lifting: With the target, over the first stretch of the lift.
        carrying: With the target when it touches nothing any more.
    """

    arm: Arm
    tool_state: ToolState
    contact: Array
    press: CupPress
    held: AttachedItem
    where: str
    approaching: SceneChecker
    pressing: SceneChecker
    lifting: SceneChecker
    carrying: SceneChecker

    @classmethod
    def of(cls, query: BinQuery, grasp: Grasp, contact: Array, where: str) -> _Lines:
        planner, scene, tool_state, contacts = query.planner, query.scene, grasp.tool_state, query.contacts
        press = query.press(grasp)
        # What the cup holds stays where it was when the cup met it: the overtravel goes into the bellows.
        held = AttachedItem(
            query.target.item, inverse(contact) @ query.target.T_world_item, query.uncertainty
        )
        return cls(
            planner.arm, tool_state, contact, press, held, where,
            planner.checker(scene, tool_state, contacts=contacts.while_approaching()),
            planner.checker(scene, tool_state, contacts=contacts.while_pressing(press)),
            planner.checker(scene, tool_state, held, contacts.while_lifting(press)),
            planner.checker(scene, tool_state, held, contacts.while_carrying()),
        )  # fmt: skip

    def first_in(self, ways: Sequence[PickPoses], q_contact: Array) -> tuple[Line, Line, Line] | Failures:
        """Pre-approach, approach and contact along the first way that the arm can follow."""
        failures = Failures()
        for poses in ways:
            lines = self._in(poses, q_contact)
            if not isinstance(lines, Reason):
                return lines
            failures += lines
        return failures

    def _in(self, poses: PickPoses, q_contact: Array) -> tuple[Line, Line, Line] | Reason:
        """Pre-approach, approach and contact, followed backwards from the contact configuration."""
        contact = self._line(self.pressing, poses.contact, poses.touch, q_contact, "contact")
        if isinstance(contact, Reason):
            return contact
        approach = self._line(
            self.approaching, poses.touch, poses.approach, contact.waypoints[-1], "approach"
        )
        if isinstance(approach, Reason):
            return approach
        q = approach.waypoints[-1]
        pre = self._line(self.approaching, poses.approach, poses.preapproach, q, "pre-approach")
        if isinstance(pre, Reason):
            return pre
        return pre.backwards(), approach.backwards(), contact.backwards()

    def first_out(
        self, ways: Sequence[LiftPoses], q_contact: Array
    ) -> tuple[Line, Line, tuple[Line, ...]] | Failures:
        """Lift and retreat with the item held, along the first way that the arm can follow."""
        failures = Failures()
        for poses in ways:
            out = self._out(poses, q_contact)
            if not isinstance(out, Reason):
                return out
            failures += out
        return failures

    def _out(self, poses: LiftPoses, q_contact: Array) -> tuple[Line, Line, tuple[Line, ...]] | Reason:
        freed = self._line(self.lifting, self.contact, poses.freed, q_contact, "lift")
        if isinstance(freed, Reason):
            return freed
        q = freed.waypoints[-1]
        if not self.carrying.is_valid(q):
            return self.carrying.explain(q).at(f"{self.where}, lift")
        lift = self._line(self.carrying, poses.freed, poses.lift, q, "lift")
        if isinstance(lift, Reason):
            return lift
        q, here = lift.waypoints[-1], poses.lift
        retreat = []
        for there in poses.retreat:
            push = self._line(self.carrying, here, there, q, "retreat")
            if isinstance(push, Reason):
                return push
            retreat.append(push)
            q, here = push.waypoints[-1], there
        return freed, lift, tuple(retreat)

    def _line(self, checker: SceneChecker, T_a: Array, T_b: Array, q_a: Array, name: str) -> Line | Reason:
        return follow_line(self.arm, checker, T_a, T_b, self.tool_state, q_a, f"{self.where}, {name}")


def _place(T: Array) -> str:
    x, y, z = T[:3, 3]
    return f"tool at ({x:.3f}, {y:.3f}, {z:.3f}) m"
