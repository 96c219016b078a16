"""Vests are found where they are; what is bright and no vest is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.watching.flash_pictures import FlashRenderer
from pickcli.watching.vest_detection import Vest, find_vests
from pickcli.watching.watched_scene import Reflector, ReflectorKind, Walker, WatchedScene
from support.watched import hall, scene, watch

PAIR, POSE = watch().pair, np.array([1.5, 4.0, 0.0])


def found_in(of: WatchedScene) -> list[Vest]:
    renderer = FlashRenderer(PAIR, of, 0)
    return find_vests(PAIR, renderer.pictures(0.0, lambda _: POSE, np.random.default_rng(7)))


@pytest.mark.parametrize("ahead", [1.4, 3.0, 7.0, 12.0, 17.0])
@pytest.mark.parametrize("turn", [0.0, 0.8, 4.0])
def test_a_vest_is_found_within_its_covariance(ahead: float, turn: float) -> None:
    place = np.array([POSE[0] + PAIR.forward + ahead, 4.2])
    towards = place + np.array([np.cos(turn), np.sin(turn)])
    person = Walker("ann", ((place[0], place[1]), (towards[0], towards[1])), 0.0)
    (vest,) = found_in(scene(person, area=hall()))
    off = vest.place[:2] - (place - POSE[:2])
    assert off @ np.linalg.solve(vest.covariance, off) < 13.8  # 99.9 %
    assert vest.place[2] == pytest.approx(1.15, abs=0.2)
    assert 0.1 < vest.size[0] < 0.7 and 0.24 < vest.size[1] < 0.9


def test_two_people_side_by_side_are_two_vests() -> None:
    people = (Walker("ann", ((9.0, 3.4),), 0.0), Walker("bob", ((9.0, 4.6),), 0.0))
    vests = sorted(vest.place[1] for vest in found_in(scene(*people, area=hall())))
    np.testing.assert_allclose(vests, [-0.6, 0.6], atol=0.15)


@pytest.mark.parametrize("turn", [1.5, -1.5])
def test_a_vest_divided_by_an_arm_is_one(turn: float) -> None:
    person = Walker("ann", ((9.7, 4.2), (9.7 + np.cos(turn), 4.2 + np.sin(turn))), 0.0)
    (vest,) = found_in(scene(person, area=hall()))
    np.testing.assert_allclose(vest.place[:2], [8.2, 0.2], atol=0.3)


@pytest.mark.parametrize(
    "reflector",
    [
        Reflector(ReflectorKind.SIGN, (9.0, 4.0, 1.2), (0.4, 0.4), np.pi),
        Reflector(ReflectorKind.SIGN, (9.0, 4.0, 2.2), (0.4, 0.5), np.pi),
        Reflector(ReflectorKind.TAPE, (9.0, 4.0, 1.1), (1.5, 0.05), np.pi),
        Reflector(ReflectorKind.TAPE, (6.0, 4.0, 0.003), (2.0, 0.05), 0.0, is_flat=True),
        Reflector(ReflectorKind.POST, (6.0, 4.0, 0.55), (0.1, 1.1)),
    ],
    ids=["sign", "high sign", "tape", "tape on the floor", "post"],
)
def test_what_is_bright_and_no_vest_is_not_found(reflector: Reflector) -> None:
    of = scene(area=hall(), reflectors=(reflector,))
    assert found_in(of) == []
    beside = replace(of, walkers=(Walker("ann", ((9.0, 6.0),), 0.0),))
    assert len(found_in(beside)) == 1


def test_people_without_vests_and_people_hidden_are_not_found() -> None:
    assert found_in(scene(Walker("bob", ((7.0, 4.0),), 0.0, has_vest=False), area=hall())) == []
    assert found_in(scene(area=hall())) == []


def test_without_a_difference_between_both_pictures_nothing_is_found() -> None:
    renderer = FlashRenderer(PAIR, scene(Walker("ann", ((9.0, 4.0),), 0.0), area=hall()), 0)
    taken = renderer.pictures(0.0, lambda _: POSE, np.random.default_rng(7))
    assert len(find_vests(PAIR, taken)) == 1
    lit = replace(taken, left_off=taken.left_on, right_off=taken.right_on)
    assert find_vests(PAIR, lit) == []


def test_a_vest_in_one_picture_only_has_no_place() -> None:
    renderer = FlashRenderer(PAIR, scene(Walker("ann", ((9.0, 4.0),), 0.0), area=hall()), 0)
    taken = renderer.pictures(0.0, lambda _: POSE, np.random.default_rng(7))
    assert find_vests(PAIR, replace(taken, right_on=taken.right_off)) == []
