"""Warnings about scenes: items at poses from which they would fall or roll."""

from __future__ import annotations

import json
import logging
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.hollow_body import N_AROUND
from pickcli.cell.shapes import ShapeKind
from pickcli.geometry import pose, to_rpy
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.scene.scene_file import read_scene, write_scene
from pickcli.simulation.reality import Reality
from pickcli.statics.balance_warning import warn_of_motion
from pickcli.statics.supports import supports_of
from pickcli.trial.make_order import make_order
from pickcli.trial.order import OrderKind
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive
from support.bin_piles import EXACT, NOISY, at, of, shaped


def leaning(cell: Cell, gap: float) -> tuple[PlacedItem, PlacedItem]:
    """A case that leans at 20 degrees towards a box, and stops a gap (m) short of it."""
    tall, thick, box = 0.19, 0.014, 0.1
    turn = float(np.radians(20.0))
    z = (tall * np.cos(turn) + thick * np.sin(turn)) / 2
    up = (box - z + thick / 2 * np.sin(turn)) / np.cos(turn)  # along its front, to the height of the box
    x = 0.3 - box / 2 - gap / np.cos(turn) - thick / 2 * np.cos(turn) - up * np.sin(turn)
    case = at(cell, "case", shaped(cell, (thick, 0.13, tall)), x, 0.0, z, (0.0, turn, 0.0))
    return case, at(cell, "box", shaped(cell, (box, 0.14, box), mass=0.5), 0.3, 0.0, box / 2)


def slope_at(cell: Cell, x: float) -> tuple[float, float]:
    """Height in m and slope in rad, down into the bin, of the floor near the mouth."""
    height, behind = cell.pod.bins["bin_E"].room.rest(np.array([x, x + 0.01]), np.zeros(2))[0]
    assert behind < height
    return float(height), float(np.arctan2(height - behind, 0.01))


@pytest.mark.parametrize(("gap", "rests"), [(0.0003, True), (0.004, False), (0.008, False)])
def test_what_leans_on_nothing_is_not_at_rest(cell: Cell, gap: float, rests: bool) -> None:
    balance = of(cell, *leaning(cell, gap)).balance
    assert balance.is_at_rest("case") is rests and balance.is_at_rest("box")


def test_with_errors_of_poses_it_may_lean_on_what_is_near(cell: Cell) -> None:
    assert of(cell, *leaning(cell, 0.004), noise=NOISY).balance.is_at_rest("case")


@pytest.mark.parametrize(("gap", "rests"), [(0.0, True), (0.003, False)])
def test_a_ball_on_a_slope_rests_against_something(cell: Cell, gap: float, rests: bool) -> None:
    radius, room = 0.037, cell.pod.bins["bin_E"].room
    height, pitch = slope_at(cell, 0.1)
    x, z = 0.1 + radius * np.sin(pitch), height + radius * np.cos(pitch) - room.floor_back
    ball = at(cell, "ball", shaped(cell, (radius,), ShapeKind.SPHERE), x, 0.0, z)
    chock = at(cell, "chock", shaped(cell, (0.02, 0.1, 0.1)), x + radius + gap + 0.01, 0.0, 0.06)
    assert of(cell, ball, chock).balance.is_at_rest("ball") is rests


@pytest.mark.parametrize(("turn", "rests"), [(0.0, False), (np.pi / 2, True)])
def test_a_long_bottle_rolls_down_a_slope_and_does_not_slide(cell: Cell, turn: float, rests: bool) -> None:
    """It lies across the slope, or along it."""
    radius, (height, pitch) = 0.035, slope_at(cell, 0.1)
    shape = shaped(cell, (radius, 0.12), ShapeKind.CYLINDER)
    room = cell.pod.bins["bin_E"].room
    x, z = 0.1 + radius * np.sin(pitch), height + radius * np.cos(pitch) - room.floor_back
    R = pose(rpy=(0.0, pitch, 0.0)) @ pose(rpy=(0.0, 0.0, turn)) @ pose(rpy=(np.pi / 2, 0.0, 0.0))
    bottle = at(cell, "bottle", shape, x, 0.0, z, tuple(to_rpy(R[:3, :3])))
    assert of(cell, bottle).balance.is_at_rest("bottle") is rests


@pytest.mark.parametrize(("beyond", "rests"), [(-0.002, True), (0.002, False)])
def test_what_is_long_tips_over_an_edge_like_anything_else(cell: Cell, beyond: float, rests: bool) -> None:
    box = at(cell, "box", shaped(cell, (0.1, 0.1, 0.1), mass=0.5), 0.3, 0.0, 0.05)
    plank = at(cell, "plank", shaped(cell, (0.37, 0.09, 0.016)), 0.25 - beyond, 0.0, 0.108)
    assert of(cell, box, plank).balance.is_at_rest("plank") is rests


def bowl_over_a_box(cell: Cell, short: float) -> tuple[PlacedItem, PlacedItem]:
    """An upturned bowl that leans, its rim on the floor and the bottom of its hollow on the edge of a box.

    short: m by which the box is too low for that
    """
    bowl, turn, edge = cell.item("platinum_pets_dog_bowl"), 0.1, -0.01
    half = float(bowl.shape.extents[2]) / 2
    rim = float(bowl.shape.size[0] * np.cos(np.pi / N_AROUND))  # as far as the true body reaches
    inside = bowl.hollows[0].depth - half
    c, s = np.cos(turn), np.sin(turn)
    z = rim * s + half * c
    height, end = z - edge * s + inside * c - short, edge * c + inside * s
    box = at(cell, "box", shaped(cell, (0.02, 0.02, height)), 0.3 + end - 0.01, 0.0, height / 2)
    return at(cell, "bowl", bowl, 0.3, 0.0, z, (np.pi, turn, 0.0)), box


@pytest.mark.parametrize(("short", "rests"), [(0.0, True), (0.003, False)])
def test_a_bowl_rests_with_its_hollow_on_something(cell: Cell, short: float, rests: bool) -> None:
    """By its outer shape it overlaps the box, whatever is in its hollow."""
    balance = of(cell, *bowl_over_a_box(cell, short)).balance
    assert balance.is_at_rest("bowl") is rests and balance.is_at_rest("box")


@pytest.mark.parametrize("over", [0.0, 0.003])
def test_nothing_rests_on_the_rim_of_a_hollow_that_it_is_in(cell: Cell, over: float) -> None:
    """A ball rests on the bottom of a bowl, and over that on nothing, though the outer shapes overlap."""
    bowl, ball = cell.item("platinum_pets_dog_bowl"), cell.item("rawlings_baseball")
    half, radius = float(bowl.shape.extents[2]) / 2, float(ball.shape.size[0])
    z = 2 * half - bowl.hollows[0].depth + radius + over
    items = at(cell, "bowl", bowl, 0.3, 0.0, half), at(cell, "ball", ball, 0.3, 0.0, z)
    assert of(cell, *items).balance.is_at_rest("ball") is (over == 0.0)


def test_a_bowl_on_its_edge_stands_as_its_true_body_does(cell: Cell) -> None:
    """On its base and a flat of its ring; the outer shape would touch the floor in one point."""
    bowl = cell.item("platinum_pets_dog_bowl")
    outer, length = bowl.shape.size
    ring = outer * np.cos(np.pi / N_AROUND)
    turn = np.arctan2(outer - ring, bowl.hollows[0].depth)
    z = ring * np.cos(turn) + length / 2 * np.sin(turn)
    stands = at(cell, "bowl", bowl, 0.3, 0.0, float(z), (0.0, np.pi / 2 + turn, 0.0))
    assert of(cell, stands).balance.is_at_rest("bowl")
    can = replace(bowl, hollows=())
    assert not of(cell, replace(stands, item=can)).balance.is_at_rest("bowl")


@pytest.mark.parametrize("noise", [EXACT, DEFAULT_NOISE])
def test_nothing_in_a_settled_scene_is_warned_of(cell: Cell, noise: PoseNoise) -> None:
    order = make_order(OrderKind.PICK, 2016, 3302)
    scene = make_scene(order.bin_contents, cell, 3302)
    seen = scene if noise is EXACT else perceive(scene, noise, 3302, 1, Reality())
    balance = supports_of(seen).balance
    assert len(seen.items) > 20 and all(balance.is_at_rest(placed.id) for placed in seen.items)


def test_a_file_tells_of_what_moves_unless_it_accepts_it(
    cell: Cell, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path, name = tmp_path / "scene.json", "rawlings_baseball"
    T_bin = cell.T_world_place(cell.pod.bins["bin_E"])
    radius = float(cell.item(name).shape.size[0])
    height, pitch = slope_at(cell, 0.1)
    T = T_bin @ pose([0.1 + radius * np.sin(pitch), 0.0, height + radius * np.cos(pitch)])
    write_scene(Scene(cell, cell.T_world_pod, (PlacedItem(name, cell.item(name), "bin_E", T),), EXACT), path)
    with caplog.at_level(logging.WARNING):
        read_scene(path, warn=warn_of_motion)
    assert f"{name} cannot be at rest at this pose" in caplog.text
    data = json.loads(path.read_text()) | {"accepted_warnings": [f"not_at_rest:{name}"]}
    path.write_text(json.dumps(data))
    caplog.clear()
    with caplog.at_level(logging.WARNING):
        read_scene(path, warn=warn_of_motion)
    assert "at rest" not in caplog.text
