"""The database of real motions."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.collision.robot_model import CollisionModel
from pickcli.jobs.job_result import JobResult
from pickcli.precompute.coarse_motion_job import CoarseMotionJob, made_of, record_of
from pickcli.precompute.coarse_motion_planner import CoarseMotionPlanner
from pickcli.precompute.database_builder import TrajectoryReport, build_trajectories
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.precompute.motion_pairs import coarse_pairs
from pickcli.roadmap.trajectory_database import CoarseMotion, MotionKey, PayloadClass, TrajectoryDatabase
from support.small_cell import LEAST_EFFORT, small_cell

Built = tuple[TrajectoryDatabase, TrajectoryReport]


def test_the_pairs_are_those_that_delft_recorded_and_our_drop_poses() -> None:
    cell = load_cell("apc2016_delft")
    kinds = Counter(
        tuple(sorted((cell.configurations[key.start].kind, cell.configurations[key.goal].kind)))
        for key in coarse_pairs(cell)
        if key.payload is PayloadClass.EMPTY
    )
    delft = {k: n for k, n in kinds.items() if "drop" not in k}
    # 135 pairs in the recording; four of the 66 pairs of camera poses were missing there.
    assert sum(delft.values()) == 135 + 4
    assert delft["bin", "camera"] == 12
    assert kinds["bin", "drop"] == 12 * 12


@pytest.fixture(scope="module")
def built() -> Built:
    database, report = build_trajectories(CoarseMotionJob(small_cell(), LEAST_EFFORT))
    assert len(database) > 0 and report.missing
    return database, report


def test_every_motion_is_proven_and_ends_where_its_name_says(built: Built) -> None:
    database, _ = built
    cell = small_cell()
    model = CollisionModel(cell)
    for motion in database:
        tests = checker(model, motion.tool_state, motion.key.payload)
        ends = [cell.configurations[name].q for name in (motion.key.start, motion.key.goal)]
        np.testing.assert_array_equal(motion.path.waypoints[[0, -1]], ends)
        assert tests.is_valid_path(motion.path.waypoints)
        assert motion.trajectory is not None
        positions = motion.trajectory.sample(np.linspace(0.0, motion.duration, 200))
        np.testing.assert_allclose(positions[[0, -1]], ends, atol=1e-9)
        assert all(tests.is_valid(q) for q in positions)


def test_every_motion_keeps_the_limits_and_the_bound(built: Built) -> None:
    database, report = built
    limits = small_cell().robot.limits
    for motion in database:
        t = np.arange(0.0, motion.duration, 1e-3)
        assert motion.trajectory is not None
        for derivative, limit in ((1, limits.velocity), (2, limits.acceleration), (3, limits.jerk)):
            assert np.all(np.abs(motion.trajectory.sample(t, derivative)) <= limit * (1 + 1e-9))
        assert motion.duration >= motion.lower_bound
    assert report.lower_bound == pytest.approx(sum(motion.lower_bound for motion in database))
    assert report.duration == pytest.approx(sum(motion.duration for motion in database))


def test_pairs_with_an_end_that_is_not_free_are_told_with_the_reason(built: Built) -> None:
    _, report = built
    told = {(key.start, key.goal): reason for key, reason in report.missing}
    assert told["tote", "tote_10h"].what == "collision"
    assert told["tote", "tote_10h"].where == "tote_10h"


def test_a_motion_depends_on_its_names_and_seed_alone() -> None:
    key = MotionKey("bin_E", "drop_00_down", PayloadClass.EMPTY)
    alone = _made(CoarseMotionPlanner(small_cell("bin_E", "drop_00_down"), LEAST_EFFORT), key)
    maker = CoarseMotionPlanner(small_cell("bin_E", "drop_00_down", "home"), LEAST_EFFORT)
    maker.make(MotionKey("home", "drop_00_down", PayloadClass.EMPTY))
    after_another = _made(maker, key)
    assert alone.path.waypoints.tobytes() == after_another.path.waypoints.tobytes()
    assert alone.trajectory is not None and after_another.trajectory is not None
    assert alone.trajectory.positions.tobytes() == after_another.trajectory.positions.tobytes()
    other = _made(
        CoarseMotionPlanner(small_cell("bin_E", "drop_00_down"), replace(LEAST_EFFORT, seed=1)), key
    )
    assert other.path.waypoints.tobytes() != alone.path.waypoints.tobytes()


def test_a_record_gives_back_its_motion_to_the_bit(built: Built) -> None:
    database, report = built
    assert len(database) and report.missing
    for motion in database:
        content = record_of(motion).to_bytes()
        again = made_of(motion.key, JobResult.of_bytes(content), database.joint_names)
        assert record_of(again).to_bytes() == content
    for key, reason in report.missing:
        assert made_of(key, JobResult.of_bytes(record_of(reason).to_bytes()), ()) == reason


def _made(maker: CoarseMotionPlanner, key: MotionKey) -> CoarseMotion:
    made = maker.make(key)
    assert isinstance(made, CoarseMotion), made
    return made
