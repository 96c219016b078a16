"""First lower bounds of all distances of a segment, a whole window of states at a time.

Every part is covered by balls; a window's bound is the distance of the balls at its middle state, less
how far the pair moves from there to either end. Coarse, but it leaves few pairs for the exact shapes.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from pickcli.geometry import Array
from pickcli.verification.fcl_solids import distances_to_boxes
from pickcli.verification.moving_parts import Fixture, Part
from pickcli.verification.state_sampling import States

Indices: TypeAlias = NDArray[np.int64]

WINDOW = 0.1  # m that the fastest part moves in one window


@dataclass(frozen=True, eq=False)
class Windows:
    """Stretches of states [first, last] and a state in the middle of each, (W,) indices."""

    first: Indices
    middle: Indices
    last: Indices

    def half_way(self, travel: Array) -> Array:
        """How far, at most, the middle is from any other state, by the travel (N, ...) up to each state."""
        back, ahead = travel[self.middle] - travel[self.first], travel[self.last] - travel[self.middle]
        return np.asarray(np.maximum(back, ahead))


def windows(states: States, first: int, last: int, reach: Array) -> Windows:
    """Cut the states of a segment into windows. reach: (n,) of the part that reaches farthest."""
    way = states.travel[first : last + 1] @ reach
    way = way - way[0]
    n = max(1, int(np.ceil(way[-1] / WINDOW)))
    edges = np.unique(np.searchsorted(way, np.linspace(0.0, way[-1], n + 1)[1:-1]))
    edges = np.unique(np.concatenate([[0], edges, [last - first]])) + first
    return Windows(edges[:-1], (edges[:-1] + edges[1:]) // 2, edges[1:])


def ball_centers(states: States, moving: tuple[Part, ...], at: Windows) -> tuple[Array, Array, Indices]:
    """Centres (W, K, 3) in the world of all parts' balls, radii (K,), and where each part's balls start."""
    centers, radii, starts = [], [], []
    k = 0
    for part in moving:
        T = states.links[part.link, at.middle] @ part.T_link_shape
        centers.append(part.balls.centers @ T[:, :3, :3].transpose(0, 2, 1) + T[:, None, :3, 3])
        radii.append(np.full(len(part.balls.centers), part.balls.radius + part.slack))
        starts.append(k)
        k += len(part.balls.centers)
    return np.concatenate(centers, axis=1), np.concatenate(radii), np.array(starts)


def world_bounds(states: States, moving: tuple[Part, ...], standing: Sequence[Fixture], at: Windows) -> Array:
    """Lower bounds (W, P, F) of the distance of every part from everything that stands."""
    centers, radii, starts = ball_centers(states, moving, at)
    boxes = np.stack([f.T_world_shape for f in standing])
    half = np.stack([f.shape.extents / 2 for f in standing])
    away = distances_to_boxes(centers.reshape(-1, 3), boxes, half).reshape(*centers.shape[:2], -1)
    slack = np.array([f.slack for f in standing])
    nearest = np.minimum.reduceat(away - radii[:, None], starts, axis=1) - slack
    ways = np.stack([at.half_way(states.travel @ part.reach) for part in moving], axis=1)
    return np.asarray(nearest - ways[:, :, None])


def own_bounds(states: States, moving: tuple[Part, ...], at: Windows) -> Array:
    """Lower bounds (W, P, P) of the distances between parts."""
    centers, radii, starts = ball_centers(states, moving, at)
    squared = np.einsum("wkc,wkc->wk", centers, centers)
    product = centers @ centers.transpose(0, 2, 1)
    away = np.sqrt(np.maximum(0.0, squared[:, :, None] + squared[:, None, :] - 2 * product))
    away -= radii[:, None] + radii[None, :]
    nearest = np.minimum.reduceat(np.minimum.reduceat(away, starts, axis=1), starts, axis=2)
    joints = at.half_way(states.travel)  # (W, n)
    reach = np.stack([[relative_reach(a, b) for b in moving] for a in moving])
    return np.asarray(nearest - np.einsum("wn,abn->wab", joints, reach))


def relative_reach(a: Part, b: Part) -> Array:
    """How far two parts move relative to each other per unit of each joint (n,); joints between count."""
    near, far = (a, b) if a.link <= b.link else (b, a)
    return np.where(near.reach > 0.0, 0.0, far.reach)


def candidates(
    bounds: Array, tested: NDArray[np.bool_], at: Windows, below: float
) -> Iterator[tuple[float, int, int, int, int]]:
    """(bound, row, column, first, last) of every tested pair and window with a bound below ``below``."""
    w, a, b = np.nonzero((bounds < below) & tested)
    rows = zip(
        bounds[w, a, b].tolist(),
        a.tolist(),
        b.tolist(),
        at.first[w].tolist(),
        at.last[w].tolist(),
        strict=True,
    )
    yield from rows
