"""The item by itself: displaced as it says, free where it is."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.collision.free_flyer import FreeItem, FreeItemChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array, pose, rotation_rpy
from support.solid_helpers import MakeScene

AXES = pose(rpy=[0.02, -0.01, 0.3])[:3, :3]


def put_in(cell: Cell, x: float, y: float, z: float, rpy: tuple[float, float, float] = (0, 0, 0)) -> Array:
    return np.asarray(cell.T_world_place(cell.pod.bins["bin_E"]) @ pose([x, y, z], rpy=rpy))


def moved(T: Array, d: Array) -> Array:
    turn = AXES @ rotation_rpy(d[5], d[4], d[3]) @ AXES.T
    return pose(T[:3, 3] + AXES @ d[:3], R=turn @ T[:3, :3])


@pytest.mark.parametrize("name", ["crayola_24_ct", "folgers_classic_roast_coffee"])
def test_an_item_displaced_is_an_item_that_stands_there(
    cell: Cell, model: CollisionModel, make_scene: MakeScene, name: str
) -> None:
    scene, item, rng = make_scene(), cell.item(name), np.random.default_rng(1)
    T = put_in(cell, 0.2, 0.0, 0.08, (0.1, -0.2, 0.7))
    flying = FreeItemChecker(model, scene, FreeItem(item, T, AXES, 0.004))
    for d in rng.uniform(-1.0, 1.0, (40, 6)) * (0.15, 0.1, 0.08, 0.5, 0.3, 1.6):
        there = FreeItemChecker(model, scene, FreeItem(item, moved(T, d), AXES, 0.004))
        ours, theirs = flying.clearance(d), there.clearance(np.zeros(6))
        assert ours.distance == pytest.approx(theirs.distance, abs=1e-6)
        assert ours.b == theirs.b


def test_one_by_one_or_all_at_once_is_the_same(
    cell: Cell, model: CollisionModel, make_scene: MakeScene
) -> None:
    free = FreeItem(cell.item("dove_beauty_bar"), put_in(cell, 0.2, 0.0, 0.08), AXES, 0.0)
    flying = FreeItemChecker(model, make_scene(), free)
    D = np.random.default_rng(2).uniform(-1.0, 1.0, (200, 6)) * (0.3, 0.2, 0.1, 0.5, 0.3, 1.6)
    are_free = flying.are_valid(D)
    assert are_free.tolist() == [flying.is_valid(d) for d in D]
    assert 0 < are_free.sum() < len(D)
