"""The verifier accepts honest plans and rejects every kind of broken one, for the right reason."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from handmade import (
    CRAYOLA,
    DOWN,
    MOVING,
    STRAIGHT,
    Builder,
    bound,
    cell,
    crayola_scene,
    make_scene,
    move_plan,
    pick,
    place,
    tip,
)

from pickcli.cell.scene import PoseNoise
from pickcli.errors import RejectedError, StaleError
from pickcli.geometry import pose
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.plan import Plan
from pickcli.motion.plan_file import motion_hash
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.verification.states import MAX_STEP
from pickcli.verification.verify import certify, verify

Mutation = Callable[[Plan], Plan]


def home_to(name: str, duration: float) -> Builder:
    b = Builder(cell().configurations["home"].q)
    b.joint(SegmentKind.TRANSIT, cell().configurations[name].q, duration)
    return b


def segment(plan: Plan, kind: SegmentKind) -> int:
    return [s.kind for s in plan.segments].index(kind)


def with_segment(k_of: SegmentKind, **changes: object) -> Mutation:
    def change(plan: Plan) -> Plan:
        k = segment(plan, k_of)
        segments = list(plan.segments)
        segments[k] = replace(segments[k], **changes)
        return replace(plan, segments=tuple(segments))

    return change


def with_points(edit: Callable[[dict[str, np.ndarray], Plan], None]) -> Mutation:
    """Edit copies of times, positions, velocities and accelerations."""

    def change(plan: Plan) -> Plan:
        t = plan.trajectory
        arrays = {
            "times": t.times.copy(),
            "positions": t.positions.copy(),
            "velocities": t.velocities.copy(),
            "accelerations": t.accelerations.copy(),
        }
        edit(arrays, plan)
        return replace(plan, trajectory=replace(t, **arrays))

    return change


def scaled(factor: float) -> Mutation:
    """The same geometry, faster: everything with a time in it shrinks with it."""

    def change(plan: Plan) -> Plan:
        t = plan.trajectory
        trajectory = replace(
            t,
            times=t.times / factor,
            velocities=t.velocities * factor,
            accelerations=t.accelerations * factor**2,
        )
        segments = tuple(
            replace(s, t_start=s.t_start / factor, t_end=s.t_end / factor) for s in plan.segments
        )
        anchors = [segments[e.anchor.segment].t_end + e.anchor.offset for e in plan.events]
        events = tuple(
            replace(e, t_anchor=t, t_trigger=t - e.lead) for e, t in zip(plan.events, anchors, strict=True)
        )
        return replace(plan, trajectory=trajectory, segments=segments, events=events)

    return change


def with_event(i: int, shift_anchor: float = 0.0, shift_trigger: float = 0.0, **changes: object) -> Mutation:
    def change(plan: Plan) -> Plan:
        event = plan.events[i]
        assert event.t_anchor is not None and event.t_trigger is not None
        times = {"t_anchor": event.t_anchor + shift_anchor, "t_trigger": event.t_trigger + shift_trigger}
        moved = replace(event, **{**times, **changes})
        return replace(plan, events=(*plan.events[:i], moved, *plan.events[i + 1 :]))

    return change


def moved_event(i: int, by: float) -> Mutation:
    """The whole event later by so many s, consistently: anchor, times and all."""

    def change(plan: Plan) -> Plan:
        anchor = plan.events[i].anchor
        return with_event(i, by, by, anchor=replace(anchor, offset=anchor.offset + by))(plan)

    return change


def without_event(i: int) -> Mutation:
    return lambda plan: replace(plan, events=plan.events[:i] + plan.events[i + 1 :])


def with_grasp(**changes: object) -> Mutation:
    def change(plan: Plan) -> Plan:
        assert plan.grasp is not None
        return replace(plan, grasp=replace(plan.grasp, **changes))

    return change


def moved_grasp(xyz: tuple[float, float, float], rpy: tuple[float, float, float] = (0, 0, 0)) -> Mutation:
    def change(plan: Plan) -> Plan:
        assert plan.grasp is not None
        return with_grasp(T_item_tip=plan.grasp.T_item_tip @ pose(xyz, rpy=rpy))(plan)

    return change


def push_into_the_pod(arrays: dict[str, np.ndarray], plan: Plan) -> None:
    """One waypoint in the middle of the pre-approach 0.2 m farther along the rail's sideways neighbour s."""
    s = plan.segments[segment(plan, SegmentKind.PREAPPROACH)]
    i = int(np.searchsorted(arrays["times"], (s.t_start + s.t_end) / 2))
    arrays["positions"][i, 1] += 0.15


def equal_stamps(arrays: dict[str, np.ndarray], plan: Plan) -> None:
    arrays["times"][40] = arrays["times"][39]


def beyond_a_limit(arrays: dict[str, np.ndarray], plan: Plan) -> None:
    arrays["positions"][:, 0] += 0.05 - arrays["positions"][:, 0].min() - 1e-3


def not_at_rest(arrays: dict[str, np.ndarray], plan: Plan) -> None:
    arrays["velocities"][-1, 3] = 0.01


def shake(arrays: dict[str, np.ndarray], plan: Plan) -> None:
    arrays["velocities"][200, 6] += 0.3


def jerk(arrays: dict[str, np.ndarray], plan: Plan) -> None:
    arrays["accelerations"][20, 7] += 6.0


# Each row: what is done to a good pick, and a reason that must be among those given.
MATRIX: dict[str, tuple[Mutation, str, str]] = {
    "a waypoint through the pod": (with_points(push_into_the_pod), "collision", "row_ABC"),
    "speed x 2.2": (scaled(2.2), "velocity limit", ""),
    "speed x 1.8 breaks the acceleration limit": (scaled(1.8), "acceleration limit", ""),
    "speed x 1.5 breaks the jerk limit": (scaled(1.5), "jerk limit", ""),
    "speed x 1.8 at contact": (scaled(1.8), "contact speed", "contact"),
    "a velocity that jumps": (with_points(shake), "jerk limit", "joint_b"),
    "an acceleration that jumps": (with_points(jerk), "jerk limit", "joint_t"),
    "does not stop": (with_points(not_at_rest), "not at rest", "end"),
    "a joint limit": (with_points(beyond_a_limit), "joint limit", "rail"),
    "equal time stamps": (with_points(equal_stamps), "time stamps", "40"),
    "an event fired 0.3 s late": (with_event(1, 0.0, 0.3), "wrong trigger", "valve on"),
    "an event fired 0.3 s early": (with_event(1, 0.0, -0.3), "wrong trigger", "valve on"),
    "both times of an event shifted": (with_event(1, 0.3, 0.3), "wrong anchor time", "valve on"),
    "valve opened after contact": (moved_event(1, 0.7), "event at the wrong time", "valve on"),
    "valve opened 0.3 s early": (moved_event(1, -0.3), "event at the wrong place", "valve on"),
    "valve closed 0.3 s early": (moved_event(3, -0.3), "event at the wrong place", "valve off"),
    "valve closed 0.3 s late": (moved_event(3, 0.3), "event at the wrong time", "valve off"),
    "vacuum lost on the way": (moved_event(4, -3.0), "vacuum lost", "pump off"),
    "sensor read before the lift": (moved_event(2, -3.0), "event at the wrong time", "sensor read"),
    "pump forgotten": (without_event(0), "event missing", "pump on"),
    "pump too late for its lead": (moved_event(0, 0.3), "event at the wrong time", "pump on"),
    "another lead": (with_event(1, lead=0.1), "wrong lead", "valve on"),
    "another device": (with_event(0, device="vacuum"), "unknown device", "vacuum"),
    "not resolved": (with_event(0, t_trigger=None), "not resolved", "pump"),
    "anchored by the wrong way": (
        with_event(1, anchor=Anchor(AnchorKind.ARC_LENGTH, 2, 0.02)), "wrong anchor time", "valve on",
    ),
    "wrong pivot at the lines": (with_segment(SegmentKind.RETREAT, pivot=DOWN), "wrong pivot", "retreat"),
    "wrong pivot at contact": (with_segment(SegmentKind.CONTACT, pivot=DOWN), "wrong pivot", "contact"),
    "pivots while holding": (
        with_segment(SegmentKind.TRANSFER, pivot=MOVING), "pivots while holding", "transfer",
    ),
    "held item forgotten": (with_segment(SegmentKind.TRANSFER, held=None), "held item forgotten", "transfer"),
    "another item held": (
        with_segment(SegmentKind.RETREAT, held="dove_beauty_bar"), "wrong held item", "retreat",
    ),
    "touching in transfer": (
        with_segment(SegmentKind.TRANSFER, touching=("wall_left",)), "touching not allowed", "transfer",
    ),
    "touching an unknown body": (
        with_segment(SegmentKind.LIFT, touching=("elephant",)), "unknown name", "elephant",
    ),
    "contact that may not touch": (
        with_segment(SegmentKind.CONTACT, touching=()), "collision", "cup and crayola",
    ),
    "lift that may not touch": (with_segment(SegmentKind.LIFT, touching=()), "too close", "row_ABC_floor"),
    "a gap between segments": (with_segment(SegmentKind.LIFT, t_end=4.0), "segments not contiguous", "lift"),
    "coarse motion called a line": (
        with_segment(SegmentKind.TRANSFER, kind=SegmentKind.RETREAT), "not straight", "retreat",
    ),
    "an approach called contact": (
        with_segment(SegmentKind.APPROACH, kind=SegmentKind.CONTACT), "held item forgotten", "",
    ),
    "grasp of another item": (with_grasp(item="folgers"), "unknown item", "folgers"),
    "cup aside of the grasp": (moved_grasp((0.004, 0, 0)), "misses the item", "aside"),
    "cup before the item": (moved_grasp((0, 0, 0.02)), "grasp off the surface", CRAYOLA),
    "cup tilted on the face": (moved_grasp((0, 0, 0), (0.2, 0, 0)), "cup not square", CRAYOLA),
    "cup over the edge": (moved_grasp((0, 0.03, 0)), "cup beyond the edge", CRAYOLA),
    "grasp for the other pivot": (with_grasp(pivot=DOWN), "wrong pivot", "contact"),
    "joints in another order": (
        lambda p: replace(p, trajectory=replace(p.trajectory, joint_names=p.trajectory.joint_names[::-1])),
        "joint names", "trajectory",
    ),
}  # fmt: skip


def test_a_good_pick_is_certified() -> None:
    plan, scene = pick()
    verdict = verify(plan, scene)
    assert verdict.reasons == ()
    certificate = verdict.certificate
    assert certificate is not None
    assert certificate.motion_hash == motion_hash(plan)
    assert certificate.max_step <= MAX_STEP * 1.001 <= 0.005
    assert 0.0 < certificate.min_clearance < 0.05
    assert 0.0 < certificate.max_velocity_ratio < 1.0


@pytest.mark.parametrize("name", MATRIX)
def test_every_mutation_is_rejected_for_its_reason(name: str) -> None:
    plan, scene = pick()
    mutate, what, detail = MATRIX[name]
    verdict = verify(mutate(plan), scene)
    assert verdict.certificate is None
    texts = [str(r) for r in verdict.reasons]
    assert any(what in text and detail in text for text in texts), texts


@pytest.mark.parametrize("speed", [0.9, 1.0])
def test_a_slower_plan_stays_good(speed: float) -> None:
    plan, scene = pick()
    assert verify(scaled(speed)(plan), scene).is_accepted


def test_another_scene_and_another_cell_are_stale() -> None:
    plan, scene = pick()
    other = replace(scene, items=scene.items[:2])
    with pytest.raises(StaleError, match=plan.scene_hash) as caught:
        verify(plan, other)
    assert "scene" in str(caught.value)
    with pytest.raises(StaleError, match=scene.cell.fingerprint):
        verify(replace(plan, cell_fingerprint="0" * 64), scene)


def test_what_stands_in_the_way_is_seen_wherever_it_stands() -> None:
    """The same motion, with one more thing in the scene: over the tote, in the bin, before the shelf."""
    plan, scene = pick()
    for xyz in ((-1.0455, -0.6165, 0.80), (0.15, 0.0, 1.60), (-0.3, 0.0, 1.60)):
        crowded = replace(scene, items=(*scene.items, place("kleenex_tissue_box", xyz, "bin_B")))
        verdict = verify(bound(plan, crowded), crowded)
        assert any("kleenex_tissue_box" in str(r) for r in verdict.reasons)


def test_the_shifted_pod_is_the_one_that_counts() -> None:
    plan, scene = pick()
    shifted = replace(scene, T_world_pod=pose((0.0, 0.12, 0.0)))
    verdict = verify(bound(plan, shifted), shifted)
    assert any("row_ABC_divider" in str(r) for r in verdict.reasons)


def test_uncertain_poses_cost_clearance() -> None:
    plan, scene = pick()
    noisy = crayola_scene(PoseNoise(0.001, 0.005))
    sharp, blurred = verify(plan, scene), verify(bound(plan, noisy), noisy)
    assert sharp.certificate is not None and blurred.certificate is not None
    assert blurred.certificate.min_clearance < sharp.certificate.min_clearance - 0.001


def test_a_heavy_item_does_not_hold() -> None:
    plan, scene = pick()
    target = scene.items[0]
    heavy = scene.moved(replace(target, item=replace(target.item, mass=6.0)))
    texts = [str(r) for r in verify(bound(plan, heavy), heavy).reasons]
    assert any("does not hold" in t and "shear" in t for t in texts)


def test_the_drop_limit_and_the_walls_count() -> None:
    """Released at the height of the shelf, or with the place line left out."""
    plan, scene = pick()
    k = segment(plan, SegmentKind.PLACE)
    empty = replace(plan.segments[k], kind=SegmentKind.DEPART, held=None)
    early = replace(plan, segments=(*plan.segments[:k], empty, plan.segments[k + 1]))
    texts = [str(r) for r in verify(early, scene).reasons]
    assert any("released too high" in t for t in texts)


def test_the_pivot_moves_in_transit_by_command_only() -> None:
    scene = make_scene()
    b = home_to("bin_H", 2.0)
    plan = move_plan(scene, b)
    assert verify(plan, scene).is_accepted
    turning = replace(plan, segments=(replace(plan.segments[0], pivot=MOVING),))
    assert verify(turning, scene).is_accepted
    event = Event("cup_pivot", "down", Anchor(AnchorKind.TIME, 0, 1.0), 0.3, 1.0, 0.7)
    texts = [str(r) for r in verify(replace(plan, events=(event,)), scene).reasons]
    assert any("wrong pivot" in t for t in texts)
    half = [
        Segment(SegmentKind.TRANSIT, 0.0, 1.2, MOVING, None),
        Segment(SegmentKind.TRANSIT, 1.2, plan.trajectory.duration, DOWN, None),
    ]
    assert verify(replace(plan, segments=tuple(half), events=(event,)), scene).is_accepted
    half[1] = replace(half[1], pivot=STRAIGHT)
    assert not verify(replace(plan, segments=tuple(half), events=(event,)), scene).is_accepted
    assert not verify(replace(plan, segments=tuple(half)), scene).is_accepted


def test_the_moving_pivot_sweeps() -> None:
    """An item where neither the straight nor the pivoted cup is, but the cup in between."""
    b = Builder(cell().configurations["bin_H"].q)
    b.wait(SegmentKind.TRANSIT, 0.5)
    q = b.q
    hinge = tip(q)[:3, 3] - 0.03 * tip(q)[:3, 2]
    between = tip(q)[:3, 2] + tip(q, DOWN)[:3, 2]
    ball = place("rawlings_baseball", (0, 0, 0), "bin_H")
    radius = ball.item.shape.extents[0] / 2
    T = pose(hinge + between / np.linalg.norm(between) * (radius + 0.031))
    scene = make_scene(replace(ball, T_world_item=T))
    plan = move_plan(scene, b)
    for pivot, is_free in ((STRAIGHT, True), (DOWN, True), (MOVING, False)):
        stated = replace(plan, segments=(replace(plan.segments[0], pivot=pivot),))
        assert verify(stated, scene).is_accepted is is_free, pivot


def test_planned_contact_is_a_touch_and_no_more() -> None:
    """The pod stands 20 mm higher than the item's pose says: the floor would be inside the item."""
    plan, scene = pick()
    raised = replace(scene, T_world_pod=pose((0.0, 0.0, 0.02)))
    texts = [str(r) for r in verify(bound(plan, raised), raised).reasons]
    assert any("planned contact too deep" in t and "row_ABC_floor_flat" in t for t in texts)


def test_a_plan_may_begin_with_a_way_out() -> None:
    """The cup is stuck at an item: it may leave it, and touch it on no later segment."""
    plan, scene = pick()
    k = segment(plan, SegmentKind.CONTACT)
    b = Builder(plan.trajectory.sample(plan.segments[k].t_end)[0])
    start = tip(b.q)
    freed = pose(start[:3, 3] - (0.04, 0.0, 0.0), R=start[:3, :3])
    b.line(SegmentKind.DEPART, freed, 1.0, touching=(CRAYOLA,))
    b.line(SegmentKind.RETREAT, pose((-0.06, *start[1:3, 3]), R=start[:3, :3]), 2.0)
    b.joint(SegmentKind.TRANSIT, cell().configurations["home"].q, 2.0)
    assert verify(move_plan(scene, b), scene).reasons == ()
    untold = move_plan(scene, b)
    silent = replace(untold, segments=(replace(untold.segments[0], touching=()), *untold.segments[1:]))
    late = (replace(untold.segments[0], touching=()), replace(untold.segments[1], touching=(CRAYOLA,)))
    assert not verify(replace(untold, segments=(*late, *untold.segments[2:])), scene).is_accepted
    assert not verify(silent, scene).is_accepted


def test_a_line_may_turn_evenly_and_in_no_other_way() -> None:
    """A straight line on which the tool turns by 20 degrees, and the same with a bow in it."""
    b = Builder(cell().configurations["bin_H"].q)
    T = tip(b.q) @ pose((0.0, 0.0, -0.1), rpy=(0.2, 0.3, 0.0))
    b.line(SegmentKind.RETREAT, T, 2.0)
    scene = make_scene()
    plan = move_plan(scene, b)
    assert verify(plan, scene).reasons == ()

    def bow(arrays: dict[str, np.ndarray], _: Plan) -> None:
        u = arrays["times"] / arrays["times"][-1]
        arrays["positions"][:, 7] += 0.03 * (u * (1 - u)) ** 3 * 64  # joint t turns the tool about its axis

    bowed = with_points(bow)(plan)
    assert any(r.what == "not straight" and "turned" in r.detail for r in verify(bowed, scene).reasons)


def test_slow_items_are_carried_slowly() -> None:
    plan, scene = pick()
    target = scene.items[0]
    for scale, is_accepted in ((0.6, True), (0.3, False)):
        slow = scene.moved(replace(target, item=replace(target.item, speed_scale=scale)))
        verdict = verify(bound(plan, slow), slow)
        assert verdict.is_accepted is is_accepted
        assert is_accepted or "carrying speed" in str(verdict.reasons[0])


def test_certify_raises_with_every_reason() -> None:
    plan, scene = pick()
    assert certify(plan, scene).certificate is not None
    with pytest.raises(RejectedError, match="jerk limit"):
        certify(scaled(2.2)(plan), scene)
