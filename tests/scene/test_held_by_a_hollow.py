"""An item is held by the bottom of its hollow: what surrounds the tool there is not in it."""

from __future__ import annotations

from pathlib import Path

import pytest

from pickcli.cell.cell import Cell
from pickcli.errors import InputError
from pickcli.geometry import pose
from pickcli.scene.scene import HeldItem, PoseNoise, Scene
from pickcli.scene.scene_file import read_scene, write_scene

BOWL = "platinum_pets_dog_bowl"


def scene_with(cell: Cell, behind: float, aside: float) -> Scene:
    """A bowl with the middle of its box behind the tip, which points into the bowl."""
    T = pose((aside, 0.0, -behind), rpy=(3.141592653589793, 0.0, 0.0))
    return Scene(cell, cell.T_world_pod, (), PoseNoise(), held=HeldItem(BOWL, cell.item(BOWL), T))


def test_a_bowl_held_by_its_inside_is_a_scene(cell: Cell, tmp_path: Path) -> None:
    item = cell.item(BOWL)
    behind = -item.hollows[0].height(item.shape)
    write_scene(scene_with(cell, behind, 0.0), tmp_path / "held.json")
    back = read_scene(tmp_path / "held.json", cell)
    assert back.held is not None and back.held.id == BOWL


def test_with_its_wall_in_the_tool_it_is_refused(cell: Cell, tmp_path: Path) -> None:
    item = cell.item(BOWL)
    behind = -item.hollows[0].height(item.shape)
    write_scene(scene_with(cell, behind, 0.05), tmp_path / "held.json")
    with pytest.raises(InputError, match="behind the tip of the cup, into the tool"):
        read_scene(tmp_path / "held.json", cell)
