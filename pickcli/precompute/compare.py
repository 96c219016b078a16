"""A contest of planners over the same pairs: who solves them, how fast, and what the motions are worth.

Delft found no benefit in RRT* over RRT-Connect; this measures it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from pickcli.cell.model import Cell
from pickcli.collision.model import CollisionModel
from pickcli.errors import InputError, UnknownNameError
from pickcli.geometry import Array
from pickcli.precompute.contest import Answer, Contestant, Query
from pickcli.precompute.pairs import delft_pairs
from pickcli.roadmap.database import PayloadClass
from pickcli.seeds import derived_seed

Names = tuple[str, str]


@dataclass(frozen=True)
class Attempt:
    """One try of one planner at one pair; answer: None where it found nothing."""

    planner: str
    pair: Names
    attempt: int
    bound: float  # s, no motion of this pair is shorter
    answer: Answer | None


@dataclass(frozen=True)
class Standing:
    """One planner's figures. Lengths and durations are those of the pairs that all planners solved.

    solved: share of all tries
    planning, whole: s, median and 95th percentile over all solved tries (see ``Answer``)
    found, length, duration: mean over the common pairs of each pair's median try
    ratio: durations over lower bounds, both summed; best_ratio: the same with each pair's best try
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


def blocked_pairs(cell: Cell, payload: PayloadClass) -> list[Names]:
    """Delft's pairs whose ends are free and whose straight line is not: elsewhere no planner is needed."""
    model = CollisionModel(cell)
    pairs = [(key.start, key.goal) for key in delft_pairs(cell, payload)]
    return [pair for pair in pairs if _is_blocked(Query.of(cell, model, pair, payload))]


def compare(
    cell: Cell,
    pairs: Sequence[Names],
    contestants: Sequence[Contestant],
    *,
    payload: PayloadClass = PayloadClass.EMPTY,
    n_tries: int = 3,
    seed: int = 0,
    report: Callable[[int, int, str], None] | None = None,
) -> Comparison:
    """Every planner's tries at every pair; all but the wall-clock times follows from the seed.

    report: called with (done, total, what comes next)
    Raises UnknownNameError for a name that is no configuration, InputError if an end of a pair is not free.
    """
    model, attempts = CollisionModel(cell), list[Attempt]()
    queries = {pair: _checked(cell, model, pair, payload) for pair in pairs}
    total = len(pairs) * len(contestants) * n_tries
    for pair, query in queries.items():
        for contestant in contestants:
            for attempt in range(n_tries):
                if report is not None:
                    report(len(attempts), total, f"{contestant.name}, {' to '.join(pair)}")
                own = derived_seed(seed, "contest", *pair, payload, attempt)
                answer = contestant.answer(query, own)
                attempts.append(Attempt(contestant.name, pair, attempt, query.bound, answer))
    return Comparison(tuple(attempts))


@dataclass(frozen=True)
class Comparison:
    """All tries, and the table that follows from them."""

    attempts: tuple[Attempt, ...]

    @property
    def planners(self) -> list[str]:
        """Names, in the order in which they started."""
        return list(dict.fromkeys(a.planner for a in self.attempts))

    @property
    def common(self) -> set[Names]:
        """Pairs that every planner solved at least once."""
        solved = {(a.planner, a.pair) for a in self.attempts if a.answer is not None}
        pairs = {a.pair for a in self.attempts}
        return {pair for pair in pairs if all((planner, pair) in solved for planner in self.planners)}

    @property
    def standings(self) -> list[Standing]:
        """The table: a row per planner."""
        tries = {name: [a for a in self.attempts if a.planner == name] for name in self.planners}
        return [_standing(name, tries[name], self.common) for name in self.planners]

    def values(self) -> dict[str, Any]:
        """Table and tries as JSON values; null where nothing was solved."""
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


def _standing(planner: str, attempts: Sequence[Attempt], common: set[Names]) -> Standing:
    answers = [a.answer for a in attempts if a.answer is not None]
    by_pair = [[a for a in attempts if a.pair == pair and a.answer is not None] for pair in sorted(common)]
    bounds = np.array([tries[0].bound for tries in by_pair])

    def medians(field: str) -> Array:
        return np.array([np.median([getattr(a.answer, field) for a in tries]) for tries in by_pair])

    best = np.array([min(a.answer.duration for a in tries if a.answer is not None) for tries in by_pair])
    return Standing(
        planner,
        len(answers) / max(len(attempts), 1),
        _median_and_p95([answer.planning for answer in answers]),
        _median_and_p95([answer.whole for answer in answers]),
        _mean(medians("found")),
        _mean(medians("length")),
        _mean(medians("duration")),
        _ratio(medians("duration"), bounds),
        _ratio(best, bounds),
    )


def _median_and_p95(seconds: Sequence[float]) -> tuple[float, float]:
    if not seconds:
        return float("nan"), float("nan")
    return float(np.median(seconds)), float(np.percentile(seconds, 95))


def _mean(values: Array) -> float:
    return float(values.mean()) if len(values) else float("nan")


def _ratio(durations: Array, bounds: Array) -> float:
    return float(durations.sum() / bounds.sum()) if len(bounds) else float("nan")


def _is_blocked(query: Query) -> bool:
    tests, (q0, q1) = query.planning, query.ends
    return tests.is_free(q0) and tests.is_free(q1) and not tests.edge_is_free(q0, q1)


def _checked(cell: Cell, model: CollisionModel, pair: Names, payload: PayloadClass) -> Query:
    for name in pair:
        if name not in cell.configurations:
            raise UnknownNameError("configuration", name, list(cell.configurations), str(cell.path))
    query = Query.of(cell, model, pair, payload)
    for name, q in zip(pair, query.ends, strict=True):
        if not query.planning.is_free(q):
            raise InputError(f"{name} is not free: {query.planning.explain(q)}; leave this pair out")
    return query
