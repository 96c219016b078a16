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
from pickcli.collision.allowed_contacts import AllowedContacts
from pickcli.collision.attached_item import AttachedItem
from pickcli.collision.checker import SceneChecker
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, inverse
from pickcli.motion.plan import Grasp
from pickcli.planning.bin_query import BinQuery
from pickcli.planning.tool_ways import tool_ways_in, tool_ways_out
from pickcli.planning.ways_out import Ways


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
    leaving: AllowedContacts  # what item and cup may touch during ``freed``
    ignored: frozenset[str]  # neighbours that are not considered (--neighbours ignore)


def plan_in_bin(
    query: BinQuery, grasp: Grasp, rng: np.random.Generator, ways: Ways = Ways.FEW
) -> InBin | Failures:
    """The first solution for one grasp, over the branches and redundancy of the arm; or every reason.

    ways: out of the bin, among which one is chosen
    """
    planner, where = query.planner, f"{grasp.kind} grasp on face {grasp.face}"
    if isinstance(query.corridors, Reason):
        return Failures.of(query.corridors)
    ways_in = tool_ways_in(query, grasp, query.overtravel(grasp))
    if isinstance(ways_in, Reason):
        return Failures.of(ways_in.within(where))
    contact = ways_in[0].contact
    ways_out = tool_ways_out(query, grasp, contact, ways)
    if isinstance(ways_out, Reason):
        return Failures.of(ways_out.within(where))
    solutions = planner.arm.solve(contact, grasp.tool_state, _seeds(query, rng))
    if len(solutions) == 0:
        return Failures.of(Reason("no inverse-kinematics solution", f"{where}, contact", _place(contact)))
    meeting = query.meeting(grasp)
    # What the cup holds stays where it was when the cup met it: the overtravel goes into the bellows.
    held = AttachedItem(query.target.item, inverse(contact) @ query.target.T_world_item, query.uncertainty)
    failures = Failures()
    for q_contact in solutions[: planner.settings.solutions_per_grasp]:
        if not meeting.is_valid(q_contact):
            failures += meeting.explain(q_contact).at(f"{where}, contact")
            continue
        way_in = _way_in(query, grasp, ways_in, q_contact, where)
        if isinstance(way_in, Failures):
            failures += way_in
            continue
        way_out = _way_out(query, grasp, contact, ways_out, held, q_contact, where)
        if isinstance(way_out, Failures):
            failures += way_out
            continue
        return InBin(grasp, held, *way_in, *way_out, leaving=query.leaving(grasp), ignored=query.ignored)
    return failures


def _seeds(query: BinQuery, rng: np.random.Generator) -> Array:
    """The configuration in front of the bin, the same along the rail, and random ones."""
    arm, cell = query.planner.arm, query.planner.cell
    front = cell.configurations[query.cell_bin.name].q
    along = np.repeat(front[None], 4, axis=0)
    along[:, 0] = np.linspace(0.25, 1.0, 4)
    return np.vstack([front[None], along, arm.random_seeds(rng, 7)])


def _way_in(
    query: BinQuery, grasp: Grasp, ways: Sequence[PickPoses], q_contact: Array, where: str
) -> tuple[Line, Line, Line] | Failures:
    """Pre-approach, approach and contact along the first way that the arm can follow."""
    failures = Failures()
    for poses in ways:
        lines = _lines_in(query, grasp, poses, q_contact, where)
        if not isinstance(lines, Reason):
            return lines
        failures += lines
    return failures


def _lines_in(
    query: BinQuery, grasp: Grasp, poses: PickPoses, q_contact: Array, where: str
) -> tuple[Line, Line, Line] | Reason:
    """Pre-approach, approach and contact, followed backwards from the contact configuration."""
    arm, tool_state = query.planner.arm, grasp.tool_state
    empty, meeting = query.empty[tool_state], query.meeting(grasp)
    contact = follow_line(
        arm, meeting, poses.contact, poses.touch, tool_state, q_contact, f"{where}, contact"
    )
    if isinstance(contact, Reason):
        return contact
    q = contact.waypoints[-1]
    approach = follow_line(arm, empty, poses.touch, poses.approach, tool_state, q, f"{where}, approach")
    if isinstance(approach, Reason):
        return approach
    q = approach.waypoints[-1]
    pre = follow_line(arm, empty, poses.approach, poses.preapproach, tool_state, q, f"{where}, pre-approach")
    if isinstance(pre, Reason):
        return pre
    return pre.backwards(), approach.backwards(), contact.backwards()


def _way_out(
    query: BinQuery, grasp: Grasp, contact: Array, ways: Sequence[LiftPoses], held: AttachedItem,
    q_contact: Array, where: str,
) -> tuple[Line, Line, tuple[Line, ...]] | Failures:  # fmt: skip
    """Lift and retreat with the item held, along the first way that the arm can follow."""
    planner = query.planner
    gone = query.ignored | {query.target.id}
    carrying = planner.checker(query.scene, grasp.tool_state, held=held, without=gone)
    touching = query.leaving(grasp)
    leaving = planner.checker(query.scene, grasp.tool_state, held=held, without=gone, touching=touching)
    failures = Failures()
    for option in ways:
        out = _lines_out(query, grasp, contact, option, q_contact, leaving, carrying, where)
        if not isinstance(out, Reason):
            return out
        failures += out
    return failures


def _lines_out(
    query: BinQuery, grasp: Grasp, contact: Array, option: LiftPoses, q_contact: Array,
    leaving: SceneChecker, carrying: SceneChecker, where: str,
) -> tuple[Line, Line, tuple[Line, ...]] | Reason:  # fmt: skip
    arm, tool_state = query.planner.arm, grasp.tool_state
    freed = follow_line(arm, leaving, contact, option.freed, tool_state, q_contact, f"{where}, lift")
    if isinstance(freed, Reason):
        return freed
    q = freed.waypoints[-1]
    if not carrying.is_valid(q):
        return carrying.explain(q).at(f"{where}, lift")
    lift = follow_line(arm, carrying, option.freed, option.lift, tool_state, q, f"{where}, lift")
    if isinstance(lift, Reason):
        return lift
    q = lift.waypoints[-1]
    retreat, here = [], option.lift
    for there in option.retreat:
        push = follow_line(arm, carrying, here, there, tool_state, q, f"{where}, retreat")
        if isinstance(push, Reason):
            return push
        retreat.append(push)
        q, here = push.waypoints[-1], there
    return freed, lift, tuple(retreat)


def _place(T: Array) -> str:
    x, y, z = T[:3, 3]
    return f"tool at ({x:.3f}, {y:.3f}, {z:.3f}) m"
