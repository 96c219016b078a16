"""Picks from a running conveyor: met with its speed, free at every instant, or never and why."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.data_path import data_path
from pickcli.collision.motion_segment import Mode
from pickcli.errors import Failures, NoPlanError, Reason, UnknownNameError
from pickcli.geometry import inverse, pose
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.linear_axis import linear_axis
from pickcli.motion.plan import times_at_work
from pickcli.motion.plan_file import plan_to_dict
from pickcli.motion.segment import SegmentKind
from pickcli.planning.belt_picks import axis_intercept
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.random_scenes.make_stream import StreamRequest, make_stream
from pickcli.scene.item_stream import RidingItem, after_travel
from pickcli.scene.scene_file import scene_hash
from pickcli.timing.limit_check import measure_limits
from pickcli.timing.line_tracking import MOST_PACE
from pickcli.verification.verify import verify
from support.belt_picks import BeltPick, belt_pick, cell, context, home, pick_on_the_way, stream
from support.cell_copies import CellCopy

SPEEDS = (0.1, 0.33, 0.5)


@pytest.fixture(scope="module", params=SPEEDS)
def pick(request: pytest.FixtureRequest) -> BeltPick:
    return belt_pick(request.param)


def contact_end(pick: BeltPick) -> float:
    return next(s.t_end for s in pick.plan.segments if s.kind is SegmentKind.CONTACT)


def test_the_verifier_accepts_it(pick: BeltPick) -> None:
    verdict = verify(pick.plan, pick.scene)
    assert verdict.reasons == () and verdict.certificate is not None


def test_it_ends_at_rest_over_the_rim_as_the_item_leaves_the_cup(pick: BeltPick) -> None:
    plan, tote = pick.plan, cell().places["tote"]
    assert plan.grasp is not None
    carrying, last = plan.segments[-2:]
    assert (carrying.kind, last.kind) == (SegmentKind.TRANSFER, SegmentKind.DEPART) and last.held is None
    valve = next(each for each in plan.events if (each.device, each.action) == ("valve", "off"))
    resting = np.linspace(valve.t_trigger or 0.0, last.t_end, 40)
    assert np.abs(plan.trajectory.sample(resting, 1)).max() < 1e-9
    tip = context().arm.tips(plan.trajectory.sample(resting[-1:]), last.tool_state)[0]
    T_world_item = tip @ inverse(plan.grasp.T_item_tip)
    shape = pick.scene.find(plan.grasp.item).item.shape
    lowest = T_world_item[2, 3] - shape.reach(T_world_item[:3, :3])[2]
    assert 0.0 < lowest - (tote.T_carrier_place @ tote.access.T_place_mouth)[2, 3] < 0.1
    assert lowest - tote.T_carrier_place[2, 3] - tote.room.floor_back <= 0.3


def test_the_tool_rests_on_the_item_while_that_rides(pick: BeltPick) -> None:
    seal = cell().robot.tool.cup.seal_time
    t = np.linspace(contact_end(pick) - seal, contact_end(pick), 60)
    tips = context().arm.tips(pick.plan.trajectory.sample(t), pick.plan.segments[0].tool_state)
    assert np.allclose(np.diff(tips[:, 0, 3]) / np.diff(t), pick.stream.speed, atol=1e-6)
    assert np.allclose(tips[:, 1:3, 3], tips[0, 1:3, 3], atol=1e-7)
    assert np.allclose(tips[:, :3, :3], tips[0, :3, :3], atol=1e-7)


def test_the_axis_comes_up_to_its_speed_while_the_arm_is_on_its_way() -> None:
    """With room for the most of the plan's pace, and at rest relative to the belt where the lines begin."""
    pick, along = pick_on_the_way(), linear_axis(cell().robot, np.eye(3)[0])
    assert along is not None
    t_works, at, speed, axis = times_at_work(pick.plan.segments)[0], pick.plan.trajectory, 0.33, along[0]
    before, then = at.sample(np.array([t_works - 0.2, t_works]), 1)
    assert 0.1 * speed < before[axis] < speed and np.delete(np.abs(before), axis).max() > 0.1
    assert then[axis] == pytest.approx(speed, abs=1e-9) and np.delete(np.abs(then), axis).max() < 1e-9
    coming = at.between(0.0, t_works)
    assert measure_limits(coming, cell().robot.limits, cell().speed_scale).time_scale * MOST_PACE <= 1.0
    verdict = verify(pick.plan, pick.scene)
    assert verdict.reasons == () and verdict.certificate is not None


@pytest.mark.parametrize("k", [1, 2, 3, 4])
def test_from_the_lines_on_it_has_room_for_the_most_of_its_pace(k: int) -> None:
    """Also where the axis comes to rest while the arm leaves already."""
    plan = pick_on_the_way(k).plan
    t_works, _ = times_at_work(plan.segments)
    most = measure_limits(plan.trajectory.between(t_works, plan.trajectory.duration), cell().robot.limits)
    assert most.time_scale * MOST_PACE <= 1.0 + 1e-6


def test_a_meeting_that_is_tried_in_steps_is_tried_at_the_last_moment(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tried, why = list[float](), Failures.of(Reason("no path", "transit"))

    def planned(belt: object, taking: object, start: object, t: float) -> axis_intercept._PutOff:
        tried.append(t)
        return axis_intercept._PutOff(0.0, axis_intercept.ELSEWHERE, why)

    pick, over_tote = pick_on_the_way(), cell().configurations["drop_01"]
    assert pick.plan.grasp is not None
    monkeypatch.setattr(axis_intercept, "_planned", planned)
    query, start = InterceptQuery(pick.plan.grasp.item, pick.now), Start(over_tote.q, over_tote.tool_state)
    with pytest.raises(NoPlanError, match="no path"):
        plan_intercept(context(), pick.stream, query, start)
    gaps = np.diff(tried)
    stepped = np.isclose(gaps, axis_intercept.ELSEWHERE)
    last = (gaps > 1e-9) & (gaps < axis_intercept.ELSEWHERE - 1e-9)  # to the last moment, once for a grasp
    assert stepped.any() and last.any() and not (last[1:] & last[:-1]).any()


def test_it_is_where_the_item_is(pick: BeltPick) -> None:
    assert pick.plan.grasp is not None
    t = contact_end(pick)
    placed = pick.stream.scene_at(pick.now + t).find(pick.plan.grasp.item)
    tip = context().arm.tip(pick.plan.trajectory.sample(t)[0], pick.plan.grasp.tool_state)
    at = placed.T_world_item @ pick.plan.grasp.T_item_tip
    off = np.linalg.inv(at) @ tip
    assert abs(off[0, 3]) < 1e-3 and abs(off[1, 3]) < 1e-3 and 0.0 <= off[2, 3] < 0.01


def test_it_is_free_at_every_instant_in_the_scene_of_that_instant(pick: BeltPick) -> None:
    """By brute force, from the stream alone, outside of the segments that plan contacts."""
    for segment in pick.plan.segments:
        if segment.touching or segment.held is not None:
            continue
        for t in np.arange(segment.t_start, segment.t_end, 0.02):
            scene = pick.stream.scene_at(pick.now + t)
            if segment.kind in (SegmentKind.PLACE, SegmentKind.DEPART):
                assert pick.plan.grasp is not None
                scene = scene.without(pick.plan.grasp.item)
            checker = context().checker_for(scene, Mode(segment.tool_state))
            assert checker.is_valid(pick.plan.trajectory.sample(t)[0]), (segment.kind, t)


@pytest.mark.parametrize("share", [0.0, 0.5, 1.5])
def test_off_the_belt_it_is_free_wherever_the_belt_brings_the_others(pick: BeltPick, share: float) -> None:
    """By brute force: from then on it runs at a share of the planned speed, as far as it can."""
    assert pick.plan.grasp is not None
    _, t_left = times_at_work(pick.plan.segments)
    speed = min(share * pick.stream.speed, pick.stream.belt.max_speed)
    scene = pick.stream.scene_at(pick.now).without(pick.plan.grasp.item)
    for segment in pick.plan.segments:
        for t in np.arange(max(segment.t_start, t_left), segment.t_end, 0.02):
            here = after_travel(scene, "belt", pick.stream.speed * t_left + speed * (t - t_left))
            checker = context().checker_for(here, Mode(segment.tool_state))
            assert checker.is_valid(pick.plan.trajectory.sample(t)[0]), (segment.kind, t)


def test_what_comes_onto_the_belt_meanwhile_is_kept_away_from() -> None:
    """A wall that comes right behind the item will be where the arm is, though it is not on the belt yet."""
    pick = belt_pick()
    assert pick.plan.grasp is not None
    item = pick.stream.find(pick.plan.grasp.item)
    reach = float(item.item.shape.reach(item.T_belt_item[:3, :3])[0])
    tall = cell().item("kleenex_tissue_box")
    half = tall.shape.extents / 2
    at = pick.stream.travel_at(item, pick.now) - reach - float(half[0]) - 0.005
    assert at - float(half[0]) < 0.0  # not on the belt yet, or not wholly
    T = pose((at, float(item.T_belt_item[1, 3]), float(half[2])))
    more = (*pick.stream.items, RidingItem("wall", tall, pick.now, T))
    scene = replace(pick.stream, items=more).scene_at(pick.now)
    assert scene.find("wall").location == "belt"
    verdict = verify(replace(pick.plan, scene_hash=scene_hash(scene)), scene)
    assert "wall" in "\n".join(map(str, verdict.reasons))


def test_a_motion_that_lasts_longer_than_what_comes_is_known_is_refused(pick: BeltPick) -> None:
    carrier = pick.scene.cell.carriers["belt"]
    assert carrier.conveyor is not None
    short = replace(carrier, conveyor=replace(carrier.conveyor, length=pick.stream.speed))  # 2 s
    scene = replace(pick.scene, cell=replace(pick.scene.cell, own_carriers=(short,)))
    verdict = verify(replace(pick.plan, scene_hash=scene_hash(scene)), scene)
    assert "lasts too long" in "\n".join(map(str, verdict.reasons))


def test_the_item_is_taken_within_the_window(pick: BeltPick) -> None:
    riding = pick.stream.find(pick.plan.grasp.item if pick.plan.grasp else "")
    leaves = next(s.t_start for s in pick.plan.segments if s.kind is SegmentKind.TRANSFER)
    first, last = pick.stream.belt.window
    assert first <= pick.stream.travel_at(riding, pick.now + contact_end(pick))
    assert pick.stream.travel_at(riding, pick.now + leaves) <= last


def test_the_same_query_gives_the_same_bytes() -> None:
    items = stream()
    query = InterceptQuery(items.items[1].id, items.items[1].stamp + 0.3)
    again = plan_intercept(PlanningContext(cell()), items, query, home())
    assert _bytes(again) == _bytes(belt_pick().plan)


def _bytes(plan: object) -> dict[str, object]:
    from pickcli.motion.plan import Plan

    assert isinstance(plan, Plan)
    return plan_to_dict(replace(plan, statistics={}))


def test_from_a_belt_that_stands_it_is_the_pick_from_a_table() -> None:
    items = make_stream(cell(), StreamRequest(3, 0.0, (0.1, 0.2)), 5)
    name = items.items[1].id
    plan = plan_intercept(context(), items, InterceptQuery(name, 2.0), home())
    static = plan_pick(context(), items.scene_at(2.0), PickQuery("belt", name), home())
    assert plan.tracking is None and _bytes(plan) == _bytes(static)


# Never, and why


def never(item: str, now: float, told: str, start: Start | None = None) -> None:
    with pytest.raises(NoPlanError) as error:
        plan_intercept(context(), stream(), InterceptQuery(item, now), start or home())
    assert told in str(error.value), str(error.value)


def test_what_is_past_the_window_is_never_met() -> None:
    riding = stream().items[0]
    never(riding.id, riding.stamp + 9.0, "out of the window: it left the window")


def test_what_has_not_come_yet_is_not_met_yet() -> None:
    never(stream().items[3].id, 0.0, "not on the belt yet: it is wholly past the infeed at")


def test_what_is_nearly_past_the_window_is_too_late_by_so_much() -> None:
    riding = stream().items[0]
    last = stream().belt.window[1]
    now = riding.stamp + (last - float(riding.T_belt_item[0, 3]) - 0.5) / 0.33
    never(riding.id, now, "too late: by ")


def test_an_unknown_item_is_told_with_a_known_one() -> None:
    with pytest.raises(UnknownNameError, match=stream().items[0].id):
        plan_intercept(context(), stream(), InterceptQuery("nothing", 0.0), home())


@pytest.fixture
def copy(tmp_path: Path) -> CellCopy:
    shutil.copytree(data_path() / "cells" / "conveyor_sia20", tmp_path / "cell")
    return CellCopy(tmp_path / "cell")


RAIL = "rail:    {has_velocity_limits: true, max_velocity: 1.0"
FRAME = "xyz: [-3.20, 0.65, 0.60], rpy: [0, 0, 0]"


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        (RAIL, RAIL.replace("1.0", "0.3"), "joint too slow: rail reaches 0.3 m/s, the belt runs at 0.33 m/s"),
        ("window: [1.20, 2.85]", "window: [1.20, 1.50]", "out of the window"),
    ],
)
def test_a_cell_that_cannot_follow_the_belt_says_why(copy: CellCopy, old: str, new: str, told: str) -> None:
    copy.yaml.replace(old, new)
    other = copy.load()
    items = make_stream(other, StreamRequest(2, 0.33, (0.3, 0.4)), 4)
    query = InterceptQuery(items.items[0].id, items.items[0].stamp + 0.3)
    with pytest.raises(NoPlanError, match=told):
        plan_intercept(PlanningContext(other), items, query, home())


def test_along_a_belt_that_is_turned_from_the_rail_all_joints_follow(copy: CellCopy) -> None:
    """The rail is one joint of eight then; with a cup as with fingers."""
    copy.yaml.replace(FRAME, FRAME.replace("0, 0]", "0, 0.05]"))
    other = copy.load()
    items = make_stream(other, StreamRequest(2, 0.33, (0.3, 0.4)), 4)
    query = InterceptQuery(items.items[0].id, items.items[0].stamp + 0.3)
    plan = plan_intercept(PlanningContext(other), items, query, home())
    contact = next(s for s in plan.segments if s.kind is SegmentKind.CONTACT)
    times = np.linspace(contact.t_end - 0.25, contact.t_end, 50)  # the cup seals
    arm, along = Arm(other.robot), items.carrier.T_world_carrier[:3, 0]
    tips = np.array([arm.tip(q, contact.tool_state)[:3, 3] for q in plan.trajectory.sample(times)])
    assert float(np.ptp(tips - 0.33 * np.outer(times, along), axis=0).max()) < 1e-6


def test_only_an_axis_that_carries_the_whole_arm_follows_a_belt() -> None:
    robot = cell().robot
    assert linear_axis(robot, np.array([1.0, 0.0, 0.0])) == (0, 1.0)
    assert linear_axis(robot, np.array([-1.0, 0.0, 0.0])) == (0, -1.0)
    assert linear_axis(robot, np.array([0.0, 1.0, 0.0])) is None
    assert linear_axis(load_cell("ur5e_crates").robot, np.array([1.0, 0.0, 0.0])) is None


@pytest.mark.parametrize("share", [0.35, 0.4])
def test_with_an_item_that_is_carried_slowly_belt_and_lines_share_the_velocity_of_the_axis(
    share: float,
) -> None:
    """The rail runs at 1 m/s: of the share for the item the belt takes 0.33 m/s, and the lines the rest."""
    riding = stream().items[1]
    slow = replace(riding, item=replace(riding.item, speed_scale=share))
    carried = replace(stream(), items=(slow,))
    now = riding.stamp + 0.3
    plan = plan_intercept(context(), carried, InterceptQuery(riding.id, now), home())
    assert verify(plan, carried.scene_at(now)).reasons == ()
    axis = linear_axis(cell().robot, stream().carrier.T_world_carrier[:3, 0])
    assert axis is not None
    held = [segment for segment in plan.segments if segment.held is not None]
    t = np.arange(held[0].t_start, held[-1].t_end, 1e-3)
    fastest = np.abs(plan.trajectory.sample(t, 1)[:, axis[0]]).max()
    assert stream().speed * (1 - 1e-6) <= fastest <= share * cell().robot.limits.velocity[axis[0]] + 1e-6


def test_an_item_that_the_axis_carries_more_slowly_than_the_belt_runs_is_never_met() -> None:
    riding = stream().items[1]
    slow = replace(riding, item=replace(riding.item, speed_scale=0.3))
    with pytest.raises(
        NoPlanError, match=r"joint too slow: rail carries .* at 0.3 m/s at most; the belt runs"
    ):
        plan_intercept(
            context(), replace(stream(), items=(slow,)), InterceptQuery(riding.id, riding.stamp + 0.3), home()
        )
