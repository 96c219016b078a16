"""Truncation of an envelope to a scene: the largest part in which the tool is proven free at every pose.

Krug et al. shrink r1, r2, c, h and phi by hand (RA-L 2016, Fig. 3b). Here the coordinates are divided into
blocks, and a block is kept if the tool is proven to keep its clearance for every place in it and every
orientation in both cones.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray

from pickcli.collision.free_flyer import FreeToolChecker
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.grasping.envelope import Alignment, Envelope
from pickcli.kernel import SurfaceKind, prove_pose_blocks

SHARES = (0.25, 0.5, 0.75, 1.0)  # of the cones' angles that are tried, rising: each contains those before
LONGEST_BLOCK, WIDEST_BLOCK = 0.015, np.radians(10.0)  # m and rad, of a block along each coordinate
MOST_BLOCKS = 36  # along a coordinate
NO_RANGE = 1e-3  # m or rad that is not divided
LEAST_BLOCKS = 3  # along a coordinate that has a range
SMALLEST = 1e-3  # m of clearance that is not looked for
MOST_CELLS = 3_000  # of a block; one that is not proven by then counts as blocked
N_WINDOWS = 8  # of a free roll
WIDEST_SECTOR = 0.7  # rad of azimuth
N_EXPLAINED = 100  # poses of the whole envelope, at which what is in the way is looked up
ANGLES = {
    SurfaceKind.PLANE: 0,
    SurfaceKind.CYLINDER: 1,
    SurfaceKind.SPHERE: 2,
}  # how many coordinates are angles


@dataclass(frozen=True, eq=False)
class Truncation:
    """What a scene leaves of an envelope.

    Attributes:
        envelope: The largest part that is proven free; None if there is none.
        kept: Its share of the coordinates' ranges.
        cone_share: Its share of the angles of both cones.
        roll_share: Share of the roll that is left: of a free one the width of a window, as a share of a full
            turn, of a bounded one that of its angle; 1 if all of it is left.
        against: What most of the sampled poses of the whole envelope that are not free meet; None if all
            of them are free.
    """

    envelope: Envelope | None
    kept: float
    cone_share: float
    roll_share: float
    against: Reason | None

    @property
    def size(self) -> float:
        """Size of what is left, as a share of the whole: coordinates, tilts in two directions, and roll."""
        return self.kept * self.cone_share**2 * self.roll_share


def truncated(envelope: Envelope, T_world_object: Array, tool: FreeToolChecker) -> Truncation:
    """Truncate an envelope to a scene.

    If its roll is free, windows of it are tried as well, each as an alignment. Of the parts that are boxes in
    the envelope's coordinates, the largest is kept: by the share of each coordinate's range, times the share
    of the angles of the cones, squared for the approach's, and of the window.

    Args:
        envelope: The envelope, not empty.
        T_world_object: (4, 4) pose of the object.
        tool: Checks the tool without the arm in the scene.

    Returns:
        The part of it in which the tool keeps the cell's clearance at every pose, and what stands against the
        rest.
    """
    found = _largest_part(envelope, T_world_object, tool)
    for window in _windows(envelope):
        part = _largest_part(window, T_world_object, tool)
        part = replace(part, roll_share=part.roll_share / N_WINDOWS)
        found = part if part.size > found.size else found
    return replace(found, against=_most_in_the_way(envelope, T_world_object, tool))


def free_sectors(envelope: Envelope, T_world_object: Array, tool: FreeToolChecker) -> tuple[Envelope, ...]:
    """Divide what a scene leaves of an envelope by its azimuth, for a controller that knows no future.

    From where the tool is, the nearest pose of a whole envelope may lie behind what is in the way.

    Args:
        envelope: The envelope, not empty.
        T_world_object: (4, 4) pose of the object.
        tool: Checks the tool without the arm in the scene.

    Returns:
        The part of it that is proven free, and after it the sectors of that, ``WIDEST_SECTOR`` wide at most;
        none if nothing is left.
    """
    part = truncated(envelope, T_world_object, tool).envelope
    if part is None:
        return ()
    if not ANGLES[part.surface]:
        return (part,)
    n = max(1, int(np.ceil((part.high[0] - part.low[0]) / WIDEST_SECTOR - 1e-9)))
    ends = np.linspace(part.low[0], part.high[0], n + 1)
    sectors = (
        part.within(np.array([low, *part.low[1:]]), np.array([high, *part.high[1:]]), 1.0)
        for low, high in pairwise(ends.tolist())
    )
    return (part, *(sectors if n > 1 else ()))


def _windows(envelope: Envelope) -> Iterator[Envelope]:
    """Yield parts of an envelope whose roll is free, in each of which it is bounded.

    About a sphere no axis is across all normals, so it has none.
    """
    if envelope.alignment is not None or envelope.surface is SurfaceKind.SPHERE:
        return
    for k in range(N_WINDOWS):
        angle = 2 * np.pi * k / N_WINDOWS
        tool_axis = np.array([np.cos(angle), np.sin(angle), 0.0])
        yield replace(envelope, alignment=Alignment(tool_axis, envelope.roll_from, np.pi / N_WINDOWS))


def _largest_part(envelope: Envelope, T_world_object: Array, tool: FreeToolChecker) -> Truncation:
    """Return the largest part that is proven free, without what is in the way."""
    found = Truncation(None, 0.0, 0.0, 1.0, None)
    blocks = _Blocks.of(envelope)
    are_free = np.ones(blocks.shape, dtype=bool)
    for share in SHARES:
        part = envelope.within(envelope.low, envelope.high, share)
        are_free = blocks.proven(part, are_free, T_world_object, tool)
        roll = 1.0 if envelope.alignment is None else share
        for low, high, kept in _largest(blocks, are_free, envelope.is_closed):
            left = Truncation(envelope.within(low, high, share), kept, share, roll, None)
            found = left if left.size > found.size else found
    return found


@dataclass(frozen=True, eq=False)
class _Blocks:
    """A grid over the coordinates of an envelope.

    Attributes:
        edges: Of each coordinate, (n + 1,) the blocks' ends.
    """

    edges: tuple[Array, Array, Array]

    @classmethod
    def of(cls, envelope: Envelope) -> _Blocks:
        n_angles = ANGLES[envelope.surface]
        sizes = [WIDEST_BLOCK] * n_angles + [LONGEST_BLOCK] * (3 - n_angles)
        edges = []
        for low, high, size in zip(envelope.low, envelope.high, sizes, strict=True):
            n = np.clip(np.ceil((high - low) / size - 1e-9), LEAST_BLOCKS, MOST_BLOCKS)
            edges.append(np.linspace(low, high, int(n) + 1 if high - low > NO_RANGE else 2))
        return cls((edges[0], edges[1], edges[2]))

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of blocks along each coordinate."""
        a, b, c = (len(edges) - 1 for edges in self.edges)
        return a, b, c

    def proven(
        self, envelope: Envelope, are_tried: NDArray[np.bool_], T_world_object: Array, tool: FreeToolChecker
    ) -> NDArray[np.bool_]:
        """Prove blocks free.

        Args:
            envelope: Its cones, and the surface of the coordinates.
            are_tried: Which blocks, in the grid's shape.
            T_world_object: (4, 4) pose of the object.
            tool: Checks the tool without the arm.

        Returns:
            Which blocks are proven, in the grid's shape.
        """
        spheres = tool.spheres(envelope.T_tip_palm)
        low, high = (cells[are_tried.ravel()] for cells in self._cells(envelope))
        are_proven = prove_pose_blocks(
            tool.kernel, envelope.surface, T_world_object @ envelope.T_object_surface,
            T_world_object[:3, :3] @ envelope.roll_from, envelope.R_nominal, envelope.cone,
            spheres.centers, spheres.radii, spheres.frames, low, high, tool.margin, SMALLEST, MOST_CELLS,
        )  # fmt: skip
        are_free = are_tried.copy()
        are_free[are_tried] = are_proven == 1
        return are_free

    def _cells(self, envelope: Envelope) -> tuple[Array, Array]:
        """Return the least and the greatest (M, 6) coordinates, roll and tilts of each block."""
        ends = [(edges[:-1], edges[1:]) for edges in self.edges]
        low, high = (
            np.stack(np.meshgrid(*(end[k] for end in ends), indexing="ij"), axis=-1).reshape(-1, 3)
            for k in (0, 1)
        )
        turns = np.broadcast_to([envelope.most_roll, envelope.cone, envelope.cone], low.shape)
        return np.hstack([low, -turns]), np.hstack([high, turns])


def _largest(
    blocks: _Blocks, are_free: NDArray[np.bool_], is_closed: bool
) -> Iterator[tuple[Array, Array, float]]:
    """Yield the longest free range of the first coordinate for all ranges of the others, and its share."""
    n, n_b, n_c = blocks.shape
    a, b, c = blocks.edges
    for b0, b1 in combinations(range(n_b + 1), 2):
        for c0, c1 in combinations(range(n_c + 1), 2):
            start, count = _longest_run(np.asarray(are_free[:, b0:b1, c0:c1].all(axis=(1, 2))), is_closed)
            if count == 0:
                continue
            step = (a[-1] - a[0]) / n
            low, high = a[0] + start * step, a[0] + (start + count) * step
            share = count * (b1 - b0) * (c1 - c0) / are_free.size
            yield np.array([low, b[b0], c[c0]]), np.array([high, b[b1], c[c1]]), share


def _longest_run(is_free: NDArray[np.bool_], is_closed: bool) -> tuple[int, int]:
    """Return start and length of the longest run of True, across the end if the row is closed."""
    if is_free.all():
        return 0, len(is_free)
    row = np.tile(is_free, 2) if is_closed else is_free
    changes = np.flatnonzero(np.diff(np.concatenate([[0], row.astype(int), [0]])))
    starts, ends = changes[::2], changes[1::2]
    if len(starts) == 0:
        return 0, 0
    k = int(np.argmax(ends - starts))
    return int(starts[k]) % len(is_free), int(ends[k] - starts[k])


def _most_in_the_way(envelope: Envelope, T_world_object: Array, tool: FreeToolChecker) -> Reason | None:
    displacements = tool.displacements(
        T_world_object @ envelope.sample(np.random.default_rng(0), N_EXPLAINED)
    )
    found = [tool.explain(d) for d in displacements[~tool.are_valid(displacements)]]
    names = [reason.in_the_way or reason.detail for reason in found]
    return found[names.index(max(names, key=names.count))] if found else None
