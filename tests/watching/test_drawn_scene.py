"""Drawn scenes: the same by seed, with people who are free, and in the way."""

from __future__ import annotations

import numpy as np

from pickcli.watching.drawn_scene import BESIDE, FROM_START, draw_watched_scene
from pickcli.watching.foreseen_contact import outline_distance
from pickcli.watching.watched_scene import ReflectorKind
from pickcli.watching.watched_scene_file import scene_to_dict
from support.watched import plan


def test_a_seed_draws_one_scene() -> None:
    first, again, other = (scene_to_dict(draw_watched_scene(plan(), 3, seed)) for seed in (5, 5, 6))
    assert first == again != other


def test_people_are_free_of_boxes_and_of_the_start_and_cross_the_path() -> None:
    area, n_crossing, n = plan().area, 0, 0
    path = plan().path.poses_at(np.linspace(0.0, plan().path.length, 60))
    for seed in range(12):
        for walker in draw_watched_scene(plan(), 3, seed).walkers:
            places = np.array([walker.place(time) for time in np.linspace(0.0, 15.0, 60)])
            assert (area.wall_distance(places) > BESIDE - 0.11).all()
            assert (area.boxes[0].distance(places) > BESIDE - 0.11).all()
            assert outline_distance(area.truck, area.start[None], places[:1])[0] >= FROM_START - 1e-3
            near = min(outline_distance(area.truck, path, np.tile(at, (60, 1))).min() for at in places)
            n, n_crossing = n + 1, n_crossing + (near == 0.0)
    assert n > 20 and n_crossing > 0.7 * n


def test_posts_stand_beside_the_path() -> None:
    path = plan().path.poses_at(np.linspace(0.0, plan().path.length, 100))
    posts = [
        each for seed in range(30) for each in draw_watched_scene(plan(), 0, seed).reflectors
        if each.kind is ReflectorKind.POST
    ]  # fmt: skip
    assert len(posts) > 5
    for post in posts:
        assert outline_distance(plan().area.truck, path, np.tile(post.centre[:2], (100, 1))).min() > 0.6
