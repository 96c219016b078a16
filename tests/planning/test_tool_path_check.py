"""Lines and contact speed are measured on the final curve; what breaks a promise is mended or refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cartesian.line import shifted
from pickcli.cartesian.line_following import follow_line
from pickcli.cell.cell import Cell
from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.errors import Failures
from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.grasping.grasp_method import ContactLimit
from pickcli.kernel import line_deviation
from pickcli.motion.segment import SegmentKind, SegmentLimits
from pickcli.planning.assembly import proven_timing
from pickcli.planning.assembly.proven_timing import proven_run
from pickcli.planning.assembly.tool_path_check import OFF_ANGLE, OFF_LINE, broken_promise, mended
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import PoseNoise, Scene
from support.tool_states import STRAIGHT


@pytest.fixture(scope="module")
def scene(cell: Cell) -> Scene:
    return Scene(cell, cell.T_world_pod, (), PoseNoise())


def corner(
    context: PlanningContext, scene: Scene, blend: float, kind: SegmentKind, speed: float
) -> list[MotionSegment]:
    """Out of a bin and up before it: two lines with a corner between them."""
    mode = Mode(STRAIGHT)
    checker, limits = context.checker_for(scene, mode), SegmentLimits(1.0, speed, blend)
    q: Array = scene.cell.configurations["bin_E"].q
    segments = []
    for name, along in ((kind, [-0.05, 0.0, 0.0]), (SegmentKind.RETREAT, [0.0, 0.0, 0.08])):
        T = context.arm.tip(q, STRAIGHT)
        line = follow_line(context.arm, checker, T, shifted(T, np.array(along)), STRAIGHT, q, "here")
        assert not isinstance(line, Failures)
        segments.append(MotionSegment(name, line, limits, mode=mode))
        q = line[-1]
    return segments


def test_lines_that_are_rounded_too_much_are_mended(
    context: PlanningContext, scene: Scene, monkeypatch: pytest.MonkeyPatch
) -> None:
    segments = corner(context, scene, 0.05, SegmentKind.APPROACH, 0.3)
    run = proven_run(context, scene, segments)
    assert not isinstance(run, Failures)
    assert broken_promise(context.arm, context.method.contact_limit, run, segments) is None
    monkeypatch.setattr(proven_timing, "MENDS", 0)
    unmended = proven_run(context, scene, segments)
    assert isinstance(unmended, Failures) and [r.what for r in unmended] == ["not straight"]


def test_narrower_blends_are_asked_for_on_the_line_and_beside_it(
    context: PlanningContext, scene: Scene
) -> None:
    segments = corner(context, scene, 0.05, SegmentKind.APPROACH, 0.3)
    run = proven_timing._timed_once(context, segments, None, None)
    assert not isinstance(run, Failures)
    better = mended(context.arm, ContactLimit(SegmentKind.CONTACT, 1.0), run, segments)
    assert better is not None
    assert len(better) == len(segments) == 2
    for new, old in zip(better, segments, strict=True):
        assert new.limits.blend_tolerance < old.limits.blend_tolerance
        assert new.waypoints is old.waypoints


def test_a_contact_that_is_too_fast_is_slowed_down(
    context: PlanningContext, cell: Cell, scene: Scene
) -> None:
    segments = corner(context, scene, 1e-4, SegmentKind.CONTACT, 0.2)
    fastest = cell.robot.tool.cup.contact_speed
    run = proven_run(context, scene, segments)
    assert not isinstance(run, Failures)
    assert broken_promise(context.arm, context.method.contact_limit, run, segments) is None
    times = np.arange(0.0, run.part_times[1], 1e-3)
    p = context.arm.tips(run.trajectory.sample(times), STRAIGHT)[:, :3, 3]
    speeds = np.linalg.norm(np.diff(p, axis=0), axis=1) / 1e-3
    assert 0.5 * fastest < speeds.max() <= fastest


def test_coarse_motions_promise_no_line(context: PlanningContext, scene: Scene) -> None:
    segments = [
        replace(p, kind=SegmentKind.TRANSIT) for p in corner(context, scene, 0.05, SegmentKind.LIFT, 0.3)
    ]
    run = proven_timing._timed_once(context, segments, None, None)
    assert not isinstance(run, Failures)
    assert mended(context.arm, ContactLimit(SegmentKind.CONTACT, 1e-3), run, segments) is None


@pytest.mark.parametrize("bow", [0.0, 0.001, 0.003])
@pytest.mark.parametrize("twist", [0.0, 0.02])
def test_the_line_deviation_measures_what_a_bow_and_a_twist_are(bow: float, twist: float) -> None:
    s = np.linspace(0.0, 1.0, 101)
    R = pose(rpy=[0.1, 0.2, 0.3])[:3, :3]
    hump = 4 * s * (1 - s)
    turns = [R @ rotation_axis_angle([0, 0, 1], 0.3 * a + twist * h) for a, h in zip(s, hump, strict=True)]
    tips = np.stack([pose([0.2 * a, bow * h, 0.0], R=T) for a, h, T in zip(s, hump, turns, strict=True)])
    distance, angle = line_deviation(tips)
    assert distance == pytest.approx(bow, abs=1e-9)
    assert angle == pytest.approx(twist, abs=1e-6)
    assert (distance > OFF_LINE) == (bow > OFF_LINE) and (angle > OFF_ANGLE) == (twist > OFF_ANGLE)
