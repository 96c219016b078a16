"""What a model knows of a print is on the item's surface, and the same every time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape
from pickcli.geometry import Array
from pickcli.perception.textures.print_model import (
    N_VIEWS,
    PrintModel,
    known_features,
    made_from,
    print_model,
    view_poses,
)


def off_surface(shape: Shape, points: Array) -> Array:
    """(N,) m between points and the surface of a box or an upright cylinder, along its normals."""
    half = shape.extents / 2
    if shape.kind.value == "cylinder":
        radii = np.hypot(points[:, 0], points[:, 1])
        return np.asarray(np.abs(np.maximum(radii - half[0], np.abs(points[:, 2]) - half[2])))
    return np.asarray(np.abs((np.abs(points) - half).max(axis=1)))


@pytest.mark.parametrize("name", ["dove_beauty_bar", "up_glucose_bottle"])
def test_points_lie_on_the_surface_and_frames_are_along_it(name: str, cell: Cell) -> None:
    item = cell.item(name, 2016)
    model = print_model(item, 21)
    off = off_surface(item.shape, model.points)
    assert np.median(off) < 1e-6
    # Beside a curved surface, by half a pixel; or past an edge, by as much.
    assert off.max() < 0.0006
    np.testing.assert_allclose(
        model.frames @ model.frames.swapaxes(1, 2), np.tile(np.eye(3), (len(model), 1, 1)), atol=1e-6
    )
    np.testing.assert_allclose(np.linalg.det(model.frames), 1.0, atol=1e-6)
    inside = model.points + 0.002 * model.frames[:, :, 2]
    assert item.shape.contains(inside).mean() > 0.99


def test_every_view_is_used_and_all_faces_are_known(soap_model: PrintModel, soap: Item) -> None:
    assert set(soap_model.views) == set(range(N_VIEWS))
    assert (np.diff(soap_model.lengths) >= 0.0).all()
    half = soap.shape.extents / 2
    for axis in range(3):
        for side in (-1.0, 1.0):
            on_face = np.abs(soap_model.points[:, axis] - side * half[axis]) < 1e-5
            assert on_face.sum() > 50, (axis, side)


def test_cameras_look_at_the_middle_from_all_around() -> None:
    T = view_poses()
    np.testing.assert_allclose(np.linalg.det(T[:, :3, :3]), 1.0)
    toward = -T[:, :3, 3] / np.linalg.norm(T[:, :3, 3], axis=1, keepdims=True)
    np.testing.assert_allclose(T[:, :3, 2], toward, atol=1e-12)
    nearest = np.sort(toward @ toward.T, axis=1)[:, -2]
    assert np.degrees(np.arccos(nearest)).max() < 30.0  # a feature is seen again from that far aside


def test_same_print_same_bytes(soap: Item, soap_model: PrintModel) -> None:
    for name, array in known_features(soap, 21).items():
        assert array.tobytes() == getattr(soap_model, name).tobytes(), name


def test_a_model_that_was_kept_is_the_one_that_was_made(soap: Item, soap_model: PrintModel) -> None:
    again = print_model.__wrapped__(soap, 21)
    for name in ("points", "frames", "lengths", "views", "descriptors", "directions", "projected"):
        kept, made = getattr(again, name), getattr(soap_model, name)
        assert kept.dtype == made.dtype and kept.tobytes() == made.tobytes(), name


def test_a_model_depends_on_looks_and_not_on_mass(soap: Item) -> None:
    of = made_from(soap, 21)
    assert made_from(replace(soap, mass=1.0, bonus=3), 21) == of
    larger = replace(soap, shape=soap.shape.inflated(0.001))
    for other in (replace(soap, colour=(1, 2, 3)), replace(soap, is_printed=False), larger):
        assert made_from(other, 21) != of
    assert made_from(soap, 22) != of
