"""A cell with several arms: what each of them sees, and what a file may not say of them."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pickcli.cell.cell import ArmState
from pickcli.cell.cell_file import load_cell, load_workcell
from pickcli.cell.tool import FIXED
from pickcli.cell.workcell import Workcell
from pickcli.errors import InputError, UnknownNameError
from pickcli.verification.forward_kinematics import link_poses
from support.two_arms import content, joints, write_cell, write_two_arms
from support.two_robots import ASIDE, write_two_robots
from support.two_robots import content as two_robots

AWAY = np.array([0.7, -0.4, 0.9])


@pytest.fixture(scope="module")
def workcell(tmp_path_factory: pytest.TempPathFactory) -> Workcell:
    return load_workcell(write_two_arms(tmp_path_factory.mktemp("arms")))


def test_each_arm_plans_its_own_joints(workcell: Workcell) -> None:
    assert list(workcell.arms) == ["left", "right"]
    for name, cell in workcell.arms.items():
        assert (cell.arm, list(cell.robot.joint_names)) == (name, joints(name))
        assert cell.robot.tool.last_link == f"{name}_hand"
        assert [state.arm for state in cell.others] == [other for other in workcell.arms if other != name]
        assert list(cell.configurations) == ["home", "parked", "across"]


def test_the_preferred_arm_comes_first(tmp_path: Path) -> None:
    folder, changed = write_two_arms(tmp_path), content()
    changed["arms"]["left"]["preference"] = 3
    write_cell(folder, changed)
    assert list(load_workcell(folder).arms) == ["right", "left"]


def test_the_others_are_links_where_their_own_cell_has_them(workcell: Workcell) -> None:
    """One arm's fixed links against the other arm's own kinematics, at any configuration of the other."""
    seen = workcell.cell("left", [ArmState("right", AWAY, FIXED)])
    own = workcell.arms["right"]
    for cell, q in ((seen, AWAY), (workcell.arms["left"], workcell.parked["right"].q)):
        fixed = poses(cell.robot, np.zeros(3))
        moved = poses(own.robot, q)
        for name in ("right_shoulder", "right_upper", "right_lower", "right_hand"):
            np.testing.assert_allclose(fixed[name], moved[name], atol=1e-12)


def poses(robot: Any, q: np.ndarray) -> dict[str, np.ndarray]:
    names = (link.name for link in robot.links)
    return dict(zip(names, link_poses(robot, q[None])[:, 0], strict=True))


def test_in_the_robot_of_all_arms_each_moves_as_its_own_cell_has_it(workcell: Workcell) -> None:
    """Drawings move all arms at once: one arm's joints by its own cell, the other at its parked ones."""
    robot, names = workcell.robot, workcell.moving_joints
    assert names == (*joints("left"), *joints("right"))
    all_move = replace(robot, joint_names=names)
    for own, other in (("left", "right"), ("right", "left")):
        at = dict(zip(joints(own), AWAY, strict=True))
        at |= dict(zip(joints(other), workcell.parked[other].q, strict=True))
        drawn = poses(all_move, np.array([at[name] for name in names]))
        for name, T in poses(workcell.arms[own].robot, AWAY).items():
            np.testing.assert_allclose(drawn[name], T, atol=1e-12)


def test_where_the_others_stand_is_part_of_the_fingerprint_but_not_of_what_scenes_carry(
    workcell: Workcell,
) -> None:
    parked = workcell.arms["left"]
    seen = workcell.cell("left", [ArmState("right", AWAY, FIXED)])
    as_parked = workcell.cell("left", [workcell.parked["right"]])
    prints = {cell.fingerprint for cell in (*workcell.arms.values(), seen)}
    assert len(prints) == 3 and as_parked.fingerprint == parked.fingerprint
    assert len({cell.scene_fingerprint for cell in (*workcell.arms.values(), seen)}) == 1
    assert parked.scene_fingerprint not in prints


def test_a_cell_of_one_arm_is_as_before() -> None:
    workcell = load_workcell("apc2016_delft")
    (cell,) = workcell.arms.values()
    assert (cell.arm, cell.others, workcell.parked) == ("", (), {})
    assert cell.scene_fingerprint == cell.fingerprint == load_cell("apc2016_delft").fingerprint
    with pytest.raises(InputError, match="has one arm, which needs no name; leave out 'left'"):
        workcell.cell("left")


def test_an_arm_must_be_named_and_exist(workcell: Workcell) -> None:
    with pytest.raises(InputError, match="has the arms left and right; say which with --arm NAME"):
        load_cell(workcell.preferred.path)
    with pytest.raises(UnknownNameError, match=r"'lefd'.*did you mean 'left'"):
        workcell.cell("lefd")
    with pytest.raises(InputError, match="arm left: is the one that moves"):
        workcell.cell("left", [ArmState("left", AWAY, FIXED)])


def _second_owner(c: dict[str, Any]) -> None:
    c["arms"]["right"]["joints"].insert(0, "left_yaw")


def _of_no_arm(c: dict[str, Any]) -> None:
    c["configurations"][0].pop("arm")


Change = Callable[[dict[str, Any]], object]
MISTAKES: dict[str, tuple[Change, str]] = {
    "joint in two arms": (
        _second_owner,
        "arms.right.joints: 'left_yaw' is a joint of arm left too; leave it out, or list",
    ),
    "no place to park": (
        lambda c: c["arms"]["left"].pop("parked"),
        "arms.left.parked: expected the configuration in which it stands while another arm moves, got",
    ),
    "parks nowhere": (
        lambda c: c["arms"]["left"].update(parked="parkt"),
        "arms.left.parked: no configuration of arm left is named 'parkt'; did you mean 'parked'?",
    ),
    "unknown arm": (
        lambda c: c["configurations"][0].update(arm="lefd"),
        "configurations[0].arm: no arm is named 'lefd'; did you mean 'left'?",
    ),
    "of no arm": (
        _of_no_arm,
        "configurations[0].arm: expected the arm that it is of (left, right), got nothing; add it",
    ),
    "joints of the robot": (
        lambda c: c["robot"].update(joints=joints("left")),
        "robot.joints: is of a cell with one arm; state it under arms",
    ),
    "posture of an arm": (
        lambda c: c["robot"]["posture"].update(left_yaw=0.0),
        "robot.posture.left_yaw: is a joint of arm left; its configurations say where it stands",
    ),
    "posture is missing": (
        lambda c: c["robot"]["posture"].clear(),
        "robot.posture.neck: is not planned; expected where it stands",
    ),
    "wrong order": (
        lambda c: c["arms"]["right"]["joints"].reverse(),
        "arms.right.joints: expected the chain's moving joints but the tool's: right_yaw, right_pitch",
    ),
    "unknown tip": (
        lambda c: c["arms"]["right"].update(tip="right_hund"),
        "arms.right.tip: no link is named 'right_hund'; did you mean 'right_hand'?",
    ),
    "beyond its limits": (
        lambda c: c["configurations"][4].update(q=[5.0, 0.0, 0.0]),
        "configurations[4].q[0]: expected right_yaw in -2 to 2 rad, got 5",
    ),
    "limits are missing": (
        lambda c: c["joint_limits"].pop("right_elbow"),
        "joint_limits.right_elbow: expected velocity, acceleration and jerk limits, got nothing",
    ),
    "device of nobody": (
        lambda c: c["devices"].update(pump={"kind": "pump", "lead": 1.0, "actions": ["a"], "arm": "middle"}),
        "devices.pump.arm: no arm is named 'middle'",
    ),
    "no joints": (
        lambda c: c.pop("arms"),
        "robot.joints: expected the planned joints, base outwards, got nothing; add it, or arms",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_told_once_where_it_stands(name: str, tmp_path: Path) -> None:
    change, told = MISTAKES[name]
    folder, changed = write_two_arms(tmp_path), content()
    change(changed)
    write_cell(folder, changed)
    with pytest.raises(InputError) as refused:
        load_workcell(folder)
    lines = [line for line in str(refused.value).splitlines() if told in line]
    assert len(lines) == 1, str(refused.value)
    assert lines[0].startswith(f"{folder / 'cell.yaml'}:")
    if name != "no joints":  # then every configuration names an arm for nothing
        assert len(str(refused.value).splitlines()) == 1, str(refused.value)


def test_mistakes_of_both_arms_are_told_at_once(tmp_path: Path) -> None:
    folder, changed = write_two_arms(tmp_path), content()
    for side in ("left", "right"):
        changed["joint_limits"].pop(f"{side}_yaw")
    write_cell(folder, changed)
    with pytest.raises(InputError, match=r"(?s)joint_limits\.left_yaw.*joint_limits\.right_yaw"):
        load_workcell(folder)


ROBOT_MISTAKES: dict[str, tuple[Change, str]] = {
    "two of a name": (
        lambda c: c["robots"]["right"].update(prefix="left_"),
        "robots.right: link 'left_rail_base' is one of robot left too; give it a prefix",
    ),
    "one robot and several": (
        lambda c: c["robot"].update(urdf="robot.urdf"),
        "robot.urdf: is of a cell with one robot; state it under robots",
    ),
    "no arms": (
        lambda c: c.update(arms={}, configurations=[]),
        "robots: the joints of several robots are those of several arms; add arms",
    ),
    "no file": (
        lambda c: c["robots"]["left"].update(urdf="robo.urdf"),
        "robots.left.urdf: 'robo.urdf': no such file in the cell's folder",
    ),
    "no place": (
        lambda c: c["robots"]["left"].pop("T_world_base"),
        "robots.left.T_world_base: expected where its root link stands, got nothing; add it",
    ),
    "unknown key of a tool": (
        lambda c: c["arms"]["left"]["tool"].update(cup_radios=1),
        "arms.left.tool.cup_radios: unknown key; did you mean 'cup_radius'?",
    ),
    "a figure of a tool": (
        lambda c: c["arms"]["left"]["tool"].update(cup_radius=-1.0),
        "arms.left.tool.cup_radius: expected",
    ),
    "state of a tool": (
        lambda c: c["configurations"][0].update(tool_state="stright"),
        "configurations[0].tool_state: no state of the tool is named 'stright'",
    ),
}


@pytest.mark.parametrize("name", ROBOT_MISTAKES)
def test_a_mistake_about_several_robots_is_told_once(name: str, tmp_path: Path) -> None:
    change, told = ROBOT_MISTAKES[name]
    folder, changed = write_two_robots(tmp_path), two_robots()
    change(changed)
    (folder / "cell.yaml").write_text(json.dumps(changed, indent=1))
    with pytest.raises(InputError) as refused:
        load_workcell(folder)
    (line,) = str(refused.value).splitlines()
    assert told in line and line.startswith(f"{folder / 'cell.yaml'}:")


def test_a_cell_of_one_robot_says_which_and_where(tmp_path: Path) -> None:
    folder, changed = write_two_arms(tmp_path), content()
    changed["robot"].pop("urdf")
    changed["robot"].pop("T_world_base")
    write_cell(folder, changed)
    with pytest.raises(InputError) as refused:
        load_workcell(folder)
    for told in ("robot.urdf: expected the URDF's path", "robot.T_world_base: expected where"):
        assert told in str(refused.value)


def test_each_robot_stands_where_the_cell_puts_it(tmp_path: Path) -> None:
    workcell = load_workcell(write_two_robots(tmp_path))
    left, right = (poses(workcell.arms[side].robot, np.zeros(8)) for side in ("left", "right"))
    np.testing.assert_allclose(left["left_cup"] - right["right_cup"], _moved(2 * ASIDE), atol=1e-12)
    single = poses(load_cell("apc2016_delft").robot, np.zeros(8))
    np.testing.assert_allclose(left["left_cup"] - single["cup"], _moved(ASIDE), atol=1e-12)


def _moved(y: float) -> np.ndarray:
    T = np.zeros((4, 4))
    T[1, 3] = y
    return T
