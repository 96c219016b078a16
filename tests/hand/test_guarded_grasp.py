"""Guarded approaches: the hand stops before what it meets topples, and rises off a table on which it lies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from pickcli.geometry import Array
from pickcli.hand import guarded_grasp
from pickcli.hand.grasp_trial import GraspEnd, PreGrasp, play_grasp
from pickcli.hand.grasp_world import GraspWorld, Standing, WorldDeviation
from pickcli.hand.guarded_grasp import BACKED, LIES, MET, GuardedGrasp
from pickcli.hand.pre_grasps import APART, random_cluster, single_grasp
from pickcli.hand.staged_execution import SETTLED, GraspStage, StageName
from support.belt_hands import HAND, post

TOO_NEAR = (0.05, 0.013, 0.02, 0.17, -0.17)  # m and rad: the palm would end in the object, high up


@dataclass(frozen=True)
class Approached:
    """How a grasp's approach went: its stage, and what was seen at its end."""

    stage: GraspStage
    lean: float  # rad of the object
    reached: Array  # (6,) m and rad of the wrist
    felt: Array  # (3,) N
    is_lifted: bool


def approached(name: str, *offset: float) -> Approached:
    """Play a grasp of an object that stands alone, the hand off by m and rad."""
    kind = HAND.objects[name]
    grasp = single_grasp(HAND, kind, np.array([*offset]))
    world = GraspWorld(HAND, kind, grasp.stand, grasp.start)
    seen: list[tuple[float, Array, Array]] = []

    def look() -> None:
        if not world.wrist.is_level_soft:  # the approach, still
            seen.append((float(world.pose(f"{name} 1")[2, 2]), world.hand.q[:6].copy(), world.wrist.felt))

    execution = GuardedGrasp(world, kind, look)
    execution.run(grasp.goal, grasp.seconds)
    upright, reached, felt = seen[-1]
    is_lifted = float(world.pose(f"{name} 1")[2, 3]) > HAND.control.lift / 2
    return Approached(execution.stages[0], float(np.arccos(min(1.0, upright))), reached, felt, is_lifted)


@pytest.mark.parametrize("name", ["box_45", "spray_bottle"])
def test_a_hand_that_comes_too_near_stops_backs_off_and_leaves_the_object_standing(name: str) -> None:
    seen = approached(name, *TOO_NEAR)
    assert seen.stage.ended_by == "contact"
    assert seen.lean < np.deg2rad(1.0)
    goal = single_grasp(HAND, HAND.objects[name], np.array(TOO_NEAR)).goal
    assert seen.reached[0] < goal[0] - BACKED
    assert seen.is_lifted


def test_without_the_guard_the_same_approach_topples_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(guarded_grasp, "MET", np.inf)
    seen = approached("spray_bottle", *TOO_NEAR)
    assert seen.stage.ended_by == "arrived"
    assert seen.lean > np.deg2rad(30.0) and not seen.is_lifted


def test_a_hand_that_lies_on_the_table_rises_and_is_not_stopped_by_the_drag() -> None:
    """Pitched with the back of the palm down, so that the wrist presses it on the table."""
    offset = (-0.05, 0.013, -0.02, 0.17, -0.17)
    seen = approached("can", *offset)
    assert seen.stage.ended_by == "arrived"
    assert seen.felt[2] < LIES
    goal = single_grasp(HAND, HAND.objects["can"], np.array(offset)).goal
    assert 1e-3 < seen.reached[2] - goal[2] < guarded_grasp.RAISED_AT_MOST
    assert seen.is_lifted


def test_an_approach_through_free_air_feels_nothing() -> None:
    goal = np.array([0.0, 0.3, 0.06, 0.0, 0.0, 0.0])
    start = goal - [0.12, 0.0, 0.0, 0.0, 0.0, 0.0]
    kind = post(0.2)
    world = GraspWorld(HAND, kind, [Standing(0.0, 0.0)], start)
    felt: list[float] = []

    def look() -> None:
        if not world.wrist.is_level_soft and world.time > SETTLED:
            felt.append(float(np.hypot(*world.wrist.felt[:2])))

    execution = GuardedGrasp(world, kind, look)
    execution.run(goal, 1.0)
    assert execution.stages[0].ended_by == "arrived"
    assert max(felt) < 0.2 * MET


def test_a_steady_push_is_felt_as_the_spring_bears_it() -> None:
    """The palm presses on a post that stands fast."""
    kind = post(60.0)
    world = GraspWorld(HAND, kind, [Standing(0.0, 0.0)], np.array([-0.1, 0.0, 0.06, 0.0, 0.0, 0.0]))
    for _ in range(500):
        world.wrist.wanted[0] += 0.1 / 500
        world.step()
    for _ in range(500):
        world.step()
    assert world.wrist.felt[0] < -10.0
    assert world.wrist.felt[0] == pytest.approx(-world.wrist.stretched[0], rel=0.02)


@pytest.mark.slow
def test_a_hand_that_met_a_neighbour_closes_on_nothing_and_goes_on() -> None:
    kind = HAND.objects["bull"]
    at = random_cluster(kind.width + APART, np.random.default_rng(16))
    x, y = at[at[:, 0].argmin()]
    goal = np.array([x - HAND.control.cluster_reach, y, kind.height / 2, 0.0, 0.0, 0.0])
    stand = [Standing(*each) for each in at.tolist()]
    start = goal - [0.15, 0.0, 0.0, 0.0, 0.0, 0.0]
    trial = play_grasp(HAND, kind, PreGrasp(stand, start, goal, WorldDeviation(), 1.25))
    names = [stage.name for stage in trial.stages]
    assert names[:5] == [
        StageName.APPROACH, StageName.CLOSING, StageName.OPENING, StageName.APPROACH, StageName.CLOSING
    ]  # fmt: skip
    assert trial.stages[0].ended_by == "contact"
    assert trial.end is GraspEnd.LIFTED and len(trial.held) == 1
