"""Coming to rest: the laws a settled scene keeps, and the reasons of those that do not settle."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.errors import Reason
from pickcli.geometry import pose
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.simulation.settle import settle
from support.pedestal import cube


@pytest.fixture(scope="module")
def empty(cell: Cell) -> Scene:
    return Scene(cell, cell.T_world_pod, (), PoseNoise())


def in_bin(scene: Scene, xyz: tuple[float, float, float], side: float = 0.05) -> PlacedItem:
    cell_bin = scene.cell.pod.bins["bin_E"]
    return PlacedItem("cube", cube(side), "bin_E", cell_bin.T_carrier_place @ pose(xyz))


def test_a_dropped_cube_rests_on_the_floor(empty: Scene) -> None:
    placed = in_bin(empty, (0.32, 0.0, 0.02))
    rested = settle(empty, (placed,))
    assert not isinstance(rested, Reason)
    floor = empty.cell.pod.bins["bin_E"].T_carrier_place[2, 3] + empty.cell.pod.bins["bin_E"].room.floor_back
    assert rested[0].T_world_item[2, 3] - 0.025 == pytest.approx(floor, abs=5e-4)
    again = settle(empty, rested)
    assert not isinstance(again, Reason)
    assert np.linalg.norm(again[0].T_world_item[:3, 3] - rested[0].T_world_item[:3, 3]) < 5e-4


def test_reasons_name_the_item_and_the_bin(empty: Scene) -> None:
    outside = settle(empty, (in_bin(empty, (-0.2, 0.0, 0.05)),))
    assert isinstance(outside, Reason)
    assert "cube" in str(outside) and "bin_E" in str(outside)
    sticking = settle(empty, (in_bin(empty, (0.02, 0.0, 0.06), side=0.08),))
    assert isinstance(sticking, Reason)


def test_two_in_one_place_overlap_or_fly(empty: Scene) -> None:
    big = Shape(ShapeKind.BOX, (0.2, 0.2, 0.15))
    one = in_bin(empty, (0.3, 0.0, 0.06))
    one = replace(one, item=replace(one.item, shape=big))
    two = replace(one, id="cube#2")
    assert isinstance(settle(empty, (one, two)), Reason)
