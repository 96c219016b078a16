"""What nobody has seen is unknown, what was seen through is not, and no body of an item is in free space."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from pickcli.cell.cell import Cell
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, inverse, pose, transform_points
from pickcli.perception.items.item_observation import PlaceObservation
from pickcli.perception.items.line_of_sight import LEAST_PIXELS, LineOfSight, unexplained_depth
from pickcli.perception.items.unknown_voxels import (
    RESERVE,
    VOXEL,
    merged_boxes,
    unrecognised_boxes,
    whole_room,
)
from pickcli.random_scenes.make_scene import make_scene
from support.filled_bins import CONTENTS, Filled, looked_at


def in_boxes(points: Array, boxes: Array, margin: float = 0.0) -> NDArray[np.bool_]:
    """(N,) whether points (N, 3) are in one of boxes (B, 2, 3), grown by a margin."""
    low, high = boxes[None, :, 0] - margin, boxes[None, :, 1] + margin
    is_in = np.logical_and(points[:, None] >= low, points[:, None] <= high).all(axis=2)
    return np.asarray(np.any(is_in, axis=1))


def on_surface(shape: Shape, n: int) -> Array:
    """(N, 3) points on a box, cylinder or sphere."""
    rng = np.random.default_rng(1)
    points = rng.uniform(-1.0, 1.0, (n, 3))
    if shape.kind is ShapeKind.CYLINDER:
        turn = rng.uniform(0.0, 2.0 * np.pi, n)
        points[:, :2] = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    elif shape.kind is ShapeKind.SPHERE:
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    else:
        points[np.arange(n), rng.integers(3, size=n)] = rng.choice([-1.0, 1.0], n)
    return np.asarray(points * shape.extents / 2)


def explained(observed: PlaceObservation, points: Array) -> NDArray[np.bool_]:
    """(N,) whether points in the place's frame are in an answer, or so near that what is unseen is free."""
    found = np.zeros(len(points), dtype=bool)
    for answer in observed.items:
        if answer.bound is not None and answer.T_world_item is not None:
            T_item_place = inverse(answer.T_world_item) @ observed.T_world_place
            shape = answer.item.shape.inflated(answer.bound.bound(answer.item) + RESERVE)
            found |= shape.contains(transform_points(T_item_place, points))
    return found


@pytest.mark.parametrize("seed", range(20))
def test_boxes_hold_each_filled_cell_once_and_no_other(seed: int) -> None:
    rng = np.random.default_rng(seed)
    is_filled = rng.random(rng.integers(1, 9, 3)) < rng.random()
    counts = np.zeros(is_filled.shape, dtype=int)
    boxes = merged_boxes(is_filled)
    for (x, y, z), (x1, y1, z1) in boxes.tolist():
        counts[x:x1, y:y1, z:z1] += 1
    np.testing.assert_array_equal(counts, is_filled)
    assert len(boxes) <= is_filled.sum()


def test_a_whole_room_is_all_between_floor_and_ceiling(cell: Cell) -> None:
    for place in cell.places.values():
        boxes = whole_room(place.room)
        points = np.random.default_rng(0).uniform(place.room.low, place.room.high, (500, 3))
        over, under = points[:, 2] - place.room.floor_at(points[:, 0]), place.room.ceiling_at(points[:, 0])
        inside = (over > VOXEL) & (points[:, 2] < under - VOXEL)
        assert in_boxes(points[inside], boxes).all()
        assert not in_boxes(points[points[:, 2] > under + VOXEL], boxes).any()


def test_no_body_is_where_nothing_is_believed_to_be(filled: Filled) -> None:
    """Also not that of an item which nobody listed: what is seen of it, and all behind it, is unknown."""
    T_place_world = inverse(filled.scene.T_world_place(filled.place))
    for left_out in (None, *filled.listed):
        observed = filled.perceived([each for each in filled.listed if each != left_out])
        for placed in filled.scene.in_location(filled.place.name):
            points = transform_points(T_place_world @ placed.T_world_item, on_surface(placed.item.shape, 400))
            room = filled.place.room
            points[:, 2] = np.maximum(points[:, 2], room.floor_at(points[:, 0]) + 1e-3)  # pressed into it
            is_there = in_boxes(points, observed.unknown, VOXEL / 2) | explained(observed, points)
            assert is_there.mean() > 0.98, (left_out, placed.id)


def test_what_is_seen_of_an_item_that_is_not_recognised_is_told(filled: Filled) -> None:
    """What is seen of one that nobody listed, and little else."""
    T_place_world = inverse(filled.scene.T_world_place(filled.place))
    T_camera_place = inverse(T_place_world @ filled.rgbd.T_world_camera)
    told = []
    for left_out in filled.listed:
        observed = filled.perceived([each for each in filled.listed if each != left_out])
        placed = filled.scene.find(left_out.id)
        refused = [each for each in observed.items if each.bound is None]
        own = [(each.item.shape, each.T_world_item) for each in refused]
        truly = [placed, *(filled.scene.find(each.id) for each in refused)]
        own += [(each.item.shape, each.T_world_item) for each in truly]
        middles = transform_points(filled.T_world_place, observed.unrecognised.mean(axis=1))
        is_there = [
            shape.inflated(2.0 * VOXEL).contains(transform_points(inverse(T), middles))
            for shape, T in own
            if T is not None
        ]
        assert np.any(is_there, axis=0).mean() > 0.8
        T = T_place_world @ placed.T_world_item
        points = transform_points(T_camera_place @ T, on_surface(placed.item.shape, 400))
        u, v = np.round(filled.rgbd.sensor.camera.project(points)).astype(int).T
        is_seen = np.abs(filled.rgbd.depth[v, u] - points[:, 2]) < 3e-3
        seen = transform_points(inverse(T_camera_place), points[is_seen])
        told.append(in_boxes(seen, observed.unrecognised, 2e-3).mean())
    assert min(told) > 0.8 and len(told) == len(filled.listed)


def test_where_a_refused_item_may_be_is_told(filled: Filled) -> None:
    """Also where it is hidden, or too thin to be told from what it lies on."""
    room = filled.place.room
    shape, middle = Shape(ShapeKind.BOX, (0.1, 0.1, 0.004)), (room.low + room.high) / 2
    boxes = unrecognised_boxes(room, [], [], [(shape, pose(tuple(middle)))])
    points = middle + np.random.default_rng(0).uniform(-0.5, 0.5, (300, 3)) * shape.extents
    assert in_boxes(points, boxes).all()
    assert (np.abs(boxes - middle) < shape.extents / 2 + 1.5 * VOXEL).all()


def test_of_looks_from_several_places_two_have_to_measure_it(cell: Cell) -> None:
    """A second look from the same place errs as the first does."""
    room = cell.places["bin_E"].room
    patch = (room.low + room.high) / 2

    def sight(aside: float, is_seen: bool) -> LineOfSight:
        """A camera that looks into the room along x, and a surface of 2 cm in its middle."""
        camera = PinholeCamera(600.0, 600.0, 250.0, 20.0, 500, 40)
        R = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])  # place to camera
        eye = patch - (0.6, aside, 0.0)
        blocked = np.full((40, 500), np.inf, dtype=np.float32)
        middle = 250 + round(600.0 * -aside / 0.6)
        if is_seen:
            blocked[10:30, middle - 10 : middle + 10] = 0.6
        return LineOfSight(camera, pose(-R @ eye, R=R), np.full((40, 500), 1.0, dtype=np.float32), blocked)

    def told(*sights: LineOfSight) -> bool:
        boxes = unrecognised_boxes(room, sights, [], [])
        if len(boxes):
            assert (np.abs(boxes - patch) < 0.01 + 2.0 * VOXEL).all()
        return len(boxes) > 0

    assert told(sight(0.0, True))
    assert told(sight(0.0, True), sight(0.01, False))
    assert not told(sight(0.0, True), sight(0.2, False))
    assert not told(sight(0.0, True), sight(0.01, True), sight(0.2, False))
    assert told(sight(0.0, True), sight(0.2, False), sight(-0.2, False), sight(-0.06, True))
    assert not told(sight(0.0, False), sight(0.2, False))


def test_where_all_is_recognised_nothing_is_told(cell: Cell) -> None:
    observed = looked_at(make_scene({"bin_E": CONTENTS[:3]}, cell, seed=5)).perceived()
    assert [each.bound is None for each in observed.items] == [False] * 3
    assert len(observed.unrecognised) == 0


def test_what_was_seen_through_is_free(filled: Filled) -> None:
    observed = filled.perceived()
    T_place_camera = inverse(filled.scene.T_world_place(filled.place)) @ filled.rgbd.T_world_camera
    rays = filled.rgbd.sensor.camera.rays[::37, ::37].reshape(-1, 3)
    depth = filled.rgbd.depth[::37, ::37].reshape(-1)
    room = filled.place.room
    points = transform_points(
        T_place_camera, rays * np.linspace(0.3, 0.95, 14)[:, None, None] * depth[:, None]
    )
    points = points.reshape(-1, 3)
    is_inside = ((points > room.low + VOXEL) & (points < room.high - VOXEL)).all(axis=1)
    is_inside &= points[:, 2] > room.floor_at(points[:, 0]) + 3.0 * VOXEL
    assert is_inside.sum() > 300
    assert in_boxes(points[is_inside], observed.unknown).mean() < 0.03


def test_few_pixels_that_nothing_explains_are_errors_of_the_sensor() -> None:
    depth = np.full((20, 20), 0.6, dtype=np.float32)
    is_before, nowhere = np.zeros((20, 20), dtype=bool), np.zeros((20, 20), dtype=bool)
    is_before[3, 3 : 3 + LEAST_PIXELS - 1] = True
    assert np.isinf(unexplained_depth(depth, is_before, nowhere, 0.005)).all()
    is_before[3, 3 : 3 + LEAST_PIXELS] = True
    blocked = unexplained_depth(depth, is_before, nowhere, 0.005)
    np.testing.assert_array_equal(np.isfinite(blocked), is_before)
    np.testing.assert_allclose(blocked[is_before], 0.6)
    depth[10:14, 10:14] = np.nan
    is_odd = np.isnan(depth)
    assert (unexplained_depth(depth, nowhere, is_odd, 0.005)[is_odd] == 0.0).all()
