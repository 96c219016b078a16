"""Colour pictures: light by its formula, textures in their places, shadows where the lamp is hidden."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from pickcli.geometry import Array, inverse, pose
from pickcli.kernel import Lighting, Looks, Texture, set_simd, simd
from support.ray_reference import BOX, CYLINDER, SPHERE, Solids, entry, rays

INTRINSICS = np.array([200.0, 200.0, 59.5, 44.5])
SIZE = np.array([120, 90], np.int32)
NO_TEXTURES = [-1] * 6
BACKGROUND = np.array([10.0, 20.0, 30.0])
# Looking along an axis of the world with another one up: columns are the camera's x, y and z.
VIEWS = {  # of the face +x, -x, ... from outside
    0: ((-1, 0, 0), (0, 0, 1)), 1: ((1, 0, 0), (0, 0, 1)), 2: ((0, -1, 0), (0, 0, 1)),
    3: ((0, 1, 0), (0, 0, 1)), 4: ((0, 0, -1), (0, 1, 0)), 5: ((0, 0, 1), (0, 1, 0)),
}  # fmt: skip
Picture = NDArray[np.uint8]


def looking(forward: tuple[int, ...], up: tuple[int, ...], distance: float) -> Array:
    """A camera that looks along ``forward`` at the origin from a distance."""
    z, y = np.array(forward, float), -np.array(up, float)
    T = np.eye(4)
    T[:3, :3] = np.column_stack([np.cross(y, z), y, z])
    T[:3, 3] = -distance * z
    return T


def light(
    ambient: float = 0.0, headlight: float = 0.0, lamp: float = 0.0, T: Array | None = None
) -> Lighting:
    return Lighting(ambient, headlight, lamp, np.eye(4) if T is None else T, BACKGROUND)


def plain(solids: Solids, colours: list[list[float]]) -> Looks:
    n = len(solids.T)
    return Looks(np.reshape(np.array(colours), (n, 3)), np.zeros(n), np.full((n, 6), -1, np.int32), [])


def shaded(solids: Solids, looks: Looks, lighting: Lighting, T: Array) -> Picture:
    return np.asarray(solids.scene.shaded(INTRINSICS, SIZE, T, looks, lighting))


def test_light_from_everywhere_is_a_quarter_less_from_below() -> None:
    """A box from above, from the side and from below; squares of bytes are amounts of light."""
    solids = Solids()
    solids.add(np.eye(4), np.full(3, 0.2))
    colour, looks = np.array([200.0, 120.0, 40.0]), plain(solids, [[200.0, 120.0, 40.0]])
    for face, share in ((4, 1.0), (0, 0.875), (5, 0.75)):
        picture = shaded(solids, looks, light(ambient=0.5), looking(*VIEWS[face], 1.0))
        np.testing.assert_allclose(picture[45, 60], colour * np.sqrt(0.5 * share), atol=0.51)


def test_where_nothing_is_seen_there_is_the_background() -> None:
    picture = shaded(Solids(), plain(Solids(), []), light(0.5), np.eye(4))
    assert (picture == BACKGROUND).all()


@pytest.mark.parametrize("z", [0.5, 0.8])
def test_light_at_the_camera_falls_with_the_square_of_the_distance(z: float) -> None:
    solids = Solids()
    solids.add(pose((0.0, 0.0, z + 0.1)), np.array([9.0, 9.0, 0.1]))
    picture = shaded(solids, plain(solids, [[250.0, 250.0, 250.0]]), light(headlight=0.6), np.eye(4))
    d = rays(INTRINSICS, (120, 90))
    distance2 = z * z * (d**2).sum(-1)
    expected = 250.0 * np.sqrt(0.6 * 0.25 / distance2 * z / np.sqrt(distance2))
    np.testing.assert_allclose(picture[..., 0], expected, atol=0.6)


def gradient(reach: int = 200) -> Picture:
    """Red from the left, green from the top."""
    v, u = np.mgrid[:reach, :reach]
    return np.stack([u, v, np.full_like(u, 50)], axis=-1).astype(np.uint8)


@pytest.mark.parametrize("face", range(6))
def test_textures_stand_upright_on_every_face(face: int) -> None:
    """Seen from outside, a texture begins at the upper left."""
    solids, half = Solids(), np.array([0.1, 0.13, 0.16])
    solids.add(np.eye(4), half)
    faces = np.full((1, 6), -1, np.int32)
    faces[0, face] = 0
    looks = Looks(np.zeros((1, 3)), np.zeros(1), faces, [Texture(gradient())])
    forward, up = VIEWS[face]
    distance, T = 1.0, looking(forward, up, 1.0 + half[face // 2])
    picture = shaded(solids, looks, light(ambient=1.0 / (0.875 + 0.125 * (0, 0, 0, 0, 1, -1)[face])), T)
    across, height = abs(T[:3, 0] @ half), abs(T[:3, 1] @ half)
    d = rays(INTRINSICS, (120, 90)) * distance
    u, v = (d[..., 0] / across + 1.0) / 2.0, (d[..., 1] / height + 1.0) / 2.0
    inside = (np.abs(u - 0.5) < 0.48) & (np.abs(v - 0.5) < 0.48)
    assert inside.sum() > 800
    np.testing.assert_allclose(picture[..., 0][inside], 200.0 * u[inside] - 0.5, atol=2.0)
    np.testing.assert_allclose(picture[..., 1][inside], 200.0 * v[inside] - 0.5, atol=2.0)


def test_the_mantle_of_a_cylinder_begins_at_x_and_goes_on_towards_y() -> None:
    """From -y its middle is at 3/4 of a turn, and turns go to the right; from +y at a quarter."""
    solids = Solids()
    solids.add(np.eye(4), np.array([0.15, 0.15, 0.2]), CYLINDER)
    looks = Looks(
        np.zeros((1, 3)), np.zeros(1), np.array([[-1, -1, 0, -1, -1, -1]], np.int32), [Texture(gradient())]
    )
    for face, turn in ((3, 0.75), (2, 0.25), (1, 0.5)):
        picture = shaded(solids, looks, light(ambient=1.0 / 0.875), looking(*VIEWS[face], 1.0))
        assert picture[45, 60, 0] == pytest.approx(200.0 * turn, abs=2)
        assert picture[45, 70, 0] > picture[45, 50, 0]
        assert picture[20, 60, 1] < picture[70, 60, 1]


@pytest.mark.parametrize("kind", [CYLINDER, SPHERE])
def test_round_solids_have_the_textures_of_all_their_faces(kind: int) -> None:
    solids = Solids()
    solids.add(np.eye(4), np.full(3, 0.15), kind)
    n = 3 if kind == CYLINDER else 6
    even = [Texture(np.full((8, 8, 3), 40 * (i + 1), np.uint8)) for i in range(n)]
    faces = np.array([[*range(n), *NO_TEXTURES[n:]]], np.int32)
    looks = Looks(np.zeros((1, 3)), np.zeros(1), faces, even)
    for view in range(6):
        up = (0, 0, 0, 0, 1, -1)[view]
        T = looking(*VIEWS[view], 1.0)
        picture = shaded(solids, looks, light(ambient=1.0 / (0.875 + 0.125 * up)), T)
        face = view if kind == SPHERE else (0 if view == 4 else 1 if view == 5 else 2)
        assert picture[45, 60, 0] == pytest.approx(40 * (face + 1), abs=1)


def test_what_is_finer_than_a_pixel_is_even() -> None:
    """Lines of 0.25 mm are black and white from 5 cm, and grey from 2 m."""
    stripes = np.zeros((400, 400, 3), np.uint8)
    stripes[:, ::2] = 200
    solids = Solids()
    solids.add(np.eye(4), np.array([0.05, 0.05, 0.05]))
    looks = Looks(
        np.zeros((1, 3)), np.zeros(1), np.array([[0, *NO_TEXTURES[1:]]], np.int32), [Texture(stripes)]
    )
    far = shaded(solids, looks, light(ambient=1.0 / 0.875), looking(*VIEWS[0], 2.0))[43:47, 57:63]
    assert np.abs(far.astype(float) - 100.0).max() <= 3.0
    near = shaded(solids, looks, light(ambient=1.0 / 0.875), looking(*VIEWS[0], 0.06))[30:60, 30:90, 0]
    assert near.max() - near.min() > 150


def test_shadows_lie_where_the_way_to_the_lamp_is_barred() -> None:
    """Of a box, a can and a ball on a floor, but for the pixels of the lamp at their edges."""
    solids = Solids()
    solids.add(pose((0.0, 0.0, -0.1)), np.array([2.0, 2.0, 0.1]))
    solids.add(pose((0.2, 0.1, 0.1), rpy=(0.0, 0.0, 0.4)), np.array([0.05, 0.08, 0.1]))
    solids.add(pose((-0.2, 0.1, 0.08)), np.array([0.06, 0.06, 0.08]), CYLINDER)
    solids.add(pose((0.0, -0.15, 0.3)), np.array([0.06, 0.06, 0.06]), SPHERE)
    lamp = looking((0, 0, -1), (0, 1, 0), 2.0)
    lamp[:3, 3] = [0.7, -0.5, 2.0]
    T = looking((0, 0, -1), (0, 1, 0), 1.6)
    picture = shaded(solids, plain(solids, [[200.0] * 3] * 4), light(0.2, 0.0, 0.5, lamp), T)[..., 0]
    depth, index, _ = solids.scene.cast_rays(INTRINSICS, SIZE, T)
    points = (rays(INTRINSICS, (120, 90)) * depth[..., None]) @ T[:3, :3].T + T[:3, 3]
    way = lamp[:3, 3] - points
    barred = np.zeros(index.shape, bool)
    for i in range(1, 4):
        d = (points - lamp[:3, 3]) @ lamp[:3, :3]
        hit = entry(solids.T[i], solids.half[i], solids.kind[i], np.zeros((0, 4)), lamp, d / d[..., 2:])
        barred |= (hit < d[..., 2] - 1e-6) & (index == 0)
    facing = way[..., 2] / np.linalg.norm(way, axis=-1)
    floor = index == 0
    lit = 200.0 * np.sqrt(0.2 + 0.5 * facing)
    is_lit, is_dark = np.abs(picture - lit) < 1.0, np.abs(picture - 200.0 * np.sqrt(0.2)) < 1.0
    assert barred.sum() > 300
    agrees = np.where(barred, is_dark, is_lit)[floor]
    assert agrees.mean() > 0.97
    inner = barred.copy()
    for shift in ((1, 0), (-1, 0), (0, 1), (0, -1)):
        inner &= np.roll(barred, shift, (0, 1))
    assert is_dark[inner & floor].mean() > 0.99


def test_convex_solids_throw_no_shadow_on_themselves() -> None:
    """A floor under a lamp at a low angle is lit everywhere, by its formula."""
    solids = Solids()
    solids.add(pose((0.0, 0.0, -0.1)), np.array([2.0, 2.0, 0.1]))
    lamp = looking((1, 0, 0), (0, 0, 1), 3.0)
    lamp[:3, 3] = [-3.0, 0.0, 0.4]
    T = looking((0, 0, -1), (0, 1, 0), 1.6)
    picture = shaded(solids, plain(solids, [[250.0] * 3]), light(0.1, 0.0, 0.9, lamp), T)[..., 0]
    points = rays(INTRINSICS, (120, 90)) * 1.6 @ T[:3, :3].T + T[:3, 3]
    way = lamp[:3, 3] - points
    expected = 250.0 * np.sqrt(0.1 + 0.9 * way[..., 2] / np.linalg.norm(way, axis=-1))
    np.testing.assert_allclose(picture, expected, atol=0.6)


def test_gloss_adds_a_highlight_where_the_lamp_is_mirrored() -> None:
    solids = Solids()
    solids.add(pose((0.0, 0.0, -0.1)), np.array([2.0, 2.0, 0.1]))
    lamp, T = looking((0, 0, -1), (0, 1, 0), 2.0), looking((0, 0, -1), (0, 1, 0), 1.0)
    lamp[:3, 3] = [0.6, 0.0, 2.0]
    T[:3, 3] = [0.0, 0.0, 1.0]
    faces = np.full((1, 6), -1, np.int32)
    dull, bright = (
        shaded(
            solids, Looks(np.full((1, 3), 90.0), np.array([gloss]), faces, []), light(0.2, 0.0, 0.4, lamp), T
        )
        for gloss in (0.0, 0.8)
    )
    added = bright[..., 0].astype(int) - dull[..., 0]
    # The mirror image of a lamp at (0.6, 2) from an eye at (0, 1) is at a third of the way: x = 0.2.
    column = INTRINSICS[0] * 0.2 + INTRINSICS[2]
    assert added[45, round(column)] >= added.max() - 1
    assert added.max() > 60
    assert added[45, 0] < added.max() / 3


def test_pictures_are_the_same_bytes_in_both_builds() -> None:
    solids = Solids()
    solids.add(pose((0.0, 0.0, 1.0), rpy=(0.3, 0.4, 0.5)), np.array([0.2, 0.1, 0.15]), BOX)
    solids.add(pose((0.2, 0.0, 1.2)), np.array([0.1, 0.1, 0.15]), CYLINDER)
    faces = np.array([[0, 0, 0, 0, 0, 0], [0, 0, 0, -1, -1, -1]], np.int32)
    looks = Looks(np.full((2, 3), 90.0), np.full(2, 0.3), faces, [Texture(gradient())])
    lamp, fastest, pictures = inverse(pose((0.5, 0.5, 2.0))), simd(), []
    for build in ("baseline", fastest, fastest):
        set_simd(build)
        pictures.append(shaded(solids, looks, light(0.3, 0.2, 0.5, lamp), np.eye(4)).tobytes())
    assert pictures[0] == pictures[1] == pictures[2]


def test_textures_that_do_not_exist_and_looks_of_others_are_refused() -> None:
    with pytest.raises(ValueError, match=r"face_textures\[0\]: no such texture"):
        Looks(
            np.zeros((1, 3)), np.zeros(1), np.array([[1, *NO_TEXTURES[1:]]], np.int32), [Texture(gradient())]
        )
    with pytest.raises(ValueError, match="no pixels"):
        Texture(np.zeros((0, 4, 3), np.uint8))
    with pytest.raises(ValueError, match="not of as many solids"):
        solids = Solids()
        solids.add(np.eye(4), np.full(3, 0.1))
        shaded(solids, plain(Solids(), []), light(0.5), np.eye(4))
