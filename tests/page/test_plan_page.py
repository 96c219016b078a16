"""The page of a plan: it replays what the plan says, and draws what the verifier has against it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.errors import Reason, StaleError
from pickcli.files.packed_array import unpacked
from pickcli.geometry import Array, from_quaternion, inverse, pose, rotation_axis_angle
from pickcli.kinematics.arm import Arm
from pickcli.motion.segment import SegmentKind
from pickcli.page.failure_marks import failure_marks, named_parts
from pickcli.page.html_page import page_bytes
from pickcli.page.motion_parts import POSITION_RESOLUTION, TIME_RESOLUTION
from pickcli.page.page_document import PageDocument, document_values
from pickcli.page.plan_page import plan_page
from pickcli.scene.item_stream import after_travel
from pickcli.verification.verify import verify
from support.belt_picks import belt_pick
from support.handmade_plans import CRAYOLA, pick, pick_pushing


@pytest.fixture(scope="module")
def shown() -> PageDocument:
    return plan_page(*pick())


def transform(told: list[float]) -> Array:
    return pose(told[:3], R=from_quaternion(told[3:]))


def test_positions_are_those_of_the_plan_also_between_samples(shown: PageDocument) -> None:
    plan, scene = pick()
    assert shown.motion is not None and shown.robot is not None
    times, positions = unpacked(shown.motion.times), unpacked(shown.motion.positions)
    assert shown.robot.moved == (*plan.trajectory.joint_names, *scene.cell.robot.tool.joints)
    assert shown.motion.duration == pytest.approx(plan.trajectory.duration, abs=TIME_RESOLUTION)
    t = np.linspace(0.0, plan.trajectory.duration, 5000)
    played = np.column_stack([np.interp(t, times, column) for column in positions.T])
    off = np.abs(played[:, : plan.trajectory.positions.shape[1]] - plan.trajectory.sample(t))
    assert off.max() < 5e-4 + POSITION_RESOLUTION


def test_the_item_is_carried_from_where_it_lay(shown: PageDocument) -> None:
    plan, scene = pick()
    assert shown.motion is not None
    (carried,) = shown.motion.carried
    contact = next(s for s in plan.segments if s.kind is SegmentKind.CONTACT)
    held = [s for s in plan.segments if s.held is not None]
    assert (carried.item, carried.t_start, carried.t_end) == (CRAYOLA, held[0].t_start, held[-1].t_end)
    tip = Arm(scene.cell.robot).tip(plan.trajectory.sample(contact.t_end)[0], contact.tool_state)
    T = tip @ transform(list(carried.pose))
    np.testing.assert_allclose(T, scene.find(CRAYOLA).T_world_item, atol=1e-5)


def test_items_on_a_belt_ride_on_and_the_one_that_is_met_goes_with_the_cup() -> None:
    met = belt_pick()
    plan, scene, motion = met.plan, met.scene, plan_page(met.plan, met.scene).motion
    assert motion is not None and plan.tracking is not None and plan.grasp is not None
    (carried,) = motion.carried
    assert {track.item for track in motion.tracks} == {placed.id for placed in scene.items}
    for track in motion.tracks:
        times, poses = unpacked(track.times), unpacked(track.poses)
        assert times[-1] == pytest.approx(plan.trajectory.duration, abs=TIME_RESOLUTION)
        for t in (0.0, carried.t_start, times[-1]):
            told = transform([np.interp(t, times, column) for column in poses.T])
            ridden = after_travel(scene, plan.tracking.conveyor, plan.tracking.speed * t)
            np.testing.assert_allclose(told, ridden.find(track.item).T_world_item, atol=1e-4)
    # Where the cup takes it, it is as it has ridden there: the cup presses along its own axis only.
    contact = next(s for s in plan.segments if s.kind is SegmentKind.CONTACT)
    tip = Arm(scene.cell.robot).tip(plan.trajectory.sample(contact.t_end)[0], contact.tool_state)
    off = inverse(tip @ transform(list(carried.pose)) @ plan.grasp.T_item_tip) @ tip
    assert carried.item == plan.grasp.item and np.abs(off[:2, 3]).max() < 1e-4 and 0.0 < off[2, 3] < 0.008


def test_lanes_and_curves_are_the_plans(shown: PageDocument) -> None:
    plan, scene = pick()
    lanes = {lane.name: lane.spans for lane in shown.lanes}
    assert [span.label for span in lanes["segments"]] == [str(s.kind) for s in plan.segments]
    valve = [e for e in plan.events if e.device == "valve"]
    assert [span.label for span in lanes["valve"]] == [event.action for event in valve]
    for span, event in zip(lanes["valve"], valve, strict=True):
        assert event.t_trigger is not None and abs(span.t_start - event.t_trigger) <= TIME_RESOLUTION
    verdict = verify(plan, scene)
    assert verdict.certificate is not None
    for signal in shown.signals:
        peak = np.abs(unpacked(signal.values)).max()
        told = getattr(verdict.certificate, f"max_{signal.name}_ratio")
        assert told * 0.97 <= peak <= told + 1e-3


def test_clearance_is_never_more_than_there_is(shown: PageDocument) -> None:
    plan, scene = pick()
    assert shown.clearance is not None
    values = unpacked(shown.clearance.values)
    assert len(values) == len(unpacked(shown.clearance.times))
    certificate = verify(plan, scene).certificate
    assert certificate is not None
    # Spheres around links are larger than the links, except for what is rounded.
    assert 0.0 < values.min() < 0.05 and values.max() <= shown.clearance.most
    assert shown.clearance.kept == scene.cell.clearance
    assert any(CRAYOLA in name for name in shown.clearance.names)


def test_what_the_verifier_has_against_a_plan_is_marked(shown: PageDocument) -> None:
    assert shown.marks == () and ("verifier", "accepts it") in {(f.label, f.value) for f in shown.facts}
    _, scene = pick()
    plan = pick_pushing(0.05)
    rejected = plan_page(plan, scene)
    assert any(mark.names and mark.t is not None for mark in rejected.marks)
    for mark in rejected.marks:
        assert set(mark.names) <= named_parts(scene)
    assert document_values(rejected)["marks"]


def test_a_plan_of_another_scene_is_refused() -> None:
    plan, scene = pick()
    with pytest.raises(StaleError):
        plan_page(replace(plan, scene_hash="0" * 64), scene)


def test_reasons_become_marks_with_bodies_depth_time_and_grasp() -> None:
    reasons = [
        Reason("collision", "top-down grasp on face x, approach", "finger against post_left, 3 mm deep"),
        Reason("collision", "segment 3 (lift)", "cup and post_left at 1.250 s, 4.2 mm deep"),
        Reason("does not hold", "top-down grasp on face +z, lift", "2.10 of what the cup bears"),
        Reason("collision", "frontal grasp on face -x, contact", "lance against pod post_left, 7 mm deep"),
        Reason("collision", "frontal grasp on face -x, contact", "lance against pod post_left, 9 mm deep"),
        Reason("no free place in the tote", "place", "40 placements tried"),
    ]
    marks = failure_marks(reasons, {"cup", "lance", "finger", "post_left"}, "soap")
    assert [(m.title, m.names, m.depth, m.t, m.count) for m in marks] == [
        ("collision", ("finger", "post_left"), 0.003, None, 1),
        ("collision", ("cup", "post_left"), 0.0042, 1.25, 1),
        ("does not hold", ("cup",), None, None, 1),
        ("collision", ("lance", "post_left"), 0.009, None, 2),
        ("no free place in the tote", (), None, None, 1),
    ]
    assert [None if m.grasp is None else (m.grasp.item, m.grasp.face, m.grasp.kind) for m in marks] == [
        ("soap", "x", "top-down"), None, ("soap", "+z", "top-down"), ("soap", "-x", "frontal"), None,
    ]  # fmt: skip


def test_a_page_is_the_same_again_and_small(shown: PageDocument) -> None:
    page = page_bytes(shown)
    assert page == page_bytes(plan_page(*pick()))
    assert len(page) < 1_000_000


def test_the_tool_frame_of_the_page_is_the_arms() -> None:
    plan, scene = pick()
    document = plan_page(plan, scene)
    assert document.robot is not None
    robot, here = scene.cell.robot, document.robot
    T = [np.eye(4) for _ in here.links]
    T[0] = transform(list(here.pose))
    at = dict(zip(here.moved, here.start, strict=True))
    for joint in here.joints:
        moved = pose()
        if joint.name in at and joint.type == "prismatic":
            moved = pose(np.array(joint.axis) * at[joint.name])
        elif joint.name in at:
            moved = pose(R=rotation_axis_angle(joint.axis, at[joint.name]))
        T[joint.child] = T[joint.parent] @ transform(list(joint.pose)) @ moved
    tip = T[here.tip_link] @ transform(list(here.tip))
    expected = Arm(robot).tip(plan.trajectory.positions[0], plan.segments[0].tool_state)
    np.testing.assert_allclose(inverse(expected) @ tip, np.eye(4), atol=1e-4)
