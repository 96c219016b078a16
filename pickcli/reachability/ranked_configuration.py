"""A suggested configuration, and how such are sought."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.cell import NamedConfiguration
from pickcli.geometry import Array


@dataclass(frozen=True)
class RankingSettings:
    """How configurations are sought and judged.

    n_places: poses in front of the bin; inverse kinematics gives several configurations for each
    n_kept: of these, by manipulability, how many are judged by what they reach
    n_poses: in the bin, the same for all
    margin: share of its range that every joint keeps from both of its limits
    clearance: m that robot and tool keep from everything while they wait, however the cup is pivoted
    apart: rad or m, largest difference of a joint below which two configurations count as one
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

    T_bin_tip: (4, 4) of the tip there
    manipulability: Yoshikawa's, rail included; see ``kinematics.manipulability``
    reach: share of the poses in the bin that it reaches in one line
    margin: least distance of a joint from a limit, as a share of its range
    clearance: m
    travel: s that any motion from home takes at least; None in a cell without home
    """

    configuration: NamedConfiguration
    T_bin_tip: Array
    manipulability: float
    reach: float
    margin: float
    clearance: float
    travel: float | None


def distinct(ranked: Sequence[RankedConfiguration], n: int, apart: float) -> list[RankedConfiguration]:
    """The first n of which no two are nearer than that."""
    chosen: list[RankedConfiguration] = []
    for each in ranked:
        q = each.configuration.q
        if len(chosen) < n and all(np.abs(q - c.configuration.q).max() > apart for c in chosen):
            chosen.append(each)
    return chosen
