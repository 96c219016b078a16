"""What an arm is to do in the time of a stream, and the proof that two arms keep apart.

Every link is covered by spheres, as for collision checks, and so is what the arm takes. They are followed
through samples of the motion, in a few groups for each link: between two samples a sphere is within half of
their distance of one of them, and within the sag of an arc, which is estimated by twice what second
differences say. Two arms are apart if the boxes around any two groups are at every sample, or else their
spheres; and also with the groups where they are a moment before and after that, as each arm may be late
against the other.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d
from scipy.spatial.distance import cdist

from pickcli.cell.tool import MOVING
from pickcli.collision.robot_model import CollisionModel
from pickcli.collision.sphere_cover import Cover, cover_shape
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse
from pickcli.motion.plan import Plan
from pickcli.scene.scene import Scene

STEP = 0.02  # s between two samples
GROUPS = 6  # of a link's spheres
LEAST_SAG = 2e-4  # m
_SIDES = np.array(list(product((0.0, 1.0), repeat=3)))


@dataclass(frozen=True, eq=False)
class ReservedMotion:
    """What an arm is to do in the time of a stream, or did.

    Attributes:
        model: Collision model of the arm.
        at: Returns its configurations (K, n) at times (K,), s of the stream.
        t_end: s of the stream from which on it rests.
        taken: What it takes, in the frame of its last link: as if it held it all the time; None if nothing.
    """

    model: CollisionModel
    at: Callable[[Array], Array]
    t_end: float
    taken: Cover | None = None

    @classmethod
    def resting(cls, model: CollisionModel, q: Array) -> ReservedMotion:
        """Describe an arm that rests.

        Args:
            model: Collision model of the arm.
            q: (n,) its configuration.

        Returns:
            The motion.
        """
        return cls(model, lambda times: np.repeat(q[None], len(times), axis=0), 0.0)

    @classmethod
    def planned(cls, model: CollisionModel, plan: Plan, scene: Scene, t: float) -> ReservedMotion:
        """Describe the motion of a plan, before and after which the arm rests.

        Args:
            model: Collision model of the arm.
            plan: The plan.
            scene: The scene at its start, with the item that it takes.
            t: s of the stream at which it starts.

        Returns:
            The motion.
        """
        trajectory = plan.trajectory
        taken = _taken(model, plan, scene)
        return cls(model, lambda times: trajectory.sample(times - t), t + trajectory.duration, taken)

    @classmethod
    def measured(cls, model: CollisionModel, times: Array, q: Array, taken: Cover | None) -> ReservedMotion:
        """Describe a motion that was measured, before and after which the arm rests.

        Args:
            model: Collision model of the arm.
            times: (N,) s of the stream, increasing.
            q: (N, n) configurations.
            taken: What it took; None if nothing.

        Returns:
            The motion.
        """

        def at(when: Array) -> Array:
            return np.column_stack([np.interp(when, times, column) for column in q.T])

        return cls(model, at, float(times[-1]), taken)

    def why_not_apart(self, other: ReservedMotion, t: float, keep: float, late: float) -> Reason | None:
        """Explain why two arms are not proven apart, from a time on until both rest.

        Args:
            other: Motion of the other arm.
            t: s of the stream.
            keep: m of distance between their shapes.
            late: s by which each arm may be late against the other.

        Returns:
            A reason; None if they are proven apart.
        """
        shifts = int(np.ceil(late / STEP))
        n = 2 + max(0, int(np.ceil((max(self.t_end, other.t_end) - t) / STEP))) + shifts
        times = np.asarray(t + STEP * np.arange(-shifts, n), dtype=float)
        mine, others = self._groups(times), other._groups(times)
        close = _are_close(mine.corners, others.corners_within(shifts), keep)
        for i, j in np.argwhere(close.any(axis=0)):
            ks = np.flatnonzero(close[:, i, j])
            reach = mine.reach[ks, i] + others.reach_within(shifts, j)[ks]
            gaps = _gaps(mine.spheres(i, ks), others.spheres(j, ks)) - reach
            if (gaps < keep).any():
                at = float(times[ks[int(np.argmax(gaps < keep))]])
                where = f"{mine.links[i]} and {others.links[j]}"
                return Reason("in the way of the other arm", where, f"not proven apart at {at:.2f} s")
        return None

    def _groups(self, times: Array) -> _MovingGroups:
        """Return where the groups of spheres are at times (K,), s of the stream."""
        kernel, names = self.model.state(MOVING), self.model.frame_names
        groups: list[tuple[int, str, Cover]] = []
        for k in np.unique(kernel.spheres.frames):
            own = kernel.spheres.of([int(k)])
            groups += [(int(k), names[k], each) for each in _divided(Cover(own.centers, own.radii, 0.0))]
        if self.taken is not None:
            groups += [(len(names) - 1, "what it takes", each) for each in _divided(self.taken)]
        frames = kernel.chain.fk_batch(self.at(times))
        return _MovingGroups(
            tuple(name for _, name, _ in groups),
            frames[:, [k for k, _, _ in groups]],
            tuple(group for _, _, group in groups),
        )


class _MovingGroups:
    """Groups of an arm's spheres at every sample.

    links: name of the link of each of G groups
    frames: (K, G, 4, 4) poses of the frame of each
    groups: spheres of each, in that frame
    """

    def __init__(self, links: tuple[str, ...], frames: Array, groups: tuple[Cover, ...]) -> None:
        self.links, self._frames, self._covers = links, frames, groups
        # (K, G, 8, 3) m, corners of a box around each group that moves with it
        points = _moved(frames, np.array([_box_points(group) for group in groups]))
        ways = np.linalg.norm(np.diff(points, axis=0), axis=3).max(axis=2)
        # h² / 8 of the acceleration, and as much again for what that changes between the samples
        bends = np.linalg.norm(np.diff(points, 2, axis=0), axis=3).max(axis=(0, 2), initial=0.0)
        longest = np.maximum(np.pad(ways, ((1, 0), (0, 0))), np.pad(ways, ((0, 1), (0, 0))))
        # reach: (K, G) m by which spheres may be elsewhere until half of the way to the samples beside each
        self._points, self.reach = points, longest / 2 + bends / 4 + LEAST_SAG

    @property
    def corners(self) -> tuple[Array, Array]:
        """Corners of the boxes along the axes of the world that hold each group: (K, G, 3) m each."""
        reach = self.reach[:, :, None]
        return self._points.min(axis=2) - reach, self._points.max(axis=2) + reach

    def corners_within(self, shifts: int) -> tuple[Array, Array]:
        """Return those of boxes that also hold each group some samples before and after every one."""
        (low, high), size = self.corners, 2 * shifts + 1
        low = -maximum_filter1d(-low, size, axis=0, mode="nearest")
        return low, maximum_filter1d(high, size, axis=0, mode="nearest")

    def reach_within(self, shifts: int, j: int) -> Array:
        """Return how far a group gets, (K,) m, from where it is within some samples before and after that."""
        points = self._points[:, j]
        ticks, far = np.arange(len(points)), np.zeros(len(points))
        for shift in range(-shifts, shifts + 1):
            then = np.clip(ticks + shift, 0, len(ticks) - 1)
            away = np.linalg.norm(points[then] - points, axis=2).max(axis=1)
            far = np.maximum(far, away + self.reach[then, j])
        return far

    def spheres(self, i: int, ks: NDArray[np.intp]) -> tuple[Array, Array]:
        """Return the spheres of a group at some samples: centres (N, S, 3) and radii (S,), m."""
        cover = self._covers[i]
        return _moved(self._frames[ks, i], cover.centers), cover.radii


def _are_close(mine: tuple[Array, Array], others: tuple[Array, Array], keep: float) -> NDArray[np.bool_]:
    """Tell which boxes (K, G, 3) are closer than ``keep`` (m) to which others, along all axes: (K, G, H)."""
    (low, high), (other_low, other_high) = mine, others
    close = np.ones((len(low), low.shape[1], other_low.shape[1]), dtype=bool)
    for axis in (1, 0, 2):  # arms mostly stand side by side
        close &= low[:, :, None, axis] - other_high[:, None, :, axis] < keep
        close &= other_low[:, None, :, axis] - high[:, :, None, axis] < keep
    return close


def _gaps(mine: tuple[Array, Array], others: tuple[Array, Array]) -> Array:
    """Return the least gaps (N,), m, between two groups of spheres."""
    (centers, radii), (other_centers, other_radii) = mine, others
    both = radii[:, None] + other_radii
    each = zip(centers, other_centers, strict=True)
    return np.array([(cdist(a, b) - both).min() for a, b in each])


def _box_points(group: Cover) -> Array:
    """Return the corners (8, 3), m, of a box around spheres in their frame."""
    low = (group.centers - group.radii[:, None]).min(axis=0)
    high = (group.centers + group.radii[:, None]).max(axis=0)
    return np.asarray(low + _SIDES * (high - low))


def _moved(frames: Array, points: Array) -> Array:
    """Return points (..., S, 3) of frames at each of their poses (K, ..., 4, 4): (K, ..., S, 3) m."""
    turned = points @ np.swapaxes(frames[..., :3, :3], -1, -2)
    return np.asarray(turned + frames[..., None, :3, 3])


def _divided(cover: Cover) -> list[Cover]:
    """Divide spheres into a few groups, each of those nearest to one of some that are far apart."""
    chosen = [int(np.argmax(np.linalg.norm(cover.centers - cover.centers.mean(axis=0), axis=1)))]
    far = np.linalg.norm(cover.centers - cover.centers[chosen[0]], axis=1)
    while len(chosen) < min(GROUPS, len(cover.radii)):
        chosen.append(int(np.argmax(far)))
        far = np.minimum(far, np.linalg.norm(cover.centers - cover.centers[chosen[-1]], axis=1))
    nearest = cdist(cover.centers, cover.centers[chosen]).argmin(axis=1)
    divided = (nearest == k for k in np.unique(nearest))
    return [Cover(cover.centers[own], cover.radii[own], 0.0) for own in divided]


def _taken(model: CollisionModel, plan: Plan, scene: Scene) -> Cover | None:
    """Return the spheres of what a plan takes, as far off its pose as it may be."""
    if plan.grasp is None:
        return None
    placed = scene.find(plan.grasp.item)
    T_last_item = model.robot.tool.T_last_tip @ inverse(plan.grasp.T_item_tip)
    cover = cover_shape(placed.item.shape).inflated(scene.bound(placed))
    return model.swept(cover.moved(T_last_item))
