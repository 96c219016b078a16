"""Gaps between solids: exact for two boxes, and a push by the overlap parts any two."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.geometry import Array, pose
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.scene.solid_overlap import PosedSolid
from pickcli.scene.touching import Gaps, PosedSolids, gaps
from support.solid_oracles import hull_depth, is_inside, points_inside

CELL = load_cell("apc2016_delft")
NAMES = (
    "crayola_24_ct",
    "rawlings_baseball",
    "dasani_water_bottle",
    "folgers_classic_roast_coffee",
    "jane_eyre_dvd",
)
small = st.floats(-0.12, 0.12)
angle = st.floats(-3.1, 3.1)
somewhere = st.tuples(small, small, small, angle, angle, angle).map(lambda v: pose(v[:3], rpy=v[3:]))


def solids_at(*placed: tuple[str, Array], noise: PoseNoise | None = None) -> tuple[Scene, PosedSolids]:
    items = tuple(
        PlacedItem(f"{name}#{k}", CELL.item(name), "bin_E", T) for k, (name, T) in enumerate(placed)
    )
    scene = Scene(CELL, CELL.T_world_pod, items, noise or PoseNoise())
    return scene, PosedSolids.of(scene, items, ())


def gap_of(*placed: tuple[str, Array]) -> Gaps:
    return gaps(solids_at(*placed)[1], np.array([0]), np.array([1]))


@given(st.sampled_from(NAMES), st.sampled_from(NAMES), somewhere, somewhere)
@settings(max_examples=150, deadline=None)
def test_pushed_along_the_normal_by_the_overlap_two_solids_part(
    a: str, b: str, T_a: Array, T_b: Array
) -> None:
    found = gap_of((a, T_a), (b, T_b))
    scene, _ = solids_at((a, T_a), (b, T_b))
    one, other = (PosedSolid(placed.item.shape, placed.T_world_item) for placed in scene.items)
    push = max(0.0, -float(found.width[0])) * found.normal[0]
    apart = PosedSolid(other.shape, pose(push) @ other.T).shrunk(1e-6)
    local = (points_inside(one) - apart.T[:3, 3]) @ apart.T[:3, :3]
    assert not np.any(is_inside(apart.shape, local))


@given(somewhere, somewhere)
@settings(max_examples=150, deadline=None)
def test_the_overlap_of_two_boxes_is_exact(T_a: Array, T_b: Array) -> None:
    found = gap_of(("crayola_24_ct", T_a), ("jane_eyre_dvd", T_b))
    scene, _ = solids_at(("crayola_24_ct", T_a), ("jane_eyre_dvd", T_b))
    one, other = (PosedSolid(placed.item.shape, placed.T_world_item) for placed in scene.items)
    assert max(0.0, -float(found.width[0])) == pytest.approx(hull_depth(one, other), abs=1e-9)


def test_a_ball_over_a_box_is_as_far_away_as_it_looks() -> None:
    radius, height = 0.034, 0.025
    for gap in (-0.003, 0.0, 0.01):
        T = pose([0.01, 0.02, height / 2 + radius + gap])
        found = gap_of(("crayola_24_ct", pose()), ("rawlings_baseball", T))
        assert found.width[0] == pytest.approx(gap, abs=1e-9)
        np.testing.assert_allclose(found.normal[0], [0.0, 0.0, 1.0], atol=1e-9)


def test_near_pairs_are_those_within_reach_and_bounds() -> None:
    apart = 0.095 + 0.010
    noise = PoseNoise(0.004, 0.0)
    _, solids = solids_at(("crayola_24_ct", pose()), ("crayola_24_ct", pose([apart, 0, 0])), noise=noise)
    assert [len(part) for part in solids.near(2)] == [len(part) for part in solids.near(2, 0.001)] == [0, 0]
    assert [part.tolist() for part in solids.near(2, 0.003)] == [[0], [1]]


def test_what_just_touches_is_near() -> None:
    """Boxes of half a metre, whose sides are exact numbers: from there on to 2^-40 m apart."""
    cube = Shape(ShapeKind.BOX, (0.5, 0.5, 0.5))
    for apart, n in ((0.0, 1), (2.0**-40, 0)):
        for x in (0.5 + apart, -0.5 - apart):
            assert len(_shaped((cube, np.eye(4)), (cube, pose((x, 0.0, 0.0)))).near(2)[0]) == n


def _shaped(*placed: tuple[Shape, Array]) -> PosedSolids:
    """Bodies of any shape at any pose, nothing of which is uncertain."""
    scene, _ = solids_at()
    return PosedSolids.of(scene, (), [(Body(f"body{k}", s, T), np.eye(4)) for k, (s, T) in enumerate(placed)])


def _gap(a: tuple[Shape, Array], b: tuple[Shape, Array]) -> tuple[float, Array]:
    """Width and normal of the gap from a to b; the same, except for its sign, from b to a."""
    found = gaps(_shaped(a, b), np.array([0, 1]), np.array([1, 0]))
    assert found.width[0] == pytest.approx(found.width[1], abs=1e-9)
    np.testing.assert_allclose(found.normal[0], -found.normal[1], atol=1e-7)
    assert np.linalg.norm(found.normal[0]) == pytest.approx(1.0)
    return float(found.width[0]), found.normal[0]


BOX = Shape(ShapeKind.BOX, (0.1, 0.06, 0.04))
CAN = Shape(ShapeKind.CYLINDER, (0.03, 0.12))
BALL = Shape(ShapeKind.SPHERE, (0.05,))
turn = st.tuples(angle, angle, angle).map(lambda rpy: pose(rpy=rpy))
outwards = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda n: np.linalg.norm(n) > 0.1)
apart = st.floats(-0.04, 0.2)


@given(somewhere, turn, outwards, apart)
def test_a_ball_is_as_far_from_a_box_as_its_middle_but_for_its_radius(
    T_world: Array, T: Array, n: tuple[float, float, float], gap: float
) -> None:
    """Over a face, an edge or a corner, apart or overlapping."""
    direction = np.array(n) / np.linalg.norm(n)
    is_off = abs(direction) > 0.3
    surface = np.where(is_off, np.copysign(BOX.extents / 2, direction), direction * BOX.extents / 2)
    normal = np.where(is_off, direction, 0.0)
    normal /= np.linalg.norm(normal)
    middle = pose(surface + (0.05 + gap) * normal) @ T
    width, found = _gap((BOX, T_world), (BALL, T_world @ middle))
    assert width == pytest.approx(gap, abs=1e-9)
    np.testing.assert_allclose(found, T_world[:3, :3] @ normal, atol=1e-6)


@given(somewhere, turn, angle, st.floats(-1.0, 1.0), apart)
def test_a_ball_is_as_far_from_a_mantle_as_its_middle_from_the_axis_but_for_both_radii(
    T_world: Array, T: Array, around: float, along: float, gap: float
) -> None:
    normal = np.array([np.cos(around), np.sin(around), 0.0])
    middle = pose((0.08 + gap) * normal + [0.0, 0.0, 0.06 * along]) @ T
    width, found = _gap((CAN, T_world), (BALL, T_world @ middle))
    assert width == pytest.approx(gap, abs=1e-9)
    np.testing.assert_allclose(found, T_world[:3, :3] @ normal, atol=1e-6)


@given(somewhere, angle, st.floats(0.2, 2.9), st.floats(-0.02, 0.2))
def test_crossing_cans_are_as_far_apart_as_their_axes_but_for_both_radii(
    T_world: Array, around: float, crossing: float, gap: float
) -> None:
    """Where the shortest way between the axes meets both mantles."""
    lying = pose((0.0, 0.0, 0.06 + gap), rpy=(np.pi / 2, 0.0, crossing))
    base = pose(rpy=(np.pi / 2, 0.0, 0.0))
    width, found = _gap((CAN, T_world @ base), (CAN, T_world @ lying @ pose(rpy=(0, 0, around))))
    assert width == pytest.approx(gap, abs=1e-9)
    np.testing.assert_allclose(found, T_world[:3, 2], atol=1e-6)


@given(somewhere, st.floats(-0.02, 0.2), angle)
def test_a_can_stands_on_a_box_as_far_as_its_end_is_over_it(T_world: Array, gap: float, yaw: float) -> None:
    on_top = pose((0.01, 0.005, 0.02 + 0.06 + gap), rpy=(0.0, 0.0, yaw))
    width, found = _gap((BOX, T_world), (CAN, T_world @ on_top))
    assert width == pytest.approx(gap, abs=1e-9)
    np.testing.assert_allclose(found, T_world[:3, 2], atol=1e-6)


@given(somewhere, st.floats(0.2, 1.3), st.floats(-0.5, 0.5), st.floats(-0.02, 0.2))
def test_a_can_along_an_edge_is_as_far_as_its_axis_but_for_its_radius(
    T_world: Array, around: float, along: float, gap: float
) -> None:
    long_can = Shape(ShapeKind.CYLINDER, (0.03, 0.3))
    normal = np.array([np.cos(around), np.sin(around), 0.0])
    middle = np.array([0.05, 0.03, 0.2 * along]) + (0.03 + gap) * normal
    width, found = _gap((BOX, T_world), (long_can, T_world @ pose(middle)))
    assert width == pytest.approx(gap, abs=1e-9)
    np.testing.assert_allclose(found, T_world[:3, :3] @ normal, atol=1e-6)


@pytest.mark.parametrize("shape", [BOX, CAN, BALL])
@given(turn, outwards)
def test_half_widths_are_those_of_the_solid_itself(
    shape: Shape, T: Array, n: tuple[float, float, float]
) -> None:
    direction = np.array(n) / np.linalg.norm(n)
    (found,) = _shaped((shape, T)).half_widths(np.array([0]), direction[None, None])[0]
    assert found == pytest.approx(float(direction @ PosedSolid(shape, T).support(direction)))


def test_items_come_with_their_noise_and_bodies_are_exact() -> None:
    noise = PoseNoise(0.004, 0.01)
    scene, _ = solids_at(("crayola_24_ct", pose()), noise=noise)
    body = Body("shelf", BOX, pose((0.1, 0.0, 0.0)))
    solids = PosedSolids.of(scene, scene.items, [(body, pose((0.0, 0.2, 0.0)))])
    assert solids.names == ("crayola_24_ct#0", "shelf")
    np.testing.assert_allclose(solids.bound, [noise.bound(scene.items[0].item), 0.0])
    np.testing.assert_allclose(solids.T[1, :3, 3], [0.1, 0.2, 0.0])
    np.testing.assert_allclose(solids.half[1], [0.05, 0.03, 0.02])


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_near_pairs_are_within_reach_along_every_axis(axis: int, sign: float) -> None:
    """Each pair once, and never two bodies."""
    scene, _ = solids_at(("crayola_24_ct", pose()), ("crayola_24_ct", pose((5.0, 5.0, 5.0))))
    half = scene.items[0].item.shape.extents[axis] / 2 + BOX.extents[axis] / 2
    for gap, is_near in ((0.0019, True), (0.0021, False)):
        way = sign * (half + gap) * np.eye(3)[axis]
        bodies = [(Body(name, BOX, pose(way)), np.eye(4)) for name in ("one", "two")]
        a, b = PosedSolids.of(scene, scene.items, bodies).near(2, 0.002)
        assert list(zip(a.tolist(), b.tolist(), strict=True)) == ([(0, 2), (0, 3)] if is_near else [])
