"""Find the points of a cloud that a motion comes near to, by a k-d tree and the verifier's own kinematics.

If no point of the robot moves far between two states, a cloud point that is far from all shapes in these
states is far at any time. The few remaining points are measured like static solids.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import ConvexHull, KDTree

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import Array, pose
from pickcli.motion.plan import Plan
from pickcli.scene.cloud import Cloud
from pickcli.scene.scene import Scene
from pickcli.verification.fcl_solids import Solid
from pickcli.verification.moving_parts import Fixture, Part, farthest
from pickcli.verification.solid_arrays import Indices
from pickcli.verification.state_sampling import States

DISTANCE_CAP = 0.02  # m, larger distances are not distinguished
MAX_STATE_DISTANCE = 0.01  # m that any point moves between two checked states
MOST_AT_ONCE = 200_000  # pairs of a state and a point


@dataclass(frozen=True)
class CloudPoints:
    """The points of a cloud that a motion comes near to.

    Attributes:
        fixtures: Points as spheres, which stand during the whole motion.
        proven: m, lower bound of the distance of all other points at any time.
    """

    fixtures: tuple[Fixture, ...] = ()
    proven: float = np.inf


def near_points(plan: Plan, scene: Scene, states: States, moving: Sequence[tuple[Part, ...]]) -> CloudPoints:
    """Find the points of the scene's cloud that a moving part may come nearer to than ``DISTANCE_CAP``.

    Args:
        plan: The plan.
        scene: The plan's scene.
        states: The motion's states.
        moving: Parts that move in each segment.

    Returns:
        The points.
    """
    cloud = scene.cloud
    if cloud is None:
        return CloudPoints()
    found: list[Indices] = [np.empty(0, np.int64)]
    for k, segment in enumerate(plan.segments):
        chosen, slack = _strided(states, *states.between(segment.t_start, segment.t_end), moving[k])
        for part in moving[k]:
            if part.reach.any():
                poses = states.links[part.link, chosen] @ part.T_link_shape
                within = DISTANCE_CAP + slack + part.slack + cloud.radius + cloud.error
                found.append(_within(cloud, part, poses, within))
    indices = np.unique(np.concatenate(found))
    return CloudPoints(tuple(_ball(cloud, i) for i in indices.tolist()), DISTANCE_CAP)


def _strided(states: States, first: int, last: int, parts: tuple[Part, ...]) -> tuple[Indices, float]:
    """Choose states of a segment, both ends included, and bound the distance (m) of any point from them."""
    way = states.travel[first : last + 1] @ farthest(parts)
    steps = np.arange(0.0, way[-1] - way[0], MAX_STATE_DISTANCE)
    chosen = np.unique(np.concatenate([np.searchsorted(way - way[0], steps), [0, last - first]]))
    widest = float(np.diff(way[chosen]).max(initial=0.0))
    return first + chosen, widest / 2


def _within(cloud: Cloud, part: Part, poses: Array, distance: float) -> Indices:
    """Return indices of the points nearer to a part than a distance in m at any of its poses (S, 4, 4)."""
    tree, spheres = _tree(cloud), part.spheres
    centers = np.einsum("sij,kj->ski", poses[:, :3, :3], spheres.centers) + poses[:, None, :3, 3]
    nearest, _ = tree.query(centers, distance_upper_bound=spheres.radius + distance)
    at = np.flatnonzero(np.isfinite(nearest).any(axis=1))
    found: list[Indices] = [np.empty(0, np.int64)]
    for state, indices in _candidates(tree, centers[at], spheres.radius + distance):
        T = poses[at[state]]
        local = np.einsum("nij,ni->nj", T[:, :3, :3], cloud.points[indices] - T[:, :3, 3])
        found.append(np.unique(indices[_outside(part.shape, local) < distance]))
    return np.unique(np.concatenate(found))


def _candidates(tree: KDTree, centers: Array, radius: float) -> Iterator[tuple[Indices, Indices]]:
    """Yield pairs of a state and a point within a radius of any of its centres (S, K, 3), in batches."""
    pairs: list[tuple[int, Indices]] = []
    for state, of_state in enumerate(centers):
        lists = tree.query_ball_point(of_state, radius)
        pairs.append((state, np.unique(np.concatenate([np.asarray(each, np.int64) for each in lists]))))
        if sum(len(indices) for _, indices in pairs) > MOST_AT_ONCE:
            yield _flat(pairs)
            pairs = []
    if pairs:
        yield _flat(pairs)


def _flat(pairs: list[tuple[int, Indices]]) -> tuple[Indices, Indices]:
    states = np.repeat([state for state, _ in pairs], [len(indices) for _, indices in pairs])
    return states, np.concatenate([indices for _, indices in pairs])


def _outside(shape: Shape, points: Array) -> Array:
    """Return lower bounds (N,), m, of how far points (N, 3) in a shape's frame are outside of it."""
    if shape.kind is ShapeKind.BOX:
        beyond = np.maximum(np.abs(points) - np.array(shape.size) / 2, 0.0)
        return np.asarray(np.linalg.norm(beyond, axis=1))
    if shape.kind is ShapeKind.CYLINDER:
        radius, length = shape.size
        across = np.maximum(np.hypot(points[:, 0], points[:, 1]) - radius, 0.0)
        return np.asarray(np.hypot(across, np.maximum(np.abs(points[:, 2]) - length / 2, 0.0)))
    if shape.kind is ShapeKind.HULL:
        planes = _planes(shape)
        return np.asarray((points @ planes[:, :3].T + planes[:, 3]).max(axis=1))
    return np.asarray(np.linalg.norm(points, axis=1) - shape.size[0])


@lru_cache(maxsize=256)
def _planes(shape: Shape) -> Array:
    """Return normal and offset (F, 4) of every face of a hull."""
    return np.asarray(ConvexHull(np.array(shape.vertices)).equations)


@lru_cache(maxsize=4)
def _tree(cloud: Cloud) -> KDTree:
    return KDTree(cloud.points)


def _ball(cloud: Cloud, i: int) -> Fixture:
    shape, T = Shape(ShapeKind.SPHERE, (cloud.radius,)), pose(cloud.points[i])
    solid = Solid(shape)
    solid.place(T)
    x, y, z = cloud.points[i].tolist()
    return Fixture(f"point of the cloud at ({x:.3f}, {y:.3f}, {z:.3f})", T, shape, solid, cloud.error)
