"""Ranking of configurations in front of a bin or another place by what can be reached from them.

KTH (section IV-A.1) chose theirs by hand, for high manipulability, "to reach a large variety of desired
end-effector poses inside or close to the bin without moving the arm into significantly different
configurations". Here that variety is measured: the share of poses in the bin that the tool reaches from the
configuration along one straight line, followed without joint jumps and proven free.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.cartesian.line_following import follow_line
from pickcli.cell.cell import Cell, NamedConfiguration
from pickcli.cell.configuration_text import DECIMALS
from pickcli.cell.tool import MOVING, ToolState
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import Failures, NoPlanError, Reason, UnknownNameError
from pickcli.geometry import Array, rotation_rpy
from pickcli.kinematics.arm import Arm
from pickcli.planning.planning_context import COARSE_RESERVE
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.progress import Progress, ProgressObserver, nobody
from pickcli.reachability.place_pose_sampling import PlacePoseSampler
from pickcli.reachability.ranked_configuration import RankedConfiguration, RankingSettings, distinct
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.seeds import derived_rng
from pickcli.trajopt.time_lower_bound import lower_bound, scaled_limits


@dataclass(frozen=True, eq=False)
class ConfigurationRanking:
    """Ranks configurations in front of one place of a cell.

    Attributes:
        cell: The cell, without items.
        bin_name: Name of the bin or other place.
        tool_state: State of the tool when it enters.
        settings: Settings of the search and the ranking.

    Raises:
        UnknownNameError: If the cell has no such place.
    """

    cell: Cell
    bin_name: str
    tool_state: ToolState
    settings: RankingSettings

    def __post_init__(self) -> None:
        if self.bin_name not in self.cell.places:
            raise UnknownNameError("place", self.bin_name, list(self.cell.places))

    def suggest(self, n: int, on_progress: ProgressObserver = nobody) -> list[RankedConfiguration]:
        """Return the best distinct configurations, by reach, then by manipulability. Repeatable by seed.

        Args:
            n: Most configurations.
            on_progress: Observer of the progress, called for each candidate.

        Returns:
            At most n, the best first.

        Raises:
            NoPlanError: If there is none, with the reasons.
        """
        kept = self.candidates()
        judged = []
        for i, q in enumerate(kept):
            on_progress(Progress(i, len(kept), f"{self.bin_name}, candidate {i + 1}"))
            judged.append(self.judged(q))
        judged.sort(key=lambda each: (-each.reach, -each.manipulability))
        return distinct(judged, n, self.settings.apart)

    def candidates(self) -> Array:
        """Return candidates in front of the bin, rounded as in a cell file.

        Returns:
            (M, n) configurations, the most manipulable first.

        Raises:
            NoPlanError: If there is none, with the reasons.
        """
        rng, settings = self._rng("front"), self.settings
        solved = [
            self._arm.solve_spread(T, self.tool_state, rng)
            for T in self._poses.in_front(rng, settings.n_places)
        ]
        Q: Array = np.concatenate(solved).round(DECIMALS)
        clear = [q for q in Q if self._is_clear(q)]
        tried = (self._waiting, self._close)
        usable = next(filter(None, ([q for q in clear if at.is_valid(q)] for at in tried)), [])
        if not usable:
            kept = " and then ".join(dict.fromkeys(f"{1e3 * at.margin:g}" for at in tried))
            what = f"a configuration in front of {self.bin_name}"
            detail = f"of {len(Q)} tried, that keep {kept} mm from everything"
            raise NoPlanError(f"{what} ({detail})" if len(Q) else what, self._why_none(Q))
        usable.sort(key=lambda q: -self._arm.manipulability(q, self.tool_state))
        return np.stack(usable[: settings.n_kept])

    def judged(self, q: Array) -> RankedConfiguration:
        """Judge one configuration.

        Args:
            q: (n,) configuration.

        Returns:
            The configuration with its measures.
        """
        T_world_tip = self._arm.tip(q, self.tool_state)
        return RankedConfiguration(
            NamedConfiguration(self.bin_name, q, self.tool_state, "bin"),
            np.linalg.inv(self._poses.T_world_entry) @ T_world_tip,
            self._arm.manipulability(q, self.tool_state),
            float(np.mean([self._reaches(q, T_world_tip, T) for T in self._inside])),
            self._margin(q),
            self._waiting.clearance(q).distance,
            self._travel(q),
        )

    def _reaches(self, q: Array, T_world_tip: Array, T_world_goal: Array) -> bool:
        """Whether one line leads to a pose. The round cup may arrive with its current roll."""
        goal = T_world_goal.copy()
        goal[:3, :3] = goal[:3, :3] @ rotation_rpy(0.0, 0.0, self._poses.roll(T_world_tip))
        line = follow_line(self._arm, self._moving_in, T_world_tip, goal, self.tool_state, q, self.bin_name)
        return not isinstance(line, Failures)

    def _margin(self, q: Array) -> float:
        """Return the least distance to a limit as a share of the range; 0.5 for continuous joints."""
        limits = self.cell.robot.limits
        lower, upper = limits.window
        shares = np.minimum(q - lower, upper - q) / (upper - lower)
        return float(np.where(limits.is_continuous, 0.5, shares).min())

    def _travel(self, q: Array) -> float | None:
        limits = scaled_limits(self.cell.robot.limits, self.cell.speed_scale)
        homes = [each.q for each in self.cell.configurations.values() if each.kind == "home"]
        return min((lower_bound(limits, home, q) for home in homes), default=None)

    def _why_none(self, Q: Array) -> list[Reason]:
        """Explain why none of the configurations (N, n) is usable."""
        if not len(Q):
            return [Reason("no IK solution", self.bin_name, "no place in front of it is within reach")]
        tight = Reason("joint limit", self.bin_name, f"nearer than {self.settings.margin:.0%} of a range")
        return [self._close.explain(q) if self._is_clear(q) else tight for q in Q]

    def _is_clear(self, q: Array) -> bool:
        return self._margin(q) >= self.settings.margin

    def _rng(self, what: str) -> np.random.Generator:
        return derived_rng(self.settings.seed, "suggest", self.bin_name, self.tool_state, what)

    @cached_property
    def _model(self) -> CollisionModel:
        return CollisionModel(self.cell)

    @cached_property
    def _arm(self) -> Arm:
        return Arm(self.cell.robot)

    @cached_property
    def _poses(self) -> PlacePoseSampler:
        return PlacePoseSampler(self._model, self.cell.places[self.bin_name], self.tool_state)

    @cached_property
    def _inside(self) -> Array:
        return self._poses.inside(self._rng("inside"), self.settings.n_poses)

    @cached_property
    def _waiting(self) -> SceneChecker:
        """Checker for waiting, in which the tool may change its state, as in roadmap and database motions."""
        reserve = self.settings.clearance - self.cell.clearance
        return checker(self._model, MOVING, PayloadClass.EMPTY, reserve)

    @cached_property
    def _close(self) -> SceneChecker:
        """Checker with the margin of coarse motions, for robots with links that are never farther apart."""
        return self._waiting.at_margin(min(self._waiting.margin, self.cell.clearance + COARSE_RESERVE))

    @cached_property
    def _moving_in(self) -> SceneChecker:
        return checker(self._model, self.tool_state, PayloadClass.EMPTY)
