"""Gaps between solids: exact for two boxes, and a push by the overlap parts any two."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_overlap import is_inside, points_inside

from pickcli.cell.load import load_cell
from pickcli.cell.overlap import Solid, overlap_depth
from pickcli.cell.scene import PlacedItem, PoseNoise, Scene
from pickcli.cell.touching import Gaps, Solids, gaps
from pickcli.geometry import Array, pose

NAMES = (
    "crayola_24_ct",
    "rawlings_baseball",
    "dasani_water_bottle",
    "folgers_classic_roast_coffee",
    "jane_eyre_dvd",
)
small = st.floats(-0.12, 0.12)
angle = st.floats(-3.1, 3.1)
somewhere = st.tuples(small, small, small, angle, angle, angle).map(lambda v: pose(v[:3], rpy=v[3:]))


def solids_at(*placed: tuple[str, Array], noise: PoseNoise | None = None) -> tuple[Scene, Solids]:
    cell = load_cell("apc2016_delft")
    items = tuple(
        PlacedItem(f"{name}#{k}", cell.item(name), "bin_E", T) for k, (name, T) in enumerate(placed)
    )
    scene = Scene(cell, cell.T_world_pod, items, noise or PoseNoise())
    return scene, Solids.of(scene, items, ())


def gap_of(*placed: tuple[str, Array]) -> Gaps:
    return gaps(solids_at(*placed)[1], np.array([0]), np.array([1]))


@given(st.sampled_from(NAMES), st.sampled_from(NAMES), somewhere, somewhere)
@settings(max_examples=150, deadline=None)
def test_pushed_along_the_normal_by_the_overlap_two_solids_part(
    a: str, b: str, T_a: Array, T_b: Array
) -> None:
    found = gap_of((a, T_a), (b, T_b))
    scene, _ = solids_at((a, T_a), (b, T_b))
    one, other = (Solid(placed.item.shape, placed.T_world_item) for placed in scene.items)
    push = max(0.0, -float(found.width[0])) * found.normal[0]
    apart = Solid(other.shape, pose(push) @ other.T).shrunk(1e-6)
    local = (points_inside(one) - apart.T[:3, 3]) @ apart.T[:3, :3]
    assert not np.any(is_inside(apart.shape, local))


@given(somewhere, somewhere)
@settings(max_examples=150, deadline=None)
def test_the_overlap_of_two_boxes_is_exact(T_a: Array, T_b: Array) -> None:
    found = gap_of(("crayola_24_ct", T_a), ("jane_eyre_dvd", T_b))
    scene, _ = solids_at(("crayola_24_ct", T_a), ("jane_eyre_dvd", T_b))
    one, other = (Solid(placed.item.shape, placed.T_world_item) for placed in scene.items)
    depth = overlap_depth(one, other, tolerance=1e-9)
    assert max(0.0, -float(found.width[0])) == pytest.approx(depth, abs=1e-9)


def test_a_ball_over_a_box_is_as_far_away_as_it_looks() -> None:
    radius, height = 0.034, 0.025
    for gap in (-0.003, 0.0, 0.01):
        T = pose([0.01, 0.02, height / 2 + radius + gap])
        found = gap_of(("crayola_24_ct", pose()), ("rawlings_baseball", T))
        assert found.width[0] == pytest.approx(gap, abs=1e-9)
        np.testing.assert_allclose(found.normal[0], [0.0, 0.0, 1.0], atol=1e-9)


def test_near_pairs_are_those_within_reach_and_bounds() -> None:
    apart = 0.095 + 0.010
    noise = PoseNoise(0.004, 0.0)
    _, solids = solids_at(("crayola_24_ct", pose()), ("crayola_24_ct", pose([apart, 0, 0])), noise=noise)
    assert [len(part) for part in solids.near(2, 0.001)] == [0, 0]
    assert [part.tolist() for part in solids.near(2, 0.003)] == [[0], [1]]
