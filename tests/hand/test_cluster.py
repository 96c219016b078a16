"""Clusters: which objects belong to one, and from where one of them stands out."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.commission.commission_file import read_commission
from pickcli.driving.driving_area import FloorBox
from pickcli.driving.free_space_proof import rectangle_distances
from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.hand.cluster import BESIDE, ROOM, Cluster
from pickcli.hand.pre_grasps import APART, random_cluster, rectangular_cluster
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from support.belt_hands import HAND
from support.commissions import SHIPPED, belts_booth

COKE = next(each.item for each in read_commission(SHIPPED).items if each.item.name == "coke")
BULL = next(each.item for each in read_commission(SHIPPED).items if each.item.name == "bull")
WIDTH = float(COKE.shape.extents[0])


def scene_of(at: Array, *others: PlacedItem) -> Scene:
    """Cans at (N, 2) m in the world, on the load."""
    cell = belts_booth()
    cans = tuple(PlacedItem(f"coke#{k}", COKE, "load", pose((*xy, 0.73))) for k, xy in enumerate(at.tolist()))
    return Scene(cell, cell.T_world_pod, (*cans, *others), PoseNoise())


def test_a_cluster_is_all_that_stands_close_one_by_one() -> None:
    chain = np.array([[0.0, 0.0], [WIDTH + ROOM / 2, 0.0], [2 * WIDTH + ROOM, 0.0], [5 * WIDTH, 0.0]])
    near = PlacedItem("bull", BULL, "load", pose((0.0, WIDTH, 0.73)))
    placed = PlacedItem("coke#9", COKE, "pallet", pose((0.0, WIDTH, 0.73)))
    scene = scene_of(chain, near, placed)
    assert set(Cluster.around(scene, "coke#0").names) == {"coke#0", "coke#1", "coke#2"}
    assert Cluster.around(scene, "coke#3").names == ("coke#3",)
    assert Cluster.around(scene, "bull").names == ("bull",)


@given(x=st.floats(-0.12, 0.12), y=st.floats(-0.12, 0.12), yaws=st.tuples(*[st.floats(-4.0, 4.0)] * 2))
def test_boxes_form_a_cluster_by_the_distance_of_their_sides(
    x: float, y: float, yaws: tuple[float, float]
) -> None:
    box = next(each.item for each in read_commission(SHIPPED).items if each.item.name == "box_50")
    a, b = (FloorBox("", at, (0.05, 0.05), yaw) for at, yaw in zip(((0.0, 0.0), (x, y)), yaws, strict=True))
    boxes = [
        PlacedItem(
            f"box#{k}", box, "load", pose((*each.centre, 0.73), R=rotation_axis_angle((0, 0, 1), each.yaw))
        )
        for k, each in enumerate((a, b))
    ]
    names = Cluster.around(scene_of(np.empty((0, 2)), *boxes), "box#0").names
    distance = rectangle_distances(a.corners[None], b.corners)[0]
    assert len(names) == 2 or distance >= ROOM
    assert len(names) == 1 or distance <= 1.42 * ROOM  # two corners are nearer across a side


@given(seed=st.integers(0, 10_000))
def test_the_best_approach_has_the_closest_object_out_in_front(seed: int) -> None:
    at = random_cluster(WIDTH + APART, np.random.default_rng(seed))
    cluster = Cluster.around(scene_of(at), "coke#0")
    assert len(cluster.names) == len(at)
    approaches = cluster.approaches(HAND)
    assert [each.overhang for each in approaches] == sorted((a.overhang for a in approaches), reverse=True)
    for each in approaches:
        T = each.T_world_hand
        middles = np.linalg.inv(T) @ np.vstack([cluster.middles.T, np.ones(len(at))])
        nearest = int(middles[0].argmin())
        # It is straight ahead, level with the hand, as far away as the hand's file says.
        assert middles[:3, nearest] == pytest.approx([HAND.control.cluster_reach, 0.0, 0.0], abs=1e-9)
        beside = [k for k in range(len(at)) if k != nearest and abs(middles[1, k]) < BESIDE]
        if beside:
            assert each.overhang == pytest.approx(middles[0, beside].min() - middles[0, nearest])


def test_a_rectangular_cluster_is_approached_at_its_corners() -> None:
    cluster = Cluster.around(scene_of(rectangular_cluster(WIDTH + APART, 0.0)), "coke#0")
    best = cluster.approaches(HAND)[:4]
    for each in best:
        yaw = np.degrees(np.arctan2(each.T_world_hand[1, 0], each.T_world_hand[0, 0]))
        assert yaw % 90 == pytest.approx(45.0, abs=1e-6)
        assert each.overhang == pytest.approx((WIDTH + APART) / np.sqrt(2))


def test_an_object_alone_is_approached_from_anywhere() -> None:
    approaches = Cluster.around(scene_of(np.zeros((1, 2))), "coke#0").approaches(HAND)
    assert len(approaches) == 48
    assert all(np.isinf(each.overhang) for each in approaches)
