"""What is mounted beside the tool: it moves with it, and the held item must keep clear of it."""

from __future__ import annotations

import shutil
from pathlib import Path

from pickcli.cell.cell_file import load_cell
from pickcli.cell.data_path import data_path
from pickcli.collision.attached_item import AttachedItem
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import pose
from pickcli.scene.scene import empty_scene

BRACKET = """
  <joint name="bracket_mount" type="fixed">
    <parent link="link_t"/>
    <child link="bracket"/>
    <origin xyz="-0.2 0 0.1"/>
  </joint>
  <link name="bracket">
    <inertial><mass value="0.1"/></inertial>
    <collision><geometry><sphere radius="0.03"/></geometry></collision>
  </link>
</robot>"""


def test_a_held_item_keeps_clear_of_a_bracket_on_the_flange(tmp_path: Path) -> None:
    folder = tmp_path / "cell"
    shutil.copytree(data_path() / "cells" / "apc2016_delft", folder)
    urdf = (folder / "robot.urdf").read_text()
    (folder / "robot.urdf").write_text(urdf.replace("</robot>", BRACKET))
    cell = load_cell(folder)
    home, item = cell.configurations["home"], cell.item("dove_beauty_bar")
    model, scene = CollisionModel(cell), empty_scene(cell)
    in_front, on_the_bracket = pose((0.0, 0.0, 0.05)), pose((-0.2, 0.0, 0.1 - 0.54))
    for T_tip_item, is_free in ((in_front, True), (on_the_bracket, False)):
        held = AttachedItem(item, T_tip_item, 0.0, item.name)
        checker = SceneChecker(model, scene, home.tool_state, held)
        assert checker.is_valid(home.q) == is_free
    assert "bracket" in str(checker.explain(home.q))
