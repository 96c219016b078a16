"""Cameras are brought to where they look from by verified motions, which take time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell, NamedConfiguration
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.perception.viewpoints import CAMERA_KIND, Viewpoint
from pickcli.planning.start_state import Start
from pickcli.scene.scene import Scene, empty_scene
from pickcli.trial.attempt_runner import AttemptRunner
from pickcli.trial.camera_motion import bring_cameras
from pickcli.trial.trial_interfaces import ExecutionResult
from pickcli.trial.trial_perception import ReachedViews
from pickcli.trial.trial_result import Attempt
from pickcli.trial.trial_settings import TrialSettings
from support.scripted_trial import DURATION, ScriptedTrial
from support.tool_states import STRAIGHT

SETTINGS = TrialSettings()
LOOK_TIME = SETTINGS.reality.look_time


@pytest.fixture
def fake(cell: Cell) -> ScriptedTrial:
    return ScriptedTrial(empty_scene(cell))


def viewpoint(cell: Cell, name: str, at: float, is_carried: bool = True) -> Viewpoint:
    """A viewpoint with all joints at a position."""
    camera = cell.cameras["hand"] if is_carried else replace(cell.cameras["hand"], name="boom", link=None)
    return Viewpoint(camera, NamedConfiguration(name, np.full(8, at), STRAIGHT, CAMERA_KIND), np.eye(4))


def say(attempt: Attempt, doing: str) -> None:
    """Nobody listens."""


def runner_of(fake: ScriptedTrial, limit: float = 900.0) -> AttemptRunner:
    return AttemptRunner(fake.interfaces(), SETTINGS, limit, say)


def names(reached: ReachedViews) -> list[str]:
    return [each.at.name for each in reached.viewpoints]


def test_the_nearest_viewpoint_comes_next_and_one_call_is_charged(fake: ScriptedTrial, cell: Cell) -> None:
    views = [viewpoint(cell, "far", 0.9), viewpoint(cell, "near", 0.2), viewpoint(cell, "middle", 0.5)]
    runner = runner_of(fake)
    before = runner.clock
    reached = bring_cameras(runner, views)
    assert names(reached) == ["near", "middle", "far"]
    assert [plan.query for plan in fake.executed] == ["look from near", "look from middle", "look from far"]
    assert len(reached.motions) == 3
    assert runner.clock.n_plans == before.n_plans + 1
    assert runner.clock.simulated == pytest.approx(before.simulated + 3 * (DURATION + LOOK_TIME))


def test_what_no_certified_motion_leads_to_is_left_out(fake: ScriptedTrial, cell: Cell) -> None:
    fake.no_plan, fake.rejects = frozenset({"look from a"}), frozenset({"look from b"})
    views = [viewpoint(cell, name, at) for name, at in (("a", 0.1), ("b", 0.2), ("c", 0.3))]
    assert names(bring_cameras(runner_of(fake), views)) == ["c"]
    assert [plan.query for plan in fake.executed] == ["look from c"]


def test_after_a_stop_there_are_no_more_pictures(fake: ScriptedTrial, cell: Cell) -> None:
    fake.executions["look from b"] = [ExecutionResult(1.0, stopped="collision")]
    views = [viewpoint(cell, name, at) for name, at in (("a", 0.1), ("b", 0.2), ("c", 0.3))]
    reached = bring_cameras(runner_of(fake), views)
    assert names(reached) == ["a"]
    assert [motion.stopped for motion in reached.motions] == ["", "collision"]


def test_cameras_are_not_brought_anywhere_once_the_time_is_over(fake: ScriptedTrial, cell: Cell) -> None:
    runner = runner_of(fake, limit=LOOK_TIME + 1.5 + 1.5 * DURATION + LOOK_TIME)
    views = [viewpoint(cell, "a", 0.1), viewpoint(cell, "b", 0.2)]
    assert names(bring_cameras(runner, views)) == ["a"]
    assert runner.clock.now <= runner.clock.limit


def test_a_camera_that_stands_still_needs_no_motion(fake: ScriptedTrial, cell: Cell) -> None:
    runner = runner_of(fake)
    before = runner.clock
    reached = bring_cameras(runner, [viewpoint(cell, "boom", 0.5, is_carried=False)])
    assert names(reached) == ["boom"] and not fake.executed
    assert runner.clock.now == pytest.approx(before.now + LOOK_TIME)


class Views:
    """A perception that wants to look from one viewpoint."""

    def __init__(self, scene: Scene, wanted: Viewpoint) -> None:
        self.scene, self.wanted = scene, wanted
        self.reached: list[list[str]] = []

    def look(self, true: Scene, number: int, touched: object) -> Scene:
        return self.scene

    def viewpoints(self) -> tuple[Viewpoint, ...]:
        return (self.wanted,)

    def look_from(self, true: Scene, number: int, reached: ReachedViews) -> Scene:
        self.reached.append(names(reached))
        return self.scene


@pytest.mark.parametrize("is_stopped", [False, True])
@pytest.mark.parametrize("is_holding", [False, True])
def test_the_arm_does_not_go_to_look_where_it_was_stopped_or_with_something_held(
    fake: ScriptedTrial, cell: Cell, is_stopped: bool, is_holding: bool
) -> None:
    runner = runner_of(fake)
    runner.perception = views = Views(fake.scene, viewpoint(cell, "a", 0.1))  # type: ignore[assignment]
    stop = ExecutionResult(1.0, stopped="operator" if is_stopped else "")
    start = Start(fake.q, fake.tool_state)
    planned = runner.interfaces.recover(fake.scene, start, 1, RecoveryLevel.AS_PLANNED, None)
    motion = runner.certified(planned, fake.scene)
    assert isinstance(motion, Plan)
    fake.executions[planned.query] = [stop]
    runner.execute(motion)
    fake.clogged = is_holding
    runner.scene()
    assert views.reached == ([] if is_stopped or is_holding else [["a"]])
    assert runner.is_current
