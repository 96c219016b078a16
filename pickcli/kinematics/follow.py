"""The outcome of following tool poses with the joints, and the check of what happens between them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.errors import Reason
from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class FollowResult:
    """Configurations along a line of tool poses, one per pose, as far as they go.

    Attributes:
        configurations: (M, n), M at most the number of poses.
        is_complete: Whether all poses were reached.
        reason: Why the line broke; None if and only if it is complete.
    """

    configurations: Array
    is_complete: bool
    reason: Reason | None


@dataclass(frozen=True)
class Deviation:
    """How far the tool may leave the line between two poses.

    Attributes:
        position: m.
        angle: rad.
    """

    position: float = 1e-3
    angle: float = np.deg2rad(0.5)

    def first_broken(self, T_ends: Array, T_middles: Array) -> tuple[int, str] | None:
        """Find the first step on which the tool leaves the line.

        The middle of a step should lie half-way between its ends; the turns before and after it should be
        equal, and their difference is twice its deviation.

        Args:
            T_ends: (M + 1, 4, 4) tool poses at the configurations.
            T_middles: (M, 4, 4) tool poses half-way in joint space between neighbouring configurations.

        Returns:
            Index of the step, and in words how far it is off; None if no step leaves the line.
        """
        expected = (T_ends[:-1, :3, 3] + T_ends[1:, :3, 3]) / 2
        offsets = np.linalg.norm(T_middles[:, :3, 3] - expected, axis=1)
        R_a, R_m, R_b = T_ends[:-1, :3, :3], T_middles[:, :3, :3], T_ends[1:, :3, :3]
        before, after = R_a.transpose(0, 2, 1) @ R_m, R_m.transpose(0, 2, 1) @ R_b
        angles = _angles(before.transpose(0, 2, 1) @ after) / 2
        broken = np.flatnonzero((offsets > self.position) | (angles > self.angle))
        if len(broken) == 0:
            return None
        i = int(broken[0])
        return i, f"{offsets[i] * 1e3:.1f} mm and {np.rad2deg(angles[i]):.1f} degrees off"


def _angles(R: Array) -> NDArray[np.float64]:
    """(M,) rotation angles of (M, 3, 3), exact near zero where arccos of the trace is not."""
    skew = np.stack([R[:, 2, 1] - R[:, 1, 2], R[:, 0, 2] - R[:, 2, 0], R[:, 1, 0] - R[:, 0, 1]], axis=1)
    cosine = (np.trace(R, axis1=1, axis2=2) - 1.0) / 2.0
    return np.asarray(np.arctan2(np.linalg.norm(skew, axis=1) / 2.0, cosine), dtype=np.float64)
