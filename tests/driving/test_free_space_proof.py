"""Distances of the truck against an oracle; nothing proven that a fine sampling refutes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.driving.driving_area import WALLS, DrivingArea, FloorBox
from pickcli.driving.free_space_proof import clearances, first_encounter, truck_corners
from pickcli.driving.steering_path import SteeringPath
from pickcli.geometry import Array

FINE = 1e-3  # m of travel


def area_of(*boxes: FloorBox, start: Array | None = None) -> DrivingArea:
    pose = np.array([5.0, 5.0, 0.3]) if start is None else start
    return DrivingArea((0.0, 0.0), (10.0, 10.0), boxes, pose, pose)


def random_boxes(rng: np.random.Generator, n: int) -> tuple[FloorBox, ...]:
    return tuple(
        FloorBox(f"b{k}", (x, y), (length, width), yaw)
        for k, (x, y, length, width, yaw) in enumerate(
            rng.uniform([0, 0, 0.1, 0.1, -4], [10, 10, 2, 2, 4], (n, 5)).tolist()
        )
    )


def filled(corners: Array, n: int = 60) -> Array:
    """(n * n, 2) points of a rectangle, edges among them."""
    u, v = (part.ravel()[:, None] for part in np.meshgrid(np.linspace(0, 1, n), np.linspace(0, 1, n)))
    filled: Array = corners[0] + u * (corners[1] - corners[0]) + v * (corners[3] - corners[0])
    return filled


@given(st.integers(0, 10**6))
@settings(max_examples=40, deadline=None)
def test_clearances_are_those_of_the_points_of_the_truck(seed: int) -> None:
    rng = np.random.default_rng(seed)
    boxes = random_boxes(rng, 3)
    area = area_of(*boxes)
    pose = np.array([[*rng.uniform(2, 8, 2), rng.uniform(-4, 4)]])
    points = filled(truck_corners(area, pose)[0])
    found = clearances(area, pose)[0]
    spacing = 0.5 * np.hypot(1.9, 0.8) / 59
    for distance, box in zip(found[1:], boxes, strict=True):
        sampled = box.distance(points).min()
        assert distance <= sampled + 1e-12
        assert distance >= sampled - spacing - 1e-12
    assert found[0] == pytest.approx(area.wall_distance(points).min(), abs=1e-12)


@given(st.integers(0, 10**6))
@settings(max_examples=50, deadline=None)
def test_nothing_is_proven_that_a_fine_sampling_refutes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    start = np.array([*rng.uniform(2, 8, 2), rng.uniform(-4, 4)])
    area = area_of(*random_boxes(rng, 4), start=start)
    signs = np.repeat(rng.choice([-1.0, 1.0], 2), 3)
    path = SteeringPath(area.truck, start, signs * rng.uniform(0.1, 1.0, 6), rng.uniform(-1.45, 1.45, 7))
    margin = float(rng.choice([0.0, 0.05]))
    travel = np.linspace(0, path.length, int(path.length / FINE) + 1)
    sampled = clearances(area, path.poses_at(travel)).min(axis=1)
    met = first_encounter(area, path, margin)
    if met is None:
        assert sampled.min() > margin
    else:
        # What is refused is near indeed: the bound of the last halving is a few millimetres.
        assert sampled.min() < margin + 0.01
        near = sampled[np.abs(travel - met.travel) < 0.3].min()
        assert near < margin + 0.01


def test_a_box_thinner_than_the_parts_is_met() -> None:
    """The truck passes over it between the first poses that are looked at."""
    area = area_of(FloorBox("post", (6.1, 5.0), (0.01, 0.01)), start=np.array([3.0, 5.0, 0.0]))
    path = SteeringPath(area.truck, area.start, np.array([3.0]), np.zeros(2))
    met = first_encounter(area, path, 0.0)
    assert met is not None and met.name == "post"


def test_leaving_the_walls_is_met() -> None:
    area = area_of(start=np.array([5.0, 5.0, 0.0]))
    path = SteeringPath(area.truck, area.start, np.array([3.36]), np.zeros(2))
    assert first_encounter(area, path, 0.03) is None
    met = first_encounter(area, path, 0.05)
    assert met is not None and met.name == WALLS


@given(
    length=st.floats(0.3, 2.0),
    part=st.floats(0.1, 0.9),
    turned=st.floats(-0.6, 0.6),
    near=st.floats(2e-4, 2e-3),
)
@settings(max_examples=60, deadline=None)
def test_what_is_proven_part_by_part_is_proven_as_a_whole(
    length: float, part: float, turned: float, near: float
) -> None:
    """A path that comes within a fifth of a millimetre of the margin, however it is divided."""
    area = area_of(start=np.array([5.0, 5.0, turned]))
    path = SteeringPath(area.truck, area.start, np.array([length]), np.array([0.2, -0.1]))
    least = clearances(
        area_of(wall := _post_beside(area, path)), path.poses_at(np.linspace(0, length, 20_000))
    )
    margin = float(least[:, 1].min()) - near
    blocked = area_of(wall)
    first, second = path.divided(part * length)
    assert first_encounter(blocked, first, margin) is None
    assert first_encounter(blocked, second, margin) is None
    assert first_encounter(blocked, path, margin) is None
    assert first_encounter(blocked, path, margin + 2 * near) is not None


def _post_beside(area: DrivingArea, path: SteeringPath) -> FloorBox:
    """A post some 0.1 m beside the truck in the middle of a path."""
    x, y, yaw = path.poses_at(np.array([path.length / 2]))[0].tolist()
    off = area.truck.width / 2 + 0.15
    return FloorBox("post", (x - off * np.sin(yaw), y + off * np.cos(yaw)), (0.1, 0.1), yaw)
