"""What is proven apart of two arms is apart by their exact shapes, also if one is late; else it is told."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept
from pickcli.planning.planning_context import PlanningContext
from pickcli.random_scenes.make_stream import StreamRequest, make_stream
from pickcli.scene.item_stream import ItemStream
from pickcli.stream_trials import pick_queries, stream_trial
from pickcli.stream_trials.reserved_motion import ReservedMotion
from pickcli.stream_trials.stream_arms import LATE
from pickcli.stream_trials.stream_trial import play_stream
from pickcli.stream_trials.stream_trial_request import StreamTrialRequest
from pickcli.verification.fcl_solids import Solid
from pickcli.verification.forward_kinematics import link_poses
from support.pr2_picks import arm_pick, context, home

KEEP = 0.009  # m


class Shapes:
    """The shapes of the links that an arm's joints move, placed by the verifier's kinematics."""

    def __init__(self, by: PlanningContext) -> None:
        robot, moving = by.cell.robot, by.model.bodies
        self._robot = robot
        self._solids = [
            (k, body.T_parent_shape, Solid(body.shape), body.shape.bounding_radius)
            for k, link in enumerate(robot.links)
            if k > 0 and moving[k - 1] > 0
            for body in link.bodies
        ]

    def placed(self, q: Array) -> list[tuple[Solid, Array, float]]:
        poses, found = link_poses(self._robot, q[None]), []
        for k, T_link_shape, solid, radius in self._solids:
            T = poses[k][0] @ T_link_shape
            solid.place(T)
            found.append((solid, T[:3, 3], radius))
        return found


@cache
def shapes(arm: str) -> Shapes:
    return Shapes(context(arm))


def distance(q_left: Array, q_right: Array) -> float:
    """The least distance (m) of the two arms, where it is below 0.1."""
    left, right = shapes("left").placed(q_left), shapes("right").placed(q_right)
    least = 0.1
    for a, at, ra in left:
        for b, then, rb in right:
            if float(np.linalg.norm(at - then)) - ra - rb < least:
                least = min(least, a.distance(b))
    return least


@cache
def motion(arm: str, t: float) -> ReservedMotion:
    pick = arm_pick(arm)
    return ReservedMotion.planned(context(arm).model, pick.plan, pick.scene, t)


def test_what_is_proven_apart_is_apart_at_every_moment_and_if_one_is_late() -> None:
    left, rng = motion("left", 0.0), np.random.default_rng(7)
    outcomes = set[bool]()
    for begins in np.arange(-5.0, 5.1, 0.5).tolist():
        right, t = motion("right", begins), max(begins, 0.0)
        is_proven = right.why_not_apart(left, t, KEEP, LATE) is None
        outcomes.add(is_proven)
        times = np.arange(t, max(left.t_end, right.t_end), 0.05) + rng.uniform(0.0, 0.05)
        late = rng.uniform(-LATE, LATE, len(times))
        each = zip(left.at(times + late), right.at(times), strict=True)
        if is_proven:
            assert min(distance(a, b) for a, b in each) >= KEEP - 1e-6, begins
    assert outcomes == {True, False}


def test_arms_that_meet_are_told_with_what_meets_and_when() -> None:
    left, right = motion("left", 0.0), motion("right", 0.0)
    why = right.why_not_apart(left, 0.0, KEEP, LATE)
    assert why is not None
    assert "in the way of the other arm" in str(why) and "not proven apart at" in str(why)
    assert str(why).count("r_") >= 1 and str(why).count("l_") >= 1


def test_being_late_is_no_better_than_being_in_time() -> None:
    left = motion("left", 0.0)
    for begins in (1.0, 3.0, 4.0):
        right = motion("right", begins)
        if right.why_not_apart(left, begins, KEEP, LATE) is None:
            assert right.why_not_apart(left, begins, KEEP, 0.0) is None
            assert right.why_not_apart(left, begins, 0.0, 0.0) is None


def test_a_measured_motion_is_that_of_its_plan_if_it_was_followed() -> None:
    plan, model = arm_pick("right").plan, context("right").model
    times = np.arange(0.0, plan.trajectory.duration, 1e-3)
    planned = motion("right", 2.0)
    followed = ReservedMotion.measured(model, 2.0 + times, plan.trajectory.sample(times), planned.taken)
    when = np.linspace(1.0, 2.0 + plan.trajectory.duration + 1.0, 300)
    assert followed.at(when) == pytest.approx(planned.at(when), abs=1e-4)
    assert followed.t_end == pytest.approx(planned.t_end, abs=2e-3)


def test_arms_at_rest_are_apart_and_one_on_the_other_is_not() -> None:
    def rests(arm: str, q: Array, model: CollisionModel | None = None) -> ReservedMotion:
        return ReservedMotion.resting(model or context(arm).model, q)

    left, right = rests("left", home("left").q), rests("right", home("right").q)
    assert right.why_not_apart(left, 3.0, KEEP, LATE) is None
    assert left.why_not_apart(left, 3.0, KEEP, LATE) is not None


@pytest.mark.slow
def test_in_a_dense_stream_both_arms_are_on_their_way_and_apart_by_their_shapes() -> None:
    request = StreamRequest(5, 0.33, (0.5, 0.8))
    items = make_stream(context().cell, request, 11)
    played = play_stream(StreamTrialRequest(items, seed=3), [context("left"), context("right")])
    assert played.result.is_clean and played.result.n_attempted >= 3
    runs = played.recorder.runs
    assert {run.arm for run in runs} == {"left", "right"}
    assert [run.t_start for run in runs] == sorted(run.t_start for run in runs)
    together = [
        (max(a.t_start, b.t_start), min(a.t_end, b.t_end))
        for a in runs
        for b in runs
        if a.arm == "left" and b.arm == "right"
    ]
    assert any(end - start > 1.0 for start, end in together)
    assert (np.diff(played.recorder.times) > 0.0).all()
    columns = {name: k for k, name in enumerate(played.recorder.joint_names)}
    mine, others = (
        [columns[name] for name in context(arm).cell.robot.joint_names] for arm in ("left", "right")
    )
    times, joints = np.array(played.recorder.times), np.array(played.recorder.joints)
    moving = [(start <= times) & (times <= end) for start, end in together]
    for row in joints[np.any(moving, axis=0)][::5]:
        assert distance(row[mine], row[others]) > context().cell.clearance
    for arm, index in (("left", mine), ("right", others)):  # as each moved in its own world
        run = next(run for run in runs if run.arm == arm)
        assert run.plan is not None
        during = (times > run.t_start + 0.5) & (times < run.t_end - 0.5)
        planned = run.plan.trajectory.sample(run.plan_time(times[during]))
        assert np.abs(joints[during][:, index] - planned).max() < 0.005


@pytest.mark.slow
def test_the_other_arm_keeps_clear_of_an_item_until_it_is_off_the_belt(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It is seen where it rides, and not asked for; from then on it is not there any more."""
    seen: list[tuple[float, str, set[str]]] = []

    def noted(by: PlanningContext, items: ItemStream, query: InterceptQuery, *rest: Any) -> Plan:
        seen.append((query.now, query.item, {riding.id for riding in items.items}))
        return plan_intercept(by, items, query, *rest)

    monkeypatch.setattr(pick_queries, "plan_intercept", noted)
    items = make_stream(context().cell, StreamRequest(3, 0.33, (0.5, 0.8)), 11)
    trial = stream_trial._StreamTrial(StreamTrialRequest(items, seed=3), [context("left"), context("right")])
    while not trial.plans:
        trial.decide()
    (rode, until), t_first = trial.at_work[0], len(seen)
    while trial.open:
        trial.decide()
    later = seen[t_first:]
    assert later and all(item != rode.id for _, item, _ in later)
    assert all((rode.id in ids) == (now < until) for now, _, ids in later)
    assert any(now < until for now, _, _ in later)
