"""Two tools on one flange: two arms with the same joints, each a part of what the other moves."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell_file import load_workcell
from pickcli.cell.data_path import data_path
from pickcli.cell.tool import MOVING, ToolState
from pickcli.cell.workcell import Workcell
from pickcli.collision.attached_item import AttachedItem
from pickcli.collision.checker import SceneChecker
from pickcli.collision.motion_segment import Mode
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import InputError
from pickcli.geometry import pose
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import empty_scene
from pickcli.verification.forward_kinematics import link_poses
from pickcli.verification.verify import verify

CELL = "apc2016_delft_pinch"


@pytest.fixture(scope="module")
def workcell() -> Workcell:
    return load_workcell(CELL)


def poses(workcell: Workcell, arm: str, Q: np.ndarray) -> dict[str, np.ndarray]:
    robot = workcell.arms[arm].robot
    return dict(zip((link.name for link in robot.links), link_poses(robot, Q), strict=True))


def test_the_other_tool_moves_along_in_the_state_in_which_it_parks(workcell: Workcell) -> None:
    limits = workcell.arms["suction"].robot.limits
    Q = np.random.default_rng(0).uniform(limits.lower, limits.upper, (20, len(limits.lower)))
    by_cup, by_fingers = poses(workcell, "suction", Q), poses(workcell, "fingers", Q)
    for name in ("hand", "lance", "link_t"):
        np.testing.assert_allclose(by_cup[name], by_fingers[name], atol=1e-12)
    for link in ("left_finger_link", "right_finger_link"):  # parked closed
        in_hand = np.linalg.inv(by_cup["hand"]) @ by_cup[link]
        np.testing.assert_allclose(in_hand, np.tile(pose((0, 0, 0.025)), (len(Q), 1, 1)), atol=1e-12)


def test_what_the_cup_holds_keeps_clear_of_the_fingers(workcell: Workcell) -> None:
    cell = workcell.arms["suction"]
    home, scene = cell.configurations["home"], empty_scene(cell)
    item = cell.item("dove_beauty_bar")
    tips = PlanningContext(cell).arm.tip(home.q, home.tool_state)
    finger = poses(workcell, "suction", home.q[None])["left_finger_link"][0]
    for T, is_free in ((tips @ pose((0, 0, 0.05)), True), (finger, False)):
        held = AttachedItem(item, np.linalg.inv(tips) @ T, 0.0, item.name)
        mode = Mode(home.tool_state, held)
        checker = SceneChecker(CollisionModel(cell), scene, mode.tool_state, mode.attached, mode.contacts)
        assert checker.is_valid(home.q) == is_free
    assert "finger" in str(checker.explain(home.q)) or "hand" in str(checker.explain(home.q))


def changed(tmp_path: Path, old: str, new: str) -> Path:
    folder = tmp_path / CELL
    shutil.copytree(data_path() / "cells" / CELL, folder)
    text = (folder / "cell.yaml").read_text()
    before, fingers, after = text.partition("  fingers:\n")
    place = after if old in after else ""
    assert place
    (folder / "cell.yaml").write_text(before + fingers + after.replace(old, new, 1))
    return folder


def test_tools_that_park_apart_or_share_only_some_joints_are_refused(tmp_path: Path) -> None:
    apart = changed(tmp_path / "a", "parked: home", "parked: bin_A")
    with pytest.raises(InputError, match="on the joints of suction, which is parked at other positions"):
        load_workcell(apart)
    some = changed(tmp_path / "b", "joint_b, joint_t]", "joint_b]")
    with pytest.raises(
        InputError, match="'rail' is a joint of arm suction too; leave it out, or list the same"
    ):
        load_workcell(some)


def test_both_tools_have_the_same_scenes_and_other_fingerprints(workcell: Workcell) -> None:
    cup, fingers = workcell.arms["suction"], workcell.arms["fingers"]
    assert cup.parked_fingerprint == fingers.parked_fingerprint and cup.fingerprint != fingers.fingerprint
    assert replace(empty_scene(cup), cell=fingers).cell.places.keys() == cup.places.keys()


def test_fingers_close_on_the_way_to_where_they_are_parked(workcell: Workcell) -> None:
    cell = workcell.arms["fingers"]
    scene, parked = empty_scene(cell), workcell.parked["fingers"]
    start = Start(cell.configurations["bin_E"].q, ToolState("open"))
    plan = plan_move(PlanningContext(cell), scene, start, MoveGoal(parked.q, parked.tool_state))
    assert [event.action for event in plan.events] == ["closed"]
    assert [segment.tool_state for segment in plan.segments] == [MOVING, ToolState("closed")]
    assert verify(plan, scene).reasons == ()
