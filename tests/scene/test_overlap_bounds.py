"""Overlaps just beyond the tolerance in corners and on edges, and what is told of many mistakes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, pose
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise
from pickcli.scene.scene_file import _coarse, read_scene, write_scene
from pickcli.scene.solid_overlap import TOUCH, PosedSolid, overlap_depth
from support.scene_files import make_scene

Refused = Callable[[Callable[[], object]], str]

CUBE = Shape(ShapeKind.BOX, (0.2, 0.2, 0.2))
BALL = Shape(ShapeKind.SPHERE, (0.05,))
CAN = Shape(ShapeKind.CYLINDER, (0.05, 0.2))
T = pose((0.3, -0.2, 0.1), rpy=(0.4, 1.0, -2.0))


def depths(a: Shape, T_a: Array, b: Shape, T_b: Array, tolerance: float) -> tuple[float, float]:
    """As it is told of the one and of the other."""
    one, other = PosedSolid(a, T_a), PosedSolid(b, T_b)
    return overlap_depth(one, other, tolerance), overlap_depth(other, one, tolerance)


@pytest.mark.parametrize(("share", "is_deep"), [(0.99, False), (1.01, True), (1.3, True), (3.0, True)])
def test_a_ball_in_a_corner_is_as_deep_as_its_radius_exceeds_its_distance(
    share: float, is_deep: bool
) -> None:
    """Along the diagonal of the corner, along that of an edge, and across a face."""
    for outwards in ((1.0, 1.0, 1.0), (1.0, 0.0, 1.0), (0.0, 1.0, 0.0)):
        n = np.array(outwards) / np.linalg.norm(outwards)
        ball = T @ pose(0.1 * np.array(outwards) + (0.05 - share * TOUCH) * n)
        expected = share * TOUCH * is_deep
        assert depths(CUBE, T, BALL, ball, TOUCH) == pytest.approx((expected, expected), abs=1e-9)


@pytest.mark.parametrize(("share", "is_deep"), [(0.99, False), (1.01, True), (1.2, True), (2.0, True)])
def test_crossing_edges_of_boxes_are_as_deep_as_they_reach_past_each_other(
    share: float, is_deep: bool
) -> None:
    """No face of either lies across the way out: a box that loses a side on every face would be apart."""
    below = T @ pose(rpy=(np.pi / 4, 0.0, 0.0))
    above = T @ pose((0.0, 0.0, 0.2 * np.sqrt(2) - share * TOUCH)) @ pose(rpy=(0.0, np.pi / 4, 0.0))
    expected = share * TOUCH * is_deep
    assert depths(CUBE, below, CUBE, above, TOUCH) == pytest.approx((expected, expected), abs=1e-9)


def test_a_depth_of_the_very_tolerance_does_not_count() -> None:
    one, half = Shape(ShapeKind.BOX, (1.0, 1.0, 1.0)), pose((0.5, 0.0, 0.0))
    assert depths(one, np.eye(4), one, half, 0.5) == (0.0, 0.0)
    assert depths(one, np.eye(4), one, half, 0.25) == (0.5, 0.5)


@pytest.mark.parametrize("other", [CUBE, CAN])
@pytest.mark.parametrize("way", [(0.3, 0.4, 0.8), (0.5, -0.1, 0.6), (-0.2, 0.7, 0.4)])
def test_what_a_plane_parts_but_for_nearly_a_touch_does_not_overlap(
    other: Shape, way: tuple[float, float, float]
) -> None:
    """Rim on corner and rim on rim: the plane lies across none of their axes."""
    n = np.array(way) / np.linalg.norm(way)
    can, turned = PosedSolid(CAN, T), PosedSolid(other, T @ pose(rpy=(1.0, 0.7, 0.4)))
    met = pose(can.support(n) - 0.97 * TOUCH * n - turned.support(-n)) @ turned.T
    assert depths(CAN, T, other, met, TOUCH) == (0.0, 0.0)


def test_a_ball_smaller_than_the_tolerance_overlaps_nothing_by_it() -> None:
    """A grain of 1 mm in the middle of a can: a motion of 20 mm does not bring it out, one of 60 mm does."""
    grain = Shape(ShapeKind.SPHERE, (0.001,))
    assert min(depths(CAN, T, grain, T, 0.02)) >= 0.051 - 1e-9
    assert depths(CAN, T, grain, T, 0.06) == (0.0, 0.0)


def test_a_hash_is_made_of_a_pose_s_twelve_figures_to_a_ten_millionth() -> None:
    T_half = pose((0.12345678, -1e-9, 2.0))
    assert _coarse(T_half) == [1.0, 0.0, 0.0, 0.1234568, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 2.0]
    assert "-0.0" not in str(_coarse(T_half))


def test_of_many_items_in_the_floor_twenty_one_are_looked_for(
    cell: Cell, tmp_path: Path, refused: Refused
) -> None:
    """Thirty in one place: of each kind of mistake one line, with how many more there are at least."""
    item = cell.item("crayola_24_ct")
    floor = cell.places["tote"].T_carrier_place
    sunk = floor @ pose((0.0, 0.0, float(item.shape.extents[2]) / 2 - 0.012))
    for n, told in ((21, "20 more"), (22, "20 more"), (30, "20 more"), (20, "19 more")):
        items = tuple(PlacedItem(f"item_{k}", item, TOTE, sunk) for k in range(n))
        write_scene(replace(make_scene(cell), items=items, noise=PoseNoise()), tmp_path / "s.json")
        lines = refused(lambda: read_scene(tmp_path / "s.json")).splitlines()
        (deep,) = [line for line in lines if "mm deep in" in line]
        assert f"and {told} are like it" in deep


def test_an_item_in_the_first_body_that_stands_is_told_as_any_other(
    cell: Cell, tmp_path: Path, refused: Refused
) -> None:
    scene = make_scene(cell)
    body, T_body = scene.standing[0]
    ball = cell.item("rawlings_baseball")
    placed = PlacedItem("ball", ball, TOTE, T_body @ body.T_parent_shape)
    write_scene(replace(scene, items=(placed,), noise=PoseNoise()), tmp_path / "s.json")
    assert f"deep in {body.name}" in refused(lambda: read_scene(tmp_path / "s.json"))
