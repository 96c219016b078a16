"""The pod by its front legs in a slice: right where both are seen, and silent where they may be mistaken."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bench.pod_pose import draw
from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.makers.pod import FRONT_LEGS
from pickcli.cell.pod_tolerance import displaced, yaw_of
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse, pose
from pickcli.perception.depth_picture import DepthPicture
from pickcli.perception.pod_legs import FrontLegs
from pickcli.perception.pod_pose import EXACT, PodStart, locate_pod
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene, RenderedSolid
from pickcli.scene.scene import empty_scene
from support.cell_copies import CellCopy

KINECT = read_sensor(sensor_file("kinect_v2"))
assert KINECT.depth is not None
NOISE = KINECT.depth
CELL = load_cell("apc2016_delft")
T_WAIST = np.array([[0, 0, 1, -1.45], [-1, 0, 0, 0.1], [0, -1, 0, 1.15], [0, 0, 0, 1]], dtype=np.float64)
CORNERS = [(x, y, yaw) for x in (-0.05, 0.05) for y in (-0.05, 0.05) for yaw in (-0.0523, 0.0523)]
Offset = tuple[float, float, float]


def legs_of(cell: Cell) -> FrontLegs:
    legs = FrontLegs.of(cell)
    assert legs is not None
    return legs


def upright(x: float, y: float, size: tuple[float, float], top: float = 0.79) -> RenderedSolid:
    """A box that stands on the floor with the middle of its front at x, y."""
    shape = Shape(ShapeKind.BOX, (*size, top))
    return RenderedSolid(OwnerKind.CARRIER, "thing", shape, pose((x + size[0] / 2, y, top / 2)))


def picture_of(
    offset: Offset, *things: RenderedSolid, without: tuple[str, ...] = (), T_world_camera: Array = T_WAIST,
    cell: Cell = CELL,
) -> DepthPicture:  # fmt: skip
    """Exact depth of the displaced pod alone, without some of its bodies, and of things beside it."""
    bodies = tuple(body for body in cell.pod.bodies if body.name not in without)
    scene = replace(
        empty_scene(replace(cell, pod=replace(cell.pod, bodies=bodies))),
        T_world_pod=displaced(cell.T_world_pod, *offset),
    )
    home = cell.configurations["home"]
    solids = RenderedScene.of(scene, home.q, home.tool_state).solids
    shown = [solid for solid in solids if solid.kind is OwnerKind.CARRIER and solid.owner == "pod"]
    depth = RenderedScene((*shown, *things)).seen_by(KINECT.camera, T_world_camera).depth
    return DepthPicture(KINECT.camera, T_world_camera, np.where(np.isfinite(depth), depth, np.nan))


def located(picture: DepthPicture) -> Array | None:
    return legs_of(CELL).located(picture, CELL.T_world_pod)


def is_right(found: Array, offset: Offset, within: float = 0.004, turned: float = 0.005) -> bool:
    off = inverse(displaced(CELL.T_world_pod, *found)) @ displaced(CELL.T_world_pod, *offset)
    return bool(np.hypot(*off[:2, 3]) < within) and abs(yaw_of(off)) < turned


@pytest.mark.parametrize("offset", [(0.0, 0.0, 0.0), (0.013, -0.037, 0.02), *CORNERS])
def test_both_legs_say_where_the_pod_is_anywhere_in_its_tolerance(offset: Offset) -> None:
    found = located(picture_of(offset))
    assert found is not None and is_right(found, offset)


@pytest.mark.parametrize("at", [(-1.6, 0.3, 1.1), (-1.3, -0.35, 1.0), (-2.0, 0.0, 0.8)])
@pytest.mark.parametrize("turned", [(0.0, 0.0), (0.1, 0.1)])
def test_it_does_not_matter_from_where_they_are_seen(
    at: tuple[float, float, float], turned: tuple[float, float]
) -> None:
    offset = (0.02, -0.03, 0.03)
    ahead = np.arctan2(-at[1], -at[0]) + turned[1]
    T = pose(at, rpy=(0.0, 0.0, float(ahead))) @ pose(R=T_WAIST[:3, :3]) @ pose(rpy=(turned[0], 0.0, 0.0))
    found = located(picture_of(offset, T_world_camera=T))
    assert found is not None and is_right(found, offset)


def test_moving_the_world_moves_nothing() -> None:
    picture, W = picture_of((0.03, 0.02, -0.02)), pose((1.2, -0.7, 0.0), rpy=(0.0, 0.0, 2.0))
    moved = replace(picture, T_world_camera=W @ picture.T_world_camera)
    here, there = located(picture), legs_of(CELL).located(moved, W @ CELL.T_world_pod)
    assert here is not None and there is not None
    np.testing.assert_allclose(there, here, atol=1e-6)


def test_the_slice_is_that_of_kth() -> None:
    legs = legs_of(CELL)
    assert (legs.low, legs.high) == pytest.approx((0.63, 0.73), abs=2e-3)
    width, depth = (
        legs.corners[0].max(axis=0)[1] - legs.corners[0].min(axis=0)[1],
        np.ptp(legs.corners[0, :, 0]),
    )
    assert (width, depth) == pytest.approx((0.03545, 0.020))
    assert legs.corners[0, :, 1].min() > 0.4 and legs.corners[1, :, 1].max() < -0.4  # left is first


def test_pods_without_legs_or_with_short_ones_have_none_to_be_found(cell_copy: CellCopy) -> None:
    stated = "legs: {width: 0.03545, depth: 0.020}"
    cell_copy.yaml.replace(stated, stated.replace("}", ", height: 0.15}"))
    assert FrontLegs.of(cell_copy.load()) is None
    cell_copy.yaml.replace(stated.replace("}", ", height: 0.15}"), "")
    solid = cell_copy.load()
    assert FrontLegs.of(solid) is None
    offset = (0.02, -0.03, 0.01)
    found = locate_pod(picture_of(offset, cell=solid), solid, NOISE)
    assert found.start is PodStart.BOXES
    np.testing.assert_allclose(found.T_world_pod, displaced(solid.T_world_pod, *offset), atol=1e-3)


@pytest.mark.parametrize("hidden", [FRONT_LEGS[:1], FRONT_LEGS[1:], FRONT_LEGS])
def test_a_leg_that_is_not_there_is_not_made_up(hidden: tuple[str, ...]) -> None:
    """The rear legs, which are seen through the open underside, are not taken for it."""
    assert located(picture_of((0.01, 0.02, 0.01), without=hidden)) is None


@pytest.mark.parametrize("y", [-0.42, 0.42])
@pytest.mark.parametrize("shift", [-0.02, -0.01, 0.0, 0.01, 0.02])
def test_a_leg_of_which_something_hides_a_part_is_no_leg(y: float, shift: float) -> None:
    offset = (0.0, 0.0, 0.0)
    before = upright(-0.5, (y + shift) * 0.95 / 1.45 + 0.1 * 0.5 / 1.45, (0.02, 0.025))
    assert located(picture_of(offset, before)) is None


@pytest.mark.parametrize("x", [-0.1, 0.0, 0.2])
@pytest.mark.parametrize("width", [0.2, 0.4, 0.76])
def test_a_box_between_the_legs_is_none(x: float, width: float) -> None:
    offset = (0.02, 0.01, 0.02)
    found = located(picture_of(offset, upright(x, 0.0, (0.3, width))))
    assert found is None or is_right(found, offset)
    if width < 0.5:
        assert found is not None


@pytest.mark.parametrize("y", [-0.55, -0.36, -0.1, 0.0, 0.25, 0.5])
@pytest.mark.parametrize("x", [-0.08, 0.0, 0.05])
def test_a_third_thing_like_a_leg_is_one_too_many(x: float, y: float) -> None:
    assert located(picture_of((0.0, 0.0, 0.0), upright(x, y, (0.02, 0.035)))) is None


def test_of_two_legs_that_are_too_near_to_each_other_neither_is_the_pods() -> None:
    decoys = [upright(0.0, y, (0.02, 0.035)) for y in (-0.40, 0.40)]
    assert located(picture_of((0.0, 0.0, 0.0), *decoys, without=FRONT_LEGS)) is None


@pytest.mark.parametrize("y", [-0.45, 0.45])
def test_legs_of_a_person_beside_the_pod_are_wider(y: float) -> None:
    """Beside a leg of the pod one is seen as what it is."""
    offset = (0.0, 0.0, 0.0)
    shape = Shape(ShapeKind.CYLINDER, (0.055, 0.9))
    for x, aside in ((-0.3, 0.0), (-0.1, 0.12), (0.1, 0.2)):
        person = RenderedSolid(OwnerKind.CARRIER, "shin", shape, pose((x, y + np.sign(y) * aside, 0.45)))
        found = located(picture_of(offset, person))
        assert found is not None and is_right(found, offset)


@settings(max_examples=60)
@given(
    offset=st.tuples(st.floats(-0.05, 0.05), st.floats(-0.05, 0.05), st.floats(-0.0523, 0.0523)),
    things=st.lists(
        st.tuples(
            st.floats(-0.9, 0.6), st.floats(-0.8, 0.8), st.floats(0.01, 0.4), st.floats(0.01, 0.4),
            st.floats(0.5, 1.2),
        ),
        max_size=4,
    ),
)  # fmt: skip
def test_whatever_stands_around_it_what_is_said_is_right(
    offset: Offset, things: list[tuple[float, float, float, float, float]]
) -> None:
    """With all legs there, an answer is right."""
    solids = [upright(x, y, (dx, dy), top) for x, y, dx, dy, top in things]
    found = located(picture_of(offset, *solids))
    assert things or found is not None
    assert found is None or is_right(found, offset, within=0.008, turned=0.015)


@settings(max_examples=25)
@given(
    decoy=st.tuples(st.floats(-0.08, 0.05), st.floats(-0.06, 0.06), st.floats(-0.06, 0.06)),
    offset=st.tuples(st.floats(-0.05, 0.05), st.floats(-0.05, 0.05), st.floats(-0.05, 0.05)),
)
def test_a_pod_beside_whose_place_other_legs_stand_is_where_it_is_or_refused(
    decoy: Offset, offset: Offset
) -> None:
    """Two posts at the distance of the legs, which are not there: what is seen of the pod decides."""
    T = displaced(CELL.T_world_pod, *decoy)
    posts = [
        RenderedSolid(OwnerKind.CARRIER, body.name, body.shape, T @ body.T_parent_shape)
        for body in CELL.pod.bodies
        if body.name in FRONT_LEGS
    ]
    picture = picture_of(offset, *posts, without=FRONT_LEGS)
    try:
        found = locate_pod(picture, CELL, NOISE)
    except InputError:
        return
    off = inverse(found.T_world_pod) @ displaced(CELL.T_world_pod, *offset)
    assert np.hypot(*off[:2, 3]) < 2e-3 and abs(yaw_of(off)) < np.radians(0.1)
    if np.abs(np.subtract(decoy, offset)).max() > 0.03:
        assert found.start is PodStart.BOXES


@pytest.mark.parametrize("sensor", ["kinect_v2", "carmine"])
def test_with_noise_legs_are_right_within_pixels(sensor: str) -> None:
    errors = []
    for k in range(12):
        drawn = draw(CELL, sensor, 20170, k, EXACT)
        found = legs_of(CELL).located(drawn.picture, CELL.T_world_pod)
        if found is not None:
            off = inverse(displaced(CELL.T_world_pod, *found)) @ drawn.T_world_pod
            errors.append((np.hypot(*off[:2, 3]), abs(yaw_of(off))))
    assert len(errors) >= 6
    assert np.median(errors, axis=0) == pytest.approx([0.0, 0.0], abs=2e-3)
    assert np.max(errors, axis=0)[0] < 4e-3 and np.max(errors, axis=0)[1] < np.radians(0.4)


def test_by_either_start_the_whole_pod_is_fitted_to_the_same_place() -> None:
    offset = (0.03, -0.04, 0.03)
    found = [
        locate_pod(picture, CELL, NOISE)
        for picture in (picture_of(offset), picture_of(offset, upright(0.0, 0.1, (0.02, 0.035))))
    ]
    assert [each.start for each in found] == [PodStart.LEGS, PodStart.BOXES]
    for one, other in pairwise(found):
        np.testing.assert_allclose(one.T_world_pod, other.T_world_pod, atol=2e-4)


def test_before_a_bin_no_legs_are_seen_and_the_pod_is_found_all_the_same() -> None:
    drawn = draw(CELL, "ensenso", 20171, 0, EXACT)
    found = locate_pod(drawn.picture, CELL, drawn.noise)
    assert found.start is PodStart.BOXES
    assert found.error.allows(inverse(found.T_world_pod) @ drawn.T_world_pod)
