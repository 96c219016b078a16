"""Poses from which grasps are played: one, a grid about an object, near it, and before clusters."""

from __future__ import annotations

from enum import StrEnum
from itertools import product

import numpy as np

from pickcli.geometry import Array
from pickcli.hand.belt_hand import BeltHand, GraspObject
from pickcli.hand.cluster import Cluster
from pickcli.hand.grasp_trial import PreGrasp
from pickcli.hand.grasp_world import Standing, WorldDeviation
from pickcli.seeds import derived_rng

BACK = 0.12  # m before the pre-grasp where a single object is approached from
CLUSTER_BACK = 0.25  # m before the closest point of a cluster, as from where it was seen
APPROACH_SPEED = 0.12  # m/s in the mean
HEIGHT = 0.5  # share of an object's height at which it is grasped

GRID_BOX = np.array([0.10, 0.08, 0.04])  # m, of Krug et al., section IV
GRID_COUNTS = (4, 4, 2)
GRID_TILT = np.deg2rad(10.0)  # rad of roll and pitch, either way
NEAR = 0.02  # m either way

MASS_SPREAD, FRICTION_SPREAD = 0.1, 0.15  # either way, of what the file states
YAW_SPREAD = 0.1  # rad either way, by which a single object stands turned

ROWS = 3  # of a rectangular cluster, and objects in each
APART = 5e-4  # m between the objects of a cluster
CORNER_YAW = np.deg2rad((25.0, 65.0))  # rad by which a rectangular cluster is turned
POINT_NOISE = 5e-3  # m, standard deviation of where each object of a cluster is seen, in each direction
DIRECTION_NOISE = np.deg2rad(2.0)  # rad, of the direction of the approach


class GraspPoses(StrEnum):
    """Sets of poses."""

    GRID = "grid"
    NEAR = "near"
    RECTANGULAR = "rectangular"
    RANDOM = "random"


def pre_grasps(hand: BeltHand, kind: GraspObject, poses: GraspPoses, count: int, seed: int) -> list[PreGrasp]:
    """Draw grasps from a set of poses.

    Args:
        hand: The hand.
        kind: What is grasped.
        poses: Where from.
        count: How many.
        seed: Seed of poses and of what the world deviates by.

    Returns:
        The grasps; the first ones are the same for any count.
    """
    grid = grid_offsets(derived_rng("grid of grasps", kind.name, seed))
    drawn = []
    for k in range(count):
        rng = derived_rng("grasp", kind.name, poses, seed, k)
        if poses in (GraspPoses.RECTANGULAR, GraspPoses.RANDOM):
            drawn.append(_before_cluster(hand, kind, poses, rng))
        else:
            offset = grid[k % len(grid)] if poses is GraspPoses.GRID else _near(rng)
            drawn.append(
                _at(hand, kind, offset, _deviation(rng), float(rng.uniform(-YAW_SPREAD, YAW_SPREAD)))
            )
    return drawn


def single_grasp(hand: BeltHand, kind: GraspObject, offset: Array) -> PreGrasp:
    """Make a grasp of a single object in a world that does not deviate.

    Args:
        hand: The hand.
        kind: What is grasped.
        offset: (5,) of the hand from where it would meet the object's middle: m along x, y and z, rad of roll
            and pitch.

    Returns:
        The grasp.
    """
    return _at(hand, kind, offset, WorldDeviation(), 0.0)


def grid_offsets(rng: np.random.Generator) -> Array:
    """Return the grid of offsets of a hand, in random order.

    Args:
        rng: Decides the order.

    Returns:
        (132, 5) m along x, y and z, rad of roll and pitch: 4 x 4 x 2 points of the box with all four tilts,
        and the middle of each of its vertical edges without a tilt.
    """
    axes = [np.linspace(-size / 2, size / 2, n) for size, n in zip(GRID_BOX, GRID_COUNTS, strict=True)]
    tilts = (-GRID_TILT, GRID_TILT)
    tilted = list(product(*axes, tilts, tilts))
    edges = [(x, y, 0.0, 0.0, 0.0) for x, y in product(axes[0][[0, -1]], axes[1][[0, -1]])]
    return np.asarray(rng.permutation(np.array([*tilted, *edges])))


def rectangular_cluster(width: float, yaw: float) -> Array:
    """Return where objects of a rectangular cluster stand.

    Args:
        width: m from one to the next.
        yaw: rad by which the cluster is turned.

    Returns:
        (9, 2) m about the middle.
    """
    steps = (np.arange(ROWS) - (ROWS - 1) / 2) * width
    at = np.array(list(product(steps, steps)))
    turn = np.array([[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]])
    return np.asarray(at @ turn.T)


def random_cluster(width: float, rng: np.random.Generator) -> Array:
    """Return where objects of a tightly packed random cluster stand: each touches two that stood before it.

    Args:
        width: m from one to the next.
        rng: Decides where.

    Returns:
        (9, 2) m about the middle.
    """
    angle = rng.uniform(0.0, 2 * np.pi)
    at = [np.zeros(2), width * np.array([np.cos(angle), np.sin(angle)])]
    while len(at) < ROWS**2:
        i, j = rng.choice(len(at), 2, replace=False)
        between = at[j] - at[i]
        off = float(np.linalg.norm(between))
        if off >= 2 * width:
            continue
        across = np.array([-between[1], between[0]]) / off * rng.choice([-1.0, 1.0])
        new = at[i] + between / 2 + across * np.sqrt(width**2 - off**2 / 4)
        if min(float(np.linalg.norm(new - each)) for each in at) > width * (1 - 1e-9):
            at.append(new)
    found = np.array(at)
    return np.asarray(found - found.mean(axis=0))


def _deviation(rng: np.random.Generator) -> WorldDeviation:
    mass, friction = rng.uniform(-1.0, 1.0, 2) * (MASS_SPREAD, FRICTION_SPREAD)
    return WorldDeviation(1.0 + mass, 1.0 + friction)


def _near(rng: np.random.Generator) -> Array:
    return np.concatenate([rng.uniform(-NEAR, NEAR, 3), rng.uniform(-GRID_TILT, GRID_TILT, 2)])


def _at(hand: BeltHand, kind: GraspObject, offset: Array, deviation: WorldDeviation, yaw: float) -> PreGrasp:
    x, y, z, roll, pitch = offset
    goal = np.array([x - hand.control.reach, y, HEIGHT * kind.height + z, 0.0, pitch, roll])
    start = goal - np.array([BACK, 0.0, 0.0, 0.0, 0.0, 0.0])
    return PreGrasp([Standing(0.0, 0.0, yaw)], start, goal, deviation, BACK / APPROACH_SPEED)


def _before_cluster(
    hand: BeltHand, kind: GraspObject, poses: GraspPoses, rng: np.random.Generator
) -> PreGrasp:
    """Approach a cluster, as perceived, from where one of its objects stands out the most."""
    apart = kind.width + APART
    if poses is GraspPoses.RECTANGULAR:
        at = rectangular_cluster(apart, float(rng.uniform(*CORNER_YAW)))
    else:
        at = random_cluster(apart, rng)
    seen = at + rng.normal(0.0, POINT_NOISE, at.shape)
    names = tuple(f"{kind.name} {k + 1}" for k in range(len(at)))
    middles = np.column_stack([seen, np.full(len(at), HEIGHT * kind.height)])
    T = Cluster(names, middles, kind.height).approaches(hand)[0].T_world_hand
    nearest = T @ (hand.control.cluster_reach, 0.0, 0.0, 1.0)
    yaw = float(np.arctan2(T[1, 0], T[0, 0]) + rng.normal(0.0, DIRECTION_NOISE))
    towards = np.array([np.cos(yaw), np.sin(yaw), 0.0])
    goal = np.array([*(nearest[:3] - hand.control.cluster_reach * towards), yaw, 0.0, 0.0])
    start = goal - np.array([*CLUSTER_BACK * towards, 0.0, 0.0, 0.0])
    stand = [Standing(float(x), float(y)) for x, y in at]
    return PreGrasp(stand, start, goal, _deviation(rng), CLUSTER_BACK / APPROACH_SPEED)
