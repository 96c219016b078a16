"""Items in the picture of a place: rendered as by the rays of cameras, compared, and decided together."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pickcli.geometry import Array, pose, rotation_angle
from pickcli.kernel import DepthNoise, PlacePicture, RaycastingScene, SolidKind, set_simd, simd

INTRINSICS, SIZE = np.array([300.0, 300.0, 79.5, 59.5]), np.array([160, 120], dtype=np.int32)
NOISE = DepthNoise(least=0.1, greatest=3.0, incidence_from=1.1, incidence_to=1.4, constant=0.001)
WALL = 0.6  # m
UP = np.array([0.0, -1.0, 0.0])
BOX, CYLINDER, SPHERE = (kind.value for kind in (SolidKind.BOX, SolidKind.CYLINDER, SolidKind.SPHERE))
SOLIDS = {
    BOX: (np.array([0.05, 0.03, 0.02]), pose((0.03, 0.01, 0.45), rpy=(0.3, 0.5, 0.2))),
    CYLINDER: (np.array([0.03, 0.03, 0.05]), pose((-0.06, 0.0, 0.5), rpy=(1.2, 0.1, 0.0))),
    SPHERE: (np.array([0.03, 0.03, 0.03]), pose((-0.02, -0.05, 0.4))),
}
NO_SOLIDS = (np.zeros((0, 4, 4)), np.zeros((0, 3)), np.zeros(0, dtype=np.int32))


def cast(kinds: tuple[int, ...]) -> tuple[NDArray[np.float32], NDArray[np.int32]]:
    """Depth and indices of these solids before a wall, by the rays of cameras."""
    poses = np.array([SOLIDS[kind][1] for kind in kinds] + [pose((0.0, 0.0, WALL + 0.1))])
    half = np.array([SOLIDS[kind][0] for kind in kinds] + [[2.0, 2.0, 0.1]])
    scene = RaycastingScene(
        poses,
        half,
        np.array([*kinds, BOX], dtype=np.int32),
        np.zeros((0, 4)),
        np.zeros(len(kinds) + 1, np.int32),
    )
    depth, index, _ = scene.cast_rays(INTRINSICS, SIZE, np.eye(4))
    return depth, np.where(index == len(kinds), -1, index).astype(np.int32)


def picture_of(measured: NDArray[np.float32], **changes: Any) -> PlacePicture:
    """A picture with this depth before a wall, and one product of each kind."""
    shape = measured.shape
    arguments: dict[str, Any] = {
        "intrinsics": INTRINSICS,
        "depth": measured,
        "share": np.ones(shape, np.float32),
        "colour": np.zeros(shape, np.int32),
        "known": [np.full(shape, WALL, np.float32), np.ones(shape, np.float32)],
        "known_solids": NO_SOLIDS,
        "known_colours": np.zeros(1),
        "noise": NOISE,
        "costs": np.array([0.002, 4.0, 8.0, 0.1, 0.7, 1.0]),
    }
    picture = PlacePicture(**(arguments | changes))
    for kind, (half, _) in SOLIDS.items():
        picture.add(kind, half, 0.0, np.zeros(1))
    return picture


def placed(kinds: tuple[int, ...]) -> tuple[NDArray[np.int32], Array]:
    return np.array(kinds, dtype=np.int32), np.array([SOLIDS[kind][1] for kind in kinds])


@pytest.mark.parametrize("kinds", [(BOX,), (CYLINDER,), (SPHERE,), (BOX, CYLINDER, SPHERE)])
def test_items_are_rendered_as_by_the_rays_of_cameras(kinds: tuple[int, ...]) -> None:
    depth, index = cast(kinds)
    owner, composed, _ = picture_of(depth).composed(*placed(kinds))
    same = owner == index
    assert same.mean() > 0.999  # but for pixels at edges, by the last digit
    np.testing.assert_allclose(composed[same], depth[same], atol=2e-6)


def test_the_true_pose_explains_a_picture_better_than_others() -> None:
    depth, _ = cast((BOX,))
    picture, rng = picture_of(depth), np.random.default_rng(1)
    T = SOLIDS[BOX][1]

    def gain(T: Array) -> float:
        return float(picture.evidence(np.array([BOX], dtype=np.int32), T[None], 0.004)[0, 5])

    best = gain(T)
    assert best > 1000.0
    for _ in range(50):
        off = pose(rng.normal(0.0, 0.01, 3), rpy=rng.normal(0.0, 0.1, 3))
        assert gain(T @ off) < best


def test_all_items_find_their_places_among_those_of_others() -> None:
    """From true poses and others in any order; an item that is not there gets none."""
    kinds = (BOX, SPHERE)
    picture, rng = picture_of(cast(kinds)[0]), np.random.default_rng(2)
    options = []
    for kind in (BOX, CYLINDER, SPHERE):
        T = SOLIDS[kind][1]
        others = [pose(T[:3, 3] + rng.normal(0.0, 0.04, 3), R=T[:3, :3]) for _ in range(6)]
        options.append(np.array([*others[:3], T, *others[3:]]))
    chosen, gains, margins = picture.choose(np.array([BOX, CYLINDER, SPHERE], dtype=np.int32), options, 40.0)
    assert chosen.tolist() == [3, -1, 3]
    assert (gains[[0, 2]] > 100.0).all()
    assert (margins[[0, 2]] > 0.0).all()


def test_a_refined_pose_comes_back() -> None:
    picture, T = picture_of(cast((BOX,))[0]), SOLIDS[BOX][1]
    start = T @ pose((0.004, -0.003, 0.003), rpy=(0.03, -0.03, 0.03))
    steps = np.array([0.002, 0.001, 0.0005, 0.00025])
    (found,) = picture.refined(np.array([BOX], dtype=np.int32), start[None], None, steps, 0.001, 3)
    assert np.linalg.norm(found[:3, 3] - T[:3, 3]) < 0.001


@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("edge", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_a_pose_that_is_turned_about_an_edge_comes_back(axis: int, edge: tuple[int, int]) -> None:
    picture, (half, T) = picture_of(cast((BOX,))[0]), SOLIDS[BOX]
    out = np.zeros(3)
    out[[(axis + 1) % 3, (axis + 2) % 3]] = edge
    turned = np.zeros(3)
    turned[axis] = 0.05
    start = T @ pose(out * half) @ pose(rpy=turned) @ pose(-out * half)
    steps = np.array([0.004, 0.002, 0.001, 0.0005, 0.00025])
    (found,) = picture.refined(np.array([BOX], dtype=np.int32), start[None], None, steps, 0.001, 2)
    assert np.linalg.norm(found[:3, 3] - T[:3, 3]) < 0.001
    assert rotation_angle(found[:3, :3].T @ T[:3, :3]) < np.radians(0.6)


@pytest.mark.parametrize("kind", SOLIDS)
def test_what_an_item_costs_is_by_how_much_the_picture_does(kind: int) -> None:
    """At many poses, behind and before another item: by whole pictures, and by the item's pixels alone."""
    rng, other = np.random.default_rng(kind), (kind + 1) % 3
    picture = picture_of(cast((kind, other))[0])
    placed = np.array([other], dtype=np.int32), SOLIDS[other][1][None]
    poses = np.array(
        [
            SOLIDS[kind][1] @ pose(rng.uniform(-0.03, 0.03, 3), rpy=tuple(rng.uniform(-1, 1, 3)))
            for _ in range(30)
        ]
    )
    without = picture.composed(*placed)[2].sum(dtype=np.float64)
    expected = [
        picture.composed(np.append(placed[0], np.int32(kind)), np.concatenate([placed[1], T[None]]))[2].sum(
            dtype=np.float64
        )
        - without
        for T in poses
    ]
    np.testing.assert_allclose(picture.costs(kind, poses, placed), expected, rtol=1e-4, atol=1e-3)


@pytest.mark.parametrize("kind", SOLIDS)
def test_both_builds_give_the_same_bytes(kind: int) -> None:
    """Odd windows at the edges of the picture, missing depth, and fits of many points among them."""
    fastest, found = simd(), []
    measured = cast((BOX, CYLINDER, SPHERE))[0]
    picture = picture_of(
        measured, share=(np.arange(measured.size) % 7 > 0).astype(np.float32).reshape(measured.shape)
    )
    rng, T = np.random.default_rng(3), SOLIDS[kind][1]
    poses = np.array([T, *(T @ pose(rng.uniform(-0.15, 0.15, 3)) for _ in range(40))])
    nothing = np.zeros(0, dtype=np.int32), np.zeros((0, 4, 4))
    for build in ("baseline", fastest):
        set_simd(build)
        own = picture.candidates(kind, poses, UP, np.array([0.008, 0.004]), (10, 5), nothing)
        seen = picture.composed(np.array([kind], dtype=np.int32), T[None])
        found.append([part.tobytes() for part in (picture.costs(kind, poses, nothing), *own, *seen)])
    assert found[0] == found[1]


def test_what_gives_no_depth_is_explained_by_what_seldom_does() -> None:
    """Nothing comes back where the box is: clear matter explains that, matt does not."""
    depth, index = cast((BOX,))
    picture = picture_of(depth, share=np.where(index < 0, 1.0, 0.0).astype(np.float32))
    gains = []
    for no_return in (0.0, 0.9):
        item = picture.add(BOX, SOLIDS[BOX][0], no_return, np.zeros(1))
        of = np.array([item], dtype=np.int32)
        gains.append(picture.evidence(of, SOLIDS[BOX][1][None], 0.004)[0, 5])
    assert gains[1] > gains[0] + 500.0


@pytest.mark.parametrize("kind", SOLIDS)
@pytest.mark.parametrize("is_near", [True, False])
def test_no_depth_says_little_of_what_is_out_of_range(kind: int, is_near: bool) -> None:
    """From where nothing is measured nothing can come back; from elsewhere all says as much as ever."""
    depth, index = cast((kind,))
    placed_one = np.array([kind], dtype=np.int32), SOLIDS[kind][1][None]
    end = float(np.median(depth[index == 0]))
    is_lost = (depth < end if is_near else depth > end) & (index == 0)
    share = np.where(is_lost, 0.0, 1.0).astype(np.float32)
    least, greatest = (end, 3.0) if is_near else (0.1, end)
    in_range = DepthNoise(
        least=least, greatest=greatest, incidence_from=1.1, incidence_to=1.4, constant=0.001
    )
    of_any, of_range = (
        picture_of(depth, share=share, noise=noise).composed(*placed_one)[2] for noise in (NOISE, in_range)
    )
    assert of_range[is_lost].max() <= np.float32(0.7)  # as much as in a shadow of the second eye
    assert np.median(of_any[is_lost]) > 2.0
    is_due = (index == 0) & (np.abs(depth - end) > 0.005) & ~is_lost
    assert is_due.any()
    np.testing.assert_array_equal(of_range[is_due], of_any[is_due])


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"intrinsics": np.array([0.0, 1.0, 1.0, 1.0])}, "intrinsics"),
        ({"share": np.full((120, 160), 2.0, np.float32)}, "share from 0 to 1"),
        ({"share": np.ones((2, 2), np.float32)}, "share: not of the size"),
        ({"depth": np.full((120, 160), np.nan, np.float32)}, "depth: must be finite"),
        ({"colour": np.full((120, 160), 1, np.int32)}, "colour: no such label"),
        ({"known": [np.ones((120, 160), np.float32)]}, "known: expected depth and facing"),
        ({"costs": np.ones(3)}, "costs"),
    ],
)
def test_what_is_no_picture_is_told(changes: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        picture_of(cast((BOX,))[0], **changes)


def test_what_is_no_product_is_told() -> None:
    picture = picture_of(cast((BOX,))[0])
    with pytest.raises(ValueError, match="no such product"):
        picture.composed(np.array([7], dtype=np.int32), np.eye(4)[None])
    with pytest.raises(ValueError, match="no_return"):
        picture.add(BOX, SOLIDS[BOX][0], 1.5, np.zeros(1))
