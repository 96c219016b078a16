"""The items: complete, inside what the sources say, and small enough for the bins they must enter."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.data_path import data_path
from pickcli.cell.device import Device, DeviceKind, pump_flow
from pickcli.cell.item import LEAST_SHARE, REFERENCE_FLOW, Item
from pickcli.cell.schemas.items_file import load_items, read_items
from pickcli.cell.schemas.items_text import items_text
from pickcli.cell.shapes import ShapeKind
from pickcli.errors import UnknownNameError

Refused = Callable[[Callable[[], object]], str]

ITEMS = load_items()
MOUTH = (0.249, 0.19)  # m: the narrowest column and the lowest row
DEPTH = 0.42
CUP = 0.030  # m, diameter


def ids(item: Item) -> str:
    return f"{item.name}-{item.year}"


@pytest.mark.parametrize("item", ITEMS.values(), ids=ids)
def test_an_item_enters_a_bin(item: Item) -> None:
    across, up, along = sorted(item.shape.extents)[1], sorted(item.shape.extents)[0], max(item.shape.extents)
    assert across <= MOUTH[0]
    assert up <= MOUTH[1]
    assert along <= DEPTH


@pytest.mark.parametrize("item", ITEMS.values(), ids=ids)
def test_what_a_cup_holds_has_a_face_for_it_and_the_rest_a_reason(item: Item) -> None:
    widest = sorted(item.shape.extents)[1]
    best = max(item.seals.values())
    assert (best >= LEAST_SHARE) != bool(item.why_not)
    if item.suction and "toothbrush" not in item.name:  # which is held across its edges, or not at all
        assert widest >= CUP + 2 * item.seal_inset
    assert 0.005 < item.mass < 1.5
    assert item.mass / item.shape.volume < 2600.0  # kg/m3: nothing is heavier than glass


@given(share=st.floats(0.0, 1.0), ratio=st.floats(1.0, 100.0))
def test_a_pump_keeps_the_share_at_which_it_draws_what_leaks_in(share: float, ratio: float) -> None:
    stated = replace(ITEMS["crayola_24_ct", 2016], seals={"+z": share, "-z": 0.0})
    kept = stated.under_pump(ratio * REFERENCE_FLOW).seals["+z"]
    if kept > 0.0:
        leak = (
            REFERENCE_FLOW * (1.0 - share) / share
        )  # l/min at full vacuum: what the small pump draws at its share
        assert kept >= LEAST_SHARE
        assert leak * kept == pytest.approx(ratio * REFERENCE_FLOW * (1.0 - kept), abs=1e-6)
    else:
        assert share * ratio / (share * ratio + 1.0 - share) < LEAST_SHARE
    assert stated.under_pump(REFERENCE_FLOW).seals["+z"] == pytest.approx(
        share if share >= LEAST_SHARE else 0.0
    )


@pytest.mark.parametrize("item", ITEMS.values(), ids=ids)
def test_an_item_is_held_or_has_a_reason_under_any_pump(item: Item) -> None:
    for flow in (1.0, REFERENCE_FLOW, 600.0):
        under = item.under_pump(flow)
        assert under.suction != bool(under.why_not)
        assert under.suction == any(under.seals.values())


def test_cloth_is_held_by_the_pump_of_more_flow_only() -> None:
    strong, small = load_cell("apc2016_delft"), load_cell("apc2016_kth_picking", arm="left")
    for name in ("cherokee_easy_tee_shirt", "womens_knit_gloves"):
        assert strong.item(name, 2016).suction
        assert not small.item(name, 2016).suction
        assert "air passes" in small.item(name, 2016).why_not
    for cell in (strong, small):
        assert not cell.item("fitness_gear_3lb_dumbbell", 2016).suction


def test_faces_that_keep_too_little_for_a_small_pump_say_so() -> None:
    weak = replace(ITEMS["crayola_24_ct", 2016], seals={"+z": 0.2, "-z": 0.1}, why_not="")
    assert weak.under_pump(REFERENCE_FLOW).why_not == (
        "its faces keep at most 20% of the vacuum, 22.5% are needed"
    )
    assert weak.under_pump(600.0).why_not == ""


def test_the_weakest_pump_of_a_cell_counts() -> None:
    pumps = [
        Device(name, DeviceKind.PUMP, 1.0, ("on", "off"), flow) for name, flow in (("a", 90.0), ("b", 600.0))
    ]
    valve = Device("valve", DeviceKind.VALVE, 0.05, ("on", "off"), 5.0)
    assert pump_flow([*pumps, valve]) == 90.0
    assert pump_flow([valve]) == REFERENCE_FLOW


def test_both_years_are_complete() -> None:
    assert sum(year == 2016 for _, year in ITEMS) == 39
    assert sum(year == 2015 for _, year in ITEMS) == 25
    names_2016 = {name for name, year in ITEMS if year == 2016}
    assert sum(year == 2015 and name in names_2016 for name, year in ITEMS) == 6


def test_the_orders_ask_for_known_items_only() -> None:
    paths = list((data_path() / "tasks").glob("*.json"))
    assert paths
    for path in paths:
        order = json.loads(path.read_text())
        if order.get("format") == "apc stream":
            assert all((each["name"], each["year"]) in ITEMS for each in order["items"]), path.name
            continue
        if order.get("format") == "apc commission":
            continue  # it has products of its own
        names = [n for contents in order["bin_contents"].values() for n in contents]
        names += order.get("tote_contents", [])
        years = {2015} if "2015" in path.name else {2016}
        assert names, path.name
        assert all(any((name, year) in ITEMS for year in years) for name in names), path.name


def test_the_bonus_is_that_of_the_rules() -> None:
    three = {"fitness_gear_3lb_dumbbell", "rolodex_jumbo_pencil_cup"}
    two = {
        "clorox_utility_brush",
        "dr_browns_bottle_brush",
        "dasani_water_bottle",
        "easter_turtle_sippy_cup",
        "fiskars_scissors_red",
    }
    bonus = {name: item.bonus for (name, year), item in ITEMS.items() if year == 2016}
    assert {name for name, points in bonus.items() if points == 3} == three
    assert {name for name, points in bonus.items() if points == 2} == two
    assert sum(points == 1 for points in bonus.values()) == 10


def test_slow_and_unholdable_items_are_those_of_the_sources() -> None:
    of_2016 = [item for item in ITEMS.values() if item.year == 2016]
    assert {item.name for item in of_2016 if item.speed_scale == 0.5} == {
        "hanes_tube_socks",
        "kleenex_paper_towels",
        "fitness_gear_3lb_dumbbell",
        "dasani_water_bottle",
    }
    assert {item.name for item in of_2016 if not item.suction} == {
        "fitness_gear_3lb_dumbbell",
        "cherokee_easy_tee_shirt",
        "womens_knit_gloves",
    }


def test_fragile_items_are_stated_in_their_files() -> None:
    fragile = {key for key, item in ITEMS.items() if item.is_fragile}
    assert fragile == {("oreo_mega_stuf", 2015), ("soft_white_lightbulb", 2016)}


def test_shapes_follow_the_sources() -> None:
    bottle, ball = ITEMS["dasani_water_bottle", 2016].shape, ITEMS["rawlings_baseball", 2016].shape
    assert (bottle.kind, bottle.size) == (ShapeKind.CYLINDER, (0.0335, 0.195))
    assert (ball.kind, ball.size) == (ShapeKind.SPHERE, (0.034,))
    np.testing.assert_allclose(ITEMS["crayola_24_ct", 2016].shape.extents, (0.095, 0.07, 0.025))
    assert {name for (name, _), item in ITEMS.items() if item.folded} == {
        "cherokee_easy_tee_shirt",
        "scotch_bubble_mailer",
    }


def test_an_item_of_the_other_year_is_found_and_an_unknown_one_guessed(cell: Cell) -> None:
    assert cell.item("expo_dry_erase_board_eraser", 2015).mass == pytest.approx(0.021)
    assert cell.item("oreo_mega_stuf", 2016).year == 2015
    with pytest.raises(UnknownNameError, match="did you mean 'crayola_24_ct'"):
        cell.item("crayola_24")


ITEM = (
    "box: [0.1, 0.1, 0.1]\n    mass: 0.1\n    bonus: 0\n    seal: 1.0\n    seal_source: test\n"
    "    seal_inset: 0.002\n    source: test"
)
MISTAKES = {
    "two shapes": ("mass: 0.1", "mass: 0.1\n    sphere: [0.1]", "exactly one of box, cylinder and sphere"),
    "no shape": ("box: [0.1, 0.1, 0.1]\n    ", "", "exactly one of box, cylinder and sphere"),
    "no size": ("0.1, 0.1, 0.1", "0.1, 0.1, 0", "items.brick.box[2]: expected"),
    "two sizes": ("0.1, 0.1, 0.1", "0.1, 0.1", "items.brick.box: expected extents"),
    "no mass": ("mass: 0.1\n    ", "", "items.brick.mass: expected a mass in kg, got nothing; add it"),
    "mass in grams": ("mass: 0.1", "mass: 125", "items.brick.mass: expected a mass in kg"),
    "no reason": ("seal: 1.0", "seal: 0.0", "items.brick: expected why_not"),
    "needless reason": ("bonus: 0", "bonus: 0\n    why_not: heavy", "items.brick: expected why_not"),
    "more than airtight": ("seal: 1.0", "seal: 1.1", "items.brick.seal: expected a share of full vacuum"),
    "no seal": ("    seal: 1.0\n", "", "items.brick.seal: expected a share of full vacuum"),
    "face of another shape": ("seal: 1.0", "seal: 1.0\n    seals: {mantle: 0.5}", "+z, -z), got mantle"),
    "area of an open face": (
        "seal: 1.0",
        'seal: 1.0\n    seals: {"+z": 0.0}\n    areas: {"+z": {x: [0.0, 0.1]}}',
        "areas of faces that seal",
    ),
    "area inside out": ("seal: 1.0", 'seal: 1.0\n    areas: {"+z": {x: [0.1, 0.0]}}', "[least, greatest]"),
    "suction as it was": ("bonus: 0", "bonus: 0\n    suction: true", "items.brick.suction: unknown key"),
    "half a point": ("bonus: 0", "bonus: 0.5", "items.brick.bonus: expected points"),
    "capital name": ("brick", "Brick", "items.Brick"),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_told_with_file_line_and_key(tmp_path: Path, refused: Refused, name: str) -> None:
    old, new, expected = MISTAKES[name]
    text = f"format: apc items\nversion: 1\nyear: 2016\nitems:\n  brick:\n    {ITEM}\n"
    path = tmp_path / "items.yaml"
    path.write_text(text)
    assert list(read_items(path)) == [("brick", 2016)]
    path.write_text(text.replace(old, new))
    message = refused(lambda: read_items(path))
    assert f"{path}:" in message
    assert expected in message


def test_a_face_seals_as_the_item_unless_it_is_stated(tmp_path: Path) -> None:
    path = tmp_path / "items.yaml"
    stated = ITEM.replace("seal: 1.0", 'seal: 0.4\n    seals: {"+z": 0.9, "-x": 0.0}')
    path.write_text(f"format: apc items\nversion: 1\nyear: 2016\nitems:\n  brick:\n    {stated}\n")
    (brick,) = read_items(path).values()
    assert brick.seals == {"+x": 0.4, "-x": 0.0, "+y": 0.4, "-y": 0.4, "+z": 0.9, "-z": 0.4}
    assert brick.suction
    assert hash(brick) == hash(read_items(path)["brick", 2016])


@pytest.mark.parametrize("name", ["crayola_24_ct", "dasani_water_bottle", "rawlings_baseball"])
def test_inertia_is_that_of_a_cloud_of_points_in_the_shape(name: str) -> None:
    item = ITEMS[name, 2016]
    half = item.shape.extents / 2
    grid = np.stack(np.meshgrid(*[np.linspace(-h, h, 81)[:-1] + h / 80 for h in half]), axis=-1).reshape(
        -1, 3
    )
    if item.shape.kind is ShapeKind.CYLINDER:
        grid = grid[np.hypot(grid[:, 0], grid[:, 1]) <= half[0]]
    elif item.shape.kind is ShapeKind.SPHERE:
        grid = grid[np.linalg.norm(grid, axis=1) <= half[0]]
    squares = np.einsum("ij,ij->i", grid, grid)
    summed = (squares.sum() * np.eye(3) - grid.T @ grid) * item.mass / len(grid)
    np.testing.assert_allclose(item.inertia, summed, rtol=3e-3, atol=1e-9)


OF_2016 = [item for item in ITEMS.values() if item.year == 2016]


def test_what_holds_no_vacuum_has_no_face_that_seals() -> None:
    """Ends of rolls, insides, bristles, cords: where the box or cylinder has a face, the item has none."""
    for name, faces in {
        "kleenex_paper_towels": ("+z", "-z"),
        "scotch_duct_tape": ("+z", "-z"),
        "platinum_pets_dog_bowl": ("+z", "mantle"),
        "clorox_utility_brush": ("-z", "+y", "-y"),
        "dr_browns_bottle_brush": ("+z", "-z"),
        "woods_extension_cord": ("+x", "-x", "+y", "-y"),
        "dasani_water_bottle": ("+z", "-z"),
    }.items():
        item = ITEMS[name, 2016]
        assert [item.seals[face] for face in faces] == [0.0] * len(faces), name
        assert item.suction, name


def test_bags_and_plush_seal_weakly_boxes_and_bottles_well() -> None:
    def best(name: str) -> float:
        return max(ITEMS[name, 2016].seals.values())

    weak = (
        "hanes_tube_socks",
        "peva_shower_curtain_liner",
        "creativity_chenille_stems",
        "cloud_b_plush_bear",
    )
    strong = ("crayola_24_ct", "staples_index_cards", "dasani_water_bottle", "folgers_classic_roast_coffee")
    assert max(best(name) for name in weak) <= 0.5
    assert min(best(name) for name in strong) >= 0.9


def test_every_seal_has_a_source_and_names_where_the_teams_disagree() -> None:
    assert all(len(item.seal_source) > 3 for item in ITEMS.values())
    disputed = {item.name for item in OF_2016 if "disagree" in item.seal_source}
    # KTH's list for the gripper, and scissors and pencil cup, which it had no pose for; Delft took them all
    # by suction, the pencil cup by pinching, too.
    assert disputed == {
        "cherokee_easy_tee_shirt", "cloud_b_plush_bear", "womens_knit_gloves", "cool_shot_glue_sticks",
        "kyjen_squeakin_eggs_plush_puppies", "creativity_chenille_stems", "fiskars_scissors_red",
        "rolodex_jumbo_pencil_cup",
    }  # fmt: skip


def test_what_seals_of_a_face_is_bounded_along_the_axes_stated() -> None:
    cord = ITEMS["woods_extension_cord", 2016]
    np.testing.assert_allclose(cord.area("+z"), [[-0.035, -0.025, -np.inf], [0.035, 0.025, np.inf]])
    assert np.isinf(cord.area("+x")).all()
    assert all(
        low < high for item in ITEMS.values() for area in item.areas.values() for low, high in area.values()
    )


def test_a_bound_of_the_tilt_is_read_back_as_it_was_written(tmp_path: Path) -> None:
    item = replace(load_items()["dove_beauty_bar", 2016], max_tilt=0.3)
    (path := tmp_path / "items.yaml").write_text(items_text([item]))
    assert read_items(path)["dove_beauty_bar", 2016] == item
