"""Pushing an item off others: geometry against closed forms, and every reason against it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.errors import Reason
from pickcli.geometry import inverse, pose, rotation_rpy, transform_points
from pickcli.scene.scene import PlacedItem, PoseNoise
from pickcli.statics.pushing import HEAVIEST
from pickcli.statics.sliding import ALONG, BEYOND, FINE_STEP, LEAST_WAY, MOST_WAY, Slide, slides
from pickcli.statics.supports import supports_of
from support.standing import BOX, CRATES, NOISE, crate, lying

CARDS, BAR = "mead_index_cards", "dove_beauty_bar"
UNDER = lying(CARDS, 0.0, 0.0)
HIGH = float(UNDER.item.shape.extents[2]) + 0.0002


def on_it(x: float = 0.0, y: float = 0.0, yaw: float = 0.0) -> PlacedItem:
    """A box that lies on the cards."""
    placed = lying(BOX, x, y, up=HIGH)
    return replace(placed, T_world_item=placed.T_world_item @ pose(R=rotation_rpy(0.0, 0.0, yaw)))


def pushes(*items: PlacedItem, noise: PoseNoise = NOISE) -> tuple[Slide, ...]:
    found = slides(supports_of(crate(*items, noise=noise)), items[0].id)
    assert not isinstance(found, Reason), str(found)
    return found


def off(*items: PlacedItem, noise: PoseNoise = NOISE) -> list[Slide]:
    """The pushes that end past what carries the item."""
    return [push for push in pushes(*items, noise=noise) if push.is_free]


def why_not(*items: PlacedItem) -> str:
    found = slides(supports_of(crate(*items)), items[0].id)
    assert isinstance(found, Reason)
    return str(found)


@settings(max_examples=30, deadline=None)
@given(x=st.floats(-0.02, 0.02), y=st.floats(-0.02, 0.02), yaw=st.floats(-3.0, 3.0))
def test_its_centre_comes_past_what_carries_it_by_both_errors(x: float, y: float, yaw: float) -> None:
    items = on_it(x, y, yaw), UNDER
    scene = crate(*items)
    least = scene.bound(items[0]) + scene.bound(UNDER)
    for push in off(*items):
        end = push.centre + push.way * push.direction
        around = 2.0 * np.pi * np.arange(36) / 36
        circle = end + least * np.column_stack([np.cos(around), np.sin(around), np.zeros(36)])
        local = transform_points(inverse(UNDER.T_world_item), circle)[:, :2]
        assert not (np.abs(local) < UNDER.item.shape.extents[:2] / 2).all(axis=1).any()
        assert 0.0 < push.way <= MOST_WAY


def test_the_shortest_way_comes_first() -> None:
    ways = [push.way for push in off(on_it(0.02, 0.0), UNDER)]
    assert len(ways) > 4 and [round(way, 3) for way in ways] == sorted(round(way, 3) for way in ways)


@settings(max_examples=40, deadline=None)
@given(yaw=st.floats(0.01, 0.38), aside=st.floats(-0.01, 0.01))
def test_a_line_meets_the_near_side_by_the_closed_form(yaw: float, aside: float) -> None:
    """A line s aside enters the slab of half h that its direction meets under n, and ``across`` under a."""
    for push in pushes(on_it(yaw=yaw), UNDER, noise=PoseNoise(0.0, 0.0)):
        R, half = push.T_world_item[:3, :3], push.shape.extents / 2
        normal, across = push.direction @ R[:, :2], push.across @ R[:, :2]
        enters = -half[:2] / np.abs(normal) - aside * across / normal  # (-h - s a) / n for both slabs
        expected = float(enters.max())
        met = push.near_side(aside, float(push.centre[2]))
        assert expected - FINE_STEP - 1e-9 <= met <= expected + 1e-9


def test_its_top_is_where_it_ends() -> None:
    push = pushes(on_it(), UNDER)[0]
    top = push.centre[2] + push.shape.extents[2] / 2
    assert top - 2 * FINE_STEP <= push.top_at(0.0) <= top
    assert push.top_at(0.5) == -np.inf


def test_what_lies_on_the_floor_is_not_pushed_off() -> None:
    assert "it lies on no other item" in why_not(lying(BOX, 0.0, 0.0))


def test_what_is_heavy_or_bears_something_firm_stays() -> None:
    heavy = replace(on_it(), item=replace(CRATES.item(BOX), mass=HEAVIEST + 0.05))
    assert "at most 0.6" in why_not(heavy, UNDER)


def test_a_way_that_leads_against_another_is_none() -> None:
    items = on_it(), UNDER
    free = pushes(*items)
    beside = lying(BAR, 0.1, 0.0, up=HIGH)
    left = pushes(*items, beside)
    assert 0 < len(left) < len(free)
    x = CRATES.T_world_place(CRATES.places[UNDER.location])[:3, 0]
    assert all(push.direction @ x < 0.95 for push in left)


def test_where_no_way_leads_off_it_is_pushed_along() -> None:
    """Between two others as high as it is, across which it does not come off what it lies on."""
    wide = replace(UNDER, item=replace(UNDER.item, shape=replace(UNDER.item.shape, size=(0.3, 0.3, 0.02))))
    item = lying(BOX, 0.0, 0.0, up=0.0202)
    found = pushes(item, wide)
    assert found and not any(push.is_free and push.way <= MOST_WAY for push in found)
    assert all(LEAST_WAY <= push.way <= ALONG for push in found)
    ways = [push.way for push in found]
    assert ways == sorted(ways, reverse=True)


def test_a_place_without_walls_is_no_box() -> None:
    shelf = replace(lying(BOX, 0.1, 0.0, place="shelf_1_1"))
    assert "is no box that is open above" in why_not(shelf)


def test_the_way_is_the_shorter_the_nearer_it_lies_to_the_edge() -> None:
    ways = [{tuple(push.direction.round(6)): push.way for push in off(on_it(x), UNDER)} for x in (0.0, 0.02)]
    both = ways[0].keys() & ways[1].keys()
    ahead = CRATES.T_world_place(CRATES.places[UNDER.location])[:3, 0]
    nearer = [ways[1][d] - ways[0][d] for d in both if np.array(d) @ ahead > 0.1]
    assert nearer and max(nearer) < 0.0


@given(x=st.floats(-0.11, 0.11), y=st.floats(-0.08, 0.08), yaw=st.floats(-3.0, 3.0))
@settings(max_examples=40, deadline=None)
def test_wherever_it_lies_its_way_leads_forwards(x: float, y: float, yaw: float) -> None:
    """Its centre may be past the edge of what carries it already, as it leans on something else, too."""
    found = slides(supports_of(crate(on_it(x, y, yaw), UNDER)), BOX)
    if not isinstance(found, Reason):
        assert all(push.way > BEYOND for push in found)
