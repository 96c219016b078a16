"""Summary of a benchmark: all attempts, and a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from pickcli.geometry import Array
from pickcli.planner_benchmark.benchmark_entries import PlannerRun

NamePair = tuple[str, str]


@dataclass(frozen=True)
class BenchmarkAttempt:
    """One attempt of one planner at one pair.

    Attributes:
        planner: Name of the planner.
        pair: Names of start and goal.
        attempt: Number of the attempt.
        bound: s, lower bound of the duration of motions of this pair.
        answer: The result, or None.
    """

    planner: str
    pair: NamePair
    attempt: int
    bound: float
    answer: PlannerRun | None


@dataclass(frozen=True)
class PlannerSummary:
    """Statistics of one planner. Lengths and durations are those of the pairs that all planners solved.

    Attributes:
        planner: Name of the planner.
        solved: Share of all attempts.
        planning: s, median and 95th percentile over all solved attempts (see ``PlannerRun``).
        whole: s, median and 95th percentile over all solved attempts.
        found: Length of the original path: mean over the common pairs of each pair's median attempt.
        length: Length of the shortened path, averaged in the same way.
        duration: s, averaged in the same way.
        ratio: Durations over lower bounds, both summed.
        best_ratio: The ratio with each pair's best attempt.
        cost_bound: Proven bounds on the costs of original paths, median and worst over all solved attempts;
            NaN of planners that prove none.
    """

    planner: str
    solved: float
    planning: tuple[float, float]
    whole: tuple[float, float]
    found: float
    length: float
    duration: float
    ratio: float
    best_ratio: float
    cost_bound: tuple[float, float]


@dataclass(frozen=True)
class PlannerComparison:
    """All attempts, and the table computed from them.

    Attributes:
        attempts: The attempts in their order.
    """

    attempts: tuple[BenchmarkAttempt, ...]

    @property
    def planners(self) -> list[str]:
        """Names of the planners, in the order in which they started."""
        return list(dict.fromkeys(a.planner for a in self.attempts))

    @property
    def common(self) -> set[NamePair]:
        """Pairs that every planner solved at least once."""
        solved = {(a.planner, a.pair) for a in self.attempts if a.answer is not None}
        pairs = {a.pair for a in self.attempts}
        return {pair for pair in pairs if all((planner, pair) in solved for planner in self.planners)}

    @property
    def standings(self) -> list[PlannerSummary]:
        """The table: a row per planner."""
        tries = {name: [a for a in self.attempts if a.planner == name] for name in self.planners}
        return [_standing(name, tries[name], self.common) for name in self.planners]

    def values(self) -> dict[str, Any]:
        """Return table and attempts as JSON values; null if nothing was solved.

        Returns:
            JSON values.
        """
        return {
            "pairs": len({a.pair for a in self.attempts}),
            "pairs_solved_by_all": len(self.common),
            "planners": [_without_nan(asdict(row)) for row in self.standings],
            "attempts": [asdict(attempt) for attempt in self.attempts],
        }


def _without_nan(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_nan(entry) for key, entry in value.items()}
    if isinstance(value, tuple):
        return [_without_nan(entry) for entry in value]
    return None if isinstance(value, float) and np.isnan(value) else value


def _standing(planner: str, attempts: Sequence[BenchmarkAttempt], common: set[NamePair]) -> PlannerSummary:
    answers = [a.answer for a in attempts if a.answer is not None]
    by_pair = [[a for a in attempts if a.pair == pair and a.answer is not None] for pair in sorted(common)]
    bounds = np.array([tries[0].bound for tries in by_pair])

    def medians(field: str) -> Array:
        return np.array([np.median([getattr(a.answer, field) for a in tries]) for tries in by_pair])

    best = np.array([min(a.answer.duration for a in tries if a.answer is not None) for tries in by_pair])
    return PlannerSummary(
        planner,
        len(answers) / max(len(attempts), 1),
        _median_and_p95([answer.planning for answer in answers]),
        _median_and_p95([answer.whole for answer in answers]),
        _mean(medians("found")),
        _mean(medians("length")),
        _mean(medians("duration")),
        _ratio(medians("duration"), bounds),
        _ratio(best, bounds),
        _median_and_worst([answer.cost_bound for answer in answers if answer.cost_bound is not None]),
    )


def _median_and_p95(seconds: Sequence[float]) -> tuple[float, float]:
    if not seconds:
        return float("nan"), float("nan")
    return float(np.median(seconds)), float(np.percentile(seconds, 95))


def _median_and_worst(bounds: Sequence[float]) -> tuple[float, float]:
    return (float(np.median(bounds)), max(bounds)) if bounds else (float("nan"), float("nan"))


def _mean(values: Array) -> float:
    return float(values.mean()) if len(values) else float("nan")


def _ratio(durations: Array, bounds: Array) -> float:
    return float(durations.sum() / bounds.sum()) if len(bounds) else float("nan")
