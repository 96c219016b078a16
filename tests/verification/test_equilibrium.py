"""Equilibrium of rigid bodies against textbook statics: slopes, edges, ladders, levers, wedges."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, pose
from pickcli.verification.equilibrium import (
    CONTACT_HALF_WIDTH,
    FRICTION,
    PileContact,
    RigidBody,
    missing_to_balance,
)

UP = np.array([0.0, 0.0, 1.0])
TOUCH = 1e-4
BLOCK = Shape(ShapeKind.BOX, (0.1, 0.06, 0.04))
CUBE = Shape(ShapeKind.BOX, (0.1, 0.1, 0.1))


def floor(T: Array | None = None) -> RigidBody:
    """A plate whose top is at height 0 in its own frame."""
    T_plate = (np.eye(4) if T is None else T) @ pose((0.0, 0.0, -0.5))
    return RigidBody("floor", Shape(ShapeKind.BOX, (4.0, 4.0, 1.0)), T_plate, np.inf)


def body(name: str, shape: Shape, T: Array, mass: float = 1.0) -> RigidBody:
    return RigidBody(name, shape, T, mass)


def missing(*bodies: RigidBody, up: Array = UP, mirrored: bool = False) -> dict[str, float]:
    """What is missing to the balance of the bodies that are not firm, from all contacts between them."""
    contacts: list[PileContact] = []
    for k, a in enumerate(bodies):
        for b in bodies[k + 1 :]:
            contact = PileContact.between(a, b, TOUCH, 0.0)
            if contact is not None:
                contacts.append(contact.flipped if mirrored else contact)
    free = [each for each in bodies if not each.is_firm]
    return missing_to_balance(free, contacts, up)


def is_at_rest(*bodies: RigidBody) -> bool:
    return max(missing(*bodies).values()) < 1e-6


@pytest.mark.parametrize("turn", [0.0, 0.7])
@pytest.mark.parametrize("beyond", [-0.02, 0.02])
def test_a_block_slides_where_the_slope_is_steeper_than_its_friction(beyond: float, turn: float) -> None:
    """Down the fall line friction holds tan(slope); aside of the pyramid's edges somewhat less."""
    slope = float(np.arctan(FRICTION)) * (1.0 + beyond)
    T = pose(rpy=(0.0, slope, 0.0))
    up = T[:3, :3].T @ UP
    block = body("block", BLOCK, pose((0.0, 0.0, 0.02), rpy=(0.0, 0.0, turn)))
    less = missing(block, floor(), up=up)["block"]
    if beyond < 0.0:
        assert less < 1e-6
    else:
        assert less > 0.5 * (np.sin(slope) - FRICTION * np.cos(slope))


def test_what_is_missing_on_a_slope_is_the_part_of_the_weight_that_friction_does_not_hold() -> None:
    slope = 0.6
    T = pose(rpy=(0.0, slope, 0.0))
    up = np.asarray(T[:3, :3].T @ UP)
    less = missing(body("ball", Shape(ShapeKind.SPHERE, (0.05,)), pose((0.0, 0.0, 0.05))), floor(), up=up)
    assert less["ball"] >= np.sin(slope) - FRICTION * np.cos(slope)
    assert less["ball"] <= 2.0 * np.sin(slope)


@pytest.mark.parametrize(("out", "rests"), [(-0.002, True), (0.002, False)])
@pytest.mark.parametrize("way", [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)])
def test_a_block_over_an_edge_rests_while_its_centre_is_within(
    out: float, rests: bool, way: tuple[float, float]
) -> None:
    at = np.array(way) * (0.05 + out)
    block = body("block", BLOCK, pose((*at, 0.12), rpy=(0.0, 0.0, 0.3)))
    assert is_at_rest(block, RigidBody("pier", CUBE, pose((0.0, 0.0, 0.05)), np.inf)) is rests


def test_a_narrow_edge_bears_by_its_breadth() -> None:
    cube = body("cube", CUBE, pose((0.0, 0.0, 0.05 * np.sqrt(2.0)), rpy=(np.pi / 4, 0.0, 0.0)))
    for aside, rests in ((0.8 * CONTACT_HALF_WIDTH, True), (1.5 * CONTACT_HALF_WIDTH, False)):
        angle = aside / (0.05 * np.sqrt(2.0))
        up = np.array([0.0, np.sin(angle), np.cos(angle)])
        assert (missing(cube, floor(), up=up)["cube"] < 1e-6) is rests


@pytest.mark.parametrize(("degrees", "rests"), [(-1.5, False), (1.5, True)])
def test_a_ladder_leans_up_to_the_angle_that_friction_allows(degrees: float, rests: bool) -> None:
    """Uniform, with the same friction at floor and wall: tan(angle) = (1 - mu^2) / (2 mu)."""
    angle = float(np.arctan((1.0 - FRICTION**2) / (2.0 * FRICTION)) + np.radians(degrees))
    length, thick = 1.0, 0.002
    ladder = Shape(ShapeKind.BOX, (length, 0.3, thick))
    middle = length / 2 * np.array([np.cos(angle), np.sin(angle)])
    across = thick / 2 * np.array([np.sin(angle), np.cos(angle)])
    T = pose((float(middle[0] + across[0]), 0.0, float(middle[1] + across[1])), rpy=(0.0, angle, 0.0))
    wall = RigidBody("wall", Shape(ShapeKind.BOX, (1.0, 1.0, 3.0)), pose((-0.5, 0.0, 1.5)), np.inf)
    reach = T @ np.array([[-length / 2, 0, s * thick / 2, 1.0] for s in (-1, 1)]).T
    T = pose((-float(reach[0].min()), 0.0, 0.0)) @ T
    low = float((T @ np.array([[length / 2, 0, s * thick / 2, 1.0] for s in (-1, 1)]).T)[2].min())
    T = pose((0.0, 0.0, -low)) @ T
    assert is_at_rest(body("ladder", ladder, T), floor(), wall) is rests


@pytest.mark.parametrize(("mass", "rests"), [(0.9, False), (1.1, True)])
def test_a_counterweight_holds_a_plank_by_its_lever(mass: float, rests: bool) -> None:
    """The plank's middle is 20 mm past the edge of the pier, the weight's 20 mm inside of it."""
    pier = RigidBody("pier", CUBE, pose((0.0, 0.0, 0.05)), np.inf)
    plank = body("plank", Shape(ShapeKind.BOX, (0.3, 0.1, 0.02)), pose((0.07, 0.0, 0.11)))
    weight = body("weight", Shape(ShapeKind.BOX, (0.02, 0.02, 0.02)), pose((0.03, 0.0, 0.13)), mass)
    assert is_at_rest(pier, plank, weight) is rests
    assert not is_at_rest(pier, plank)


def test_who_hangs_in_the_air_lacks_its_weight_and_nobody_else_lacks_anything() -> None:
    lying = body("lying", BLOCK, pose((0.0, 0.0, 0.02)))
    hanging = body("hanging", BLOCK, pose((1.0, 0.0, 0.3)))
    assert missing(lying, hanging, floor()) == pytest.approx({"lying": 0.0, "hanging": 1.0}, abs=1e-6)


def test_two_cards_lean_on_each_other_and_one_alone_does_not() -> None:
    lean, length = 0.2, 0.2
    card = Shape(ShapeKind.BOX, (0.1, 0.001, length))
    y, z = length / 2 * np.sin(lean), length / 2 * np.cos(lean)
    left = body("left", card, pose((0.0, -y - 0.0005, z), rpy=(-lean, 0.0, 0.0)))
    right = body("right", card, pose((0.0, y + 0.0005, z), rpy=(lean, 0.0, 0.0)))
    assert is_at_rest(left, right, floor())
    assert not is_at_rest(left, floor())


def test_walls_hold_by_friction_what_is_wedged_between_them_and_one_wall_does_not() -> None:
    left, right = (RigidBody(f"wall{s}", CUBE, pose((s * 0.1, 0.0, 0.05)), np.inf) for s in (-1, 1))
    block = body("block", CUBE, pose((0.0, 0.0, 0.05)))
    assert is_at_rest(block, left, right)
    assert missing(block, left)["block"] == pytest.approx(1.0, abs=1e-6)


@given(
    st.integers(0, 10_000),
    st.floats(0.05, 20.0),
    st.tuples(*[st.floats(-3.0, 3.0)] * 3),
)
@settings(max_examples=25, deadline=None, derandomize=True)
def test_neither_units_of_mass_nor_the_frame_nor_the_order_matter(
    seed: int, heavier: float, rpy: tuple[float, float, float]
) -> None:
    rng = np.random.default_rng(seed)
    pile: list[RigidBody] = [floor()]
    z = 0.0
    for k in range(3):
        size = rng.uniform(0.02, 0.1, 3)
        T = pose(
            (*rng.uniform(-0.04, 0.04, 2).tolist(), z + float(size[2]) / 2), rpy=(0, 0, rng.uniform(-3, 3))
        )
        pile.append(
            body(f"b{k}", Shape(ShapeKind.BOX, tuple(size.tolist())), T, float(rng.uniform(0.1, 2.0)))
        )
        z += float(size[2])
    found = sum(missing(*pile).values())
    T_new = pose((0.3, -0.2, 0.1), rpy=rpy)
    moved = [RigidBody(b.name, b.shape, T_new @ b.T, b.mass * heavier) for b in pile]
    for same in (
        missing(*moved, up=T_new[:3, :3] @ UP),
        missing(*reversed(pile)),
        missing(*pile, mirrored=True),
    ):  # sums of components depend on the frame, and cones of friction on how they are turned
        assert (found - 0.05) / 2.0 <= sum(same.values()) <= 2.0 * found + 0.05
