"""The Panda with its hand, as others prepared it: its cell gets the gripper, moves and is verified."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.tool import ToolState
from robot_setup.test_example_robots import FIGURES, ROBOTS, robots, timed

HAND = """tool:
  kind: gripper
  flange_link: panda_link8
  hand_link: panda_hand
  T_hand_tip: {xyz: [0, 0, 0.1034], rpy: [0, 0, 0]}
  fingers: [panda_leftfinger, panda_rightfinger]
  states: {open: 0.08, closed: 0.0}
  pad_size: [0.0175, 0.0175]
  force: 70
  friction: 0.5
  closing_speed: 0.1
  contact_speed: 0.1
"""


def with_hand(cell: Path) -> None:
    """Put the hand into an initialised cell as its tool, in place of the tip and of fingers that stand."""
    path = cell / "cell.yaml"
    text = re.sub(r"^  tip: .*\n  posture:.*\n    panda_finger_joint1.*\n", "", path.read_text(), flags=re.M)
    path.write_text(text + HAND)


@pytest.mark.slow
def test_the_hand_of_the_panda_is_a_tool(tmp_path: Path) -> None:
    panda, cell, move = ROBOTS["panda"], tmp_path / "panda", tmp_path / "move.json"
    assert panda.srdf is not None
    timed(("init", cell, "--urdf", robots() / panda.urdf, "--srdf", robots() / panda.srdf, *FIGURES))
    with_hand(cell)
    tool = load_cell(cell).robot.tool
    assert tool.joints == ("panda_finger_joint1", "panda_finger_joint2")
    assert tool.joint_position("panda_finger_joint2", ToolState.of_width(0.05)) == 0.025
    planned = timed(("plan-move", "--cell", cell, "--from", "home", "--to", "parked", "-o", move))
    assert "certified" in planned.out
    assert "accepted" in timed(("verify", move, "--cell", cell)).out
    told = json.loads(timed(("inspect", cell, "--json")).out)
    assert told["tool"] == {"kind": "gripper", "state open": 0.08, "state closed": 0.0}
