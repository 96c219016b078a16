"""Benchmark of planners on the same pairs: success, planning time, and quality of the motions.

Delft found no benefit in RRT* over RRT-Connect; this measures it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pickcli.cell.cell import Cell
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import InputError, UnknownNameError
from pickcli.planner_benchmark.benchmark_entries import BenchmarkEntry, BenchmarkQuery
from pickcli.planner_benchmark.benchmark_summary import BenchmarkAttempt, NamePair, PlannerComparison
from pickcli.precompute.motion_pairs import delft_pairs
from pickcli.progress import Progress, ProgressObserver, nobody
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.seeds import derived_seed


def blocked_pairs(cell: Cell, payload: PayloadClass) -> list[NamePair]:
    """Return Delft's pairs whose ends are free and whose straight line is blocked: only these need a planner.

    Args:
        cell: The cell.
        payload: Payload class in the cup.

    Returns:
        Names of start and goal of each pair.
    """
    model = CollisionModel(cell)
    pairs = [(key.start, key.goal) for key in delft_pairs(cell, payload)]
    return [pair for pair in pairs if _is_blocked(BenchmarkQuery.of(cell, model, pair, payload))]


def compare(
    cell: Cell,
    pairs: Sequence[NamePair],
    contestants: Sequence[BenchmarkEntry],
    *,
    payload: PayloadClass = PayloadClass.EMPTY,
    n_tries: int = 3,
    seed: int = 0,
    on_progress: ProgressObserver = nobody,
) -> PlannerComparison:
    """Run every planner on every pair; all results except wall-clock times are determined by the seed.

    Args:
        cell: The cell, without items.
        pairs: Names of start and goal.
        contestants: The planners.
        payload: Payload class in the cup.
        n_tries: Attempts at each pair.
        seed: Seed of all random choices.
        on_progress: Observer of the progress, called for each attempt.

    Returns:
        All attempts, and their summary.

    Raises:
        UnknownNameError: If the cell has no configuration of a name.
        InputError: If the ends of a pair are the same or not free.
    """
    queries = pair_queries(cell, pairs, payload)
    return compare_queries(
        queries, contestants, label=payload, n_tries=n_tries, seed=seed, on_progress=on_progress
    )


def pair_queries(
    cell: Cell, pairs: Sequence[NamePair], payload: PayloadClass = PayloadClass.EMPTY
) -> dict[NamePair, BenchmarkQuery]:
    """Make the queries between named configurations.

    Args:
        cell: The cell, without items.
        pairs: Names of start and goal.
        payload: Payload class in the cup.

    Returns:
        The queries by the names of their ends.

    Raises:
        UnknownNameError: If the cell has no configuration of a name.
        InputError: If the ends of a pair are the same or not free.
    """
    model = CollisionModel(cell)
    return {pair: _checked(cell, model, pair, payload) for pair in pairs}


def compare_queries(
    queries: Mapping[NamePair, BenchmarkQuery],
    contestants: Sequence[BenchmarkEntry],
    *,
    label: str,
    n_tries: int = 3,
    seed: int = 0,
    on_progress: ProgressObserver = nobody,
) -> PlannerComparison:
    """Run every planner on every query (see ``compare``).

    Args:
        queries: The queries by the names of their ends.
        contestants: The planners.
        label: Which queries these are; seeds of attempts depend on it.
        n_tries: Attempts at each query.
        seed: Seed of all random choices.
        on_progress: Observer of the progress, called for each attempt.

    Returns:
        All attempts, and their summary.
    """
    attempts = list[BenchmarkAttempt]()
    total = len(queries) * len(contestants) * n_tries
    for pair, query in queries.items():
        for contestant in contestants:
            for attempt in range(n_tries):
                on_progress(Progress(len(attempts), total, f"{contestant.name}, {' to '.join(pair)}"))
                own = derived_seed(seed, "contest", *pair, label, attempt)
                answer = contestant.answer(query, own)
                attempts.append(BenchmarkAttempt(contestant.name, pair, attempt, query.bound, answer))
    return PlannerComparison(tuple(attempts))


def _is_blocked(query: BenchmarkQuery) -> bool:
    checker, q0, q1 = query.planning, query.start, query.goals[0]
    return checker.is_valid(q0) and checker.is_valid(q1) and not checker.is_valid_edge(q0, q1)


def _checked(cell: Cell, model: CollisionModel, pair: NamePair, payload: PayloadClass) -> BenchmarkQuery:
    for name in pair:
        if name not in cell.configurations:
            raise UnknownNameError("configuration", name, list(cell.configurations), str(cell.path))
    if pair[0] == pair[1]:
        raise InputError(f"{':'.join(pair)} is no motion; name two different configurations")
    query = BenchmarkQuery.of(cell, model, pair, payload)
    for name, q in zip(pair, (query.start, query.goals[0]), strict=True):
        if not query.planning.is_valid(q):
            raise InputError(f"{name} is not free: {query.planning.explain(q)}; leave this pair out")
    return query
