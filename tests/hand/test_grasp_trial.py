"""Grasps as a whole: each stage comes to its end, and each way to fail can happen and is told."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from pickcli.hand import guarded_grasp
from pickcli.hand.belt_hand import BeltHand
from pickcli.hand.grasp_figures import grasp_as_json, grasp_figures
from pickcli.hand.grasp_trial import GraspEnd, GraspTrial, PreGrasp, play_grasp
from pickcli.hand.grasp_world import GraspWorld, Standing, WorldDeviation
from pickcli.hand.guarded_grasp import GuardedGrasp
from pickcli.hand.pre_grasps import APART, single_grasp
from pickcli.hand.staged_execution import StageName
from support.belt_hands import HAND, post


def played(hand: BeltHand, name: str, *offset: float) -> GraspTrial:
    """A grasp of an object that stands alone, the hand off by m and rad."""
    return play_grasp(hand, hand.objects[name], single_grasp(hand, hand.objects[name], np.array([*offset])))


@cache
def can() -> GraspTrial:
    """A grasp of a can, a little off."""
    return played(HAND, "can", 0.01, 0.015, 0.0, 0.1, 0.0)


def test_a_can_is_pulled_in_enveloped_and_lifted_stage_by_stage() -> None:
    trial = can()
    assert trial.end is GraspEnd.LIFTED and trial.is_enveloping and trial.held == ("can 1",)
    names = [stage.name for stage in trial.stages]
    assert names == [
        StageName.APPROACH, StageName.CLOSING, StageName.PULL_IN, StageName.FIRM, StageName.LIFT
    ]  # fmt: skip
    approach, closing, pull_in, firm, _ = trial.stages
    kind = HAND.objects["can"]
    assert (approach.ended_by, closing.ended_by, pull_in.ended_by) == ("arrived", "contact", "belts blocked")
    assert closing.current == pytest.approx(kind.low_current, rel=0.05)
    assert pull_in.current == pytest.approx(kind.low_current, rel=0.05)
    assert {name.split("_")[0] for name in pull_in.blocked} == {"left", "right"}
    assert firm.current == pytest.approx(kind.high_current, rel=0.05)
    assert all(a.end == pytest.approx(b.start) for a, b in zip(trial.stages, trial.stages[1:], strict=False))
    assert trial.execution_time == pytest.approx(firm.end - closing.start)
    # No pad bears more than all torque of the motor on the shortest lever that the belts allow.
    assert trial.most_force < kind.high_current * HAND.drive.torque_constant / 0.01


def test_the_same_grasp_comes_out_the_same() -> None:
    again = played(HAND, "can", 0.01, 0.015, 0.0, 0.1, 0.0)
    assert grasp_as_json(again) == grasp_as_json(can())


def test_figures_count_each_grasp_once() -> None:
    figures = grasp_figures([can(), can()])
    assert figures["grasps"] == figures["lifted"] == figures["enveloping"] == 2
    assert figures["ends"] == {"lifted": 2} and figures["separated"] == 0
    assert figures["execution_time"] == pytest.approx(can().execution_time)


def test_a_box_jams_on_hinges_that_stand_between_the_belts() -> None:
    """Pads farther apart than the box is wide lean inwards: it lies on the hinges, which hold it back."""
    jamming = replace(
        HAND, fingers=replace(HAND.fingers, base=0.054, hinge_relief=0.001),
        palm=replace(HAND.palm, friction=0.5), belts=replace(HAND.belts, friction=0.7),
        drive=replace(HAND.drive, hinge_ratio=0.3),
    )  # fmt: skip
    smooth, rough = (_pulled_in(hand, current) for hand, current in ((HAND, 2.0), (jamming, 1.6)))
    assert smooth["way"] > 0.015
    assert rough["way"] < 0.005 and rough["hinges"]


def _pulled_in(hand: BeltHand, current: float) -> dict[str, float]:
    """How far a box comes in from its closing on, and on how many hinges it lies at the end."""
    kind = replace(hand.objects["box_45"], low_current=current)
    grasp = single_grasp(
        hand, kind, np.array([hand.control.reach - 0.065, 0.01, 0.0, *np.deg2rad((10.0, 10.0))])
    )
    seen: dict[float, tuple[float, int]] = {}
    world = GraspWorld(hand, kind, grasp.stand, grasp.start)

    def look() -> None:
        hinges = sum(name.endswith("hinge") for name in world.contacts("box_45 1"))
        seen[world.time] = float(world.middle_in_hand("box_45 1")[0]), hinges

    execution = GuardedGrasp(world, kind, look)
    execution.run(grasp.goal, grasp.seconds)
    stage = next(each for each in execution.stages if each.name is StageName.PULL_IN)
    times = np.array(list(seen))
    before, after = (seen[times[np.abs(times - t).argmin()]] for t in (stage.start, stage.end))
    return {"way": before[0] - after[0], "hinges": after[1]}


@pytest.mark.parametrize("off", [-0.005, 0.005])
def test_two_cans_are_told_by_the_opening_and_separated_by_the_belts(off: float) -> None:
    """The same grasp of two cans side by side fails without the separation, and lifts one of them with it."""
    kind = HAND.objects["coke"]
    goal = np.array([-HAND.control.cluster_reach, 0.0, kind.height / 2, 0.0, 0.0, 0.0])
    start, apart = goal - [0.12, 0.0, 0.0, 0.0, 0.0, 0.0], kind.width + APART
    stand = [Standing(0.0, off - apart / 2), Standing(0.0, off + apart / 2)]
    grasp = PreGrasp(stand, start, goal, WorldDeviation(), 1.0)
    at_once = replace(HAND, control=replace(HAND.control, two_objects=-1.2))
    failed, trial = (play_grasp(each, kind, grasp) for each in (at_once, HAND))
    assert failed.end is not GraspEnd.LIFTED
    assert grasp_figures([failed])["separated"] == 0
    closing = next(stage for stage in trial.stages if stage.name is StageName.CLOSING)
    assert closing.angle < HAND.control.two_objects
    separation = next(stage for stage in trial.stages if stage.name is StageName.SEPARATION)
    assert separation.ended_by == "one object left"
    assert separation.end - separation.start < HAND.control.separation
    assert separation.angle > HAND.control.two_objects
    assert trial.end is GraspEnd.LIFTED and len(trial.held) == 1
    assert grasp_figures([trial])["separated"] == 1


def test_a_weight_beyond_friction_is_dropped() -> None:
    kind = replace(post(4.0), high_current=2.0)
    goal = np.array([-0.105, 0.0, 0.06, 0.0, 0.0, 0.0])
    hand = replace(HAND, belts=replace(HAND.belts, friction=0.3))
    trial = play_grasp(hand, kind, PreGrasp((Standing(0.0, 0.0),), goal, goal, WorldDeviation(), 0.1))
    assert trial.end in (GraspEnd.DROPPED, GraspEnd.HINGE) and trial.held == ()


def test_fingers_that_close_on_nothing_say_so() -> None:
    goal = np.array([0.0, 0.3, 0.06, 0.0, 0.0, 0.0])
    trial = play_grasp(HAND, post(0.2), PreGrasp((Standing(0.0, 0.0),), goal, goal, WorldDeviation(), 0.1))
    assert trial.end is GraspEnd.NOTHING and not trial.is_enveloping


def test_what_an_unguarded_approach_runs_into_stops_the_arm(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(guarded_grasp, "MET", np.inf)
    goal = np.array([0.05, 0.0, 0.06, 0.0, 0.0, 0.0])
    start = goal - [0.15, 0.0, 0.0, 0.0, 0.0, 0.0]
    trial = play_grasp(HAND, post(80.0), PreGrasp((Standing(0.0, 0.0),), start, goal, WorldDeviation(), 1.0))
    assert trial.end is GraspEnd.STOPPED
    assert [stage.ended_by for stage in trial.stages] == ["torque threshold"]
    assert trial.execution_time == 0.0
