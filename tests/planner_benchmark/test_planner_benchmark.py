"""The contest of planners: what is counted, and that nothing but the clock differs from run to run."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import InputError, UnknownNameError
from pickcli.path_planning.planner_names import PlannerName
from pickcli.path_planning.planner_options import PlannerOptions
from pickcli.path_planning.sampling_planner import plan
from pickcli.path_planning.shortcutting import shorten
from pickcli.planner_benchmark.benchmark_entries import (
    BenchmarkEntry,
    BenchmarkQuery,
    GeometricEntry,
    MinimumTimeEntry,
    PlannerRun,
)
from pickcli.planner_benchmark.benchmark_summary import BenchmarkAttempt, PlannerComparison
from pickcli.planner_benchmark.planner_benchmark import blocked_pairs, compare
from pickcli.progress import Progress
from pickcli.roadmap.trajectory_database import PayloadClass
from support.edge_costs import edge_costs
from support.small_cell import LEAST_EFFORT, small_cell

BLOCKED = ("cam_D", "cam_L")
ALL: list[BenchmarkEntry] = [
    *(
        GeometricEntry(p, 400)
        for p in (PlannerName.RRT_CONNECT, PlannerName.RRT_STAR, PlannerName.AO_RRT_CONNECT)
    ),
    MinimumTimeEntry(LEAST_EFFORT),
]


def test_no_answer_is_faster_than_its_bound() -> None:
    done = compare(small_cell(*BLOCKED), [BLOCKED], ALL, n_tries=2)
    assert len(done.attempts) == 2 * len(ALL)
    answers = [(a.bound, a.answer) for a in done.attempts if a.answer is not None]
    assert len(answers) >= 6
    for bound, answer in answers:
        assert answer.duration >= bound > 0.0
        assert 0.0 < answer.planning <= answer.whole


@pytest.mark.parametrize("name", [PlannerName.RRT_CONNECT, PlannerName.AO_RRT_CONNECT])
def test_lengths_are_those_of_the_path_as_found_and_of_one_that_costs_no_more(name: PlannerName) -> None:
    cell = small_cell(*BLOCKED)
    query = BenchmarkQuery.of(cell, CollisionModel(cell), BLOCKED, PayloadClass.EMPTY)
    tests, joints, start, goals = query.planning, query.space, query.start, query.goals
    found = plan(tests, joints, start, goals, seed=1, options=PlannerOptions(name, 400))
    assert found is not None
    short = shorten(tests, joints, found, seed=1, iterations=100)
    answer = GeometricEntry(name, 400, 100).answer(query, 1)
    assert answer is not None and (answer.found, answer.length) == (found.length, short.length)
    costs = [edge_costs(joints, path.waypoints).sum() for path in (short, found)]
    assert costs[0] <= costs[1] + 1e-12


def test_all_but_the_clock_follows_from_the_seed() -> None:
    def told(seed: int) -> list[tuple[object, ...]]:
        done = compare(small_cell(*BLOCKED), [BLOCKED], ALL[:2], n_tries=2, seed=seed)
        return [(a.planner, a.answer and replace(a.answer, planning=0.0, whole=0.0)) for a in done.attempts]

    assert told(1) == told(1)
    assert told(1) != told(2)


def test_where_the_line_is_free_every_geometric_planner_takes_it() -> None:
    cell = small_cell("home", "bin_A")
    done = compare(cell, [("home", "bin_A")], ALL[:3], n_tries=1)
    straight = np.linalg.norm(cell.configurations["home"].q - cell.configurations["bin_A"].q)
    lengths = [a.answer.found for a in done.attempts if a.answer is not None]
    assert lengths == pytest.approx([straight] * 3)


def test_pairs_by_default_are_delfts_whose_ends_are_free_and_whose_line_is_not() -> None:
    cell = small_cell("home", "cam_D", "cam_L", "tote", "tote_10h")
    assert blocked_pairs(cell, PayloadClass.EMPTY) == [BLOCKED]


def test_names_that_are_none_and_ends_that_are_not_free_are_refused() -> None:
    with pytest.raises(UnknownNameError, match="unknown configuration 'bin_Z'"):
        compare(small_cell(), [("bin_A", "bin_Z")], ALL)
    with pytest.raises(InputError, match=r"tote_10h is not free: collision.*leave this pair out"):
        compare(small_cell(), [("bin_A", "tote_10h")], ALL)


def test_progress_is_told_before_each_try() -> None:
    told: list[Progress] = []
    compare(small_cell("home", "bin_A"), [("home", "bin_A")], [_Fake()], n_tries=2,
            on_progress=told.append)  # fmt: skip
    assert told == [Progress(n, 2, "fake, home to bin_A") for n in (0, 1)]


def test_the_table_compares_pairs_that_all_solved() -> None:
    done = PlannerComparison((
        _attempt("quick", "ab", 0, 2.0), _attempt("quick", "ab", 1, 4.0), _attempt("quick", "bc", 0, 9.0),
        _attempt("slow", "ab", 0, 1.0), _attempt("slow", "ab", 1, None), _attempt("slow", "bc", 0, None),
    ))  # fmt: skip
    quick, slow = done.standings
    assert done.common == {("a", "b")}
    assert (quick.planner, quick.solved, quick.duration, quick.ratio) == ("quick", 1.0, 3.0, 3.0)
    assert quick.best_ratio == 2.0
    assert (slow.planner, slow.duration, slow.ratio) == ("slow", 1.0, 1.0)
    assert slow.solved == pytest.approx(1 / 3)


def test_a_planner_that_solves_nothing_is_told_without_numbers() -> None:
    values = PlannerComparison((_attempt("never", "ab", 0, None),)).values()
    (row,) = values["planners"]
    assert row["solved"] == 0.0 and row["duration"] is None and row["planning"] == [None, None]
    assert values["attempts"][0]["answer"] is None


@dataclass(frozen=True)
class _Fake:
    name: ClassVar[str] = "fake"

    def answer(self, query: BenchmarkQuery, seed: int) -> PlannerRun | None:
        return None


def _attempt(planner: str, pair: str, attempt: int, duration: float | None) -> BenchmarkAttempt:
    answer = None if duration is None else PlannerRun(0.1, 0.2, 5.0, 4.0, duration)
    return BenchmarkAttempt(planner, (pair[0], pair[1]), attempt, 1.0, answer)
