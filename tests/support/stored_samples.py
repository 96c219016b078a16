"""A small roadmap and database for the stores' tests."""

from __future__ import annotations

import numpy as np

from pickcli.cell.tool import MOVING
from pickcli.motion.path import JointPath
from pickcli.motion.trajectory import Trajectory
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.trajectory_database import CoarseMotion, MotionKey, PayloadClass, TrajectoryDatabase
from support.tool_states import DOWN

JOINTS = ("x", "y", "z")
FINGERPRINT = "f" * 64
MADE = {"seed": 7, "planner": "RRTstar"}


def roadmap(n_nodes: int = 6) -> Roadmap:
    rng = np.random.default_rng(1)
    built = Roadmap.empty(JOINTS)
    for i, q in enumerate(rng.uniform(-1, 1, (n_nodes, 3))):
        built, _ = built.with_node(q, f"node_ä{i}" if i else "", DOWN)
    for a in range(n_nodes - 1):
        ends = built.configurations[[a, a + 1]]
        built = built.with_edge(a, a + 1, np.stack([ends[0], rng.uniform(-1, 1, 3), ends[1]]))
    return built


def database() -> TrajectoryDatabase:
    named = dict(zip("abc", np.random.default_rng(2).uniform(-1, 1, (3, 3)), strict=True))
    return TrajectoryDatabase.of(
        JOINTS,
        [
            _motion(named, "a", "b", PayloadClass.EMPTY),
            _motion(named, "b", "c", PayloadClass.EMPTY),
            _motion(named, "a", "b", PayloadClass.CUBE),
        ],
    )


def _motion(named: dict[str, np.ndarray], start: str, goal: str, payload: PayloadClass) -> CoarseMotion:
    """A straight edge, timed as one quintic of 2 s from rest to rest, with a point at its middle."""
    q0, q1 = named[start], named[goal]
    ends = Trajectory(JOINTS, np.array([0.0, 2.0]), np.stack([q0, q1]), np.zeros((2, 3)), np.zeros((2, 3)))
    times = np.array([0.0, 0.7, 2.0])
    timed = Trajectory(JOINTS, times, ends.sample(times), ends.sample(times, 1), ends.sample(times, 2))
    path = JointPath(JOINTS, np.stack([q0, q1]))
    return CoarseMotion(MotionKey(start, goal, payload), MOVING, path, 2.0, timed)
