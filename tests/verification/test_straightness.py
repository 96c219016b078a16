"""Lines of the tool, pose by pose: how far aside, how turned, how fast, and over which way they may touch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.verification.straightness_check import (
    _contact,
    _straight,
    _touched_too_long,
    check_lines,
    fastest_tip,
)
from support.handmade_plans import CRAYOLA, cell
from support.rail_motions import HOME, rail, states_of

ROBOT = cell().robot
ASKEW = pose((0.3, -0.2, 0.9), rpy=(0.4, -0.7, 1.1))


def whats(tips: list[Array]) -> list[str]:
    return [reason.what for reason in _straight(np.array([ASKEW @ T for T in tips]), "line")]


def turned(degrees: float) -> Array:
    return rotation_axis_angle((0.48, 0.6, 0.64), np.radians(degrees))


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("side", [(0.0, 1.0, 0.0), (0.0, 0.0, -1.0)])
def test_every_pose_is_within_2_mm_of_the_line(share: float, side: tuple[float, float, float]) -> None:
    for aside, is_refused in ((0.00199, False), (0.00201, True)):
        middle = pose(np.array([0.1 * share, 0.0, 0.0]) + aside * np.array(side))
        assert whats([pose(), middle, pose((0.1, 0.0, 0.0))]) == ["not straight"] * is_refused


@pytest.mark.parametrize("way", [0.1, 1e-5, 0.0])
def test_a_line_ends_where_it_ends(way: float) -> None:
    """A pose beyond an end is as far off the line as it is from there, also of a line without a length."""
    end = pose((way, 0.0, 0.0))
    for beyond, is_refused in ((0.00199, False), (0.00201, True)):
        for x in (-beyond, way + beyond):
            assert whats([pose(), pose((x, 0.0, 0.0)), end]) == ["not straight"] * is_refused


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("whole", [0.0, 40.0, 170.0])
def test_every_pose_is_turned_by_as_much_as_it_is_on_its_way_and_a_degree(share: float, whole: float) -> None:
    end = pose((0.1, 0.0, 0.0), R=turned(whole))
    for off, is_refused in ((0.0, False), (0.99, False), (-0.99, False), (1.01, True), (-1.01, True)):
        middle = pose((0.1 * share, 0.0, 0.0), R=turned(share * whole + off))
        assert whats([pose(), middle, end]) == ["not straight"] * is_refused


def test_a_tool_that_turns_on_the_spot_turns_evenly() -> None:
    for off, is_refused in ((0.0, False), (0.99, False), (1.01, True), (-1.01, True)):
        tips = [pose(R=turned(degrees)) for degrees in (0.0, 20.0 + off, 40.0)]
        assert whats(tips) == ["not straight"] * is_refused


def test_of_a_line_that_goes_a_hundredth_of_a_millimetre_the_way_counts() -> None:
    for share, is_refused in ((0.9, False), (0.5, True)):
        tips = [pose((1e-5 * s, 0.0, 0.0), R=turned(40.0 * t)) for s, t in ((0, 0), (0.9, share), (1, 1))]
        assert whats(tips) == ["not straight"] * is_refused


def test_how_far_off_the_worst_pose_is_is_told() -> None:
    tips = [pose(), pose((0.02, 0.003, 0.0)), pose((0.03, 0.0, -0.004)), pose((0.1, 0.0, 0.0))]
    (reason,) = _straight(np.array(tips), "line")
    assert reason.detail == "4.00 mm off the line"
    tips = [
        pose((x, 0.0, 0.0), R=turned(by)) for x, by in ((0.0, 0.0), (0.02, 3.0), (0.05, -5.0), (0.1, 0.0))
    ]
    (reason,) = _straight(np.array(tips), "line")
    assert reason.detail == "turned 5.00 deg away from the line"


@pytest.mark.parametrize("kind", list(SegmentKind))
def test_all_but_coarse_motions_are_straight(kind: SegmentKind) -> None:
    plan = rail(0.1, kind=kind)
    p = np.vstack([HOME, HOME, HOME])
    p[1:, 0] += (0.05, 0.1)
    p[1, 6] += 0.1
    still = np.zeros_like(p)
    bent = replace(plan.trajectory, times=np.array([0.0, 0.5, 1.0]), positions=p, velocities=still,
                   accelerations=still)  # fmt: skip
    found = lines(replace(plan, trajectory=bent))
    assert ("not straight" in found) is (kind not in (SegmentKind.TRANSIT, SegmentKind.TRANSFER))


def lines(plan: Plan) -> list[str]:
    return [reason.what for reason in check_lines(plan, ROBOT, states_of(plan))]


# The contact


def contact(end: Array) -> list[str]:
    """What is wrong with a contact from a pose to another, of a tool that is slow enough."""
    plan = rail(0.0, kind=SegmentKind.CONTACT)
    tips = np.array([ASKEW, ASKEW @ pose((0.0, 0.0, -0.5)), ASKEW @ end])  # only the ends count
    return [reason.what for reason in _contact(plan, ROBOT, plan.segments[0], tips, "")]


@pytest.mark.parametrize("forward", [0.02, 1e-4])
def test_a_contact_leads_forward_along_the_axis_of_the_tool_and_2_mm_aside(forward: float) -> None:
    for way, is_refused in (
        ((0.0, 0.0, forward), False), ((0.00199, 0.0, forward), False), ((0.00201, 0.0, forward), True),
        ((0.0, -0.00199, forward), False), ((0.0, -0.00201, forward), True),
        ((0.0015, 0.0015, forward), True), ((0.0, 0.0, -forward), True), ((0.0, 0.0, 0.0), True),
    ):  # fmt: skip
        assert contact(pose(way)) == ["not along the tool axis"] * is_refused


def test_the_axis_is_that_of_the_tool_where_it_is_pressed_on() -> None:
    R = rotation_axis_angle((1.0, 0.0, 0.0), 0.3)
    assert contact(pose(0.02 * R[:, 2], R=R)) == []
    assert contact(pose((0.0, 0.0, 0.02), R=R)) == ["not along the tool axis"]


@pytest.mark.parametrize(("over", "is_refused"), [(0.9e-3, False), (1.1e-3, True)])
def test_a_tool_comes_at_its_contact_speed_at_most(over: float, is_refused: bool) -> None:
    """The rail goes at one speed for a second; what it does before and after is another matter."""
    speed = ROBOT.tool.contact_speed * (1.0 + over)
    plan = rail(1.0, kind=SegmentKind.CONTACT)
    p, v = np.tile(HOME, (4, 1)), np.zeros((4, len(HOME)))
    p[:, 0] += (0.0, 0.5, 0.5 + speed, 1.0)
    v[1:3, 0] = speed
    motion = replace(plan.trajectory, times=np.arange(4.0), positions=p, velocities=v,
                     accelerations=np.zeros_like(p))  # fmt: skip
    (segment,) = plan.segments
    even = replace(plan, trajectory=motion, segments=(replace(segment, t_start=1.0, t_end=2.0),))
    assert ("contact speed" in lines(even)) is is_refused
    state = segment.tool_state
    assert fastest_tip(even, ROBOT, state, 1.0, 2.0) == pytest.approx(speed, rel=1e-6)
    assert fastest_tip(even, ROBOT, state, 0.0, 2.0) > 10 * speed


# The way on which something is touched


@pytest.mark.parametrize(
    ("kind", "most"),
    [(SegmentKind.CONTACT, 0.025), (SegmentKind.LIFT, 0.055), (SegmentKind.PLACE, 0.055),
     (SegmentKind.DEPART, 0.055)],
)  # fmt: skip
def test_what_may_be_touched_is_named_over_a_few_centimetres_in_all(kind: SegmentKind, most: float) -> None:
    """Also in several segments, and there and back."""
    for beyond, problem in ((-1e-4, []), (1e-4, ["touching too long"])):
        for ways in ((most + beyond,), (0.02, most - 0.02 + beyond), (0.02, -(most - 0.02 + beyond))):
            plan = rail(*ways, kind=kind)
            named = tuple(replace(segment, touching=(CRAYOLA,)) for segment in plan.segments)
            found = lines(replace(plan, segments=named))
            assert [what for what in found if what == "touching too long"] == problem
            assert "touching too long" not in lines(replace(plan, segments=(*named[1:], plan.segments[0])))
    assert list(_touched_too_long({kind: most})) == []


def test_ways_of_different_kinds_are_not_added_up() -> None:
    plan = rail(0.05, -0.05)
    kinds = SegmentKind.PLACE, SegmentKind.DEPART
    named = (replace(s, kind=k, touching=(CRAYOLA,)) for s, k in zip(plan.segments, kinds, strict=True))
    assert lines(replace(plan, segments=tuple(named))) == []
