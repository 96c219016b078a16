"""What carries an item and over which edge it tips: each step against what can be counted by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.pod_tolerance import Displacement
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import GRAVITY, Array, pose
from pickcli.scene.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.scene.solid_overlap import TOUCH
from pickcli.verification.tipping_check import (
    N_HALVINGS,
    Press,
    _along,
    _beside,
    _edges,
    _energy,
    _heights,
    _others,
    _outside,
    _support,
    beside_support,
    falls_over,
)
from support.handmade_plans import cell, make_scene
from support.solid_oracles import is_inside

BOX = Shape(ShapeKind.BOX, (0.1, 0.06, 0.04))
CAN = Shape(ShapeKind.CYLINDER, (0.03, 0.12))
BALL = Shape(ShapeKind.SPHERE, (0.05,))
ON_ITS_SIDE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
UPSIDE_DOWN = np.diag([1.0, -1.0, -1.0])
ASKEW = pose(rpy=(0.3, -0.5, 1.1))[:3, :3]


def lying(name: str, shape: Shape, T: Array, mass: float = 0.5) -> PlacedItem:
    item = replace(cell().item("scotch_bubble_mailer"), shape=shape, mass=mass, mass_error=0.0)
    return PlacedItem(name, item, TOTE, T)


@pytest.mark.parametrize("shape", [BOX, CAN, BALL])
@pytest.mark.parametrize("R", [np.eye(3), ON_ITS_SIDE, ON_ITS_SIDE.T, UPSIDE_DOWN, ASKEW])
def test_a_vertical_line_meets_a_solid_from_its_lowest_to_its_highest_point(shape: Shape, R: Array) -> None:
    T, step = pose((0.3, -0.2, 0.7), R=R), 1e-4
    columns = T[:2, 3] + np.random.default_rng(1).uniform(-0.07, 0.07, (60, 2))
    z = np.arange(-0.08, 0.08, step) + T[2, 3]
    low, high = _heights(shape, T, columns)
    n_met = 0
    for (x, y), lowest, highest in zip(columns, low, high, strict=True):
        points = np.column_stack([np.full(len(z), x), np.full(len(z), y), z])
        met = z[is_inside(shape, (points - T[:3, 3]) @ R)]
        n_met += len(met) > 0
        if len(met) == 0:
            assert (np.isnan(lowest) and np.isnan(highest)) or highest - lowest < step
        else:
            assert met[0] - step <= lowest <= met[0] and met[-1] <= highest <= met[-1] + step
    assert 0 < n_met < len(columns)


@pytest.mark.parametrize("shape", [BOX, CAN, BALL])
@pytest.mark.parametrize("R", [np.eye(3), ON_ITS_SIDE, ASKEW])
def test_the_energy_of_what_turns_is_that_of_its_parts(shape: Shape, R: Array) -> None:
    """A grid of equal parts, each as far from the axis as it is."""
    grid = (np.arange(24) + 0.5) / 24 - 0.5
    local = np.stack(np.meshgrid(grid, grid, grid), axis=-1).reshape(-1, 3) * shape.extents
    local = local[is_inside(shape, local)]
    placed = lying("item", shape, pose((0.1, 0.2, 0.3), R=R), mass=0.7)
    from_edge = np.array([0.02, -0.03, 0.05])
    way = np.array([0.6, -0.8])
    level = np.array([way[0], way[1], 0.0])
    parts = local @ R.T + from_edge
    squares = (parts @ level) ** 2 + parts[:, 2] ** 2  # from the axis, which is level and across the way
    energy = 0.5 * placed.item.lightest * squares.mean()
    assert _energy(placed, from_edge, way) == pytest.approx(energy, rel=0.01)


@pytest.mark.parametrize("turn", [0.0, 0.4, np.pi / 2, 3.0])
@pytest.mark.parametrize(
    ("aside", "at", "height"),
    [(0.02, 0.02, 0.304), (-0.03, -0.03, 0.294), (0.2, 0.05, 0.31), (-0.2, -0.05, 0.29)],
)
def test_an_item_turns_over_the_point_of_the_last_edge_that_is_beside_its_centre(
    turn: float, aside: float, at: float, height: float
) -> None:
    """Of a support from x = 0 to 40 mm that rises along y by a fifth, from -50 to 50 mm."""
    x, y = np.meshgrid(np.linspace(0.0, 0.04, 41), np.linspace(-0.05, 0.05, 41))
    R, away = pose(rpy=(0.0, 0.0, turn))[:3, :3], np.array([0.5, -0.3, 0.0])
    support = np.column_stack([x.ravel(), y.ravel(), 0.3 + 0.2 * y.ravel()]) @ R.T + away
    centre = R @ [0.01, aside, 0.9] + away
    found = _beside(support, R[:2, 0], centre)
    np.testing.assert_allclose(found, R @ [0.04, at, height] + away, atol=1e-9)


def test_an_edge_that_is_a_point_has_the_height_of_what_is_there() -> None:
    support = np.array([[0.0, 0.0, 0.1], [-0.05, -0.05, 0.2], [-0.05, 0.05, 0.3]])
    found = _beside(support, np.array([1.0, 0.0]), np.array([0.2, 0.7, 0.9]))
    np.testing.assert_allclose(found, [0.0, 0.0, 0.1], atol=1e-12)


def test_a_point_is_as_far_outside_of_a_support_as_from_its_nearest_side() -> None:
    square = np.array([[0.0, 0.0], [0.2, 0.0], [0.2, 0.1], [0.0, 0.1], [0.07, 0.03]])
    for p, far in (((0.1, 0.05), -0.05), ((0.01, 0.05), -0.01), ((0.25, 0.05), 0.05), ((0.1, -0.3), 0.3)):
        assert _outside(square, np.array(p)) == pytest.approx(far)
    line = np.array([[0.1, 0.1], [0.2, 0.1], [0.3, 0.1]])
    for p, far in (((0.2, 0.1), 0.0), ((0.2, 0.15), 0.05), ((0.35, 0.1), 0.05), ((0.02, 0.1), 0.08)):
        assert _outside(line, np.array(p)) == pytest.approx(far, abs=1e-9)


@pytest.mark.parametrize("radius", [0.031, 0.047])
def test_the_edge_of_a_support_is_found_from_inside_to_a_part_of_the_gap(radius: float) -> None:
    """A disc among lines 10 mm apart: a point for every two neighbours of which one bears."""
    at = np.arange(-7, 8) * 0.01
    lines = np.stack(np.meshgrid(at, at, indexing="ij"), axis=-1)

    def bears(points: Array) -> np.ndarray:
        return np.asarray(np.hypot(points[:, 0], points[:, 1]) <= radius)

    borne = bears(lines.reshape(-1, 2)).reshape(15, 15)
    found = _edges(lines, borne, bears)
    steps = sum(int(np.abs(np.diff(borne.astype(int), axis=axis)).sum()) for axis in (0, 1))
    assert len(found) == steps > 20
    far = np.hypot(found[:, 0], found[:, 1])
    assert far.max() <= radius and far.min() >= radius - 0.01 / 2**N_HALVINGS
    assert len({tuple(p) for p in found.round(9).tolist()}) > 0.9 * steps


@pytest.mark.parametrize("turn", [0.0, 0.7, 2.0])
@pytest.mark.parametrize(
    ("R", "longest"), [(np.eye(3), 0), (pose(rpy=(0.0, np.pi / 2, 0.0))[:3, :3], 1), (ON_ITS_SIDE, 0)]
)
def test_lines_are_laid_along_the_longest_level_side(turn: float, R: Array, longest: int) -> None:
    yaw = pose(rpy=(0.0, 0.0, turn))[:3, :3]
    found = _along(lying("item", BOX, pose((0.1, 0.2, 0.3), R=yaw @ R)))
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(found[2], [0.0, 0.0, 1.0], atol=1e-12)
    assert np.linalg.det(found) == pytest.approx(1.0)
    assert abs(found[:, 0] @ (yaw @ R)[:, longest]) == pytest.approx(1.0)


def test_the_force_of_a_cup_leads_along_its_axis_by_what_its_bellows_are_pressed_in() -> None:
    tip = pose((0.1, 0.2, 0.3), R=ASKEW)
    np.testing.assert_allclose(Press(tip, 0.004, 1000.0, 0.1).force, 4.0 * ASKEW[:, 2])


DEEP = pose((0.0, 0.0, -5.0))  # under everything that stands in the cell


def standing_on(parts: dict[str, tuple[Shape, Array]], noise: float = 0.0) -> tuple[Scene, PlacedItem]:
    """A light box of 60 by 60 by 100 mm, and what is around it, as seen from the middle of its lower face."""
    box = Shape(ShapeKind.BOX, (0.06, 0.06, 0.1))
    item = lying("item", box, DEEP @ pose((0.0, 0.0, 0.05)), mass=1e-6)
    others = [lying(name, shape, DEEP @ T, 1.0) for name, (shape, T) in parts.items()]
    return make_scene(item, *others, noise=PoseNoise(noise, 0.0)), item


SLAB = Shape(ShapeKind.BOX, (0.5, 0.5, 0.02))
FLOOR = {"floor": (SLAB, pose((0.0, 0.0, -0.01)))}


@pytest.mark.parametrize("noise", [0.0, 0.004])
def test_the_support_grows_by_what_both_may_be_off(noise: float) -> None:
    """A press of 100 N, 20 mm beside the face of what weighs nothing."""
    scene, item = standing_on(FLOOR, noise)
    point = DEEP[:3, 3] + (0.05, 0.0, 0.1)
    beside = beside_support(scene, item, np.array([0.0, 0.0, -100.0]), point)
    assert beside == pytest.approx(0.02 - 2 * noise, abs=1e-6)


def test_what_lies_on_nothing_is_not_judged() -> None:
    """Nor where all that is near stands beside it."""
    for parts in ({}, {"slab": (SLAB, pose((0.4, 0.0, -0.01)))}):
        scene, item = standing_on(parts)
        top = DEEP @ pose((0.5, 0.0, 0.1), rpy=(0.0, np.pi / 2, 0.0))
        assert beside_support(scene, item, np.array([0.0, 0.0, -100.0]), top[:3, 3]) == 0.0
        assert not falls_over(scene, item, Press(top, 0.05, 1000.0, 5.0))


@pytest.mark.parametrize("noise", [0.0, 0.004])
@pytest.mark.parametrize(
    ("xyz", "carries"),
    [((0.0, 0.0, -0.01), True), ((0.0, 0.0, -2.0), True), ((0.4, 0.0, -0.01), False),
     ((0.0, 0.4, -0.01), False), ((0.0, 0.0, 0.2), False)],
)  # fmt: skip
def test_what_is_below_carries_and_not_what_is_beside_or_above(
    xyz: tuple[float, float, float], carries: bool, noise: float
) -> None:
    scene, item = standing_on({"slab": (SLAB, pose(xyz))}, noise)
    support, aside = _support(scene, item)
    assert aside == pytest.approx(2 * noise if carries else noise)
    assert (len(support) > 0) is carries
    if carries:
        np.testing.assert_allclose(np.abs(support[:, :2]).max(axis=0), [0.03, 0.03], atol=1e-9)
        np.testing.assert_allclose(support[:, 2], -5.0, atol=1e-9)


@pytest.mark.parametrize("noise", [0.0, 0.002])
def test_what_is_within_a_touch_of_what_carries_carries_as_well_and_nothing_lower(noise: float) -> None:
    """Two bars under the box, one lower than the other by 1.5 mm and what both of box and bar may be off."""
    bar = Shape(ShapeKind.BOX, (0.01, 0.2, 0.02))
    for lower, reach in ((0.0014, 0.025), (0.0016, -0.015)):
        down = -0.01 - lower - 2 * noise
        scene, item = standing_on(
            {"one": (bar, pose((-0.02, 0.0, -0.01))), "other": (bar, pose((0.02, 0.0, down)))}, noise
        )
        support, _ = _support(scene, item)
        assert support[:, 0].min() == pytest.approx(-0.025, abs=1e-4)
        assert support[:, 0].max() == pytest.approx(reach, abs=1e-4)


@pytest.mark.parametrize("noise", [PoseNoise(), PoseNoise(0.002, 0.0), PoseNoise(0.001, 0.02)])
def test_what_stands_in_an_item_deeper_than_poses_and_a_touch_explain_is_beside_it(noise: PoseNoise) -> None:
    """A bar that reaches up into the box from below; both of them may be off."""
    bar = Shape(ShapeKind.BOX, (0.01, 0.2, 0.02))
    scene, item = standing_on({"bar": (bar, pose())})
    off = noise.bound(item.item) + noise.bound(scene.find("bar").item)
    for beyond, carries in ((-1e-5, True), (1e-5, False)):
        up = pose((0.0, 0.0, -0.01 + off + TOUCH + beyond))
        scene, item = standing_on({"bar": (bar, up)})
        support, _ = _support(replace(scene, noise=noise), item)
        assert (len(support) > 0) is carries


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
def test_a_press_and_a_weight_lead_between_them_by_their_shares(share: float) -> None:
    """A press at the very edge of the face and beyond, and a weight in its middle."""
    scene, item = standing_on(FLOOR)
    heavy = replace(item, item=replace(item.item, mass=1.0))
    scene = scene.moved(heavy)
    press = np.array([0.0, 0.0, -GRAVITY * share / (1.0 - share)])
    for at, beside in ((0.029 / share, 0.0), (0.031 / share, 0.001), (0.08 / share, 0.05)):
        point = DEEP[:3, 3] + (0.0, at, 0.1)
        assert beside_support(scene, heavy, press, point) == pytest.approx(beside, abs=1e-6)


def test_of_everything_but_the_item_itself_it_is_known_how_far_it_may_be_off() -> None:
    """Items by the noise of poses, the pod by as much as a turn moves its parts, all else not at all."""
    yaw, noise = 0.002, 0.003
    scene, item = standing_on(FLOOR, noise)
    scene = replace(scene, pod_error=Displacement(0.0, 0.0, yaw))
    found = list(_others(scene, item))
    bodies = [body for body, _ in scene.standing]
    assert len(found) == 1 + len(bodies)
    assert found[0][0] == FLOOR["floor"][0] and found[0][2] == pytest.approx(noise)
    pod = {body.name for body in scene.cell.pod.bodies}
    n_pod = 0
    for (shape, T, bound), (body, T_body) in zip(found[1:], scene.standing, strict=True):
        assert shape == body.shape
        np.testing.assert_allclose(T, T_body @ body.T_parent_shape)
        away = float(np.linalg.norm(body.T_parent_shape[:2, 3]))
        half = float(np.linalg.norm(body.shape.extents)) / 2
        expected = scene.pod_error.bound(away + half) if body.name in pod else 0.0
        assert bound == pytest.approx(expected)
        n_pod += body.name in pod
    assert 0 < n_pod < len(bodies)


def test_the_last_edge_is_what_is_within_a_millimetre_of_the_last_point() -> None:
    """An edge at 40 mm up to y = 0, and beside it one that ends 0.9 or 1.1 mm before."""
    y = np.linspace(-0.05, 0.05, 21)
    for before, last in ((0.0009, 0.03), (0.0011, 0.0)):
        x = np.where(y > 1e-9, 0.04 - before, 0.04)
        found = _beside(np.column_stack([x, y, 0.1 + y]), np.array([1.0, 0.0]), np.array([0.0, 0.03, 0.5]))
        np.testing.assert_allclose(found, [0.04, last, 0.1 + last], atol=1e-9)
