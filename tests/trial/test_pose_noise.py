"""Perception's error is bounded, stated, seeded per item and look."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.geometry import inverse, is_pose, pose, rotation_angle, transform_points
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.trial.pose_noise import perceive
from support.order_builders import pick_order
from support.scripted_trial import scene_of

ORDER = pick_order(
    {"bin_A": ("crayola_24_ct",) * 3, "bin_B": ("kleenex_paper_towels",)}, ("bin_A", "crayola_24_ct")
)
SCENE = scene_of(ORDER, load_cell("apc2016_delft"))


@given(st.integers(0, 2**31 - 1), st.integers(0, 100), st.floats(0, 0.05), st.floats(0, 0.5))
def test_error_keeps_the_stated_bound(seed: int, look: int, position: float, angle: float) -> None:
    noise = PoseNoise(position, angle)
    seen = perceive(SCENE, noise, seed, look)
    assert seen.noise is noise
    for true, guess in zip(SCENE.items, seen.items, strict=True):
        T_true, T_seen = true.T_world_item, guess.T_world_item
        assert is_pose(T_seen)
        assert np.linalg.norm(T_seen[:3, 3] - T_true[:3, 3]) <= position + 1e-12
        assert rotation_angle(T_true[:3, :3].T @ T_seen[:3, :3]) <= angle + 1e-7
        half = true.item.shape.extents / 2
        corners = half * np.array(np.meshgrid(*[[-1, 1]] * 3)).T.reshape(-1, 3)
        off = np.linalg.norm(transform_points(T_seen, corners) - transform_points(T_true, corners), axis=1)
        assert off.max() <= noise.bound(true.item) + 1e-9


def test_error_depends_on_seed_item_and_look_alone() -> None:
    noise = PoseNoise(0.002, 0.02)

    def first(scene: Scene, seed: int, look: int) -> np.ndarray:
        return perceive(scene, noise, seed, look).find("crayola_24_ct").T_world_item

    alone = replace(SCENE, items=SCENE.items[:1])
    np.testing.assert_array_equal(first(SCENE, 1, 1), first(alone, 1, 1))
    assert (first(SCENE, 1, 1) != first(SCENE, 2, 1)).any()
    assert (first(SCENE, 1, 1) != first(SCENE, 1, 2)).any()
    errors = [
        p.T_world_item - t.T_world_item
        for p, t in zip(perceive(SCENE, noise, 1, 1).items, SCENE.items, strict=True)
    ]
    assert (errors[0] != errors[1]).any()


def test_errors_fill_the_ball() -> None:
    noise = PoseNoise(1.0, 0.0)
    alone = replace(SCENE, items=SCENE.items[:1])
    offsets = np.array([
        perceive(alone, noise, 0, look).items[0].T_world_item[:3, 3] - SCENE.items[0].T_world_item[:3, 3]
        for look in range(2000)
    ])  # fmt: skip
    assert np.abs(offsets.mean(axis=0)).max() < 0.05
    inner_share = (np.linalg.norm(offsets, axis=1) < 0.5).mean()
    assert inner_share == pytest.approx(1 / 8, abs=0.03)  # of the volume


def test_without_noise_the_truth_is_seen() -> None:
    seen = perceive(SCENE, PoseNoise(), 5, 7)
    assert SCENE.items
    for true, guess in zip(SCENE.items, seen.items, strict=True):
        np.testing.assert_allclose(guess.T_world_item, true.T_world_item, atol=1e-15)


def test_an_item_is_where_its_seen_pose_is_and_not_where_the_truth_says() -> None:
    item = SCENE.find("kleenex_paper_towels")
    told = SCENE.moved(replace(item, location="bin_L"))  # it lies in bin_B
    assert perceive(told, PoseNoise(), 0, 1).find(item.id).location == "bin_B"


@pytest.mark.parametrize("off", [(0.0, 0.0, -0.003), (-0.201, 0.0, 0.0), (0.0, 0.2, 0.0)])
def test_what_is_seen_a_little_outside_of_its_bin_is_in_the_nearest(off: tuple[float, float, float]) -> None:
    """A thin book under its floor, a centre before the mouth, or within the divider to the next bin."""
    bin_b = SCENE.cell.pod.bins["bin_B"]
    low = 0.001 + bin_b.room.floor_back - 0.05 if off[2] else 0.0
    y = bin_b.room.y_range[1] + 0.001 - 0.2 if off[1] else 0.0
    T = bin_b.T_carrier_place @ pose((0.2 + off[0], y + off[1], 0.05 + off[2] + low))
    seen = perceive(
        SCENE.moved(replace(SCENE.find("kleenex_paper_towels"), T_world_item=T)), PoseNoise(), 0, 1
    )
    assert not bin_b.holds((inverse(bin_b.T_carrier_place) @ T)[:3, 3])
    assert seen.find("kleenex_paper_towels").location == "bin_B"
