"""A route follows from what an item looks like, from the pixels and from what else is in the place alone."""

from __future__ import annotations

from dataclasses import replace
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.errors import InputError
from pickcli.geometry import pose
from pickcli.perception.items.item_observation import FoundBy, ItemObservation
from pickcli.perception.items.item_perception import perceive_items, told_apart
from pickcli.perception.items.listed_item import ListedItem
from pickcli.perception.items.routing import LEAST_PIXELS, ItemRoute, PrintSearch, pixels_per_mm, routes_of
from pickcli.perception.textures.sift_views import SiftRule, SiftViews
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import PoseNoise
from support.filled_bins import looked_at

NAMES = (
    "dove_beauty_bar", "crayola_24_ct", "oral_b_toothbrush_red", "oral_b_toothbrush_green",
    "rawlings_baseball", "womens_knit_gloves", "clorox_utility_brush", "hanes_tube_socks",
)  # fmt: skip
FINE = 3.0  # px per mm
pixels = st.floats(0.0, 20.0)
rules = st.sampled_from(SiftRule)


def listed_of(cell: Cell, names: tuple[str, ...], may_deform: bool = False) -> list[ListedItem]:
    return [ListedItem.of(name, cell.item(name, 2016), may_deform) for name in names]


def route_of(item: Item, per_mm: float = FINE, rule: SiftRule = SiftRule.AUTO) -> ItemRoute:
    (route,) = routes_of([ListedItem(item.name, item)], per_mm, rule)
    return route


def plain_box(
    cell: Cell, name: str, size: tuple[float, ...], colour: tuple[int, ...] = (200, 40, 40)
) -> Item:
    own = cell.item("dove_beauty_bar", 2016)
    return replace(own, name=name, shape=Shape(ShapeKind.BOX, size), is_printed=False, colour=colour)


@given(st.lists(st.sampled_from(NAMES), min_size=1, unique=True), pixels, rules, st.randoms())
def test_the_order_of_the_list_does_not_matter(
    cell: Cell, names: list[str], per_mm: float, rule: SiftRule, random: Random
) -> None:
    listed = listed_of(cell, tuple(names))
    routes = dict(zip(names, routes_of(listed, per_mm, rule), strict=True))
    assert dict(zip(names, routes_of(listed, per_mm, rule), strict=True)) == routes
    shuffled = random.sample(listed, len(listed))
    assert {
        each.id: route for each, route in zip(shuffled, routes_of(shuffled, per_mm, rule), strict=True)
    } == routes


@given(st.sampled_from(NAMES), pixels, pixels, rules)
def test_more_pixels_never_lose_the_print(
    cell: Cell, name: str, one: float, other: float, rule: SiftRule
) -> None:
    item = cell.item(name, 2016)
    coarse, fine = (route_of(item, per_mm, rule) for per_mm in sorted((one, other)))
    assert coarse.views is None or fine.views is coarse.views


@given(st.sampled_from(NAMES), pixels, rules)
def test_a_route_without_a_print_says_why(cell: Cell, name: str, per_mm: float, rule: SiftRule) -> None:
    item = cell.item(name, 2016)
    route = route_of(item, per_mm, rule)
    assert (route.views is None) == bool(route.why)
    assert route.views is None or item.is_printed
    if rule is SiftRule.NONE:
        assert route.views is None
    elif rule is not SiftRule.AUTO and item.is_printed:
        assert route.views == rule.value


def test_a_print_needs_pixels_across_the_item(cell: Cell) -> None:
    soap = cell.item("dove_beauty_bar", 2016)
    needed = LEAST_PIXELS / (1e3 * float(np.sort(soap.shape.extents)[1]))
    assert route_of(soap, 1.01 * needed) == ItemRoute(SiftViews.ALL)
    assert route_of(soap, 1.01 * needed).text == "by print (all-views) and shape"
    less = route_of(soap, 0.5 * needed)
    assert less.text == f"by shape: {0.5 * needed:.2f} pixels per mm, its print needs {needed:.2f}"
    narrow = replace(soap, shape=Shape(ShapeKind.BOX, (0.093, 0.01, 0.01)))
    assert route_of(narrow, 1.01 * needed).views is None


def test_what_is_plain_and_what_deforms_has_no_print(cell: Cell) -> None:
    socks = cell.item("hanes_tube_socks", 2016)
    assert route_of(socks).views is SiftViews.ALL
    (rumpled,) = routes_of(listed_of(cell, ("hanes_tube_socks",), may_deform=True), FINE)
    assert rumpled.text == "by shape: it may be rumpled"
    assert route_of(cell.item("womens_knit_gloves", 2016)).text == "by shape: it is plain"
    assert (
        route_of(replace(socks, is_printed=False, colour=None)).text == "by shape: its file states no print"
    )


def test_an_item_without_a_model_is_refused(cell: Cell) -> None:
    soap = cell.item("dove_beauty_bar", 2016)
    mesh = replace(soap, name="statue", shape=replace(soap.shape, kind=ShapeKind.HULL))
    others = [ListedItem("statue", mesh), ListedItem("other", replace(mesh, name="other"))]
    with pytest.raises(InputError, match="has no model") as error:
        routes_of(others, FINE)
    assert str(error.value).startswith(("statue: ", "other: "))


def test_twins_are_of_like_colour_and_like_shape(cell: Cell) -> None:
    a = plain_box(cell, "a", (0.1, 0.06, 0.04))
    cases = {
        "b": (plain_box(cell, "b", (0.04, 0.102, 0.06)), True),  # the same, lying
        "longer": (plain_box(cell, "longer", (0.12, 0.06, 0.04)), False),
        "blue": (plain_box(cell, "blue", (0.1, 0.06, 0.04), (40, 40, 200)), False),
        "printed": (replace(a, name="printed", is_printed=True), True),
        "round": (replace(a, name="round", shape=Shape(ShapeKind.CYLINDER, (0.03, 0.1))), False),
    }
    for name, (other, are_twins) in cases.items():
        one, two = routes_of([ListedItem("a", a), ListedItem(name, other)], FINE)
        assert (one.twins, two.twins) == (((name,), ("a",)) if are_twins else ((), ())), name
    copies = routes_of([ListedItem("a", a), ListedItem("a#2", a)], FINE)
    assert all(route.twins == () for route in copies)
    one, _ = routes_of([ListedItem("a", a), ListedItem("b", cases["b"][0])], FINE)
    assert one.text == "by shape: it is plain; like b"


def answer(item: Item, found_by: FoundBy = FoundBy.SHAPE) -> ItemObservation:
    bound = PoseNoise(0.002, 0.01)
    return ItemObservation(item.name, item, np.eye(4), 0.996, "", bound, None, found_by=found_by)


def test_twins_that_no_print_tells_apart_are_refused(cell: Cell) -> None:
    a, b = (plain_box(cell, name, (0.1, 0.06, 0.04)) for name in "ab")
    routes = [ItemRoute(None, "it is plain", ("b",)), ItemRoute(None, "it is plain", ("a",))]
    one, two = told_apart([answer(a), answer(b)], routes)
    assert one.refusal == "shape and colour do not tell it from b" and one.bound is None
    assert two.refusal == "shape and colour do not tell it from a" and two.confidence < 0.5
    assert [each.route for each in (one, two)] == routes
    for found_by in (
        (FoundBy.PRINT, FoundBy.SHAPE),
        (FoundBy.SHAPE, FoundBy.PRINT),
    ):  # what is left is the other
        told = told_apart([answer(a, found_by[0]), answer(b, found_by[1])], routes)
        assert all(each.is_answer and each.bound is not None for each in told)


def test_what_shows_no_print_that_was_looked_for_has_no_bound(cell: Cell) -> None:
    """Something else of about its shape, that nobody listed, may be there."""
    item = cell.item("dove_beauty_bar", 2016)
    for views, found_by, has_bound in (
        (SiftViews.ALL, FoundBy.SHAPE, False), (SiftViews.ALL, FoundBy.PRINT, True),
        (None, FoundBy.SHAPE, True),
    ):  # fmt: skip
        (told,) = told_apart([answer(item, found_by)], [ItemRoute(views)])
        assert told.is_answer and (told.bound is not None) == has_bound


def test_what_is_refused_has_no_bound(cell: Cell) -> None:
    item = cell.item("dove_beauty_bar", 2016)
    outside = replace(answer(item, FoundBy.PRINT), refusal="its middle is outside of bin_E")
    (told,) = told_apart([outside], [ItemRoute(SiftViews.ALL)])
    assert told.refusal == outside.refusal and told.bound is None


def test_of_copies_the_one_that_its_print_tells_is_not_refused(cell: Cell) -> None:
    a, b = (plain_box(cell, name, (0.1, 0.06, 0.04)) for name in "ab")
    routes = [ItemRoute(None, "", ("b",)), ItemRoute(None, "", ("b",)), ItemRoute(None, "", ("a",))]
    by_print, copy, twin = told_apart([answer(a, FoundBy.PRINT), answer(a), answer(b)], routes)
    assert by_print.is_answer and by_print.bound is not None and by_print.confidence == 0.996
    assert "do not tell it from b" in copy.refusal and "do not tell it from a" in twin.refusal


def test_pixels_per_mm_are_those_at_the_mouth(cell: Cell) -> None:
    place = cell.places["bin_E"]
    camera = PinholeCamera(1000.0, 1000.0, 320.0, 240.0, 640, 480)
    T_mouth = place.access.T_place_mouth
    T_look = np.array(
        [[0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]]
    )
    before = T_mouth @ pose((-0.5, 0.0, 0.0)) @ T_look
    assert pixels_per_mm(camera, before, place, np.eye(4)) == pytest.approx(2.0)
    assert pixels_per_mm(camera, T_mouth @ pose((0.5, 0.0, 0.0)) @ T_look, place, np.eye(4)) == 0.0


def test_the_routes_of_a_look_are_in_its_answers(cell: Cell) -> None:
    scene = make_scene({"bin_E": ("dove_beauty_bar", "womens_knit_gloves")}, cell, seed=6)
    seen = looked_at(scene, texture_seed=21)

    def perceived(rule: SiftRule) -> list[ItemObservation]:
        T = seen.T_world_place
        prints = PrintSearch(rule, 21)
        return list(perceive_items(seen.rgbd, seen.place, T, seen.listed, seen.known, prints).items)

    auto, none = perceived(SiftRule.AUTO), perceived(SiftRule.NONE)
    by_id = {each.id: each.route for each in auto}
    assert by_id == {
        "dove_beauty_bar": ItemRoute(SiftViews.ALL),
        "womens_knit_gloves": ItemRoute(None, "it is plain"),
    }
    assert {each.id: each.found_by for each in auto}["dove_beauty_bar"] is FoundBy.PRINT
    assert all(each.found_by is FoundBy.SHAPE for each in none)
    assert {each.route.why for each in none if each.route is not None} == {
        "prints are left out",
        "it is plain",
    }


def test_a_place_with_twins_says_so_and_claims_neither(cell: Cell) -> None:
    pair = {
        ("a", 2016): plain_box(cell, "a", (0.1, 0.07, 0.04)),
        ("b", 2016): plain_box(cell, "b", (0.1, 0.07, 0.04)),
    }
    scene = make_scene(
        {"bin_E": ("a", "b", "crayola_24_ct")}, replace(cell, items={**cell.items, **pair}), seed=3
    )
    seen = looked_at(scene, texture_seed=21)
    prints = PrintSearch(SiftRule.AUTO, 21)
    observed = perceive_items(seen.rgbd, seen.place, seen.T_world_place, seen.listed, seen.known, prints)
    told = {each.id: each for each in observed.items}
    assert told["a"].T_world_item is not None and told["b"].T_world_item is not None
    assert told["a"].refusal == "shape and colour do not tell it from b"
    assert told["b"].refusal == "shape and colour do not tell it from a"
    assert told["crayola_24_ct"].is_answer
    assert len(observed.unrecognised)
