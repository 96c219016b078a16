"""A ranked configuration, and the settings of the ranking."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.cell import NamedConfiguration
from pickcli.geometry import Array


@dataclass(frozen=True)
class RankingSettings:
    """Settings of the search for configurations and of their ranking.

    Attributes:
        n_places: Poses in front of the bin; inverse kinematics gives several configurations for each.
        n_kept: Number of these, the most manipulable, that are judged by their reach.
        n_poses: Poses in the bin, the same for all.
        margin: Share of its range that every joint keeps from both of its limits.
        clearance: m that robot and tool keep from everything while they wait, in any state of the tool; if no
            configuration does, the margin of coarse motions is used.
        apart: rad or m, largest difference of a joint below which two configurations count as one.
        seed: Seed of all random choices.
    """

    n_places: int = 60
    n_kept: int = 40
    n_poses: int = 100
    margin: float = 0.03
    clearance: float = 0.02
    apart: float = 0.15
    seed: int = 0


@dataclass(frozen=True, eq=False)
class RankedConfiguration:
    """A configuration in front of a bin, and its measures.

    Attributes:
        configuration: The configuration, with its name and kind.
        T_bin_tip: (4, 4) pose of the tip in the entry frame, which for a bin is the bin's frame.
        manipulability: Yoshikawa's, rail included (see ``kinematics.manipulability``).
        reach: Share of the poses in the bin that it reaches in one line.
        margin: Least distance of a joint from a limit, as a share of its range.
        clearance: m.
        travel: s, lower bound of the duration of a motion from home; None in a cell without home.
    """

    configuration: NamedConfiguration
    T_bin_tip: Array
    manipulability: float
    reach: float
    margin: float
    clearance: float
    travel: float | None


def distinct(ranked: Sequence[RankedConfiguration], n: int, apart: float) -> list[RankedConfiguration]:
    """Return the best-ranked configurations that are at least ``apart`` from each other.

    Args:
        ranked: Configurations, the best first.
        n: Most configurations.
        apart: Largest difference of a joint below which two configurations count as one, rad or m.

    Returns:
        The configurations, the best first.
    """
    chosen: list[RankedConfiguration] = []
    for each in ranked:
        q = each.configuration.q
        if len(chosen) < n and all(np.abs(q - c.configuration.q).max() > apart for c in chosen):
            chosen.append(each)
    return chosen
