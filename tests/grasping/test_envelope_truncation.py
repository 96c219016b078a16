"""Truncated envelopes: no kept pose collides, what is free is kept, and what blocks the rest is named."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.grasping.envelope_truncation import WIDEST_SECTOR, free_sectors, truncated
from pickcli.kernel import SurfaceKind
from support.cans import CanScene, can


@pytest.fixture(scope="module")
def table() -> Cell:
    return load_cell("panda_table")


@pytest.mark.parametrize("seed", range(2))
def test_no_pose_of_what_is_kept_collides(table: Cell, seed: int) -> None:
    rng = np.random.default_rng(seed)
    angles = rng.uniform(-np.pi, np.pi, 3)
    others = [
        can(table, f"n{i}", 0.46 + d * np.cos(a), d * np.sin(a))
        for i, (a, d) in enumerate(zip(angles, rng.uniform(0.12, 0.3, 3), strict=True))
    ]
    scene = CanScene(table, tuple(others))
    n_kept = 0
    for envelope in scene.envelopes[::2]:  # a side and an end
        found = truncated(envelope, scene.target.T_world_item, scene.tool)
        if found.envelope is None:
            continue
        poses = found.envelope.sample(rng, 2000)
        assert envelope.contains(poses).all()
        assert scene.tool.are_valid(scene.tool.displacements(scene.target.T_world_item @ poses)).all()
        n_kept += len(poses)
    assert n_kept > 0


def test_all_azimuths_of_a_free_envelope_are_kept(table: Cell) -> None:
    scene = CanScene(table)
    found = truncated(scene.envelopes[0], scene.target.T_world_item, scene.tool)
    assert found.envelope is not None
    assert found.kept > 0.2 and found.cone_share >= 0.5
    assert found.envelope.is_closed  # all around


def test_an_obstacle_cuts_out_the_side_that_it_stands_on(table: Cell) -> None:
    """A can beside the target at +y: the hand comes from elsewhere, and the can is named."""
    scene = CanScene(table, (can(table, "beside", 0.46, 0.13),))
    found = truncated(scene.envelopes[0], scene.target.T_world_item, scene.tool)
    assert found.envelope is not None and not found.envelope.is_closed
    middle = (found.envelope.low[0] + found.envelope.high[0]) / 2
    assert np.sin(middle) < 0.0
    assert found.against is not None and "beside" in str(found.against)


def test_where_nothing_is_free_nothing_is_kept_and_the_obstacle_is_named(table: Cell) -> None:
    ring = [
        can(table, f"ring {k}", 0.46 + 0.1 * np.cos(a), 0.1 * np.sin(a))
        for k, a in enumerate(np.arange(10) * 2 * np.pi / 10)
    ]
    scene = CanScene(table, tuple(ring))
    found = truncated(scene.envelopes[0], scene.target.T_world_item, scene.tool)
    assert found.envelope is None and found.kept == 0.0
    assert found.against is not None and "ring" in str(found.against)
    assert free_sectors(scene.envelopes[0], scene.target.T_world_item, scene.tool) == ()


def test_sectors_are_what_is_free_divided_by_azimuth(table: Cell) -> None:
    scene = CanScene(table, (can(table, "beside", 0.46, 0.13),))
    part, *sectors = free_sectors(scene.envelopes[0], scene.target.T_world_item, scene.tool)
    assert len(sectors) >= 2
    assert sectors[0].low[0] == part.low[0] and sectors[-1].high[0] == part.high[0]
    for before, after in pairwise(sectors):
        assert before.high[0] == after.low[0]
    for each in sectors:
        assert each.high[0] - each.low[0] <= WIDEST_SECTOR + 1e-12
        poses = each.sample(np.random.default_rng(1), 300)
        assert part.contains(poses).all()
        assert scene.tool.are_valid(scene.tool.displacements(scene.target.T_world_item @ poses)).all()


def test_what_has_no_azimuth_is_not_divided(table: Cell) -> None:
    scene = CanScene(table)
    ends = [each for each in scene.envelopes if each.surface is SurfaceKind.PLANE]
    assert ends and all(len(free_sectors(each, scene.target.T_world_item, scene.tool)) <= 1 for each in ends)
