"""Tools with one state and with three, and what of their states a cell file cannot mean."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml
from numpy.testing import assert_allclose

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.tool import ACROSS, FIXED, IN_LINE, MOVING, ToolState
from support.cell_copies import CellCopy
from support.other_robots import write_robot
from support.other_tools import ONE_STATE, SLANT, THREE_STATES, with_tool
from support.tool_states import DOWN, STRAIGHT

Refused = Callable[[Callable[[], object]], str]

SLANTED = ToolState("slanted")


def test_a_tool_without_a_joint_has_one_state(cell: Cell, cell_copy: CellCopy) -> None:
    rigid = with_tool(cell_copy, ONE_STATE).load()
    tool = rigid.robot.tool
    assert tool.states == (FIXED,) and tool.default_state == FIXED and tool.joint is None
    assert tool.states_and_moving == (FIXED, MOVING) and tool.range == (0.0, 0.0)
    assert rigid.configurations
    assert {named.tool_state for named in rigid.configurations.values()} == {FIXED}
    assert_allclose(tool.T_lance_tip[FIXED], cell.robot.tool.T_lance_tip[STRAIGHT])
    assert rigid.fingerprint != cell.fingerprint


def test_a_third_state_stands_where_the_file_says(cell: Cell, cell_copy: CellCopy) -> None:
    tool = with_tool(cell_copy, THREE_STATES).load().robot.tool
    assert tool.states == (STRAIGHT, DOWN, SLANTED) and tool.default_state == STRAIGHT
    assert tool.range == (0.0, np.pi / 2)
    assert tool.position(SLANTED) == SLANT and tool.position(MOVING) == 0.0
    assert_allclose(tool.lance_axis(SLANTED), (-np.sin(SLANT), 0.0, np.cos(SLANT)), atol=1e-9)
    for state in (STRAIGHT, DOWN):
        assert_allclose(tool.T_lance_tip[state], cell.robot.tool.T_lance_tip[state])


def test_states_are_found_by_where_the_cup_points_and_not_by_their_names(cell_copy: CellCopy) -> None:
    cell_copy.yaml.replace("{straight: 0.0, down:", "{ahead: 0.0, below:")
    cell_copy.yaml.replace('actions: ["straight", "down"]', 'actions: ["ahead", "below"]')
    text = cell_copy.yaml.path.read_text().replace("tool_state: straight", "tool_state: ahead")
    cell_copy.yaml.path.write_text(text.replace("tool_state: down", "tool_state: below"))
    tool = cell_copy.load().robot.tool
    assert tool.state_with_lance(IN_LINE) == ToolState("ahead")
    assert tool.state_with_lance(ACROSS) == ToolState("below")
    assert tool.state_with_lance(-IN_LINE) is None


@pytest.mark.parametrize("state", [STRAIGHT, DOWN])
def test_the_axes_of_the_lance_are_exact_quarter_turns_of_the_tool(cell: Cell, state: ToolState) -> None:
    R = cell.robot.tool.R_tip_lance(state)
    assert_allclose(R.T @ R, np.eye(3), atol=0.0)
    assert np.linalg.det(R) == 1.0 and set(np.abs(R).ravel()) == {0.0, 1.0}
    assert_allclose(cell.robot.tool.T_lance_tip[state][:3, :3] @ R[:, 0], (0.0, 0.0, 1.0), atol=1e-12)


@pytest.mark.parametrize("state", [STRAIGHT, DOWN])
def test_from_the_tip_a_straight_way_meets_the_axis_of_the_lance(cell: Cell, state: ToolState) -> None:
    tool = cell.robot.tool
    T, way = tool.T_lance_tip[state], tool.tip_to_lance(state)
    assert_allclose((T @ [*way, 1.0])[:2], 0.0, atol=1e-12)  # the lance runs along the flange's z
    assert way @ tool.lance_axis(state) == 0.0


def test_a_lance_that_is_mounted_aslant_points_where_it_is_turned_to(tmp_path: Path) -> None:
    folder = write_robot(tmp_path)
    before = load_cell(folder).robot.tool
    text = (folder / "cell.yaml").read_text()
    content = yaml.safe_load(text)
    content["tool"]["T_flange_tool"] = {"xyz": [0.02, -0.01, 0.01], "rpy": [0.3, 1.2, -0.7]}
    (folder / "cell.yaml").write_text(yaml.safe_dump(content, sort_keys=False))
    after = load_cell(folder).robot.tool
    assert_allclose(after.lance_axis(FIXED), (0.0, 0.0, 1.0), atol=1e-9)
    assert_allclose(after.tip_to_lance(FIXED), before.tip_to_lance(FIXED), atol=1e-9)
    assert_allclose(after.R_tip_lance(FIXED), before.R_tip_lance(FIXED), atol=1e-9)


def test_a_configuration_without_a_state_is_for_the_first(cell_copy: CellCopy) -> None:
    cell_copy.yaml.replace("name: home, kind: home, tool_state: straight,", "name: home, kind: home,")
    assert cell_copy.load().configurations["home"].tool_state == STRAIGHT


MISTAKES = {
    "no positions": (f"  states: {{straight: 0.0, down: {np.pi / 2}}}\n", "",
                     "tool.states: expected a position by state, got nothing; add it"),
    "no joint": ("  joint: cup_pivot\n", "",
                 "tool.joint: expected the joint that has these positions, got nothing; add it"),
    "the name that is taken": ("{straight: 0.0,", "{straight: 0.0, moving: 1.0,",
                               "tool.states.moving: moving means that the tool is between two"),
    "an unknown state": ("kind: home, tool_state: straight", "kind: home, tool_state: strait",
                         "configurations[0].tool_state: no state of the tool is named 'strait'; did you"),
    "not the last joint": ("  joint: cup_pivot", "  joint: joint_t",
                           "tool.joint: expected the last joint of the chain, 'cup_pivot', got"),
    "an action that is no state": ('["straight", "down"]}', '["straight", "down", "up"]}',
                                   "devices.cup_pivot.actions[2]: no state of the tool is named 'up'"),
    "a state without an action": ('["straight", "down"]}', '["straight"]}',
                                  "devices.cup_pivot.actions: no action leads to down; add one"),
    "no state at all": (f"{{straight: 0.0, down: {np.pi / 2}}}", "{}", "tool.states: expected"),
}  # fmt: skip


@pytest.mark.parametrize("what", MISTAKES)
def test_what_states_cannot_mean_is_told(cell_copy: CellCopy, refused: Refused, what: str) -> None:
    old, new, problem = MISTAKES[what]
    cell_copy.yaml.replace(old, new)
    assert problem in refused(cell_copy.load)
