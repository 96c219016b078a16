"""Photographs: what all pictures of a hall share, what each has of its own, and the same bytes."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.sensors.pinhole_camera import PinholeCamera
from pickcli.geometry import Array, pose
from pickcli.perception.looks import HALL, colour_picture
from pickcli.perception.photograph import drawn_light, photograph
from pickcli.perception.procedural_texture import ColourPicture
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene, RenderedSolid

CAMERA = PinholeCamera(700.0, 700.0, 160.0, 120.0, 320, 240)
TEXTURES = 21


@pytest.fixture(scope="module")
def soap(cell: Cell) -> RenderedScene:
    item = cell.item("dove_beauty_bar", 2016)
    T = pose((0.0, 0.0, 0.3), rpy=(0.4, 0.3, 0.2))
    return RenderedScene((RenderedSolid(OwnerKind.ITEM, item.name, item.shape, T, item),))


def on_item(rendered: RenderedScene, picture: ColourPicture) -> Array:
    """(N, 3) what the picture shows of the item."""
    seen = picture[rendered.seen_by(CAMERA, pose()).index >= 0]
    return np.asarray(seen, dtype=np.float64)


def test_same_seeds_same_bytes_and_others_differ(soap: RenderedScene) -> None:
    first = photograph(soap, CAMERA, pose(), TEXTURES, 3, 5)
    assert first.shape == (240, 320, 3) and first.dtype == np.uint8
    assert photograph(soap, CAMERA, pose(), TEXTURES, 3, 5).tobytes() == first.tobytes()
    for others in ((TEXTURES, 4, 5), (TEXTURES, 3, 6), (TEXTURES + 1, 3, 5)):
        assert photograph(soap, CAMERA, pose(), *others).tobytes() != first.tobytes()


def test_pictures_of_one_hall_show_the_same_labels(soap: RenderedScene) -> None:
    """Noise and exposure apart: what is alike in them is the damage, too."""
    one, two, elsewhere = (
        on_item(soap, photograph(soap, CAMERA, pose(), TEXTURES, hall, seed)).mean(axis=1)
        for hall, seed in ((3, 5), (3, 6), (8, 5))
    )
    alike, other = (np.corrcoef(one, each)[0, 1] for each in (two, elsewhere))
    assert alike > 0.99
    assert alike > other > 0.5


def test_a_label_in_a_photograph_is_that_of_a_rendering(soap: RenderedScene) -> None:
    rendered = on_item(soap, colour_picture(soap, CAMERA, pose(), TEXTURES)).mean(axis=1)
    taken = on_item(soap, photograph(soap, CAMERA, pose(), TEXTURES, 3, 5)).mean(axis=1)
    assert np.corrcoef(rendered, taken)[0, 1] > 0.5


@pytest.mark.parametrize("seed", range(1, 20))
def test_light_is_within_what_is_stated(seed: int) -> None:
    light = drawn_light(seed)
    for amount, usual in (
        (light.ambient, HALL.ambient),
        (light.headlight, HALL.headlight),
        (light.lamp, HALL.lamp),
    ):
        assert 0.75 * usual <= amount <= 1.25 * usual
    off = np.subtract(light.lamp_position, HALL.lamp_position)
    assert (np.abs(off) <= [0.8, 2.5, 0.8]).all()
