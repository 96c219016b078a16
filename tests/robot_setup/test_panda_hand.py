"""The Panda with its hand, as others prepared it: its cell gets the gripper, moves and is verified."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.tool import ToolState
from robot_setup.test_example_robots import FIGURES, ROBOTS, robots, timed
from support.tool_frame import tip_in_flange

OPEN = ToolState("open")
FIGURES_OF_HAND = ("force=70", "friction=0.5", "closing_speed=0.1")


@pytest.mark.slow
def test_the_hand_of_the_panda_is_a_tool(tmp_path: Path) -> None:
    panda, cell, move = ROBOTS["panda"], tmp_path / "panda", tmp_path / "move.json"
    assert panda.srdf is not None
    hand = ("--tool", "gripper", *(word for each in FIGURES_OF_HAND for word in ("--tool-figure", each)))
    timed(("init", cell, "--urdf", robots() / panda.urdf, "--srdf", robots() / panda.srdf, *FIGURES, *hand))
    loaded = load_cell(cell)
    tool = loaded.robot.tool
    # The maker's manual: the middle between the pads is 103.4 mm out of the hand, the pads 17.5 x 18.5 mm.
    np.testing.assert_allclose(tip_in_flange(loaded, OPEN)[:3, 3], (0.0, 0.0, 0.1034), atol=5e-4)
    assert tool.gripper is not None
    np.testing.assert_allclose(tool.gripper.pad, (0.0175, 0.0185), atol=1.1e-3)
    assert tool.joints == ("panda_finger_joint1", "panda_finger_joint2")
    assert tool.joint_position("panda_finger_joint2", ToolState.of_width(0.05)) == 0.025
    planned = timed(("plan-move", "--cell", cell, "--from", "home", "--to", "parked", "-o", move))
    assert "certified" in planned.out
    assert "accepted" in timed(("verify", move, "--cell", cell)).out
    told = json.loads(timed(("inspect", cell, "--json")).out)
    assert told["tool"] == {"kind": "gripper", "state open": 0.08, "state closed": 0.0}
