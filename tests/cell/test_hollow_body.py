"""Items with hollows in the engine: what is cut out is empty, and the rest is solid."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.hollow import Hollow
from pickcli.cell.hollow_body import N_AROUND, solids_of
from pickcli.cell.schemas.items_file import load_items
from pickcli.cell.shapes import Shape, ShapeKind, box
from pickcli.geometry import pose
from pickcli.simulation.engine import Engine
from pickcli.simulation.engine_bodies import MOST_SOLIDS
from pickcli.simulation.suction import face_at
from pickcli.simulation.world import TIME_STEP
from support.hollow_items import are_in_any, points_around, rectangular_hollows, round_hollows

Refused = Callable[[Callable[[], object]], str]

ITEMS = load_items()
BOWL, BRUSH = ITEMS["platinum_pets_dog_bowl", 2016], ITEMS["dr_browns_bottle_brush", 2016]
GREY = (0.5, 0.5, 0.5, 1.0)


@given(of=rectangular_hollows(), seed=st.integers(0, 99))
def test_a_box_is_solid_but_for_its_hollow(of: tuple[Shape, Hollow], seed: int) -> None:
    shape, hollow = of
    item = replace(BOWL, shape=shape, hollows=(hollow,))
    points = points_around(shape, 3000, seed)
    solid = are_in_any(points, [(each.shape, each.T_parent_shape) for each in solids_of(item)])
    np.testing.assert_array_equal(solid, shape.contains(points) & ~hollow.contains(shape, points))


@given(of=round_hollows(), seed=st.integers(0, 99))
def test_a_cylinder_is_solid_between_the_chords_of_its_wall(of: tuple[Shape, Hollow], seed: int) -> None:
    shape, hollow = of
    item, share = replace(BOWL, shape=shape, hollows=(hollow,)), float(np.cos(np.pi / N_AROUND))
    points = points_around(shape, 3000, seed)
    solid = are_in_any(points, [(each.shape, each.T_parent_shape) for each in solids_of(item)])
    assert hollow.radius is not None
    assert not solid[~shape.contains(points)].any()
    narrow = replace(hollow, radius=hollow.radius * share - 1e-9)
    assert not solid[narrow.contains(shape, points)].any()
    within = Shape(ShapeKind.CYLINDER, (shape.size[0] * share, shape.size[1]))
    assert solid[within.contains(points) & ~hollow.contains(shape, points)].all()


def test_solids_do_not_overlap_so_that_boxes_have_their_volume() -> None:
    found = solids_of(BRUSH)
    cut = sum(float(np.prod(np.ptp(hollow.bounds(BRUSH.shape), axis=0))) for hollow in BRUSH.hollows)
    assert sum(each.shape.volume for each in found) == pytest.approx(BRUSH.shape.volume - cut)
    assert len(found) <= MOST_SOLIDS


def test_an_item_without_hollows_is_its_shape() -> None:
    (body,) = solids_of(replace(BOWL, hollows=()))
    assert body.shape == BOWL.shape


def test_too_many_pieces_are_one_clear_error(refused: Refused) -> None:
    shape = Shape(ShapeKind.BOX, (0.4, 0.4, 0.05))
    spans = [(-0.19 + 0.08 * k, -0.13 + 0.08 * k) for k in range(5)]
    hollows = tuple(
        Hollow(f"h{i}{j}", "+z", 0.03, None, (x, y)) for i, x in enumerate(spans) for j, y in enumerate(spans)
    )
    item = replace(BOWL, shape=shape, hollows=hollows)
    assert len(solids_of(item)) > MOST_SOLIDS
    message = refused(lambda: Engine(TIME_STEP).add_item("bowl", item, np.eye(4), GREY))
    assert "item platinum_pets_dog_bowl: its hollows divide it into" in message
    assert "state fewer" in message


def lowest_of_a_ball_over(item_hollows: tuple[Hollow, ...]) -> float:
    """Height in m over the ground at which the middle of a ball of 10 mm rests that fell onto a bowl."""
    engine = Engine(TIME_STEP)
    engine.add_static(box("ground", (-1.0, -1.0, -0.1), (1.0, 1.0, 0.0)), np.eye(4), GREY)
    bowl = replace(BOWL, hollows=item_hollows)
    engine.add_item("bowl", bowl, pose([0.0, 0.0, BOWL.shape.size[1] / 2]), GREY)
    ball = replace(BOWL, name="ball", shape=Shape(ShapeKind.SPHERE, (0.01,)), hollows=(), mass=0.02)
    engine.add_item("ball", ball, pose([0.005, 0.0, 0.06]), GREY)
    for _ in range(round(1.0 / TIME_STEP)):
        engine.step()
    height = float(engine.pose("ball")[2, 3])
    engine.close()
    return height


def test_a_ball_falls_into_the_bowl_and_stays_on_the_rim_without_a_hollow() -> None:
    assert lowest_of_a_ball_over(BOWL.hollows) == pytest.approx(0.031 - 0.03 + 0.01, abs=1e-3)
    assert lowest_of_a_ball_over(()) == pytest.approx(0.031 + 0.01, abs=1e-3)


@pytest.mark.parametrize(
    ("point", "face"),
    [
        ((0.0, 0.0, -0.0145), "+z/bowl"),
        ((0.0, 0.01, -0.0149), "+z/bowl"),
        ((0.0, 0.0, 0.0155), "+z"),
        ((0.0, 0.045, 0.0155), "+z"),
        ((0.0, 0.0, -0.0155), "-z"),
        ((0.0595, 0.0, -0.008), "mantle"),
    ],
)
def test_the_cup_is_on_the_bottom_where_it_is_in_the_hollow(
    point: tuple[float, float, float], face: str
) -> None:
    assert face_at(BOWL, np.array(point)) == face
    assert face in BOWL.face_names
