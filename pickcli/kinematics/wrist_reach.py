"""Where an arm can hold the centre of its wrist: bounds that no configuration escapes.

The axes of the last joints of most arms meet in one point. Where it is depends on the joints before them
alone: four of an arm with seven. Their range is divided into cells, and of each cell a box is computed that
contains the point for every configuration in it: the first derivatives in the middle of the cell, and a bound
of how they change within it (the mean value theorem). Other joints and collisions are left out, so that the
boxes cover more than the arm reaches, and nothing less. Kept are the voxels that they meet.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.tool import ToolState
from pickcli.geometry import Array, inverse, skew
from pickcli.kinematics.arm import Arm

MOST_JOINTS = 4  # before the wrist, whose cells are few enough to be listed
MEETS = 1e-6  # m by which axes may miss each other and are said to meet
VOXEL = 0.02  # m
FINEST = 0.02  # m that one joint moves the centre, from the middle of a cell to its side, at most
COARSEST = 0.12  # m of the cells that are looked at first
APART = 1e-5  # rad or m between configurations whose difference gives a derivative
ROUNDING = 1e-5  # m added to all boxes: of differences, and of numbers that are stored in single precision


@dataclass(frozen=True, eq=False)
class WristCentre:
    """The point in which the axes of the last joints meet.

    Attributes:
        n_before: Number of joints before it, which alone decide where it is.
        in_tip: (3,) m in the tool frame.
    """

    n_before: int
    in_tip: Array

    @classmethod
    def of(cls, arm: Arm, tool_state: ToolState) -> WristCentre | None:
        """Find the wrist of an arm.

        Args:
            arm: Kinematics.
            tool_state: State of the tool.

        Returns:
            The wrist with the most joints behind it; None if more than ``MOST_JOINTS`` are before it.
        """
        lower, upper = arm.window
        q = lower + 0.37 * (upper - lower)
        J, T = arm.jacobian(q, tool_state), arm.tip(q, tool_state)
        axes, moments = J[3:].T, J[:3].T  # of each joint: its axis w, and w x (tip - point on the axis)
        for n_before in range(MOST_JOINTS + 1):
            w, m = axes[n_before:], moments[n_before:]
            if len(w) == 0 or not np.allclose(np.linalg.norm(w, axis=1), 1.0):
                continue
            # The centre c is on every axis: w x (tip - c) = w x (tip - point on the axis).
            crosses = np.vstack([skew(each) for each in w])
            to_tip, *_ = np.linalg.lstsq(crosses, m.ravel(), rcond=None)
            if float(np.abs(crosses @ to_tip - m.ravel()).max()) < MEETS:
                return cls(n_before, -T[:3, :3].T @ to_tip)
        return None


@dataclass(frozen=True, eq=False)
class WristReach:
    """Voxels of a region in which the centre of a wrist may be; it is in none of the others.

    Attributes:
        lower: (3,) m, lower corner of the region in its frame.
        occupied: (X, Y, Z) whether a voxel of side ``VOXEL`` may have it.
    """

    lower: Array
    occupied: NDArray[np.bool_]

    @classmethod
    def within(
        cls,
        arm: Arm,
        tool_state: ToolState,
        wrist: WristCentre,
        T_world_frame: Array,
        lower: Array,
        upper: Array,
    ) -> WristReach:
        """Find the voxels of a region that an arm may reach.

        Cells of joints are halved until a joint moves the centre by less than ``FINEST`` in each, or until
        the middles of others have been in every voxel of their box.

        Args:
            arm: Kinematics.
            tool_state: State of the tool.
            wrist: Its wrist.
            T_world_frame: (4, 4) frame of the region.
            lower: (3,) m in that frame, lower corner of the region.
            upper: (3,) m, upper corner.

        Returns:
            The voxels, in that frame.
        """
        cells = _Cells(arm, tool_state, wrist, inverse(T_world_frame))
        first, last = (each[: wrist.n_before] for each in arm.window)
        longest = cells.moves((first + last)[None] / 2)[1][0]
        n = np.maximum(1, np.ceil((last - first) * longest / (2.0 * COARSEST))).astype(int)
        half = (last - first) / (2 * n)
        axes = [lo + h * (2 * np.arange(k) + 1) for lo, h, k in zip(first, half, n, strict=True)]
        joints = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, wrist.n_before)
        occupied = np.zeros(np.ceil((upper - lower) / VOXEL).astype(int), dtype=bool)
        while len(joints):
            middles, halves, most = cells.boxes(joints, half)
            _mark(occupied, (middles - lower) / VOXEL)
            low, high = _voxels(occupied, middles - halves - lower, middles + halves - lower)
            is_open = _count(_sums(~occupied), low, high) > 0
            is_long = half * most[is_open].max(axis=0, initial=0.0) > FINEST
            if not is_long.any():
                for corner, beyond in zip(low[is_open], high[is_open], strict=True):
                    occupied[tuple(map(slice, corner, beyond))] = True
                break
            joints = joints[is_open]
            for k in np.flatnonzero(is_long):
                aside = np.where(np.arange(len(half)) == k, half / 2, 0.0)
                joints = np.concatenate([joints - aside, joints + aside])
            half = np.where(is_long, half / 2, half)
        return cls(lower, occupied)

    @cached_property
    def _totals(self) -> NDArray[np.int64]:
        return _sums(self.occupied)

    def may_be_in(self, lower: Array, upper: Array) -> NDArray[np.bool_]:
        """Tell which of some boxes may contain the centre.

        Args:
            lower: (..., 3) m in the frame of the region, lower corners.
            upper: (..., 3) m, upper corners; what is outside of the region is not looked at.

        Returns:
            (...) whether they may.
        """
        low, high = _voxels(self.occupied, lower - self.lower, upper - self.lower)
        return np.asarray(_count(self._totals, low, high) > 0)


def _mark(occupied: NDArray[np.bool_], at: Array) -> None:
    """Mark the voxels of points (M, 3), in voxels from the lower corner."""
    k = np.floor(at).astype(int)
    k = k[((k >= 0) & (k < occupied.shape)).all(axis=1)]
    occupied[tuple(k.T)] = True


def _voxels(occupied: NDArray[np.bool_], lower: Array, upper: Array) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return the first voxels (..., 3) of boxes, in m from the lower corner, and those after their last."""
    low = np.clip(np.floor(lower / VOXEL).astype(int), 0, occupied.shape)
    high = np.clip(np.floor(upper / VOXEL).astype(int) + 1, low, occupied.shape)
    return low, high


def _sums(of: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return the number of true voxels before every corner (X + 1, Y + 1, Z + 1): a summed-area table."""
    sums = np.pad(of.astype(np.int64), ((1, 0),) * 3)
    for axis in range(3):
        np.cumsum(sums, axis=axis, out=sums)
    return sums


def _count(sums: NDArray[np.int64], low: NDArray[Any], high: NDArray[Any]) -> NDArray[np.int64]:
    """Count the true voxels of boxes (..., 3), from the first voxels to those after their last."""
    total = np.zeros(low.shape[:-1], dtype=np.int64)
    for choice in product((0, 1), repeat=3):
        corner = np.where(choice, high, low)
        sign = 1 if sum(choice) % 2 else -1
        total += sign * sums[corner[..., 0], corner[..., 1], corner[..., 2]]
    return total


class _Cells:
    """Boxes of the centre of a wrist over cells of the joints before it."""

    def __init__(self, arm: Arm, tool_state: ToolState, wrist: WristCentre, T_frame_world: Array) -> None:
        self._arm, self._state, self._wrist, self._T = arm, tool_state, wrist, T_frame_world
        lower, upper = arm.window
        self._behind = ((lower + upper) / 2)[wrist.n_before :]

    def centres(self, joints: Array) -> Array:
        """Return the centre (M, 3) in m for joints (M, m)."""
        behind = np.broadcast_to(self._behind, (len(joints), len(self._behind)))
        tips = self._arm.tips(np.ascontiguousarray(np.hstack([joints, behind])), self._state)
        world = tips[:, :3, :3] @ self._wrist.in_tip + tips[:, :3, 3]
        return np.asarray(world @ self._T[:3, :3].T + self._T[:3, 3])

    def moves(self, joints: Array) -> tuple[Array, Array]:
        """Return the derivatives (M, m, 3) of the centre by the joints, and their lengths (M, m)."""
        columns = []
        for k in range(joints.shape[1]):
            aside = np.where(np.arange(joints.shape[1]) == k, APART, 0.0)
            columns.append((self.centres(joints + aside) - self.centres(joints - aside)) / (2.0 * APART))
        J = np.stack(columns, axis=1)
        return J, np.linalg.norm(J, axis=2)

    def boxes(self, joints: Array, half: Array) -> tuple[Array, Array, Array]:
        """Return middles and half sides (M, 3) in m of the boxes over cells, and how much joints move it.

        The third is (M, m) in m per rad or m: the centre is no farther from a joint's axis anywhere in the
        cell.
        """
        J, least = self.moves(joints)
        most, beyond = np.empty_like(least), np.zeros(len(joints))
        for k in reversed(range(len(half))):  # joints after it alone change how far its axis is away
            most[:, k] = least[:, k] + beyond
            beyond = beyond + half[k] * most[:, k]
        # A derivative turns with the joints before it, and changes with the motion by those after it.
        bends = np.zeros(len(joints))
        for k in range(len(half)):
            bends += half[k] * (half[:k].sum() * most[:, k] + most[:, k:] @ half[k:])
        halves = np.einsum("k,mki->mi", half, np.abs(J)) + bends[:, None] / 2 + ROUNDING
        return self.centres(joints), halves, most
