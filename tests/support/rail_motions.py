"""Motions of the rail alone: how far, how fast and how near is told by where the rail is."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.verification.state_sampling import States, sample_states
from support.handmade_plans import cell
from support.tool_states import STRAIGHT

HOME = np.asarray(cell().configurations["home"].q)


def rail(*ways: float, level: RecoveryLevel | None = None, kind: SegmentKind = SegmentKind.RETREAT) -> Plan:
    """The rail goes by so many m, a second each, at rest in between; every way is a segment."""
    at = np.cumsum([0.0, *ways])
    p = np.tile(HOME, (len(at), 1))
    p[:, 0] += at
    still = np.zeros_like(p)
    trajectory = Trajectory(cell().robot.joint_names, np.arange(float(len(at))), p, still, still)
    segments = tuple(Segment(kind, a, b, STRAIGHT, None) for a, b in pairwise(trajectory.times.tolist()))
    return Plan("recover", "", "", 0, segments, trajectory, (), recovery=level)


def states_of(plan: Plan) -> States:
    """The states of a motion in which a point moves as far as the rail."""
    reach = np.zeros(len(HOME))
    reach[0] = 1.0
    return sample_states(cell().robot, plan.trajectory, np.empty(0), reach)
