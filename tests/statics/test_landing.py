"""What falls a little onto another item stays there if its energy is too little to tip; physics judges."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.geometry import pose, rotation_axis_angle
from pickcli.scene.scene import Scene
from pickcli.simulation.engine import Engine
from pickcli.statics.landing import DIRECTIONS, N_DIRECTIONS, stays_on
from pickcli.verification.landing_statics import tips_as_it_lands
from support.bin_piles import EXACT, at, shaped

CELL = load_cell("apc2016_delft")
STAND = 0.3  # m, height of what carries it


def on_a_disc(size: tuple[float, ...], radius: float, aside: float) -> np.ndarray:
    """How far a disc that a box lies on reaches from below its centre."""
    own = Shape(ShapeKind.BOX, size).reach(DIRECTIONS)
    return np.minimum(own, DIRECTIONS[:, 0] * -aside + radius)


def turned_by_the_fall(
    size: tuple[float, ...], radius: float, aside: float, fall: float, tilt: float
) -> float:
    """How far in rad a box has turned 1 s after it was let go over a post, aside of its axis.

    tilt: rad, of the box, inwards: it meets the far edge first
    """
    engine = Engine(1e-3)
    try:
        post = Body("post", Shape(ShapeKind.CYLINDER, (radius, STAND)), pose([0.0, 0.0, STAND / 2]))
        engine.add_static(post, np.eye(4), (0.5, 0.5, 0.5, 1.0))
        item = replace(shaped(CELL, size), mass=0.2)
        R = rotation_axis_angle(np.array([0.0, 1.0, 0.0]), -tilt)
        low = float(item.shape.reach(R)[2])
        start = pose([aside, 0.0, STAND + low + fall - 0.5 * np.sin(tilt) * radius], R=R)
        engine.add_item("box", item, start, (0.8, 0.2, 0.2, 1.0))
        for _ in range(1000):
            engine.step()
        up = engine.pose("box")[:3, 2]
    finally:
        engine.close()
    return float(np.arccos(np.clip(up[2], -1.0, 1.0)))


@pytest.mark.parametrize("tilt", [0.0, 0.014, 0.03])
@pytest.mark.parametrize("size", [(0.146, 0.121, 0.05), (0.08, 0.06, 0.04), (0.2, 0.16, 0.02)])
def test_what_is_said_to_stay_stays_in_physics(size: tuple[float, float, float], tilt: float) -> None:
    """As far aside as the law allows, and falling as far as any release may."""
    radius, fall = 0.05, 0.01
    shape = Shape(ShapeKind.BOX, size)
    asides = np.linspace(0.0, radius, 101)
    staying = [a for a in asides if stays_on(shape, np.eye(3), on_a_disc(size, radius, a), 0.0, fall)]
    assert staying and staying[-1] < radius - 0.005
    assert turned_by_the_fall(size, radius, staying[-1], fall, tilt) < 0.05


def test_a_box_beside_the_middle_of_a_can_turned_over_its_edge() -> None:
    """146 x 121 x 50 mm, 44 mm aside of a can of 50 mm, let go 8.6 mm above it with a small tilt."""
    size = (0.146, 0.121, 0.05)
    assert not stays_on(Shape(ShapeKind.BOX, size), np.eye(3), on_a_disc(size, 0.05, 0.044), 0.0, 0.0086)
    assert turned_by_the_fall(size, 0.05, 0.044, 0.0086, 0.014) > 0.5


@given(
    st.tuples(*[st.floats(0.03, 0.25)] * 3), st.floats(0.02, 0.15), st.floats(0.0, 0.1), st.floats(0.0, 0.02)
)
def test_less_fall_and_less_error_never_make_it_tip(
    size: tuple[float, float, float], radius: float, aside: float, fall: float
) -> None:
    shape, reaches = Shape(ShapeKind.BOX, size), on_a_disc(size, radius, aside)
    if stays_on(shape, np.eye(3), reaches, 0.004, fall):
        assert stays_on(shape, np.eye(3), reaches, 0.004, fall / 2)
        assert stays_on(shape, np.eye(3), reaches, 0.0, fall)
        assert reaches.min() > 0.004


@settings(deadline=None, max_examples=60)
@given(
    st.tuples(*[st.floats(0.04, 0.12)] * 3),
    st.floats(0.03, 0.05),
    st.floats(0.0, 0.04),
    st.floats(0.002, 0.015),
)
def test_the_verifier_judges_by_the_same_law(
    size: tuple[float, float, float], radius: float, aside: float, fall: float
) -> None:
    """Planner and verifier have each their own; they may differ only at the edge."""
    can = at(CELL, "can", shaped(CELL, (radius, 0.06), ShapeKind.CYLINDER), 0.3, 0.0, 0.03)
    box = at(CELL, "box", shaped(CELL, size), 0.3 + aside, 0.0, 0.06 + fall + size[2] / 2)
    tips = tips_as_it_lands(Scene(CELL, CELL.T_world_pod, (can, box), EXACT), "box")
    shape, reaches = Shape(ShapeKind.BOX, size), on_a_disc(size, radius, aside)
    stays = [stays_on(shape, np.eye(3), reaches, error, fall) for error in (-2e-4, 2e-4)]
    assert stays[0] is not stays[1] or tips is not stays[0]


def test_what_also_lies_on_the_floor_is_judged_by_that_alone(cell: Cell) -> None:
    thin = at(cell, "thin", shaped(cell, (0.05, 0.05, 0.001)), 0.3, 0.06, 0.0005)
    box = at(cell, "box", shaped(cell, (0.1, 0.15, 0.03)), 0.3, 0.0, 0.0158)
    assert not tips_as_it_lands(Scene(cell, cell.T_world_pod, (thin, box), EXACT), "box")
    assert N_DIRECTIONS % 2 == 0
