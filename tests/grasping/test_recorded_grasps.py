"""Recorded grasps: from plans and files, and the chase and kinematic filters over them."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.collision.motion_segment import Mode
from pickcli.errors import InputError, StaleError
from pickcli.geometry import Array, inverse, pose
from pickcli.grasping.recorded_filters import (
    chase_cosine,
    chase_filter,
    filter_grasps,
    kinematic_filter,
)
from pickcli.grasping.recorded_grasp import (
    USUAL_DISTANCE,
    RecordedGrasp,
    recorded_along_axis,
    recorded_from_plan,
)
from pickcli.grasping.recorded_grasp_file import read_recorded_grasps, write_recorded_grasps
from pickcli.motion.plan import Plan
from pickcli.path_planning.lattice_planner import LatticePlan, plan_on_lattice
from pickcli.path_planning.workspace_lattice import HandGoals
from pickcli.scene.scene import empty_scene
from pickcli.verification.verify import certifier
from support.pr2_picks import arm_pick, context, home

BELT = np.array([0.0, -0.33, 0.0])  # m/s: it runs from the robot's left to its right
DOWN = pose(rpy=(np.pi, 0.0, 0.0))


def cell() -> Cell:
    return context().cell


@cache
def certified() -> Plan:
    plan = certifier(arm_pick().scene)(arm_pick().plan)
    assert isinstance(plan, Plan)
    return plan


def coming_from(direction: Array) -> RecordedGrasp:
    """A grasp at the item's middle, the tool pointing down, its pregrasp 0.1 m off in a direction."""
    before = pose(0.1 * direction, R=DOWN[:3, :3])
    return RecordedGrasp("dove_beauty_bar", 2016, "open", before, DOWN, before)


# From plans


def test_a_plans_pregrasp_is_straight_before_the_grasp_and_its_postgrasp_over_it() -> None:
    """Relative to the belt, which carries item and tool on meanwhile."""
    found = recorded_from_plan(certified(), cell())
    plan, T_item_grasp = certified(), found.T_item_grasp
    assert plan.grasp is not None and np.array_equal(T_item_grasp, plan.grasp.T_item_tip)
    before = inverse(T_item_grasp) @ found.T_item_pregrasp
    assert before[2, 3] == pytest.approx(-0.04, abs=1e-3)  # settings.approach_offset
    assert np.allclose(before[:2, 3], 0.0, atol=1e-3) and np.allclose(before[:3, :3], np.eye(3), atol=1e-3)
    item = next(r for r in arm_pick().stream.items if r.id == plan.grasp.item)
    R_world_item = (arm_pick().stream.carrier.T_world_carrier @ item.T_belt_item)[:3, :3]
    lifted = R_world_item @ (found.T_item_postgrasp - T_item_grasp)[:3, 3]
    assert lifted[2] > 0.05 and np.allclose(lifted[:2], 0.0, atol=2e-3)
    assert (found.item, found.tool_state, found.source) == (plan.grasp.item, "open", plan.query)


def test_plans_without_grasp_or_certificate_and_of_another_cell_are_refused() -> None:
    for plan, message in (
        (replace(certified(), grasp=None), "has no grasp to record"),
        (replace(certified(), certificate=None), "was not verified"),
    ):
        with pytest.raises(InputError, match=message):
            recorded_from_plan(plan, cell())
    with pytest.raises(StaleError, match="made for another cell than pr2_belt"):
        recorded_from_plan(certified(), context("right").cell)


def test_a_stated_grasp_comes_along_the_tools_axis() -> None:
    found = recorded_along_axis(("dove_beauty_bar", 2016), "open", DOWN, "stated")
    assert np.allclose(found.T_item_pregrasp, pose((0.0, 0.0, USUAL_DISTANCE), R=DOWN[:3, :3]))


# Files


def test_what_is_written_is_read_again(tmp_path: Path) -> None:
    path, written = (
        tmp_path / "grasps.json",
        (recorded_from_plan(certified(), cell()), coming_from(np.eye(3)[2])),
    )
    write_recorded_grasps(written, cell(), path)
    read = read_recorded_grasps(path, cell())
    assert len(read) == 2
    for a, b in zip(written, read, strict=True):
        assert (a.item, a.year, a.tool_state, a.source) == (b.item, b.year, b.tool_state, b.source)
        for name in ("T_item_pregrasp", "T_item_grasp", "T_item_postgrasp"):
            assert np.allclose(getattr(a, name), getattr(b, name), atol=1e-12)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"name": "dove_beauty_ba"}, "unknown item 'dove_beauty_ba' of 2016"),
        ({"tool_state": "opn"}, "unknown state of the tool 'opn'; did you mean 'open'"),
        ({"tool_state": None}, "tool_state"),
        (
            {"grasp": {"position": [0.9, 0, 0], "quaternion": [1, 0, 0, 0]}},
            "0.90 m from the middle of the item",
        ),
        ({"grasp": {"position": [0, 0, 0], "quaternion": [1, 1, 0, 0]}}, "expected a length of 1"),
        ({"grasp": {"position": [0, 0, float("nan")], "quaternion": [1, 0, 0, 0]}}, "grasp"),
        ({"pregrasp": {"position": [0, 0, 0], "quaternion": [1, 0, 0, 0]}}, "0.0 mm from the grasp"),
        ({"postgrasp": {"position": [0, 0, 0.6], "quaternion": [1, 0, 0, 0]}}, "600.0 mm from the grasp"),
        ({"extra": 1}, "extra"),
    ],
)
def test_what_is_wrong_in_a_file_is_told_with_its_place(
    tmp_path: Path, change: dict[str, Any], message: str
) -> None:
    path = tmp_path / "grasps.json"
    write_recorded_grasps([coming_from(np.eye(3)[2])], cell(), path)
    values = json.loads(path.read_text())
    values["grasps"][0] |= change
    path.write_text(json.dumps(values, indent=1))
    with pytest.raises(InputError) as refused:
        read_recorded_grasps(path, cell())
    assert message in str(refused.value) and f"{path}:" in str(refused.value)


def test_grasps_of_another_cells_tool_and_files_without_any_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "grasps.json"
    write_recorded_grasps([coming_from(np.eye(3)[2])], cell(), path)
    with pytest.raises(InputError, match="of the tool of cell pr2_belt, not of panda_table"):
        read_recorded_grasps(path, replace(cell(), name="panda_table"))
    path.write_text(json.dumps({"format": "apc grasps", "version": 1, "cell": "pr2_belt", "grasps": []}))
    with pytest.raises(InputError, match="grasps"):
        read_recorded_grasps(path, cell())


def test_a_grasp_that_could_not_be_read_again_is_not_written(tmp_path: Path) -> None:
    far = recorded_along_axis(("dove_beauty_bar", 2016), "open", pose((0.0, 0.0, 0.7)), "stated")
    with pytest.raises(InputError, match=r"0\.70 m from the middle of the item"):
        write_recorded_grasps([far], cell(), tmp_path / "grasps.json")
    assert not (tmp_path / "grasps.json").exists()


# Filters


@pytest.mark.parametrize("degrees", [0.0, 29.0, 31.0, 90.0, 180.0])
def test_what_runs_after_the_item_within_30_degrees_is_rejected(degrees: float) -> None:
    way = np.radians(degrees)
    behind = coming_from(np.array([np.sin(way), np.cos(way), 0.0]))  # the item runs along -y
    assert chase_cosine(behind, np.eye(4), BELT) == pytest.approx(-np.cos(way), abs=1e-12)
    kept = chase_filter([behind], np.eye(4), BELT)
    assert kept == (() if degrees < 30.0 else (behind,))


def test_the_chase_is_judged_where_the_item_lies() -> None:
    behind = coming_from(np.array([0.0, 1.0, 0.0]))
    turned = pose((1.0, 2.0, 3.0), rpy=(0.0, 0.0, np.pi))
    assert chase_filter([behind], np.eye(4), BELT) == ()
    assert chase_filter([behind], turned, BELT) == (behind,)
    assert chase_filter([behind], np.eye(4), 3.0 * BELT) == ()


@pytest.mark.parametrize("velocity", [np.zeros(3), np.array([0.0, np.nan, 0.0])])
def test_without_a_velocity_nothing_chases(velocity: Array) -> None:
    with pytest.raises(InputError, match="the item has no velocity"):
        chase_filter([coming_from(np.eye(3)[2])], np.eye(4), velocity)


def test_the_kinematic_filter_keeps_what_both_poses_are_reached_of() -> None:
    arm, T_world_item = context().arm, on_the_belt()
    from_above, from_below = coming_from(np.eye(3)[2]), coming_from(np.eye(3)[2])
    from_below = replace(from_below, T_item_pregrasp=pose((0.0, 0.0, 1.2), R=DOWN[:3, :3]))
    reached = kinematic_filter([from_below, from_above], T_world_item, arm)
    assert reached and {id(each.grasp) for each in reached} == {id(from_above)}
    state = home().tool_state
    for each in reached:
        assert np.allclose(
            arm.tip(each.q_pregrasp, state), T_world_item @ from_above.T_item_pregrasp, atol=1e-5
        )
        assert np.allclose(arm.tip(each.q_grasp, state), T_world_item @ DOWN, atol=1e-3)
        assert np.abs(each.q_pregrasp - each.q_grasp).max() < 1.0


def test_grasps_of_another_tool_and_items_out_of_reach_leave_none() -> None:
    grasp = coming_from(np.eye(3)[2])
    assert kinematic_filter([replace(grasp, tool_state="half open")], on_the_belt(), context().arm) == ()
    assert kinematic_filter([grasp], pose((5.0, 0.0, 0.7)), context().arm) == ()


def test_each_grasp_that_is_removed_is_told_with_its_filter_and_why() -> None:
    above, behind = coming_from(np.eye(3)[2]), coming_from(np.eye(3)[1])
    from_below = replace(above, T_item_pregrasp=pose((0.0, 0.0, 1.2), R=DOWN[:3, :3]), source="stated")
    far = replace(above, T_item_grasp=pose((0.0, 0.0, 3.0), R=DOWN[:3, :3]))
    other = replace(above, item="crayola_24_ct")
    recorded, item = (other, behind, above, from_below, far), (above.item, above.year)
    found = filter_grasps(recorded, item, on_the_belt(), BELT, context().arm)
    assert found.kept == (above,)
    assert [str(each).split(", ")[0] for each in found.removed] == [
        "recorded grasp 2: chase filter: it runs after the item",
        "recorded grasp 4 (stated): kinematic filter: the arm does not reach its pregrasp in a posture in "
        "which it reaches its grasp",
        "recorded grasp 5: kinematic filter: the arm does not reach its grasp",
    ]
    assert "0 degrees from its velocity, over 30 is asked for" in str(found.removed[0])
    resting = filter_grasps(recorded, item, on_the_belt(), np.zeros(3), context().arm)
    assert behind in resting.kept and len(resting.removed) == 2


def test_what_the_kinematic_filter_finds_of_a_grasp_does_not_depend_on_the_others() -> None:
    arm, above = context().arm, coming_from(np.eye(3)[2])
    other = replace(above, T_item_grasp=pose((0.0, 0.0, 3.0), R=DOWN[:3, :3]))
    alone = kinematic_filter([above], on_the_belt(), arm)
    beside = kinematic_filter([other, above], on_the_belt(), arm)
    assert len(alone) == len(beside) > 0
    for a, b in zip(alone, beside, strict=True):
        assert np.array_equal(a.q_grasp, b.q_grasp) and np.array_equal(a.q_pregrasp, b.q_pregrasp)


def test_all_pregrasps_that_pass_are_one_goal_set_of_the_planner() -> None:
    """The rules of 2013 one after the other: chase, kinematics, ARA* to any of what is left."""
    arm, T_world_item = context().arm, on_the_belt()
    turned = (pose(rpy=(0.0, 0.0, turn)) for turn in (0.0, np.pi / 2, np.pi))
    tilted = [pose(rpy=(np.pi - 0.3, 0.0, 0.0)), DOWN, pose(rpy=(np.pi + 0.3, 0.0, 0.0))]
    grasps = [
        recorded_along_axis(("dove_beauty_bar", 2016), "open", turn @ tilt, "stated")
        for turn in turned
        for tilt in tilted
    ]
    passed = kinematic_filter(chase_filter(grasps, T_world_item, BELT), T_world_item, arm)
    assert len({id(each.grasp) for each in passed}) > 1
    poses = np.array([T_world_item @ each.grasp.T_item_pregrasp for each in passed])
    checker = context().checker_for(empty_scene(cell()), Mode(home().tool_state))
    goals = HandGoals(poses, np.array([each.q_pregrasp for each in passed]))
    plan = plan_on_lattice(arm, checker, home().q, goals)
    assert isinstance(plan, LatticePlan) and checker.is_valid_path(plan.path.waypoints)
    assert np.allclose(arm.tip(plan.path.waypoints[-1], home().tool_state), poses[plan.goal], atol=1e-5)


def on_the_belt() -> Array:
    """Pose of an item in the middle of the left arm's part of the belt."""
    tip = context().arm.tip(context().cell.configurations["belt"].q, home().tool_state)
    return pose((*tip[:2, 3], 0.72))
