"""Motions near their lower bound, proven by those who did not make them."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import Reason
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.precompute.coarse_motion_planner import CoarseMotionPlanner
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.roadmap.trajectory_database import CoarseMotion, MotionKey, PayloadClass
from pickcli.scene.scene import empty_scene
from pickcli.scene.scene_file import scene_hash
from pickcli.trajopt.trajectory_settings import TrajectorySettings
from pickcli.verification.verify import verify
from support.small_cell import small_cell
from support.tool_states import STRAIGHT

EMPTY, CENTRED = PayloadClass.EMPTY, PayloadClass.CENTRED_CUBE

# A free line, a line that only the empty tool has, lines blocked for both, and both tool states.
KEYS = (
    MotionKey("home", "bin_E", EMPTY),
    MotionKey("cam_J", "tote", EMPTY),
    MotionKey("bin_E", "drop_00_down", EMPTY),
    MotionKey("bin_A", "cam_G", CENTRED),
    MotionKey("bin_L", "tote", CENTRED),
)


def maker(*keys: MotionKey) -> CoarseMotionPlanner:
    return CoarseMotionPlanner(
        small_cell(*(name for key in keys for name in (key.start, key.goal))), TrajectorySettings()
    )


def made(key: MotionKey) -> CoarseMotion:
    motion = maker(key).make(key)
    assert isinstance(motion, CoarseMotion), motion
    return motion


@pytest.fixture(scope="module")
def motions() -> dict[MotionKey, CoarseMotion]:
    return {key: made(key) for key in KEYS}


@pytest.mark.parametrize("key", [key for key in KEYS if key.payload is EMPTY], ids=str)
def test_the_second_opinion_accepts_the_motion(
    key: MotionKey, motions: dict[MotionKey, CoarseMotion]
) -> None:
    motion, scene = motions[key], empty_scene(small_cell(key.start, key.goal))
    assert motion.trajectory is not None
    segment = Segment(SegmentKind.TRANSIT, 0.0, motion.duration, motion.tool_state, None)
    plan = Plan("stored", scene.cell.fingerprint, scene_hash(scene), 0, (segment,), motion.trajectory, ())
    verdict = verify(plan, scene)
    assert verdict.certificate is not None, verdict.reasons
    assert verdict.certificate.min_clearance >= motion.clearance - 1e-3


@pytest.mark.parametrize("key", KEYS, ids=str)
def test_no_state_of_the_motion_comes_closer_than_it_says(
    key: MotionKey, motions: dict[MotionKey, CoarseMotion]
) -> None:
    """Distances in double precision, every two milliseconds."""
    motion, cell = motions[key], small_cell(key.start, key.goal)
    assert motion.trajectory is not None
    tests = checker(CollisionModel(cell), motion.tool_state, key.payload)
    Q = motion.trajectory.sample(np.arange(0.0, motion.duration, 0.002))
    assert motion.clearance >= cell.clearance
    assert tests.kernel.clearances(Q).min() >= motion.clearance


@pytest.mark.parametrize("key", KEYS, ids=str)
def test_the_motion_is_near_its_bound_and_its_path_near_the_motion(
    key: MotionKey, motions: dict[MotionKey, CoarseMotion]
) -> None:
    motion, cell = motions[key], small_cell(key.start, key.goal)
    assert motion.trajectory is not None
    ends = [cell.configurations[name].q for name in (key.start, key.goal)]
    np.testing.assert_array_equal(motion.trajectory.positions[[0, -1]], ends)
    np.testing.assert_array_equal(motion.path.waypoints[[0, -1]], ends)
    assert motion.lower_bound <= motion.duration <= 1.02 * motion.lower_bound
    Q = motion.trajectory.sample(np.linspace(0.0, motion.duration, 300))
    a, b = motion.path.waypoints[:-1, None], motion.path.waypoints[1:, None]
    u = np.clip(((Q - a) * (b - a)).sum(-1) / ((b - a) ** 2).sum(-1), 0.0, 1.0)[..., None]
    assert np.abs(Q - a - u * (b - a)).max(axis=-1).min(axis=0).max() < 0.03
    assert checker(CollisionModel(cell), motion.tool_state, key.payload).is_valid_path(motion.path.waypoints)


def test_the_straight_line_of_the_blocked_ones_is_blocked() -> None:
    for key in KEYS[3:]:
        cell = small_cell(key.start, key.goal)
        tests = checker(CollisionModel(cell), STRAIGHT, key.payload)
        assert not tests.is_valid_edge(cell.configurations[key.start].q, cell.configurations[key.goal].q)


def test_a_task_can_be_sent_to_another_process(motions: dict[MotionKey, CoarseMotion]) -> None:
    key = KEYS[3]
    cell, settings, sent = pickle.loads(
        pickle.dumps((small_cell(key.start, key.goal), TrajectorySettings(), key))
    )
    there = CoarseMotionPlanner(cell, settings).make(sent)
    assert isinstance(there, CoarseMotion) and there.trajectory is not None
    here = motions[key].trajectory
    assert here is not None and there.trajectory.positions.tobytes() == here.positions.tobytes()
    assert pickle.loads(pickle.dumps(there)).duration == motions[key].duration


def test_an_end_in_collision_is_told_with_bodies_and_depth() -> None:
    key = MotionKey("tote", "tote_10h", CENTRED)
    reason = maker(key).make(key)
    assert isinstance(reason, Reason) and reason.where == "tote_10h"
    assert "held cube against tote tote_wall_right" in reason.detail and "mm deep" in reason.detail
