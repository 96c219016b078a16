"""Where grasps start from: the paper's grid, poses near an object, and tightly packed clusters."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.hand.pre_grasps import (
    APART,
    GraspPoses,
    grid_offsets,
    pre_grasps,
    random_cluster,
    rectangular_cluster,
    single_grasp,
)
from support.belt_hands import HAND

CAN, COKE = HAND.objects["can"], HAND.objects["coke"]


def distances(at: np.ndarray) -> np.ndarray:
    """(K, K) m between what stands, itself infinitely far."""
    found = np.linalg.norm(at[:, None] - at[None], axis=2)
    np.fill_diagonal(found, np.inf)
    return np.asarray(found)


def test_the_grid_fills_the_box_and_the_tilts_of_the_paper() -> None:
    grid = grid_offsets(np.random.default_rng(0))
    assert 121 <= len(grid) <= 161 and len(np.unique(grid, axis=0)) == len(grid)
    limits = [0.05, 0.04, 0.02, np.deg2rad(10), np.deg2rad(10)]
    assert grid.max(axis=0) == pytest.approx(limits)
    assert grid.min(axis=0) == pytest.approx([-x for x in limits])


def test_an_offset_moves_the_hand_from_the_middle_of_the_object() -> None:
    grasp = single_grasp(HAND, CAN, np.array([0.01, -0.02, 0.03, 0.1, -0.2]))
    reach = HAND.control.reach
    assert grasp.goal == pytest.approx([0.01 - reach, -0.02, CAN.height / 2 + 0.03, 0.0, -0.2, 0.1])
    assert grasp.start[0] < grasp.goal[0] and grasp.start[1:] == pytest.approx(grasp.goal[1:])


@pytest.mark.parametrize("poses", GraspPoses)
def test_the_same_seed_gives_the_same_grasps_and_more_begin_alike(poses: GraspPoses) -> None:
    few, many, others = (
        [[*g.goal, *g.start, g.deviation.mass, g.stand[0].x] for g in pre_grasps(HAND, COKE, poses, n, seed)]
        for n, seed in ((3, 1), (6, 1), (3, 2))
    )
    assert few == many[:3]
    assert few != others


def test_near_poses_stay_near() -> None:
    middle = single_grasp(HAND, CAN, np.zeros(5)).goal
    off = np.array([g.goal for g in pre_grasps(HAND, CAN, GraspPoses.NEAR, 50, 0)]) - middle
    assert np.abs(off[:, :3]).max() <= 0.02 and np.abs(off[:, 4:]).max() <= np.deg2rad(10)
    assert np.abs(off[:, :3]).max() > 0.018


@pytest.mark.parametrize("seed", range(5))
def test_clusters_are_packed_tightly_and_nothing_overlaps(seed: int) -> None:
    width = 0.06
    between = distances(random_cluster(width, np.random.default_rng(seed)))
    assert between.min() > width * (1 - 1e-6)
    assert ((between < width * (1 + 1e-6)).sum(axis=1) >= 1).all()
    assert (between < width * (1 + 1e-6)).sum() >= 2 * (1 + 2 * 7)  # each of the last seven touches two


def test_a_rectangular_cluster_is_turned_as_a_whole() -> None:
    straight, turned = rectangular_cluster(0.06, 0.0), rectangular_cluster(0.06, 0.5)
    assert distances(turned) == pytest.approx(distances(straight))
    assert np.ptp(straight, axis=0) == pytest.approx([0.12, 0.12])
    assert distances(straight).min() == pytest.approx(0.06)


@pytest.mark.parametrize("poses", [GraspPoses.RECTANGULAR, GraspPoses.RANDOM])
def test_the_palm_comes_towards_the_closest_object_of_a_cluster(poses: GraspPoses) -> None:
    for grasp in pre_grasps(HAND, COKE, poses, 10, 0):
        at = np.array([(each.x, each.y) for each in grasp.stand])
        assert distances(at).min() == pytest.approx(COKE.width + APART)
        towards = (grasp.goal - grasp.start)[:2]
        assert np.arctan2(towards[1], towards[0]) == pytest.approx(grasp.goal[3])
        ahead = at[(at @ towards).argmin()]
        assert np.linalg.norm(ahead - grasp.goal[:2]) == pytest.approx(HAND.control.cluster_reach, abs=0.03)
