"""Corridors through the mouth of a bin, for items that are told what is free."""

from __future__ import annotations

from typing import cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pickcli.cartesian.corridor import (
    LEAST_LIP_DISTANCE,
    RETREAT_DISTANCE,
    LiftPoses,
    corridor_transforms,
    corridors,
)
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.collision.free_flyer import FreeItemChecker
from pickcli.collision.kernel_validator import Contact
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, inverse, pose, transform_points
from support.front_places import front_place

BIN = front_place()
FIRST = 0.05
MOST = 4


class Open:
    """An item by itself with nothing in its way, but for lifts below a height."""

    margin = 0.005

    def __init__(self, wall: float = 0.0) -> None:
        self.wall = wall

    def is_valid(self, d: Array) -> bool:
        return bool(d[2] >= self.wall)

    def are_valid(self, D: Array) -> NDArray[np.bool_]:
        return np.array([self.is_valid(d) for d in D])

    def is_valid_path(self, Q: Array, slack: Array | None = None) -> bool:
        return self.first_blocked_edge(Q, slack) < 0

    def first_blocked_edge(self, D: Array, slack: Array | None = None) -> int:
        return -1

    def clearance(self, d: Array) -> Contact:
        return Contact(0.001, "item", "neighbour", "item")

    def clearances(self, D: Array) -> Array:
        return np.array([self.clearance(d).distance for d in D])

    def explain(self, d: Array) -> Reason:
        contact = self.clearance(d)
        return Reason("collision", "", str(contact), contact.item)


def alone(wall: float = 0.0) -> FreeItemChecker:
    return cast(FreeItemChecker, Open(wall))


def corners(T: Array, extents: tuple[float, ...]) -> Array:
    signs = np.array([[i, j, k] for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    return transform_points(T, signs * np.array(extents) / 2)


@given(
    st.floats(0.08, 0.35),
    st.floats(-0.08, 0.08),
    st.floats(0.02, 0.12),
    st.floats(-3.1, 3.1),
    st.floats(-0.08, 0.08),
)
def test_the_item_passes_the_mouth_and_ends_outside(
    x: float, y: float, size: float, yaw: float, pitch: float
) -> None:
    extents = (size, size * 0.7, size * 0.9)
    T_item = BIN.T_carrier_place @ pose([x, y, -0.0297 + size / 2], rpy=[0.0, pitch, yaw])
    found = corridors(
        BIN,
        inverse(BIN.T_carrier_place) @ T_item,
        Shape(ShapeKind.BOX, extents),
        alone(),
        alone(),
        FIRST,
        MOST,
    )
    assert isinstance(found, tuple) and found
    contact = T_item @ pose([0.01, -0.02, size / 2], rpy=[np.pi, 0.0, 0.3])
    for corridor in found:
        poses = LiftPoses.of(corridor_transforms(corridor, BIN.T_carrier_place, T_item[:3, 3]) @ contact)
        moved = inverse(BIN.T_carrier_place) @ poses.lift @ inverse(contact) @ T_item
        at_lift = corners(moved, extents)
        assert at_lift[:, 2].min() >= LEAST_LIP_DISTANCE - 1e-9
        assert at_lift[:, 2].max() <= BIN.access.height - LEAST_LIP_DISTANCE + 1e-9
        assert np.abs(at_lift[:, 1]).max() <= BIN.access.width / 2 - LEAST_LIP_DISTANCE + 1e-9
        out = corners(inverse(BIN.T_carrier_place) @ poses.retreat[-1] @ inverse(contact) @ T_item, extents)
        assert out[:, 0].max() <= -RETREAT_DISTANCE + 1e-9
        assert np.linalg.norm(corridor.first_stretch[:3]) <= FIRST + 1e-9


def test_an_item_that_only_fits_when_turned_is_turned() -> None:
    T_item = pose([0.2, 0.0, 0.0], rpy=[0.0, 0.0, 0.35])
    shape = Shape(ShapeKind.BOX, (0.15, 0.27, 0.05))  # 0.305 m wide as it lies, the mouth has 0.299
    found = corridors(BIN, T_item, shape, alone(), alone(), FIRST, MOST)
    assert isinstance(found, tuple) and found
    assert all(abs(c.lift[3] + 0.35) < 0.02 for c in found)


@pytest.mark.parametrize("yaw", [0.0, 0.05, np.pi])
def test_what_is_wider_than_the_mouth_rolls_until_it_fits(yaw: float) -> None:
    extents = (0.145, 0.31, 0.02)  # the mouth is 299 mm wide, the bin behind it may be wider
    T_entry_item = pose([0.2, 0.0, 0.0], rpy=[0.0, 0.0, yaw])
    found = corridors(BIN, T_entry_item, Shape(ShapeKind.BOX, extents), alone(), alone(), FIRST, 100)
    assert isinstance(found, tuple)
    assert {np.sign(c.lift[5]) for c in found} == {-1.0, 1.0}
    for c in found:
        moved = corridor_transforms(c, np.eye(4), T_entry_item[:3, 3]) @ T_entry_item
        out = corners(moved[-1], extents)
        assert np.ptp(out[:, 1]) <= BIN.access.width - 2 * LEAST_LIP_DISTANCE + 1e-9
        assert np.ptp(out[:, 2]) <= BIN.access.height - 2 * LEAST_LIP_DISTANCE + 1e-9
    # Some sink no side of it while it may touch what it lies on.
    first = [corridor_transforms(c, np.eye(4), T_entry_item[:3, 3])[0] @ T_entry_item for c in found]
    lowest = [corners(T, extents)[:, 2].min() for T in first]
    assert sum(z >= -0.0101 for z in lowest) >= len(found) // 2


def test_what_rolls_may_go_to_the_middle_of_its_bin_first_and_aside_last() -> None:
    wide = front_place(y_range=(-0.175, 0.1494))  # behind a post
    T_entry_item, extents = pose([0.2, -0.01, 0.0]), (0.145, 0.31, 0.02)
    found = corridors(wide, T_entry_item, Shape(ShapeKind.BOX, extents), alone(), alone(), FIRST, 1000)
    assert isinstance(found, tuple)
    middle = sum(wide.room.y_range) / 2
    late = [c for c in found if len(c.retreat) == 2]
    assert late
    for c in late:
        assert T_entry_item[1, 3] + c.first_stretch[1] == pytest.approx(middle)
        assert c.lift[1] == c.first_stretch[1] and np.linalg.norm(c.first_stretch[:3]) <= FIRST + 1e-9
        np.testing.assert_array_equal(c.retreat[0][3:], c.lift[3:])  # it has rolled before it goes aside


def test_a_steep_item_rolls_and_is_levelled_where_only_both_together_fit() -> None:
    low = front_place(0.249, 0.175, (-0.136, 0.136))
    T_entry_item = pose([0.15, 0.0, 0.0], rpy=[0.0, 0.09, 0.0])
    shape = Shape(ShapeKind.BOX, (0.16, 0.25, 0.03))
    found = corridors(low, T_entry_item, shape, alone(), alone(), FIRST, 1000)
    assert isinstance(found, tuple) and found
    assert all(c.lift[4] < 0.0 != c.lift[5] for c in found)


def test_what_fits_as_it_lies_is_not_rolled() -> None:
    found = corridors(
        BIN,
        pose([0.2, 0.0, 0.0]),
        Shape(ShapeKind.BOX, (0.1, 0.2, 0.05)),
        alone(),
        alone(),
        FIRST,
        100,
    )
    assert isinstance(found, tuple) and found
    assert all(c.lift[5] == 0.0 for c in found)


def test_too_tall_an_item_is_refused_with_its_size() -> None:
    failures = corridors(
        BIN,
        pose([0.2, 0.0, 0.08]),
        Shape(ShapeKind.BOX, (0.1, 0.28, 0.23)),
        alone(),
        alone(),
        FIRST,
        MOST,
    )
    assert isinstance(failures, Failures)
    assert all("280 x 230 mm" in reason.detail for reason in failures)


def test_higher_lifts_are_tried_and_a_wall_is_named() -> None:
    shape = Shape(ShapeKind.BOX, (0.1, 0.1, 0.05))
    found = corridors(BIN, pose([0.2, 0.0, 0.0]), shape, alone(0.1), alone(0.1), FIRST, MOST)
    assert isinstance(found, tuple) and min(c.lift[2] for c in found) >= 0.1
    failures = corridors(BIN, pose([0.2, 0.0, 0.0]), shape, alone(9.0), alone(9.0), FIRST, MOST)
    assert isinstance(failures, Failures) and failures.in_the_way == ("neighbour",)


class BetweenWalls(Open):
    """Nothing comes out: straight ahead for a wall, aside for a neighbour."""

    def __init__(self) -> None:
        super().__init__(9.0)

    def clearance(self, d: Array) -> Contact:
        other = ("wall", "pod") if d[1] == 0.0 else ("neighbour", "item")
        return Contact(0.001, "item", *other)


def test_what_only_longer_corridors_meet_is_named() -> None:
    shape, walled = Shape(ShapeKind.BOX, (0.1, 0.1, 0.05)), cast(FreeItemChecker, BetweenWalls())
    failures = corridors(BIN, pose([0.2, 0.0, 0.0]), shape, walled, walled, FIRST, MOST)
    assert isinstance(failures, Failures)
    assert "wall" in failures.reasons[0].detail and failures.in_the_way == ("neighbour",)
