"""A ranked configuration, and the settings of the ranking."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.cell import NamedConfiguration
from pickcli.geometry import Array


@dataclass(frozen=True)
class RankingSettings:
    """How configurations are sought and judged.

    Attributes:
        n_places: Poses in front of the bin; inverse kinematics gives several configurations for each.
        n_kept: How many of these, by manipulability, are judged by what they reach.
        n_poses: Poses in the bin, the same for all.
        margin: Share of its range that every joint keeps from both of its limits.
        clearance: m that robot and tool keep from everything while they wait, in whatever state the tool is;
            where no configuration does, what coarse motions keep will do.
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
    """A configuration in front of a bin, and what it is worth.

    Attributes:
        configuration: The configuration, with its name and kind.
        T_bin_tip: (4, 4) pose of the tip there, in the frame of the way in: of a bin, its own.
        manipulability: Yoshikawa's, rail included (see ``kinematics.manipulability``).
        reach: Share of the poses in the bin that it reaches in one line.
        margin: Least distance of a joint from a limit, as a share of its range.
        clearance: m.
        travel: s that any motion from home takes at least; None in a cell without home.
    """

    configuration: NamedConfiguration
    T_bin_tip: Array
    manipulability: float
    reach: float
    margin: float
    clearance: float
    travel: float | None


def distinct(ranked: Sequence[RankedConfiguration], n: int, apart: float) -> list[RankedConfiguration]:
    """The best-ranked configurations that are at least ``apart`` from each other.

    Args:
        ranked: Configurations, the best first.
        n: How many, at most.
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
