"""The motion inside a bin for one grasp: key waypoints first, then every line, proven, or the reason.

Delft, section 2.2: (1) the grasp and the key waypoints are checked one after the other, (2) then each
linear segment; the first thing that fails discards the candidate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cartesian.corridor import LiftPoses, along
from pickcli.cartesian.follow import Line, follow_line
from pickcli.cartesian.keyposes import PickPoses, pick_poses
from pickcli.collision.checker import Held, SceneChecker
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse
from pickcli.grasping.surfaces import tilt_on
from pickcli.motion.plan import Grasp
from pickcli.planning.bin_query import BinQuery

PRESS = 0.001  # m that the bellows are pressed at least


@dataclass(frozen=True, eq=False)
class InBin:
    """All lines of one grasp. Each starts where the one before ends; the configurations are exact."""

    grasp: Grasp
    held: Held
    preapproach: Line
    approach: Line
    contact: Line
    freed: Line  # first stretch of the lift
    lift: Line
    retreat: tuple[Line, ...]
    touching: frozenset[str]  # what the held item may touch during ``freed``
    ignored: frozenset[str]  # neighbours that are not considered (--neighbours ignore)


def plan_in_bin(query: BinQuery, grasp: Grasp, rng: np.random.Generator) -> InBin | list[Reason]:
    """The first solution for one grasp, over the branches and redundancy of the arm; or every reason."""
    planner, where = query.planner, f"{grasp.kind} grasp on face {grasp.face}"
    if isinstance(query.corridors, Reason):
        return [query.corridors]
    poses = _poses(query, grasp)
    solutions = planner.arm.solve(poses.contact, grasp.pivot, _seeds(query, rng))
    if len(solutions) == 0:
        return [Reason("no inverse-kinematics solution", f"{where}, contact", _place(poses.contact))]
    empty, meeting = query.empty[grasp.pivot], query.meeting[grasp.pivot]
    # What the cup holds stays where it was when the cup met it: the overtravel goes into the bellows.
    T_tip_item = inverse(poses.contact) @ query.target.T_world_item
    held = Held(query.target.item, T_tip_item, query.uncertainty)
    reasons: list[Reason] = []
    for q_contact in solutions[: planner.settings.solutions_per_grasp]:
        if not meeting.is_free(q_contact):
            reason = meeting.explain(q_contact)
            reasons.append(reason.at(f"{where}, contact"))
            continue
        way_in = _way_in(query, grasp, poses, q_contact, empty, meeting, where)
        if isinstance(way_in, Reason):
            reasons.append(way_in)
            continue
        way_out = _way_out(query, grasp, poses, held, q_contact, where)
        if isinstance(way_out, list):
            reasons += way_out
            continue
        return InBin(grasp, held, *way_in, *way_out, touching=query.touching, ignored=query.ignored)
    return reasons


def _poses(query: BinQuery, grasp: Grasp) -> PickPoses:
    tool = query.planner.cell.robot.tool
    noise = query.scene.noise
    aside = float(np.linalg.norm(np.cross(grasp.T_item_tip[:3, 3], grasp.T_item_tip[:3, 2])))
    # How far the surface under the cup may be along the tool axis from where its pose says.
    # The side of a tilted cup that is farther away must meet it as well.
    lag = tool.cup_radius * float(np.sin(tilt_on(query.target.item, grasp.face, grasp.T_item_tip)))
    overtravel = min(noise.position + noise.angle * aside + PRESS + lag, 0.75 * tool.cup_stroke)
    return pick_poses(
        query.T_world_bin, query.target.T_world_item, grasp.T_item_tip,
        query.planner.settings.approach_offset, overtravel,
    )  # fmt: skip


def _seeds(query: BinQuery, rng: np.random.Generator) -> Array:
    """The configuration in front of the bin, the same along the rail, and random ones."""
    arm, cell = query.planner.arm, query.planner.cell
    front = cell.configurations[query.cell_bin.name].q
    along = np.repeat(front[None], 4, axis=0)
    along[:, 0] = np.linspace(0.25, 1.0, 4)
    return np.vstack([front[None], along, arm.random_seeds(rng, 7)])


def _way_in(
    query: BinQuery, grasp: Grasp, poses: PickPoses, q_contact: Array,
    empty: SceneChecker, meeting: SceneChecker, where: str,
) -> tuple[Line, Line, Line] | Reason:  # fmt: skip
    """Pre-approach, approach and contact, followed backwards from the contact configuration."""
    arm, pivot = query.planner.arm, grasp.pivot
    contact = follow_line(arm, meeting, poses.contact, poses.touch, pivot, q_contact, f"{where}, contact")
    if isinstance(contact, Reason):
        return contact
    q = contact.waypoints[-1]
    approach = follow_line(arm, empty, poses.touch, poses.approach, pivot, q, f"{where}, approach")
    if isinstance(approach, Reason):
        return approach
    q = approach.waypoints[-1]
    pre = follow_line(arm, empty, poses.approach, poses.preapproach, pivot, q, f"{where}, pre-approach")
    if isinstance(pre, Reason):
        return pre
    return _backwards(pre), _backwards(approach), _backwards(contact)


def _backwards(line: Line) -> Line:
    return Line(line.waypoints[::-1].copy())


def _way_out(
    query: BinQuery, grasp: Grasp, poses: PickPoses, held: Held, q_contact: Array, where: str
) -> tuple[Line, Line, tuple[Line, ...]] | list[Reason]:
    """Lift and retreat with the item held, along the first corridor that the arm can follow."""
    planner = query.planner
    gone = query.ignored | {query.target.id}
    carrying = planner.checker(query.scene, grasp.pivot, held=held, without=gone)
    leaving = planner.checker(query.scene, grasp.pivot, held=held, without=gone, touching=query.touching)
    assert not isinstance(query.corridors, Reason)
    reasons = []
    for corridor in query.corridors:
        option = along(corridor, query.T_world_bin, query.target.T_world_item, poses.contact)
        out = _lines_out(query, grasp, poses.contact, option, q_contact, leaving, carrying, where)
        if isinstance(out, Reason):
            reasons.append(out)
        else:
            return out
    return reasons


def _lines_out(
    query: BinQuery, grasp: Grasp, contact: Array, option: LiftPoses, q_contact: Array,
    leaving: SceneChecker, carrying: SceneChecker, where: str,
) -> tuple[Line, Line, tuple[Line, ...]] | Reason:  # fmt: skip
    arm, pivot = query.planner.arm, grasp.pivot
    freed = follow_line(arm, leaving, contact, option.freed, pivot, q_contact, f"{where}, lift")
    if isinstance(freed, Reason):
        return freed
    q = freed.waypoints[-1]
    if not carrying.is_free(q):
        reason = carrying.explain(q)
        return reason.at(f"{where}, lift")
    lift = follow_line(arm, carrying, option.freed, option.lift, pivot, q, f"{where}, lift")
    if isinstance(lift, Reason):
        return lift
    q = lift.waypoints[-1]
    retreat, here = [], option.lift
    for there in option.retreat:
        push = follow_line(arm, carrying, here, there, pivot, q, f"{where}, retreat")
        if isinstance(push, Reason):
            return push
        retreat.append(push)
        q, here = push.waypoints[-1], there
    return freed, lift, tuple(retreat)


def _place(T: Array) -> str:
    x, y, z = T[:3, 3]
    return f"tool at ({x:.3f}, {y:.3f}, {z:.3f}) m"
