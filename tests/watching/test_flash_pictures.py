"""Pictures show vests where they are, with flash only; shares in view are those of known scenes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from pickcli.driving.driving_area import FloorBox
from pickcli.geometry import Array
from pickcli.watching.flash_pictures import FlashPictures, FlashRenderer
from pickcli.watching.watched_scene import SunPatch, Walker, WatchedScene
from support.watched import hall, scene, watch

PAIR = watch().pair
PERSON = Walker("ann", ((9.0, 4.5),), 0.0)
BODY = FloorBox("pillar", (7.0, 4.0), (0.5, 3.0))


def stands(_: float) -> Array:
    return np.array([1.5, 4.0, 0.0])


def pictures(of: WatchedScene, seed: int = 1) -> FlashPictures:
    return FlashRenderer(PAIR, of, 0).pictures(0.0, stands, np.random.default_rng(seed))


def around(picture: NDArray[np.float32], point: Array, is_right: bool) -> NDArray[np.float32]:
    u, v = np.rint(PAIR.projected(point, is_right)).astype(int)
    return picture[v - 4 : v + 5, u - 8 : u + 9]


def test_a_vest_is_bright_with_flash_where_it_is() -> None:
    taken = pictures(scene(PERSON, area=hall()))
    band = np.array([9.0 - 1.5 - 0.17, 0.5, 1.225])
    for on, off, is_right in (
        (taken.left_on, taken.left_off, False),
        (taken.right_on, taken.right_off, True),
    ):
        assert around(on, band, is_right).max() == PAIR.largest
        assert around(off, band, is_right).max() < 20
    without = pictures(scene(Walker("bob", PERSON.route, 0.0, has_vest=False), area=hall()))
    assert around(without.left_on, band, False).max() < 20


def test_pictures_are_of_their_size_in_whole_counts_and_the_same_by_seed() -> None:
    first, again, other = (pictures(scene(PERSON, area=hall()), seed) for seed in (3, 3, 4))
    assert first.left_on.shape == (PAIR.height, PAIR.width) and first.left_on.dtype == np.float32
    assert first.left_on.min() >= 0 and (first.left_on == np.rint(first.left_on)).all()
    np.testing.assert_array_equal(first.right_on, again.right_on)
    assert (first.right_on != other.right_on).any()


def test_the_sun_is_bright_without_flash() -> None:
    area = hall()
    dark = scene(area=area)
    sunny = WatchedScene(area, (), (), (), (SunPatch((6.0, 4.0), (2.0, 2.0), 0.3, 10.0),))
    point = np.array([6.0 - 1.5, 0.0, 0.0])
    ratio = (
        around(pictures(sunny).left_off, point, False).mean()
        / around(pictures(dark).left_off, point, False).mean()
    )
    assert ratio == pytest.approx(10.0, rel=0.2)


def test_each_picture_is_of_its_own_instant() -> None:
    """A truck that drives sees the vest farther outside in the second pair."""
    runner = Walker("cid", ((9.0, 2.0), (9.0, 6.0)), 2.0)
    asked: list[float] = []

    def pose_at(time: float) -> Array:
        asked.append(time)
        return stands(time)

    FlashRenderer(PAIR, scene(runner, area=hall()), 0).pictures(0.5, pose_at, np.random.default_rng(0))
    assert asked == [0.5, 0.5 + PAIR.gap]


def test_visible_shares_of_free_hidden_far_and_bare_people() -> None:
    free = FlashRenderer(PAIR, scene(PERSON, area=hall()), 0)
    assert free.visible_shares(0.0, stands(0.0))[0] == 1.0
    behind = FlashRenderer(PAIR, scene(PERSON, area=hall(BODY)), 0)
    assert behind.visible_shares(0.0, stands(0.0))[0] == 0.0
    low = FlashRenderer(PAIR, scene(PERSON, area=hall(BODY), box_height=1.25), 0)
    assert 0.1 < low.visible_shares(0.0, stands(0.0))[0] < 0.9
    others = (
        Walker("far", ((24.5, 4.0),), 0.0), Walker("beside", ((4.0, 7.5),), 0.0),
        Walker("bare", ((8.0, 3.0),), 0.0, has_vest=False),
    )  # fmt: skip
    found = FlashRenderer(PAIR, scene(*others, area=hall()), 0).visible_shares(0.0, stands(0.0))
    np.testing.assert_array_equal(found, np.zeros(3))
