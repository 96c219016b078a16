"""A pick with two fingers out of the tote: planned, certified by code of its own, its forgeries refused."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from pickcli.cartesian.line import shifted
from pickcli.cartesian.line_following import follow_line
from pickcli.cell.cell import Cell
from pickcli.cell.tool import MOVING, ToolState
from pickcli.collision.motion_segment import Mode, MotionSegment
from pickcli.errors import Failures, NoPlanError
from pickcli.geometry import pose
from pickcli.motion.plan import Grasp, Plan
from pickcli.motion.segment import Segment, SegmentKind, SegmentLimits
from pickcli.planning.assembly.proven_timing import proven_run
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.scene.scene_file import scene_hash
from pickcli.verification.verify import verify
from support.gripper_cell import CLOSED, LEAD, OPEN

ERASER = "expo_dry_erase_board_eraser"  # 130 x 54 x 35 mm, 20 g
WIDTH = ToolState.of_width(0.054)


@dataclass(frozen=True, eq=False)
class Planned:
    """A scene and the plan for it."""

    scene: Scene
    plan: Plan

    def forged(self, **parts: object) -> tuple[str, ...]:
        """What the verifier says to the plan with some parts replaced."""
        reasons = verify(replace(self.plan, **parts), self.scene).reasons  # type: ignore[arg-type]
        return tuple(reason.what for reason in reasons)


def scene_of(cell: Cell, *items: tuple[str, float, float]) -> Scene:
    """Items lying in the tote: name, x and turn about z; an item named twice is there once."""
    place = cell.places["tote"]
    placed = []
    for name, x, yaw in items:
        item = cell.item(name)
        T = cell.T_world_place(place) @ pose((x, 0.0, item.shape.extents[2] / 2 + 5e-4), rpy=(0.0, 0.0, yaw))
        placed.append(PlacedItem(name, item, "tote", T))
    return Scene(cell, cell.T_world_pod, tuple(placed), PoseNoise())


def planned(cell: Cell, scene: Scene, state: ToolState = OPEN) -> Planned:
    start = Start(cell.configurations["home"].q, state)
    return Planned(scene, plan_pick(PlanningContext(cell), scene, PickQuery("tote", ERASER), start, seed=1))


@pytest.fixture(scope="module")
def pick(gripper_cell: Cell) -> Planned:
    return planned(gripper_cell, scene_of(gripper_cell, (ERASER, 0.1, 0.3)))


def test_the_fingers_come_open_close_at_rest_and_open_at_rest(pick: Planned) -> None:
    k = SegmentKind
    stated = [(s.kind, s.tool_state, s.held is not None) for s in pick.plan.segments]
    assert stated == [
        (k.TRANSIT, OPEN, False), (k.PREAPPROACH, OPEN, False), (k.APPROACH, OPEN, False),
        (k.CONTACT, MOVING, False),
        (k.LIFT, WIDTH, True), (k.LIFT, WIDTH, True), (k.RETREAT, WIDTH, True), (k.TRANSFER, WIDTH, True),
        (k.PLACE, WIDTH, True),
        (k.DEPART, MOVING, False), (k.DEPART, OPEN, False),
    ]  # fmt: skip
    for segment in pick.plan.segments:
        if segment.tool_state == MOVING:
            times = np.linspace(segment.t_start, segment.t_end, 50)
            assert np.ptp(pick.plan.trajectory.sample(times), axis=0).max() < 1e-6
            assert segment.t_end - segment.t_start == pytest.approx(LEAD)


def test_the_fingers_are_commanded_when_the_arm_rests(pick: Planned) -> None:
    moving = [s for s in pick.plan.segments if s.tool_state == MOVING]
    events = [(e.device, e.action, e.t_trigger, e.t_anchor) for e in pick.plan.events]
    assert [e[:2] for e in events] == [("fingers", "closed"), ("fingers", "open")]
    for (_, _, trigger, complete), segment in zip(events, moving, strict=True):
        assert trigger == pytest.approx(segment.t_start) and complete == pytest.approx(segment.t_end)


def test_the_verifier_certifies_it(pick: Planned) -> None:
    verdict = verify(pick.plan, pick.scene)
    assert verdict.reasons == () and verdict.certificate is not None
    assert verdict.certificate.min_clearance >= pick.scene.cell.clearance - 1e-6


def test_fingers_that_start_closed_open_on_the_way(gripper_cell: Cell) -> None:
    made = planned(gripper_cell, scene_of(gripper_cell, (ERASER, 0.1, 0.3)), CLOSED)
    assert made.plan.segments[0].tool_state == MOVING
    assert [e.action for e in made.plan.events] == ["open", "closed", "open"]
    assert verify(made.plan, made.scene).reasons == ()


def segments(plan: Plan, change: Callable[[Segment], Segment]) -> tuple[Segment, ...]:
    return tuple(change(segment) for segment in plan.segments)


def grasp(pick: Planned, **parts: object) -> Grasp:
    assert pick.plan.grasp is not None
    return replace(pick.plan.grasp, **parts)  # type: ignore[arg-type]


def test_another_width_is_refused(pick: Planned) -> None:
    wide = segments(pick.plan, lambda s: replace(s, tool_state=ToolState.of_width(0.06)) if s.held else s)
    assert "wrong width" in pick.forged(segments=wide)


def test_fingers_that_come_closed_are_refused(pick: Planned) -> None:
    closed = segments(pick.plan, lambda s: replace(s, tool_state=CLOSED) if s.tool_state == OPEN else s)
    found = pick.forged(segments=closed)
    assert "fingers not open" in found and "collision" in found


def test_a_hold_beside_the_item_or_askew_is_refused(pick: Planned) -> None:
    T = grasp(pick).T_item_tip
    assert "misses the item" in pick.forged(grasp=grasp(pick, T_item_tip=T @ pose((0.01, 0.0, 0.0))))
    askew, beside = T @ pose(rpy=(0.0, 0.0, 0.6)), T @ pose((0.5, 0.0, 0.0))
    for T_off in (askew, beside):
        assert pick.forged(grasp=grasp(pick, T_item_tip=T_off)) == ("nothing between the pads",)


def test_commands_that_are_missing_or_early_are_refused(pick: Planned) -> None:
    close, release = pick.plan.events
    assert "event missing" in pick.forged(events=(close,))
    assert "event missing" in pick.forged(events=(release,))
    assert close.t_trigger is not None and close.t_anchor is not None
    anchor = replace(close.anchor, offset=close.anchor.offset - 0.3)
    early = replace(close, anchor=anchor, t_trigger=close.t_trigger - 0.3, t_anchor=close.t_anchor - 0.3)
    assert {"event missing", "wrong tool state"} <= set(pick.forged(events=(early, release)))


def test_a_load_that_is_not_the_load_is_refused(pick: Planned) -> None:
    assert "load not as stated" in pick.forged(grasp=grasp(pick, shear=0.01))


def test_what_pads_cannot_bear_is_neither_planned_nor_certified(gripper_cell: Cell, pick: Planned) -> None:
    """The eraser at 7 kg: 68.7 N of weight, of which two pads of 40 N with friction 0.5 bear 40."""
    heavy = replace(gripper_cell.item(ERASER), mass=7.0)
    scene = replace(pick.scene, items=tuple(replace(p, item=heavy) for p in pick.scene.items))
    with pytest.raises(NoPlanError, match="does not hold"):
        planned(gripper_cell, scene)
    forged = replace(pick.plan, scene_hash=scene_hash(scene))
    assert "does not hold" in [reason.what for reason in verify(forged, scene).reasons]


def blocked(cell: Cell, *items: tuple[str, float, float]) -> Iterable[str]:
    with pytest.raises(NoPlanError) as caught:
        planned(cell, scene_of(cell, *items))
    yield str(caught.value)


def test_a_gripper_that_opens_too_little_says_so(gripper_cell: Cell) -> None:
    tool = gripper_cell.robot.tool
    narrow = replace(tool, positions={state: width / 4 for state, width in tool.positions.items()})
    robot = replace(gripper_cell.robot, tool=narrow)
    cell = replace(gripper_cell, robot=robot)
    (said,) = blocked(cell, (ERASER, 0.1, 0.3))
    assert "too wide for the gripper" in said and "the fingers open 20 mm" in said


def test_an_approach_with_open_fingers_that_is_too_fast_is_slowed_down(gripper_cell: Cell) -> None:
    context, scene, mode = PlanningContext(gripper_cell), scene_of(gripper_cell), Mode(OPEN)
    q = gripper_cell.configurations["bin_E"].q
    T = context.arm.tip(q, OPEN)
    checker = context.checker_for(scene, mode)
    line = follow_line(context.arm, checker, T, shifted(T, np.array([-0.05, 0.0, 0.0])), OPEN, q, "here")
    assert not isinstance(line, Failures)
    approach = MotionSegment(SegmentKind.APPROACH, line, SegmentLimits(1.0, 0.2, 1e-4), mode=mode)
    run = proven_run(context, scene, [approach])
    assert not isinstance(run, Failures)
    p = context.arm.tips(run.trajectory.sample(np.arange(0.0, run.part_times[-1], 1e-3)), OPEN)[:, :3, 3]
    fastest = gripper_cell.robot.tool.contact_speed
    assert 0.5 * fastest < np.linalg.norm(np.diff(p, axis=0), axis=1).max() / 1e-3 <= fastest
