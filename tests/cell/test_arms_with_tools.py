"""Two arms with a tool each, a cup and a gripper: KTH's Baxter."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from pickcli.cell.cell import ArmState
from pickcli.cell.cell_file import load_workcell
from pickcli.cell.data_path import data_path
from pickcli.cell.tool import ToolState
from pickcli.cell.workcell import Workcell
from pickcli.errors import InputError
from pickcli.geometry import inverse
from pickcli.verification.forward_kinematics import link_poses

KTH = data_path() / "cells/apc2016_kth"
OPEN, CLOSED = 0.056, 0.0145  # m between the fingers, as the cell states them


def both_arms() -> dict[str, Any]:
    content: dict[str, Any] = yaml.safe_load((KTH / "cell.yaml").read_text())
    return content


def written(folder: Path, content: dict[str, Any]) -> Path:
    (folder / "cell.yaml").write_text(json.dumps(content, indent=1))
    shutil.copyfile(KTH / "robot.urdf", folder / "robot.urdf")
    return folder


@pytest.fixture(scope="module")
def workcell(tmp_path_factory: pytest.TempPathFactory) -> Workcell:
    return load_workcell(written(tmp_path_factory.mktemp("kth"), both_arms()))


def test_each_arm_has_its_own_tool_and_devices(workcell: Workcell) -> None:
    right, left = workcell.arms["right"], workcell.arms["left"]
    assert right.robot.tool.suction_cup is not None and right.robot.tool.gripper is None
    assert left.robot.tool.gripper is not None and left.robot.tool.suction_cup is None
    assert list(right.devices) == ["pump", "valve", "vacuum_sensor"] and list(left.devices) == ["gripper"]
    assert workcell.parked["left"].tool_state == ToolState("open")


def test_the_fingers_of_an_arm_that_stands_are_where_its_tool_state_has_them(workcell: Workcell) -> None:
    def apart(state: str) -> float:
        seen = workcell.cell("right", [ArmState("left", workcell.parked["left"].q, ToolState(state))])
        names = [link.name for link in seen.robot.links]
        hand, *fingers = (
            link_poses(seen.robot, np.zeros((1, 7)))[names.index(name), 0]
            for name in ("left_gripper_base_link", "l_gripper_l_finger", "l_gripper_r_finger")
        )
        left, right = ((inverse(hand) @ finger)[1, 3] for finger in fingers)
        return float(left - right)

    assert apart("open") - apart("closed") == pytest.approx(OPEN - CLOSED, abs=1e-9)


def test_the_state_of_the_other_tool_is_part_of_the_fingerprint(workcell: Workcell) -> None:
    q = workcell.parked["left"].q
    closed = workcell.cell("right", [ArmState("left", q, ToolState("closed"))])
    assert closed.fingerprint != workcell.arms["right"].fingerprint


MISTAKES: dict[str, tuple[Callable[[dict[str, Any]], object], str]] = {
    "width": (
        lambda arms: arms["left"]["tool"]["states"].update(open=0.2),
        "arms.left.tool.states.open: expected 0.0145 to",
    ),
    "finger": (
        lambda arms: arms["left"]["tool"].update(fingers=["l_finger", "l_gripper_r_finger"]),
        "arms.left.tool.fingers[0]: no link is named 'l_finger'",
    ),
    "key of the other kind": (
        lambda arms: arms["left"]["tool"].update(cup_radius=0.01),
        "arms.left.tool.cup_radius: unknown key",
    ),
    "kind": (
        lambda arms: arms["left"]["tool"].update(kind="griper"),
        "arms.left.tool.kind: expected suction or gripper, got 'griper'",
    ),
    "cup": (
        lambda arms: arms["right"]["tool"].update(cup_link="right_cap"),
        "arms.right.tool.cup_link: no link is named 'right_cap'",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_about_a_tool_names_its_arm(name: str, tmp_path: Path) -> None:
    change, told = MISTAKES[name]
    content = both_arms()
    change(content["arms"])
    with pytest.raises(InputError) as refused:
        load_workcell(written(tmp_path, content))
    assert told in str(refused.value)
