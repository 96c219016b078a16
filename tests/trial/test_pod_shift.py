"""The pod stands elsewhere than in its place, estimated with an error that is stated and counted."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.cell.pod_tolerance import UNMOVED, Displacement
from pickcli.cell.shapes import Body
from pickcli.collision.collision_world import build_world
from pickcli.collision.robot_model import CollisionModel
from pickcli.commands.make_scene import command
from pickcli.commands.options.pod_shift import parse_pod_shift
from pickcli.errors import InputError
from pickcli.geometry import inverse, transform_points
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.scene.scene_file import read_scene, scene_hash, write_scene
from pickcli.simulation.reality import DEFAULT, IDEAL
from pickcli.trial.pod_shift import random_shift, shifted_pod
from pickcli.trial.pose_noise import perceive
from pickcli.verification.moving_parts import fixtures
from support.order_builders import pick_order
from support.scripted_trial import scene_of

CELL = load_cell("apc2016_delft")
SCENE = scene_of(pick_order({"bin_A": ("crayola_24_ct",)}, ("bin_A", "crayola_24_ct")), CELL)
seeds = st.integers(0, 2**31 - 1)


def pod_bodies(scene: Scene) -> tuple[Body, ...]:
    """The pod's bodies, each grown by the error of its pose."""
    return scene.posed_carriers[0].grown


@given(seeds)
def test_a_random_pod_stands_within_its_cells_bounds(seed: int) -> None:
    T = shifted_pod(CELL, random_shift(CELL, seed))
    assert replace(SCENE, T_world_pod=T).is_pod_within_bounds


def test_another_seed_is_another_pod() -> None:
    assert random_shift(CELL, 1) == random_shift(CELL, 1) != random_shift(CELL, 2)


def test_a_shift_beyond_the_bounds_is_refused_with_both_named() -> None:
    with pytest.raises(InputError, match=r"60 mm.*50 mm"):
        shifted_pod(CELL, Displacement(0.06, 0.0, 0.0))


@given(seeds)
def test_the_true_pod_is_inside_what_the_estimate_allows_for(seed: int) -> None:
    true = replace(SCENE, T_world_pod=shifted_pod(CELL, random_shift(CELL, seed)))
    seen = perceive(true, PoseNoise(), seed, 1, DEFAULT)
    assert (seen.T_world_pod != true.T_world_pod).any()
    assert seen.pod_error.allows(inverse(seen.T_world_pod) @ true.T_world_pod)
    assert CELL.pod.bodies
    for body, grown in zip(CELL.pod.bodies, pod_bodies(seen), strict=True):
        half = body.shape.extents / 2
        corners = half * np.array(np.meshgrid(*[[-1, 1]] * 3)).T.reshape(-1, 3)
        in_grown = inverse(seen.T_world_pod @ grown.T_parent_shape) @ true.T_world_pod @ body.T_parent_shape
        assert (np.abs(transform_points(in_grown, corners)) <= grown.shape.extents / 2 + 1e-9).all()


def test_the_pod_is_estimated_once_and_items_are_seen_anew() -> None:
    looks = [perceive(SCENE, PoseNoise(0.002, 0.01), 5, look, DEFAULT) for look in (1, 2)]
    np.testing.assert_array_equal(looks[0].T_world_pod, looks[1].T_world_pod)
    assert (looks[0].items[0].T_world_item != looks[1].items[0].T_world_item).any()
    assert perceive(SCENE, PoseNoise(), 5, 1, IDEAL).pod_error == UNMOVED


def test_a_floor_is_not_raised_by_an_error_on_the_floor() -> None:
    seen = replace(SCENE, pod_error=Displacement(0.002, 0.002, 0.00524))
    assert CELL.pod.bodies
    for body, grown in zip(CELL.pod.bodies, pod_bodies(seen), strict=True):
        growth = (grown.shape.extents - body.shape.extents) / 2
        assert (growth >= -1e-12).all() and growth.max() < 0.008
        level = np.abs(body.T_parent_shape[2, :3])  # of the vertical along the body's axes
        assert growth @ (level > 0.999) < 1e-9


def test_planner_and_verifier_count_with_wherever_the_pod_may_be() -> None:
    off = replace(SCENE, pod_error=Displacement(0.002, 0.002, 0.00524))
    model, sizes = CollisionModel(CELL), [grown.shape.extents for grown in pod_bodies(off)]
    world = build_world(model, off)
    planned = [2 * half for half, kind in zip(world.half_extents, world.kinds, strict=True) if kind == "pod"]
    np.testing.assert_array_equal(planned, sizes)
    names = {body.name for body in CELL.pod.bodies}
    verified = [fixture.shape.extents for fixture in fixtures(off) if fixture.name in names]
    np.testing.assert_array_equal(verified, sizes)


def test_the_error_survives_the_file_and_counts_in_the_hash(tmp_path: Path) -> None:
    empty = replace(SCENE, items=())
    scene = replace(empty, pod_error=Displacement(0.002, 0.003, 0.004))
    write_scene(scene, tmp_path / "scene.json")
    read = read_scene(tmp_path / "scene.json", CELL)
    assert read.pod_error == scene.pod_error and scene_hash(read) == scene_hash(scene)
    assert scene_hash(scene) != scene_hash(empty)


@given(seeds)
def test_some_poses_are_off_by_more_than_is_told_and_none_by_more_than_is_stated(seed: int) -> None:
    noise = PoseNoise(0.002, 0.01)
    off = []
    for look in range(30):
        (seen,) = perceive(SCENE, noise, seed, look, replace(DEFAULT, pose_outlier_share=0.5)).items
        off.append(np.linalg.norm((seen.T_world_item - SCENE.items[0].T_world_item)[:3, 3]) / noise.position)
    assert max(off) <= DEFAULT.pose_outlier_scale
    assert 3 <= sum(o > 1.0 for o in off) <= 27


@pytest.mark.parametrize("text", ["1,2", "1,2,3,4", "a,b,c", "1,nan,2", "inf,0,0", "randomly", ""])
def test_what_is_no_shift_is_a_usage_error(text: str) -> None:
    with pytest.raises(click.BadParameter, match="expected three numbers"):
        parse_pod_shift(None, None, text)


def test_a_shift_is_given_in_millimetres_and_degrees() -> None:
    shift = parse_pod_shift(None, None, "-20,10,1.5")
    assert isinstance(shift, Displacement)
    assert (shift.x, shift.y, shift.yaw) == pytest.approx((-0.02, 0.01, np.radians(1.5)))
    assert [parse_pod_shift(None, None, text) for text in ("random", "none", None)] == [
        "random",
        "none",
        None,
    ]


def test_a_scene_is_made_with_its_items_in_the_shifted_pod(tmp_path: Path) -> None:
    order = Path(__file__).parents[2] / "data" / "tasks" / "jsk_pick_sample.json"
    small = tmp_path / "order.json"
    content = json.loads(order.read_text())
    content["bin_contents"] = {
        b: (items[:1] if b == "bin_A" else []) for b, items in content["bin_contents"].items()
    }
    content["work_order"] = [{"bin": "bin_A", "item": content["bin_contents"]["bin_A"][0]}]
    small.write_text(json.dumps(content))
    arguments = [str(small), "--pod-shift", "-30,20,2", "-o", str(tmp_path / "scene.json")]
    assert CliRunner().invoke(command, arguments).exit_code == 0
    scene = read_scene(tmp_path / "scene.json", CELL)
    np.testing.assert_allclose(scene.T_nominal_pod[:2, 3], [-0.03, 0.02], atol=1e-9)
    assert [placed.location for placed in scene.items] == ["bin_A"]
