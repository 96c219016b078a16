"""Toppling a box: its geometry by closed form, and every reason for which it must not be toppled."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from pickcli.errors import Reason
from pickcli.geometry import pose
from pickcli.scene.scene import PlacedItem, PoseNoise
from pickcli.statics.pushing import HEAVIEST
from pickcli.statics.supports import supports_of
from pickcli.statics.toppling import BEYOND, FRICTION, Topple, topples
from support.standing import BOX, CRATES, NOISE, SHELF, box, crate, lying, standing

EXACT = PoseNoise(0.0, 0.0)
FACES = CRATES.item(BOX).shape.face_names


def pushes(*items: PlacedItem, noise: PoseNoise = NOISE) -> tuple[Topple, ...]:
    found = topples(supports_of(crate(*items, noise=noise)), items[0].id)
    assert not isinstance(found, Reason), str(found)
    return found


def why_not(*items: PlacedItem) -> str:
    found = topples(supports_of(crate(*items)), items[0].id)
    assert isinstance(found, Reason)
    return str(found)


def test_it_is_pushed_across_its_thin_side_from_both_sides() -> None:
    first, second = pushes(standing(BOX, 0.0, 0.0))
    assert {first.face, second.face} == {"+z", "-z"}
    assert first.direction @ second.direction == pytest.approx(-1.0)
    for push in (first, second):
        R = crate(standing(BOX, 0.0, 0.0)).find(BOX).T_world_item[:3, :3]
        normal = R[:, 2] if push.face == "+z" else -R[:, 2]
        assert normal @ push.direction == pytest.approx(-1.0)  # from outside, against that face


@settings(max_examples=60, deadline=None)
@given(
    width=st.floats(0.01, 0.04), height=st.floats(0.06, 0.09), share=st.floats(0.6, 0.95),
    tilt=st.floats(0.01, 0.6), yaw=st.floats(-3.0, 3.0),
)  # fmt: skip
def test_its_near_side_moves_by_the_closed_form(
    width: float, height: float, share: float, tilt: float, yaw: float
) -> None:
    """At height z the face of a box that turned by a about its far edge is w + z tan(a) - w / cos(a) on."""
    placed = standing(BOX, 0.0, 0.0, yaw, item=box(0.1, height, width))
    push = pushes(placed, noise=EXACT)[0]
    top = height * np.cos(tilt) + width * np.sin(tilt)
    z = share * top
    assume(width * np.sin(tilt) < z < height)
    moved = push.near_side(push.edge[1] + z, tilt) - push.near_side(push.edge[1] + z)
    assert moved == pytest.approx(width + z * np.tan(tilt) - width / np.cos(tilt), abs=1e-9)
    assert push.near_side(push.edge[1] + 1.01 * top, tilt) == np.inf


@settings(max_examples=40, deadline=None)
@given(width=st.floats(0.01, 0.04), height=st.floats(0.06, 0.09))
def test_it_is_turned_until_its_centre_is_past_the_edge(width: float, height: float) -> None:
    for noise in (EXACT, NOISE):
        push = pushes(standing(BOX, 0.0, 0.0, item=box(0.1, height, width)), noise=noise)[0]
        balance = np.arctan2(width, height)
        assert push.tilt == pytest.approx(balance + BEYOND + noise.angle, abs=1e-6)
        turned = push._turned(push.tilt).mean(axis=0)
        assert turned[0] > push.edge[0]


def test_a_push_lower_than_friction_allows_slides_it() -> None:
    """By the moments about the far edge: what friction holds, and the lift of the near side."""
    width = 0.035
    push = pushes(standing(BOX, 0.0, 0.0, item=box(0.13, 0.054, width)))[0]
    force = FRICTION / (1.0 + FRICTION**2)  # in weights: f (1 - f F) with F lifting by friction f
    least = (width / 2 - force * FRICTION * width) / force
    assert push.lowest - push.edge[1] == pytest.approx(max(least, 0.027), abs=1e-6)
    assert not push.sliding
    for wide in pushes(standing(BOX, 0.0, 0.0, item=box(0.13, 0.07, 0.07))):
        assert wide.sliding == "it would slide: 35 mm to its edge, 67 mm high"
    assert "it would slide" in why_not(standing(BOX, 0.0, 0.0, item=box(0.13, 0.07, 0.095)))


def test_it_names_the_face_on_top() -> None:
    upright = standing(BOX, 0.0, 0.0, 0.7)
    assert {push.upper for push in pushes(upright)} == {"+y"}
    over = replace(upright, T_world_item=upright.T_world_item @ pose((0.0, 0.0, 0.0), rpy=(np.pi, 0.0, 0.0)))
    assert {push.upper for push in pushes(over)} == {"-y"}


def test_beside_a_wall_it_only_falls_away_from_it() -> None:
    (push,) = pushes(standing(BOX, 0.16, 0.0))
    assert push.direction[0] == pytest.approx(-1.0)
    assert "no room to fall: crate_right_wall" in why_not(
        standing(BOX, 0.0, 0.12, np.pi / 2), lying("mead_index_cards", 0.0, 0.055, up=0.05)
    )


def test_it_may_fall_over_what_is_low_but_not_against_what_is_high() -> None:
    low = lying("staples_index_cards", 0.09, 0.0)
    assert len(pushes(standing(BOX, 0.0, 0.0), low)) == 2
    high = standing("dove_beauty_bar", 0.07, 0.0)
    (push,) = pushes(standing(BOX, 0.0, 0.0), high)
    assert push.direction[0] == pytest.approx(-1.0)


@pytest.mark.parametrize(
    ("item", "why"),
    [
        (box(0.1, 0.08, 0.03, mass=HEAVIEST), "kg with all on it"),
        (box(0.25, 0.08, 0.03), "over the rim"),
        (replace(box(0.1, 0.08, 0.03), seals=dict.fromkeys(FACES, 0.0)), "no upright face"),
    ],
)  # fmt: skip
def test_what_is_heavy_or_could_leave_the_box_or_gains_nothing_stays(item: object, why: str) -> None:
    assert why in why_not(standing(BOX, 0.0, 0.0, item=item))  # type: ignore[arg-type]


def test_in_a_bin_a_box_turns_over_to_a_side_only() -> None:
    across = standing(BOX, 0.1, 0.0, place=SHELF)
    assert "in a bin it may only turn over to a side" in why_not(across)
    along = standing(BOX, 0.1, 0.0, np.pi / 2, place=SHELF)
    assert {push.face for push in pushes(along)} == {"+z", "-z"}
    assert all(abs(push.direction[1]) == pytest.approx(1.0) for push in pushes(along))
    askew = standing(BOX, 0.1, 0.0, np.radians(78.0), place=SHELF)
    assert "in a bin it may only turn over to a side" in why_not(askew)


@pytest.mark.parametrize(
    ("x", "mass", "why"), [(0.04, 0.1, "mm out of the mouth"), (0.1, HEAVIEST, "kg, at most")]
)
def test_what_reaches_out_of_a_bin_or_is_heavy_stays(x: float, mass: float, why: str) -> None:
    item = box(0.095, 0.07, 0.025, mass=mass)
    assert why in why_not(standing(BOX, x, 0.0, np.pi / 2, item=item, place=SHELF))


def test_in_a_bin_nothing_may_rest_on_it() -> None:
    height = float(CRATES.item(BOX).shape.extents[1]) + 0.0004
    on_it = lying("mead_index_cards", 0.1, 0.0, up=height, place=SHELF)
    assert "rests or leans on it" in why_not(standing(BOX, 0.1, 0.0, np.pi / 2, place=SHELF), on_it)


def test_only_boxes_that_stand_on_edge_are_toppled() -> None:
    assert "its shape is no box" in why_not(lying("rawlings_baseball", 0.0, 0.0))
    assert "no upright face of it seals" in why_not(lying("mead_index_cards", 0.0, 0.0))


def test_what_lies_on_it_counts() -> None:
    height = float(CRATES.item(BOX).shape.extents[1]) + 0.0004
    on_it = lying("mead_index_cards", 0.0, 0.0, up=height)
    heavy = replace(on_it, item=replace(on_it.item, mass=HEAVIEST))
    assert "kg with all on it" in why_not(standing(BOX, 0.0, 0.0), heavy)
