"""How far along a running belt an arm reaches with its tool on an item that rides there.

The pose of the tool is that of a grasp, displaced along the belt. From a place where inverse kinematics has a
configuration, the arm follows the pose both ways in small steps, as far as it can. That says where lines may
be tried, and from which configurations; it proves nothing, and lines are proven where they are tried.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.follow import Deviation

STEP = 0.03  # m along the belt between configurations
ROUGHLY = Deviation(0.01, float(np.radians(5.0)))  # that the tool may be off half-way between two of them
STARTS = (
    0.5,
    0.25,
    0.75,
)  # shares of the stretch at which the arm begins to follow, the first that it reaches


@dataclass(frozen=True, eq=False)
class BeltReach:
    """Configurations whose tool rides along a belt.

    Attributes:
        travel: (M,) m of the belt from where the pose of the tool was given, increasing.
        configurations: (M, n).
    """

    travel: Array
    configurations: Array

    def at(self, travel: float) -> Array:
        """Interpolate the configuration for a travel of the belt.

        Args:
            travel: m; beyond the ends, theirs counts.

        Returns:
            (n,).
        """
        return np.array([np.interp(travel, self.travel, column) for column in self.configurations.T])

    @property
    def stretch(self) -> tuple[float, float]:
        """The first and the last travel, m."""
        return float(self.travel[0]), float(self.travel[-1])


def belt_reaches(
    arm: Arm, T_world_tip: Array, tool_state: ToolState, along: Array, stretch: tuple[float, float],
    seeds: Array,
) -> Iterator[BeltReach]:  # fmt: skip
    """Find how far along a belt an arm reaches a pose of its tool, in one branch after the other.

    Args:
        arm: Kinematics.
        T_world_tip: (4, 4) pose of the tool, with a travel of 0.
        tool_state: State of the tool.
        along: (3,) unit vector in the world, in which the belt runs.
        stretch: m of travel, the first and the last that are of interest.
        seeds: (K, n) from which inverse kinematics begins.

    Yields:
        What one branch of the arm reaches. Where one does, it is not begun anew.
    """
    travel = np.linspace(*stretch, max(2, 1 + int(np.ceil((stretch[1] - stretch[0]) / STEP))))
    poses = np.repeat(T_world_tip[None], len(travel), axis=0)
    poses[:, :3, 3] += np.outer(travel, along)
    known: list[BeltReach] = []
    for share in STARTS:
        k = round(share * (len(travel) - 1))
        if any(each.stretch[0] <= travel[k] <= each.stretch[1] for each in known):
            continue
        for q in arm.solve(poses[k], tool_state, seeds):
            after = arm.follow(poses[k + 1 :], tool_state, q, ROUGHLY).configurations
            before = arm.follow(poses[:k][::-1], tool_state, q, ROUGHLY).configurations
            rows = slice(k - len(before), k + 1 + len(after))
            known.append(BeltReach(travel[rows], np.vstack([before[::-1], q, after])))
            yield known[-1]
