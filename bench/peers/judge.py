"""The judge of all paths, ours and the peers': the verifier's exact shapes (python-fcl) and kinematics.

It shares no code with any planner. Between the states that it looks at no point of the robot moves more than
2 mm, and what could happen there is bounded.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bench.peers.queries import Query
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.scene.scene import Scene
from pickcli.verification.clearance_check import check_clearance
from pickcli.verification.exemptions import exemptions
from pickcli.verification.moving_parts import farthest, fixtures, parts
from pickcli.verification.state_sampling import sample_states
from pickcli.verification.static_solids import PlanFixtures

SAME = 1e-6  # rad or m by which an end may be off


@dataclass(frozen=True)
class Judgement:
    """What became of one path.

    is_valid: from start to goal, within the limits, nothing touches
    clearance: m that it is proven to keep from everything, at most 50 mm; 0 if something touches
    why: not valid, "" if it is
    """

    is_valid: bool
    clearance: float
    why: str


def judge(scene: Scene, query: Query, waypoints: Array) -> Judgement:
    """Look at a path (N, n) that answers a query in its scene."""
    why = _wrong_ends(scene, query, waypoints)
    if why:
        return Judgement(False, 0.0, why)
    trajectory = _halting(scene, waypoints)
    held = next(iter(query.without)) if query.held is not None else None
    kind = SegmentKind.TRANSIT if held is None else SegmentKind.TRANSFER
    segment = Segment(kind, 0.0, trajectory.duration, query.tool_state, held)
    plan = Plan(query.name, scene.cell.fingerprint, "", 0, (segment,), trajectory, ())
    moving = parts(scene, segment, None if query.held is None else query.held.T_tip_item)
    ends = np.array([0.0, trajectory.duration])
    states = sample_states(scene.cell.robot, trajectory, ends, farthest(moving))
    world = PlanFixtures(plan, fixtures(scene), None)
    exempt = exemptions(plan, scene, states, [moving], world)
    found = check_clearance(plan, states, [moving], world, exempt)
    touching = [str(reason) for reason in found.reasons if reason.what == "collision"]
    return Judgement(not touching, 0.0 if found.reasons else found.minimum, "; ".join(touching))


def _wrong_ends(scene: Scene, query: Query, waypoints: Array) -> str:
    limits = scene.cell.robot.limits
    if np.abs(waypoints[[0, -1]] - np.stack([query.q_start, query.q_goal])).max() > SAME:
        return "does not lead from start to goal"
    outside = np.any(waypoints < limits.lower - SAME) or np.any(waypoints > limits.upper + SAME)
    return "leaves the joint limits" if outside else ""


def _halting(scene: Scene, waypoints: Array) -> Trajectory:
    """The polyline as a trajectory that halts at each vertex, a second per edge: so it stays on the edges."""
    kept = np.concatenate([[True], np.abs(np.diff(waypoints, axis=0)).max(axis=1) > 0.0])
    points = waypoints[kept]
    still = np.zeros_like(points)
    return Trajectory(scene.cell.robot.joint_names, np.arange(float(len(points))), points, still, still)
