"""Poses come out of matches as they went in; what is there in part or not at all is not claimed."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.item import Item
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.geometry import Array, pose, rotation_angle, transform_points
from pickcli.perception.looks import LightingModel, colour_picture, coloured
from pickcli.perception.procedural_texture import damaged_faces, face_textures
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene, RenderedSolid
from pickcli.perception.textures.print_features import PrintFeatures, print_features
from pickcli.perception.textures.print_matching import Matches, matches_of
from pickcli.perception.textures.print_model import PrintModel, surface_frames, surface_points
from pickcli.perception.textures.print_pose import PictureFeatures, PrintPose, print_poses
from pickcli.perception.textures.sift_views import SiftViews

CAMERA = PinholeCamera(1400.0, 1400.0, 320.0, 240.0, 640, 480)
N_POSES, MOST_WRONG = 60, 40
OTHER_LIGHT = LightingModel(ambient=0.4, headlight=0.1, lamp=0.5, lamp_position=(0.4, -1.0, -0.6))


def made_up(
    model: PrintModel, T: Array, rng: np.random.Generator, n_wrong: int
) -> tuple[PictureFeatures, Matches]:
    """What a camera would see of the features of some views, with matches of which so many are wrong."""
    towards = np.einsum("ij,nj->ni", T[:3, :3], -model.frames[:, :, 2])
    at = transform_points(T, model.points)
    known = np.flatnonzero((towards * at).sum(axis=1) < -0.5 * np.linalg.norm(at, axis=1))
    known = rng.choice(known, 80, replace=False)
    points, frames = at[known], T[:3, :3] @ model.frames[known]
    pixels = CAMERA.project(points) + rng.normal(0.0, 0.2, (80, 2))
    step = CAMERA.project(points + 1e-4 * frames[:, :, 0]) - CAMERA.project(points)
    features = PrintFeatures(
        pixels,
        model.lengths[known] * CAMERA.fx / points[:, 2],
        np.arctan2(step[:, 1], step[:, 0]),
        model.descriptors[known],
    )
    claimed = known.copy()
    claimed[:n_wrong] = rng.choice(len(model), n_wrong)
    seen = PictureFeatures(CAMERA, features, points + rng.normal(0.0, 0.0005, points.shape), towards[known])
    return seen, Matches(np.arange(80), claimed, np.full(80, 0.5))


def test_poses_are_recovered_among_wrong_matches(soap_model: PrintModel) -> None:
    """Up to half of the matches are wrong; the others have errors, so that the last of many is off more."""
    off, turned = [], []
    for seed in range(N_POSES):
        rng, n_wrong = np.random.default_rng(seed), MOST_WRONG * seed // (N_POSES - 1)
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        T = pose((*rng.uniform(-0.06, 0.06, 2), rng.uniform(0.5, 0.9)), R=turn * np.linalg.det(turn))
        seen, matches = made_up(soap_model, T, rng, n_wrong)
        (found,) = print_poses(seen, soap_model, (matches,), 1)
        off.append(float(np.linalg.norm(found.T_camera_item[:3, 3] - T[:3, 3])))
        turned.append(np.degrees(rotation_angle(found.T_camera_item[:3, :3].T @ T[:3, :3])))
        assert found.n_matches >= 0.8 * (80 - n_wrong)
    assert np.quantile(off, 0.9) < 0.0015 and max(off) < 0.006
    assert np.quantile(turned, 0.9) < 1.0 and max(turned) < 6.0


def test_wrong_matches_alone_give_no_pose(soap_model: PrintModel) -> None:
    for seed in range(5):
        seen, matches = made_up(soap_model, pose((0.0, 0.0, 0.7)), np.random.default_rng(seed), 80)
        assert print_poses(seen, soap_model, (matches,), 2) == ()


def test_depth_decides(soap_model: PrintModel) -> None:
    """What agrees in the picture alone is not claimed if something else was measured there."""
    seen, matches = made_up(soap_model, pose((0.0, 0.0, 0.7)), np.random.default_rng(1), 0)
    assert len(print_poses(seen, soap_model, (matches,), 1)) == 1
    nearer = PictureFeatures(seen.camera, seen.features, 0.8 * seen.points, seen.normals)
    assert print_poses(nearer, soap_model, (matches,), 1) == ()


def test_matches_on_one_spot_are_too_little(soap_model: PrintModel) -> None:
    seen, matches = made_up(soap_model, pose((0.0, 0.0, 0.7)), np.random.default_rng(1), 0)
    spot = soap_model.points[matches.known[0]]
    near = np.argsort(np.linalg.norm(soap_model.points[matches.known] - spot, axis=1))[:10]
    crowded = soap_model.points[matches.known[near]].std(axis=0).max()
    found = print_poses(seen, soap_model, (matches.only(near),), 1)
    assert crowded < 0.015 and all(each.spread > 0.0008 for each in found)
    few = print_poses(seen, soap_model, (matches.only(near[:7]),), 1)
    assert few == ()


def rendered_print(item: Item, T_camera_item: Array, seed: int) -> PictureFeatures:
    """What a camera sees of an item in other light than models are made in."""
    solid = RenderedSolid(OwnerKind.ITEM, item.name, item.shape, T_camera_item, item)
    rendered = RenderedScene((solid,))
    view = rendered.seen_by(CAMERA, pose())
    colour = colour_picture(rendered, CAMERA, pose(), seed, OTHER_LIGHT, damage_seed=3)
    features = print_features(colour, view.index >= 0)
    return PictureFeatures(CAMERA, features, *surface_points(view, features.pixels))


def found_in(seen: PictureFeatures, model: PrintModel, views: SiftViews) -> tuple[PrintPose, ...]:
    lengths = seen.features.sizes * seen.points[:, 2] / CAMERA.fx
    return print_poses(seen, model, matches_of(seen.features, lengths, model, views), 1)


@pytest.mark.parametrize("views", SiftViews)
def test_a_damaged_label_in_other_light_is_recognised(
    soap: Item, soap_model: PrintModel, views: SiftViews
) -> None:
    T = pose((0.02, -0.01, 0.6), rpy=(0.4, 0.5, 1.0))
    (found,) = found_in(rendered_print(soap, T, 21), soap_model, views)
    assert np.linalg.norm(found.T_camera_item[:3, 3] - T[:3, 3]) < 0.003
    assert rotation_angle(found.T_camera_item[:3, :3].T @ T[:3, :3]) < np.radians(3.0)


@pytest.mark.parametrize("views", SiftViews)
def test_another_print_is_not_claimed(soap: Item, soap_model: PrintModel, views: SiftViews) -> None:
    for k, set_of_prints in enumerate((22, 23, 24)):
        T = pose((0.0, 0.0, 0.6), rpy=(0.4, 0.5, float(k)))
        assert found_in(rendered_print(soap, T, set_of_prints), soap_model, views) == ()


def test_same_matches_same_bytes(soap: Item, soap_model: PrintModel) -> None:
    seen = rendered_print(soap, pose((0.02, -0.01, 0.6), rpy=(0.4, 0.5, 1.0)), 21)
    one, two = (found_in(seen, soap_model, SiftViews.ALL)[0] for _ in range(2))
    assert one.T_camera_item.tobytes() == two.T_camera_item.tobytes()


def test_frames_of_a_surface_are_those_of_its_picture() -> None:
    """Going along a direction on the surface is going along it in the picture."""
    points, normals = np.array([[0.1, -0.05, 0.7]]), np.array([[0.3, 0.4, -1.0]])
    normals /= np.linalg.norm(normals)
    (frame,) = surface_frames(points, normals, np.array([0.7]))
    step = CAMERA.project(points + 1e-5 * frame[:, 0]) - CAMERA.project(points)
    assert np.arctan2(step[0, 1], step[0, 0]) == pytest.approx(0.7, abs=1e-4)
    np.testing.assert_allclose(frame[:, 2], -normals[0])


def test_damage_differs_from_copy_to_copy_and_leaves_most_of_a_label(soap: Item) -> None:
    faces = face_textures(coloured(soap), 21)
    one, same, other = (damaged_faces(faces, 3, name) for name in ("a", "a", "b"))
    assert [face.tobytes() for face in one] == [face.tobytes() for face in same]
    assert [face.tobytes() for face in one] != [face.tobytes() for face in other]
    for new, worn in zip(faces, one, strict=True):
        assert worn.shape == new.shape
        a, b = (face.astype(np.float64).ravel() for face in (new, worn))
        assert np.corrcoef(a, b)[0, 1] > 0.4
