"""Hollows of items: what is in them, how a file states them, and what it must not state."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given

from pickcli.cell.hollow import Hollow
from pickcli.cell.item import Item
from pickcli.cell.schemas.items_file import load_items, read_items
from pickcli.cell.schemas.items_text import items_text
from pickcli.cell.shapes import Shape
from support.hollow_items import points_around, rectangular_hollows, round_hollows

Refused = Callable[[Callable[[], object]], str]

ITEMS = load_items()
BOWL, BRUSH = ITEMS["platinum_pets_dog_bowl", 2016], ITEMS["dr_browns_bottle_brush", 2016]
HEAD = "format: apc items\nversion: 1\nyear: 2016\nitems:\n  tray:\n"
REST = "    mass: 0.2\n    bonus: 0\n    seal_source: test\n    seal_inset: 0.002\n    source: test\n"
BOX = (
    '    box: [0.2, 0.1, 0.05]\n    seal: 0.0\n    seals: {"+z/cup": 0.9}\n    hollows:\n'
    '      cup: {face: "+z", x: [-0.08, 0.08], y: [-0.04, 0.04], depth: 0.03}\n'
)
CAN = (
    '    cylinder: [0.06, 0.03]\n    seal: 0.0\n    seals: {"+z/cup": 0.9}\n    hollows:\n'
    '      cup: {face: "+z", radius: 0.04, depth: 0.02}\n'
)
BALL = "    sphere: [0.06]\n    seal: 0.9\n"


def written(path: Path, text: str) -> Path:
    path.write_text(HEAD + text + REST)
    return path


@given(of=round_hollows())
def test_a_round_hollow_contains_what_is_near_the_axis_and_over_its_bottom(of: tuple[Shape, Hollow]) -> None:
    shape, hollow = of
    points = points_around(shape, 200)
    over = points[:, 2] * (1.0 if hollow.face == "+z" else -1.0) + shape.size[1] / 2
    expected = (np.hypot(points[:, 0], points[:, 1]) <= (hollow.radius or 0.0)) & (
        (over >= shape.size[1] - hollow.depth) & (over <= shape.size[1])
    )
    np.testing.assert_array_equal(hollow.contains(shape, points), expected)


@given(of=rectangular_hollows())
def test_a_rectangular_hollow_begins_at_its_face_and_ends_at_its_bottom(of: tuple[Shape, Hollow]) -> None:
    shape, hollow = of
    low, high = hollow.bounds(shape)
    rim = float(shape.extents[hollow.axis]) / 2
    ends = sorted((abs(rim - abs(float(low[hollow.axis]))), abs(rim - abs(float(high[hollow.axis])))))
    assert ends[0] == pytest.approx(0.0, abs=1e-12)
    assert float(high[hollow.axis] - low[hollow.axis]) == pytest.approx(hollow.depth)
    assert [(low[k], high[k]) for k in hollow.across] == list(hollow.sides)
    assert (np.abs(hollow.bounds(shape)) <= shape.extents / 2 + 1e-12).all()


def test_the_bottom_of_a_hollow_is_a_face_at_its_depth() -> None:
    assert BOWL.face_names == ("+z", "-z", "mantle", "+z/bowl")
    assert BOWL.height("+z/bowl") == pytest.approx(0.0155 - 0.03)
    assert BOWL.height("+z") == pytest.approx(0.0155)
    assert BOWL.hollow_at("+z") is None
    assert BOWL.suction


def test_the_bottom_of_a_rectangular_hollow_ends_at_its_sides() -> None:
    low, high = BRUSH.area("+z/left")
    np.testing.assert_allclose([low[0], high[0], low[1], high[1]], [-0.139, 0.0, 0.0125, 0.0525])
    rooms = BRUSH.rooms("+z/left", np.array([-0.05, 0.03, 0.0005]))
    np.testing.assert_allclose(rooms, [[0.089, 0.05], [0.0175, 0.0225]])


@pytest.mark.parametrize("item", [BOWL, BRUSH], ids=lambda item: item.name)
def test_what_is_written_is_read_again(tmp_path: Path, item: Item) -> None:
    path = tmp_path / "items.yaml"
    path.write_text(items_text([item]))
    assert read_items(path)[item.name, 2016] == item


def test_two_items_that_differ_in_a_hollow_differ() -> None:
    deeper = replace(BOWL, hollows=(replace(BOWL.hollows[0], depth=0.02),))
    assert deeper != BOWL


X, SIDES = "[-0.08, 0.08]", "x: [-0.08, 0.08], y: [-0.04, 0.04]"
OF_A_BALL = 'seal: 0.9\n    hollows: {a: {face: "+z", depth: 0.01}}'
LOW = 'depth: 0.03}\n      low: {face: "-z", x: [0.0, 0.05], y: [0.0, 0.02], depth: '
DEPTH_AT_MOST = "hollows.cup.depth: expected at most"
MISTAKES = {
    "unknown face": (BOX, '"+z", x', '"+w", x', "hollows.cup.face: expected a flat face of its shape"),
    "curved face": (CAN, 'face: "+z", r', "face: mantle, r", "hollows.cup.face: expected a flat face"),
    "of a ball": (BALL, "seal: 0.9", OF_A_BALL, "a sphere has no flat face"),
    "deeper than the item": (BOX, "depth: 0.03", "depth: 0.06", f"{DEPTH_AT_MOST} 0.049 m"),
    "through the other face": (CAN, "depth: 0.02", "depth: 0.03", f"{DEPTH_AT_MOST} 0.029 m"),
    "outside of the box": (BOX, X, "[-0.08, 0.12]", "hollows.cup.x: expected within 0.1 m"),
    "outside of the cylinder": (CAN, "radius: 0.04", "radius: 0.06", "hollows.cup.radius: expected at most"),
    "round in a box": (BOX, SIDES, "radius: 0.02", "expected x and y, the axes"),
    "one side only": (BOX, "x: [-0.08, 0.08], ", "", "expected x and y, the axes of face +z"),
    "along its face": (BOX, "x: [-0.08", "z: [-0.01, 0.01], x: [-0.08", "expected x and y, the axes"),
    "rectangular in a cylinder": (CAN, "radius: 0.04", "x: [-0.01, 0.01]", "expected radius alone"),
    "inside out": (BOX, X, "[0.08, -0.08]", "expected [least, greatest] for x"),
    "all of a face": (BOX, SIDES, "x: [-0.1, 0.1], y: [-0.05, 0.05]", "takes all of"),
    "no depth": (CAN, ", depth: 0.02", "", "hollows.cup.depth: expected m from the face"),
    "unknown key": (CAN, "depth: 0.02", "depth: 0.02, width: 0.1", "hollows.cup.width: unknown key"),
    "seal of another": (BOX, "+z/cup", "+z/mug", "got +z/mug"),
    "a face that it opens": (BOX, "seal: 0.0", "seal: 0.9", "+z is said to seal where it opens"),
    "a side that it opens": (
        BOX, '0.9}\n    hollows:\n      cup: {face: "+z", x: [-0.08',
        '0.9, "-x": 0.9}\n    hollows:\n      cup: {face: "+z", x: [-0.1',
        "-x is said to seal where it opens",
    ),
    "area beside it": (
        BOX, "    hollows", '    areas: {"+z/cup": {x: [0.09, 0.1]}}\n    hollows', "within its hollow",
    ),
    "area along its depth": (
        BOX, "    hollows", '    areas: {"+z/cup": {z: [0.0, 0.01]}}\n    hollows', "correct the axis",
    ),
    "two that meet": (BOX, "depth: 0.03}", LOW + "0.03}", "cup and low meet"),
    "no wall between": (BOX, "depth: 0.03}", LOW + "0.02}", "cup and low meet"),
    "nothing left for the cup": (CAN, "radius: 0.04", "radius: 0.002", "expected a seal_inset under 0.002"),
    "soft": (BOX, "seal: 0.0", "seal: 0.0\n    deforms: 0.004", "expected none of an item with hollows"),
}  # fmt: skip


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_one_clear_error(tmp_path: Path, refused: Refused, name: str) -> None:
    text, old, new, expected = MISTAKES[name]
    assert old in text
    path = written(tmp_path / "items.yaml", text)
    assert list(read_items(path)) == [("tray", 2016)]
    written(path, text.replace(old, new, 1))
    message = refused(lambda: read_items(path))
    assert expected in message
    assert message.count(f"{path}:") == 1


def test_hollows_of_one_face_may_lie_side_by_side(tmp_path: Path) -> None:
    more = '      next: {face: "+z", x: [0.08, 0.1], y: [-0.04, 0.04], depth: 0.01}\n'
    (tray,) = read_items(written(tmp_path / "items.yaml", BOX + more)).values()
    assert [hollow.bottom for hollow in tray.hollows] == ["+z/cup", "+z/next"]


def test_a_rim_that_seals_beside_a_hollow_is_accepted(tmp_path: Path) -> None:
    text = BOX.replace('seals: {"+z/cup": 0.9}', 'seals: {"+z": 0.9}\n    areas: {"+z": {x: [0.08, 0.1]}}')
    (tray,) = read_items(written(tmp_path / "items.yaml", text)).values()
    assert tray.seals["+z"] == 0.9
    assert tray.seals["+z/cup"] == 0.0


def test_a_side_seals_beside_what_opens_there(tmp_path: Path) -> None:
    channel = BOX.replace("[-0.08, 0.08]", "[-0.1, 0.1]").replace(
        'seals: {"+z/cup": 0.9}', 'seals: {"-x": 0.9}\n    areas: {"-x": {y: [0.04, 0.05]}}'
    )
    (tray,) = read_items(written(tmp_path / "items.yaml", channel)).values()
    assert tray.hollows[0].opens(tray.shape) == ("+z", "-x", "+x") and tray.seals["-x"] == 0.9


def test_a_hollow_narrower_than_any_cup_is_warned_of(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    narrow = BOX.replace("[-0.04, 0.04]", "[-0.008, 0.008]")
    with caplog.at_level(logging.WARNING):
        read_items(written(tmp_path / "wide.yaml", BOX))
        assert "narrower" not in caplog.text
        read_items(written(tmp_path / "narrow.yaml", narrow))
    assert "the hollow cup is 16 mm wide, narrower than any usual cup (20 mm)" in caplog.text
