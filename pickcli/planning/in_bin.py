"""The motion inside a bin for one grasp: key waypoints first, then every line, proven, or the reason.

Delft, section 2.2: (1) the grasp and the key waypoints are checked one after the other, (2) then each
linear segment; the first thing that fails discards the candidate.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cartesian.follow import Line, follow_line
from pickcli.cartesian.keyposes import LiftPoses, PickPoses, lift_options, pick_poses
from pickcli.cell.scene import PlacedItem, Scene
from pickcli.cell.station import Bin
from pickcli.collision.checker import Held, SceneChecker
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse
from pickcli.motion.plan import Grasp
from pickcli.planning.context import Planner
from pickcli.planning.settings import Neighbours

PRESS = 0.001  # m that the bellows are pressed at least
MAX_TOUCHING = 12  # bodies around a resting item; more means that it is buried


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
    retreat: Line
    touching: frozenset[str]  # what the held item may touch during ``freed``
    ignored: frozenset[str]  # neighbours that are not considered (--neighbours ignore)


@dataclass(frozen=True, eq=False)
class BinQuery:
    """One pick as seen inside its bin."""

    planner: Planner
    scene: Scene
    cell_bin: Bin
    target: PlacedItem
    neighbours: Neighbours

    @property
    def T_world_bin(self) -> Array:
        """Pose of the bin frame where the pod really stands."""
        return np.asarray(self.scene.T_world_pod @ self.cell_bin.T_pod_bin)

    @property
    def ignored(self) -> frozenset[str]:
        """Neighbours that are left out of the collision model."""
        if self.neighbours is Neighbours.AVOID:
            return frozenset()
        here = self.scene.in_location(self.cell_bin.name)
        return frozenset(i.id for i in here if i.id != self.target.id)

    @property
    def uncertainty(self) -> float:
        """How far any point of the target may be from where its pose says, m."""
        return self.scene.noise.bound(self.target.item)


def plan_in_bin(query: BinQuery, grasp: Grasp, rng: np.random.Generator) -> InBin | list[Reason]:
    """The first solution for one grasp, over the branches and redundancy of the arm; or every reason."""
    planner, where = query.planner, f"{grasp.kind} grasp on face {grasp.face}"
    poses = _poses(query, grasp)
    solutions = planner.arm.solve(poses.contact, grasp.pivot, _seeds(query, rng))
    if len(solutions) == 0:
        return [Reason("no inverse-kinematics solution", f"{where}, contact", _place(poses.contact))]
    empty = planner.checker(query.scene, grasp.pivot, without=query.ignored)
    meeting = planner.checker(
        query.scene, grasp.pivot, without=query.ignored, touching=frozenset({query.target.id})
    )
    reasons: list[Reason] = []
    for q_contact in solutions[: planner.settings.solutions_per_grasp]:
        if not meeting.is_free(q_contact):
            reason = meeting.explain(q_contact)
            reasons.append(Reason(reason.what, f"{where}, contact", reason.detail))
            continue
        way_in = _way_in(query, grasp, poses, q_contact, empty, meeting, where)
        if isinstance(way_in, Reason):
            reasons.append(way_in)
            continue
        way_out = _way_out(query, grasp, poses, q_contact, where)
        if isinstance(way_out, list):
            reasons += way_out
            continue
        held, touching, out = way_out
        return InBin(grasp, held, *way_in, *out, touching=touching, ignored=query.ignored)
    return reasons


def _poses(query: BinQuery, grasp: Grasp) -> PickPoses:
    tool = query.planner.cell.robot.tool
    noise = query.scene.noise
    aside = float(np.linalg.norm(np.cross(grasp.T_item_tip[:3, 3], grasp.T_item_tip[:3, 2])))
    # How far the surface under the cup may be along the tool axis from where its pose says.
    overtravel = min(noise.position + noise.angle * aside + PRESS, 0.75 * tool.cup_stroke)
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
    query: BinQuery, grasp: Grasp, poses: PickPoses, q_contact: Array, where: str
) -> tuple[Held, frozenset[str], tuple[Line, Line, Line]] | list[Reason]:
    """Lift and retreat with the item held, by the first of the lift options that is free."""
    planner, item = query.planner, query.target.item
    # What the cup holds stays where it was when the cup met it: the overtravel goes into the bellows.
    T_tip_item = inverse(poses.contact) @ query.target.T_world_item
    held = Held(item, T_tip_item, query.uncertainty)
    options = lift_options(
        query.cell_bin, query.T_world_bin, query.target.T_world_item, item.shape.inflated(query.uncertainty),
        poses.contact, planner.settings.lift_contact,
    )  # fmt: skip
    if isinstance(options, Reason):
        return [Reason(options.what, f"{where}, {options.where}", options.detail)]
    gone = query.ignored | {query.target.id}
    carrying = planner.checker(query.scene, grasp.pivot, held=held, without=gone)
    touching = _resting_on(planner, query.scene, grasp, held, gone, q_contact)
    if isinstance(touching, Reason):
        return [Reason(touching.what, f"{where}, lift", touching.detail)]
    leaving = planner.checker(query.scene, grasp.pivot, held=held, without=gone, touching=touching)
    reasons = []
    for option in options:
        out = _lines_out(query, grasp, poses.contact, option, q_contact, leaving, carrying, where)
        if isinstance(out, Reason):
            reasons.append(out)
        else:
            return held, touching, out
    return reasons


def _resting_on(
    planner: Planner, scene: Scene, grasp: Grasp, held: Held, gone: frozenset[str], q: Array
) -> frozenset[str] | Reason:
    """Everything within the clearance of the item at rest: its support, walls and neighbours."""
    touching: frozenset[str] = frozenset()
    for _ in range(MAX_TOUCHING):
        checker = planner.checker(scene, grasp.pivot, held=held, without=gone, touching=touching)
        if checker.is_free(q):
            return touching
        near = checker.clearance(q)
        if near.b in touching:
            break
        touching |= {near.b}
    return Reason("buried", "", f"more than {MAX_TOUCHING} bodies touch it, or the arm is not free of {near.b}")


def _lines_out(
    query: BinQuery, grasp: Grasp, contact: Array, option: LiftPoses, q_contact: Array,
    leaving: SceneChecker, carrying: SceneChecker, where: str,
) -> tuple[Line, Line, Line] | Reason:  # fmt: skip
    arm, pivot = query.planner.arm, grasp.pivot
    freed = follow_line(arm, leaving, contact, option.freed, pivot, q_contact, f"{where}, lift")
    if isinstance(freed, Reason):
        return freed
    q = freed.waypoints[-1]
    if not carrying.is_free(q):
        reason = carrying.explain(q)
        return Reason(reason.what, f"{where}, lift", reason.detail)
    lift = follow_line(arm, carrying, option.freed, option.lift, pivot, q, f"{where}, lift")
    if isinstance(lift, Reason):
        return lift
    q = lift.waypoints[-1]
    retreat = follow_line(arm, carrying, option.lift, option.retreat, pivot, q, f"{where}, retreat")
    if isinstance(retreat, Reason):
        return retreat
    return freed, lift, retreat


def _place(T: Array) -> str:
    x, y, z = T[:3, 3]
    return f"tool at ({x:.3f}, {y:.3f}, {z:.3f}) m"
