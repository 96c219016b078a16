"""What cameras see of solids, against rays by numpy, analytic depths, and itself."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.geometry import Array, pose
from pickcli.kernel import RaycastingScene, set_simd, simd
from support.ray_reference import BOX, CYLINDER, SPHERE, Solids, random_pose, random_solids, rays, seen

SEEDS = st.integers(0, 2**32 - 1)
SIZE = np.array([100, 75], np.int32)  # no multiple of the lanes
CAMERA = np.array([90.0, 85.0, 48.3, 37.9])
NUDGES = [(dx, dy) for dx in (-0.02, 0.0, 0.02) for dy in (-0.02, 0.0, 0.02)]  # px


def one(T: Array, half: list[float], kind: int = BOX) -> RaycastingScene:
    solids = Solids()
    solids.add(T, np.array(half), kind)
    return solids.scene


@settings(deadline=None, max_examples=60)
@given(SEEDS)
def test_depth_and_solids_are_those_of_the_reference(seed: int) -> None:
    """Cameras are anywhere, also inside of solids. A pixel is excused only where the reference itself is of
    two minds within a fiftieth of a pixel."""
    rng = np.random.default_rng(seed)
    solids, T = random_solids(rng, int(rng.integers(1, 40))), random_pose(rng, 1.5)
    depth, index, _ = solids.scene.cast_rays(CAMERA, SIZE, T)
    around = [seen(solids, CAMERA, (100, 75), T, nudge) for nudge in NUDGES]
    depths, indices = np.array([d for d, _ in around]), np.array([i for _, i in around])
    is_clear = (indices == indices[0]).all(axis=0)
    assert is_clear.mean() > 0.9
    np.testing.assert_array_equal(index[is_clear], indices[0][is_clear])
    np.testing.assert_array_equal(np.isnan(depth), index < 0)
    low, high = depths.min(axis=0), depths.max(axis=0)
    surely = is_clear & (index >= 0)
    slack = 2e-6 + 2e-6 * high[surely]
    assert (depth[surely] >= low[surely] - slack).all()
    assert (depth[surely] <= high[surely] + slack).all()


@settings(deadline=None, max_examples=30)
@given(SEEDS)
def test_depth_is_exact_where_surfaces_face_the_camera(seed: int) -> None:
    rng = np.random.default_rng(seed)
    solids, T = random_solids(rng, 20), random_pose(rng, 1.5)
    depth, index, normals = solids.scene.cast_rays(CAMERA, SIZE, T)
    expected, expected_index = seen(solids, CAMERA, (100, 75), T)
    d = rays(CAMERA, (100, 75))
    cosine = -(normals * d).sum(-1) / np.linalg.norm(d, axis=-1)
    facing = (index == expected_index) & (cosine > 0.5)
    assert np.abs(depth[facing] - expected[facing]).max(initial=0.0) < 3e-6


@settings(deadline=None, max_examples=30)
@given(SEEDS)
def test_normals_are_those_of_the_surfaces(seed: int) -> None:
    """Of length 1, turned to the camera, and square to the points of a neighbourhood on flat faces."""
    rng = np.random.default_rng(seed)
    solids, T = random_solids(rng, 20), random_pose(rng, 1.5)
    depth, index, normals = solids.scene.cast_rays(CAMERA, SIZE, T)
    d = rays(CAMERA, (100, 75))
    points, is_seen = d * depth[..., None], index >= 0
    np.testing.assert_array_equal(np.isnan(normals).any(-1), ~is_seen)
    np.testing.assert_allclose(np.linalg.norm(normals[is_seen], axis=1), 1.0, atol=1e-6)
    assert ((normals * d).sum(-1)[is_seen] < 1e-4).all()
    same = (index[:, 1:] == index[:, :-1]) & (index[:, 1:] >= 0)
    same &= (np.abs(normals[:, 1:] - normals[:, :-1]) < 1e-6).all(-1)
    steps = ((points[:, 1:] - points[:, :-1]) * normals[:, 1:]).sum(-1)
    assert np.abs(steps[same]).max(initial=0.0) < 1e-5


@pytest.mark.parametrize("kind", [BOX, CYLINDER, SPHERE])
def test_the_middle_of_a_solid_is_seen_at_its_surface(kind: int) -> None:
    half = [0.1, 0.1, 0.1]
    depth, index, normals = one(pose((0.0, 0.0, 2.0)), half, kind).cast_rays(
        np.array([100.0, 100.0, 10.0, 10.0]), np.array([21, 21], np.int32), np.eye(4)
    )
    assert depth[10, 10] == np.float32(1.9)
    assert index[10, 10] == 0
    np.testing.assert_array_equal(normals[10, 10], [0.0, 0.0, -1.0])
    assert index[0, 0] == -1


def test_depth_is_measured_along_the_optical_axis() -> None:
    """A wall across the axis is equally deep everywhere, a ball is not."""
    depth, _, _ = one(pose((0.0, 0.0, 3.0)), [9.0, 9.0, 1.0]).cast_rays(CAMERA, SIZE, np.eye(4))
    np.testing.assert_allclose(depth, 2.0, atol=1e-6)
    depth, _, _ = one(pose((0.0, 0.0, 3.0)), [1.0] * 3, SPHERE).cast_rays(CAMERA, SIZE, np.eye(4))
    d = rays(CAMERA, (100, 75))
    points = (d * depth[..., None] - [0.0, 0.0, 3.0])[~np.isnan(depth)]
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 1.0, atol=1e-6)


def test_x_is_to_the_right_and_y_is_down() -> None:
    """The box at x > 0 is in the right half of the picture, the one at y > 0 in the lower half."""
    solids = Solids()
    solids.add(pose((0.5, 0.0, 2.0)), np.full(3, 0.1))
    solids.add(pose((0.0, 0.5, 2.0)), np.full(3, 0.1))
    _, index, _ = solids.scene.cast_rays(CAMERA, SIZE, np.eye(4))
    rows, columns = np.nonzero(index == 0)
    assert columns.min() > CAMERA[2]
    assert rows.min() < CAMERA[3] < rows.max()
    assert np.nonzero(index == 1)[0].min() > CAMERA[3]


@pytest.mark.parametrize("offset", [0.0, 0.1, -0.1, 0.0999999, 0.1000001])
def test_rays_parallel_to_faces_are_judged_by_their_place(offset: float) -> None:
    """The middle row and column divide by zero; a ray in the face itself may count to either side."""
    scene = one(pose((offset, 0.0, 2.0)), [0.1, 0.1, 0.5])
    depth, _, _ = scene.cast_rays(
        np.array([100.0, 100.0, 20.0, 20.0]), np.array([41, 41], np.int32), np.eye(4)
    )
    inside = depth[20, 20]
    if abs(offset) != 0.1:
        assert (inside == 1.5) == (abs(offset) < 0.1)
    else:
        assert np.isnan(inside) or inside == 1.5
    assert (np.isnan(depth) | (depth > 1.4)).all()


@pytest.mark.parametrize("kind", [BOX, CYLINDER, SPHERE])
def test_a_solid_around_the_camera_is_not_seen_and_hides_nothing(kind: int) -> None:
    solids = Solids()
    solids.add(np.eye(4), np.full(3, 0.2), kind)
    solids.add(pose((0.0, 0.0, 1.0)), np.array([5.0, 5.0, 0.1]))
    _, index, _ = solids.scene.cast_rays(CAMERA, SIZE, np.eye(4))
    assert (index == 1).all()


def test_a_floor_through_the_camera_plane_is_seen_to_its_end() -> None:
    """It begins behind the camera; its rows are those under the horizon."""
    scene = one(pose((0.0, 1.1, 0.0)), [50.0, 0.1, 40.0])
    depth, index, _ = scene.cast_rays(CAMERA, SIZE, np.eye(4))
    y = (np.arange(SIZE[1]) - CAMERA[3]) / CAMERA[1]
    expected = np.where(y > 1.0 / 40.0, 1.0 / np.maximum(y, 1e-9), np.nan)
    np.testing.assert_allclose(depth, np.repeat(expected[:, None], SIZE[0], axis=1), rtol=1e-5)
    np.testing.assert_array_equal(index >= 0, ~np.isnan(depth))


@settings(deadline=None, max_examples=20)
@given(SEEDS)
def test_both_builds_give_the_same_bytes(seed: int) -> None:
    rng = np.random.default_rng(seed)
    scene, T, fastest = random_solids(rng, 30).scene, random_pose(rng, 1.5), simd()
    pictures = []
    for build in ("baseline", fastest, fastest):
        set_simd(build)
        pictures.append([part.tobytes() for part in scene.cast_rays(CAMERA, SIZE, T)])
    assert pictures[0] == pictures[1] == pictures[2]


@settings(deadline=None, max_examples=20)
@given(SEEDS)
def test_a_picture_is_the_nearest_of_the_pictures_of_single_solids(seed: int) -> None:
    rng = np.random.default_rng(seed)
    solids, T = random_solids(rng, 12), random_pose(rng, 1.5)
    depth, _, _ = solids.scene.cast_rays(CAMERA, SIZE, T)
    single = []
    for i in range(12):
        alone = Solids([solids.T[i]], [solids.half[i]], [solids.kind[i]], [solids.planes[i]])
        single.append(alone.scene.cast_rays(CAMERA, SIZE, T)[0])
    np.testing.assert_array_equal(depth, np.fmin.reduce(single))


def test_no_solids_are_an_empty_picture() -> None:
    depth, index, normals = Solids().scene.cast_rays(CAMERA, SIZE, np.eye(4))
    assert depth.shape == index.shape == (75, 100)
    assert np.isnan(depth).all()
    assert (index == -1).all()
    assert np.isnan(normals).all()


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"intrinsics": [0.0, 1.0, 0.0, 0.0]}, "fx and fy must be positive"),
        ({"intrinsics": [np.nan, 1.0, 0.0, 0.0]}, "intrinsics: not finite"),
        ({"size": np.array([0, 4], np.int32)}, "width and height"),
        ({"size": np.array([100_000, 100_000], np.int32)}, "at most 1e8 pixels"),
        ({"T_world_camera": 2.0 * np.eye(4)}, "not a rigid pose"),
    ],
)
def test_impossible_cameras_are_refused(changed: dict[str, Array], told: str) -> None:
    arguments = {"intrinsics": CAMERA, "size": SIZE, "T_world_camera": np.eye(4), **changed}
    with pytest.raises(ValueError, match=told):
        Solids().scene.cast_rays(**arguments)


@pytest.mark.parametrize(
    ("half", "kind", "planes", "n_planes", "told"),
    [
        ([0.1, 0.1, 0.0], 0, np.zeros((0, 4)), 0, r"half_extents\[0\]"),
        ([0.1, 0.2, 0.3], 1, np.zeros((0, 4)), 0, r"half_extents\[0\]"),
        ([0.1, 0.1, 0.1], 3, np.zeros((0, 4)), 0, r"kind\[0\]"),
        ([0.1, 0.1, 0.1], 0, [[1.0, 0.0, 0.0, 0.0]], 0, "sum"),
        ([0.1, 0.1, 0.1], 0, [[1.0, 0.0, 0.0, 0.0]], 2, r"n_planes\[0\]"),
        ([0.1, 0.1, 0.1], 2, [[1.0, 0.0, 0.0, 0.0]], 1, r"n_planes\[0\]"),
        ([0.1, 0.1, 0.1], 0, [[2.0, 0.0, 0.0, 0.0]], 1, r"planes\[0\]"),
    ],
)
def test_impossible_solids_are_refused(
    half: list[float], kind: int, planes: Array, n_planes: int, told: str
) -> None:
    with pytest.raises(ValueError, match=told):
        RaycastingScene(
            np.eye(4)[None],
            np.array([half]),
            np.array([kind], np.int32),
            np.array(planes),
            np.array([n_planes], np.int32),
        )
