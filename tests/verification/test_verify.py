"""The verifier accepts honest plans and rejects every kind of broken one, for the right reason."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.tool import MOVING
from pickcli.errors import RejectedError, StaleError
from pickcli.geometry import pose
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.motion.plan_file import motion_hash
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.scene.scene import PoseNoise
from pickcli.verification.contact_exemptions import may_touch
from pickcli.verification.held_pose import pose_in_tool
from pickcli.verification.moving_parts import parts_of_segments
from pickcli.verification.state_sampling import MAX_STEP
from pickcli.verification.straightness_check import check_lines
from pickcli.verification.verify import certify, sampled, verify
from support.handmade_plans import (
    CRAYOLA,
    Builder,
    bound,
    cell,
    crayola_scene,
    loaded,
    make_scene,
    move_plan,
    pick,
    place,
    tip,
)
from support.plan_mutations import MATRIX, scaled, segment, with_grasp, with_points
from support.tool_states import DOWN, STRAIGHT


def home_to(name: str, duration: float) -> Builder:
    b = Builder(cell().configurations["home"].q)
    b.joint(SegmentKind.TRANSIT, cell().configurations[name].q, duration)
    return b


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
    T_tip_item = pose_in_tool(plan, scene)
    assert T_tip_item is not None
    assert verify(loaded(scaled(speed)(plan), T_tip_item), scene).certificate is not None


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


def test_the_tool_changes_its_state_in_transit_by_command_only() -> None:
    scene = make_scene()
    b = home_to("bin_H", 2.0)
    plan = move_plan(scene, b)
    assert verify(plan, scene).certificate is not None
    turning = replace(plan, segments=(replace(plan.segments[0], tool_state=MOVING),))
    assert verify(turning, scene).certificate is not None
    event = Event("cup_pivot", "down", Anchor(AnchorKind.TIME, 0, 1.0), 0.4, 1.0, 0.6)
    texts = [str(r) for r in verify(replace(plan, events=(event,)), scene).reasons]
    assert any("wrong tool state" in t for t in texts)
    half = [
        Segment(SegmentKind.TRANSIT, 0.0, 1.2, MOVING, None),
        Segment(SegmentKind.TRANSIT, 1.2, plan.trajectory.duration, DOWN, None),
    ]
    assert verify(replace(plan, segments=tuple(half), events=(event,)), scene).certificate is not None
    half[1] = replace(half[1], tool_state=STRAIGHT)
    assert verify(replace(plan, segments=tuple(half), events=(event,)), scene).certificate is None
    assert verify(replace(plan, segments=tuple(half)), scene).certificate is None


def test_the_moving_cup_sweeps() -> None:
    """An item where neither the straight nor the turned cup is, but the cup in between."""
    b = Builder(cell().configurations["bin_H"].q)
    b.wait(SegmentKind.TRANSIT, 0.5)
    q = b.q
    hinge = tip(q)[:3, 3] - 0.03 * tip(q)[:3, 2]
    between = tip(q)[:3, 2] + tip(q, DOWN)[:3, 2]
    ball = place("rawlings_baseball", (0, 0, 0), "bin_H")
    radius = ball.item.shape.extents[0] / 2
    T = pose(hinge + between / np.linalg.norm(between) * (radius + 0.0335))
    scene = make_scene(replace(ball, T_world_item=T))
    plan = move_plan(scene, b)
    for tool_state, is_free in ((STRAIGHT, True), (DOWN, True), (MOVING, False)):
        stated = replace(plan, segments=(replace(plan.segments[0], tool_state=tool_state),))
        assert (verify(stated, scene).certificate is not None) is is_free, tool_state


def test_planned_contact_is_a_touch_and_no_more() -> None:
    """The pod stands 20 mm higher than the item's pose says: the floor would be inside the item."""
    plan, scene = pick()
    raised = replace(scene, T_world_pod=pose((0.0, 0.0, 0.02)))
    texts = [str(r) for r in verify(bound(plan, raised), raised).reasons]
    assert any("planned contact too deep" in t and "row_ABC_floor_flat" in t for t in texts)


def test_a_way_out_of_a_stop_may_begin_by_leaving_what_is_touched() -> None:
    """The cup is stuck at an item: it may leave it, and touch it on no later segment; no other plan may."""
    plan, scene = pick()
    k = segment(plan, SegmentKind.CONTACT)
    b = Builder(plan.trajectory.sample(plan.segments[k].t_end)[0])
    start = tip(b.q)
    freed = pose(start[:3, 3] - (0.04, 0.0, 0.0), R=start[:3, :3])
    b.line(SegmentKind.DEPART, freed, 1.0, touching=(CRAYOLA,))
    b.line(SegmentKind.RETREAT, pose((-0.06, *start[1:3, 3]), R=start[:3, :3]), 2.0)
    b.joint(SegmentKind.TRANSIT, cell().configurations["home"].q, 2.0)
    untold = replace(move_plan(scene, b), recovery=RecoveryLevel.AS_PLANNED)
    assert verify(untold, scene).reasons == ()
    assert verify(replace(untold, recovery=None), scene).certificate is None
    silent = replace(untold, segments=(replace(untold.segments[0], touching=()), *untold.segments[1:]))
    late = (replace(untold.segments[0], touching=()), replace(untold.segments[1], touching=(CRAYOLA,)))
    assert verify(replace(untold, segments=(*late, *untold.segments[2:])), scene).certificate is None
    assert verify(silent, scene).certificate is None


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


def test_a_line_with_a_corner_is_not_straight() -> None:
    """Back by 60 mm and then up by 30 mm, the tool turned the same all the way: one segment, not two."""
    b = Builder(cell().configurations["bin_H"].q)
    back = tip(b.q) @ pose((0.0, 0.0, -0.06))
    b.line(SegmentKind.RETREAT, back, 1.0)
    b.line(SegmentKind.RETREAT, pose((0.0, 0.0, 0.03)) @ back, 1.0)
    scene = make_scene()
    assert not any(r.what == "not straight" for r in verify(move_plan(scene, b), scene).reasons)
    last = b.segments.pop()
    b.segments[-1] = replace(b.segments[-1], t_end=last.t_end)
    told = [r.detail for r in verify(move_plan(scene, b), scene).reasons if r.what == "not straight"]
    assert len(told) == 1 and "off the line" in told[0]


def test_an_item_may_touch_something_only_where_it_is_let_go() -> None:
    plan, _ = pick()
    k = segment(plan, SegmentKind.PLACE)
    assert may_touch(plan, k)
    kept = replace(plan.segments[k + 1], held=CRAYOLA)
    assert not may_touch(replace(plan, segments=(*plan.segments[: k + 1], kept)), k)


def test_slow_items_are_carried_slowly() -> None:
    plan, scene = pick()
    target = scene.items[0]
    for scale, is_accepted in ((0.6, True), (0.3, False)):
        slow = scene.moved(replace(target, item=replace(target.item, speed_scale=scale)))
        verdict = verify(bound(plan, slow), slow)
        assert (verdict.certificate is not None) is is_accepted
        assert is_accepted or "carrying speed" in str(verdict.reasons[0])


def test_certify_raises_with_every_reason() -> None:
    plan, scene = pick()
    assert certify(plan, scene).certificate is not None
    with pytest.raises(RejectedError, match="jerk limit"):
        certify(scaled(2.2)(plan), scene)


def _filled(name: str, value: float, rows: slice) -> object:
    def edit(arrays: dict[str, np.ndarray], plan: Plan) -> None:
        arrays[name][rows] = value

    return with_points(edit)


@pytest.mark.parametrize("value", [1e300, -1e300, 1e7, np.nan, np.inf])
@pytest.mark.parametrize("name", ["positions", "velocities", "accelerations"])
def test_numbers_that_no_plan_has_are_rejected_at_once(name: str, value: float) -> None:
    plan, scene = pick()
    verdict = verify(_filled(name, value, slice(3, 5))(plan), scene)  # type: ignore[operator]
    assert verdict.reasons and verdict.reasons[0].what in ("not finite", "not a plan's number")


@pytest.mark.parametrize(("velocity", "acceleration"), [(1e5, 1e6), (1e2, 0.0), (0.0, 1e6)])
def test_motion_far_beyond_the_limits_is_rejected_before_it_is_sampled(
    velocity: float, acceleration: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    plan, scene = pick()
    wild = _filled("velocities", velocity, slice(3, 5))(plan)  # type: ignore[operator]
    wild = _filled("accelerations", acceleration, slice(3, 5))(wild)  # type: ignore[operator]
    monkeypatch.setattr("pickcli.verification.state_sampling.link_poses", None)
    reasons = verify(wild, scene).reasons
    assert "velocity limit" in {reason.what for reason in reasons}


@pytest.mark.parametrize("factor", [1e-300, 1e-12])
def test_times_without_a_distance_are_rejected(factor: float) -> None:
    plan, scene = pick()
    trajectory = replace(plan.trajectory, times=plan.trajectory.times * factor)
    (reason,) = verify(replace(plan, trajectory=trajectory), scene).reasons
    assert reason.what == "time stamps" and "apart" in reason.detail


def test_a_plan_of_hours_is_rejected() -> None:
    plan, scene = pick()
    trajectory = replace(plan.trajectory, times=plan.trajectory.times * 1e4)
    (reason,) = verify(replace(plan, trajectory=trajectory), scene).reasons
    assert reason.what == "too long"


@pytest.mark.parametrize("value", [1e300, np.nan])
def test_grasps_and_events_are_numbers_of_a_plan(value: float) -> None:
    plan, scene = pick()
    assert plan.grasp is not None
    T = plan.grasp.T_item_tip.copy()
    T[0, 3] = value
    events = (replace(plan.events[0], t_anchor=value), *plan.events[1:])
    for broken in (replace(plan, grasp=replace(plan.grasp, T_item_tip=T)), replace(plan, events=events)):
        assert verify(broken, scene).reasons[0].what == "not a plan's number"


@pytest.mark.parametrize("value", [1e300, np.nan])
@pytest.mark.parametrize("name", ["score", "moment", "pull", "shear", "twist", "load_ratio"])
def test_what_a_plan_states_of_its_grasp_are_numbers(name: str, value: float) -> None:
    plan, scene = pick()
    assert verify(with_grasp(**{name: value})(plan), scene).reasons[0].what == "not a plan's number"


@pytest.mark.parametrize(("beyond", "is_refused"), [(-2e-4, False), (2e-4, True)])
def test_the_cup_ends_where_the_sealing_part_of_the_face_ends(beyond: float, is_refused: bool) -> None:
    plan, scene = pick()
    assert plan.grasp is not None
    item, tool, T = scene.find(CRAYOLA).item, scene.cell.robot.tool, plan.grasp.T_item_tip.copy()
    axis = int(np.argmax(np.abs(T[:3, 1])))  # across the tool, along the face
    T[axis, 3] = item.shape.extents[axis] / 2 - tool.cup.radius - item.seal_inset + beyond
    verdict = verify(replace(plan, grasp=replace(plan.grasp, T_item_tip=T)), scene)
    assert ("cup beyond the edge" in {reason.what for reason in verdict.reasons}) is is_refused


@pytest.mark.parametrize(
    ("way", "is_refused"),
    [
        ((0.0, 0.0, 0.02), False),
        ((0.0019, 0.0, 0.02), False),
        ((0.0021, 0.0, 0.02), True),
        ((0.0019, 0.0, 0.002), False),
        ((0.0, 0.0021, 0.002), True),
        ((0.0, -0.0021, 0.02), True),
        ((0.0, 0.0, -0.02), True),
        ((0.0, 0.0, 0.0), True),
    ],
)
def test_the_cup_meets_its_item_along_its_own_axis(way: tuple[float, ...], is_refused: bool) -> None:
    """way: m along the axes of the tool, of which at most 2 mm aside, and some forward."""
    builder = Builder(cell().configurations["home"].q)
    if any(way):
        builder.line(SegmentKind.CONTACT, tip(builder.q) @ pose(way), 2.0)
    else:
        builder.wait(SegmentKind.CONTACT, 2.0)
    plan, scene = move_plan(make_scene(), builder), make_scene()
    reasons = check_lines(plan, cell().robot, sampled(plan, scene, parts_of_segments(plan, scene, None)))
    assert [r.what for r in reasons] == ["not along the tool axis"] * is_refused


def test_a_slow_item_in_a_slow_cell_is_carried_at_the_product_of_both() -> None:
    plan, scene = pick()
    target = scene.items[0]
    slow = scene.moved(replace(target, item=replace(target.item, speed_scale=0.9)))
    carried = [s for s in plan.segments if s.held is not None]
    speeds = np.abs(plan.trajectory.sample(np.linspace(carried[0].t_start, carried[-1].t_end, 3000), 1))
    worst = float((speeds / scene.cell.robot.limits.velocity).max())
    for share, is_refused in ((1.05, False), (0.95, True)):
        both = replace(slow, cell=replace(scene.cell, speed_scale=worst * share / 0.9))
        reasons = {reason.what for reason in verify(bound(plan, both), both).reasons}
        assert ("carrying speed limit" in reasons) is is_refused


def test_what_breaks_a_limit_is_not_looked_at_for_long(monkeypatch: pytest.MonkeyPatch) -> None:
    plan, scene = pick()
    fast = scaled(2.2)(plan)
    assert any(r.what == "contact speed" for r in verify(fast, scene).reasons)
    monkeypatch.setattr("pickcli.verification.verify.MANY_STATES", 1000)
    assert {r.what for r in verify(fast, scene).reasons} == {
        "velocity limit", "acceleration limit", "jerk limit",
    }  # fmt: skip
    assert verify(plan, scene).certificate is not None


def test_a_move_leads_between_the_configurations_that_its_query_names() -> None:
    scene = make_scene()
    plan = move_plan(scene, home_to("bin_C", 3.0))
    for query, fault in (
        ("move from home to bin_C", None),
        ("park arm left", None),
        ("move from home to bin_D", "the end of the motion is not bin_D"),
        ("move from bin_B to bin_C", "the start of the motion is not bin_B"),
        ("pick dove_beauty_bar from bin_C", "takes and pushes no item"),
        ("Stow dove_beauty_bar into bin_C", "takes and pushes no item"),
    ):
        reasons = [str(r) for r in verify(replace(plan, query=query), scene).reasons if "query" in str(r)]
        assert bool(reasons) == (fault is not None), query
        assert fault is None or fault in reasons[0]


def test_the_query_of_an_item_whose_id_has_blanks_is_compared_too() -> None:
    """Also one whose id reads like the rest of a query."""
    plan, scene = pick()
    for name in ("my crayons 1", "crayons from bin_A into bin_F"):
        renamed = replace(scene, items=(replace(scene.items[0], id=name), *scene.items[1:]))
        segments = tuple(
            replace(s, held=s.held and name, touching=tuple(name if t == CRAYOLA else t for t in s.touching))
            for s in plan.segments
        )
        other = replace(with_grasp(item=name)(plan), segments=segments, query=f"pick {name} from bin_B")
        assert verify(bound(other, renamed), renamed).reasons == ()
        for query in (f"pick {name} from bin_A", f"pick {name} from bin_B into bin_F", f"pick {CRAYOLA}"):
            found = verify(bound(replace(other, query=query), renamed), renamed).reasons
            assert [reason.what for reason in found] == ["wrong query"]
