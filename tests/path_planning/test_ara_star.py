"""ARA*: the bound on the cost holds after every search, against Dijkstra; the last search finds the best."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from heapq import heappop, heappush
from itertools import pairwise, repeat
from math import fsum

import numpy as np
import pytest

import pickcli.path_planning.ara_star as ara_star_module
from pickcli.errors import InputError
from pickcli.path_planning.ara_star import AraStarSettings, SearchGraph, ara_star


@dataclass
class _Random:
    """A graph with random edges, and a consistent heuristic: a share of the true cost to the goal."""

    seed: int
    n: int = 60
    share: float = 0.7
    start: int = 0
    goal: int = 1
    asked: list[int] = field(default_factory=list)

    @cached_property
    def edges(self) -> list[list[tuple[int, float]]]:
        rng = np.random.default_rng(self.seed)
        ends, costs = rng.integers(self.n, size=(self.n, 3)), rng.uniform(0.1, 1.0, (self.n, 3))
        return [
            [(int(end), float(cost)) for end, cost in zip(*row, strict=True)]
            for row in zip(ends, costs, strict=True)
        ]

    @cached_property
    def to_go(self) -> list[float]:
        back: list[list[tuple[int, float]]] = [[] for _ in range(self.n)]
        for node, out in enumerate(self.edges):
            for end, cost in out:
                back[end].append((node, cost))
        return _dijkstra(lambda node: back[node], self.goal, self.n)

    def successors(self, node: int) -> list[tuple[int, float]]:
        self.asked.append(node)
        return self.edges[node]

    def heuristic(self, node: int) -> float:
        return self.share * self.to_go[node] if self.share > 0.0 else 0.0


def _dijkstra(successors, start: int, n: int) -> list[float]:  # type: ignore[no-untyped-def]
    costs, queue = [np.inf] * n, [(0.0, start)]
    costs[start] = 0.0
    while queue:
        cost, node = heappop(queue)
        for end, more in successors(node) if cost == costs[node] else ():
            if cost + more < costs[end]:
                costs[end] = cost + more
                heappush(queue, (cost + more, end))
    return costs


def _graphs() -> list[_Random]:
    return [_Random(seed, share=share) for seed in range(40) for share in (0.0, 0.7, 1.0)]


def test_there_are_graphs_with_a_path_and_without() -> None:
    has_path = [graph.to_go[0] < np.inf for graph in _graphs()]
    assert 60 < sum(has_path) < len(has_path)


def test_the_last_search_finds_what_dijkstra_finds() -> None:
    for graph in _graphs():
        result, least = ara_star(graph), graph.to_go[0]
        if least == np.inf:
            assert result.best is None
            continue
        assert result.best is not None
        assert result.best.cost == pytest.approx(least) and result.best.cost_bound == 1.0


def test_every_path_keeps_its_epsilon_and_its_bound() -> None:
    n_worse = 0
    for graph in _graphs():
        least = graph.to_go[0]
        for path in ara_star(graph).paths:
            n_worse += path.cost > least + 1e-9
            assert path.cost <= path.epsilon * least + 1e-9
            assert path.lower_bound <= least + 1e-9
            assert path.cost <= path.cost_bound * least + 1e-9
    assert n_worse > 10  # else the first search would be as good as the last


def test_bounds_hold_wherever_the_expansions_end() -> None:
    n_early = 0
    for graph in _graphs()[1::3]:
        for most in range(1, 40):
            result = ara_star(graph, AraStarSettings(max_expansions=most))
            assert result.n_expanded <= most
            if result.best is not None:
                n_early += result.best.cost_bound > 1.0
                assert result.best.lower_bound <= graph.to_go[0] + 1e-9
    assert n_early > 10


def test_costs_and_bounds_only_get_better_and_are_those_of_the_path() -> None:
    for graph in _graphs():
        paths = ara_star(graph).paths
        costs, bounds = [path.cost for path in paths], [path.lower_bound for path in paths]
        assert costs == sorted(costs, reverse=True)
        assert all(b >= a - 1e-9 for a, b in pairwise(bounds))
        for path in paths:
            assert (path.nodes[0], path.nodes[-1]) == (graph.start, graph.goal)
            steps = pairwise(path.nodes)
            along = [min(cost for end, cost in graph.edges[a] if end == b) for a, b in steps]
            assert path.cost == pytest.approx(sum(along))


def test_a_search_is_repaired_and_not_begun_again() -> None:
    n_repaired = n_anew = 0
    for graph in _graphs()[1::3]:
        n_repaired += ara_star(graph).n_expanded
        for epsilon in AraStarSettings().deflation:
            n_anew += ara_star(graph, AraStarSettings((epsilon,))).n_expanded
    assert n_repaired < 0.7 * n_anew


def test_the_start_may_be_next_to_the_goal() -> None:
    @dataclass
    class Two:
        start: int = 0
        goal: int = 1

        def successors(self, node: int) -> list[tuple[int, float]]:
            return [(1, 0.0)] if node == 0 else []

        def heuristic(self, node: int) -> float:
            return 0.0

    graph: SearchGraph = Two()
    best = ara_star(graph).best
    assert best is not None and (best.nodes, best.cost, best.cost_bound) == ((0, 1), 0.0, 1.0)


@dataclass
class _Grid:
    """Steps of 0.06 in eight directions: many ways have one length, but for the rounding of their sums."""

    seed: int
    n: int = 9
    start: int = 0
    goal: int = 80

    @cached_property
    def is_free(self) -> list[bool]:
        free = np.random.default_rng(self.seed).random(self.n * self.n) > 0.25
        free[[self.start, self.goal]] = True
        return [bool(each) for each in free]

    def successors(self, node: int) -> list[tuple[int, float]]:
        x, y = divmod(node, self.n)
        steps = ((i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j)
        ends = ((x + i, y + j, 0.06 * float(np.hypot(i, j))) for i, j in steps)
        inside = ((a * self.n + b, cost) for a, b, cost in ends if 0 <= a < self.n and 0 <= b < self.n)
        return [(end, cost) for end, cost in inside if self.is_free[end]]

    def heuristic(self, node: int) -> float:
        x, y = (self.n - 1 - k for k in divmod(node, self.n))
        return 0.06 * (abs(x - y) + float(np.sqrt(2.0)) * min(x, y))


def test_with_expansions_left_the_bound_is_1_whatever_the_rounding() -> None:
    n_solved = 0
    for graph in map(_Grid, range(60)):
        result = ara_star(graph)
        assert not result.ran_out
        least = _dijkstra(graph.successors, graph.start, graph.n**2)[graph.goal]
        if result.best is None:
            assert least == np.inf
            continue
        n_solved += 1
        assert result.best.cost == pytest.approx(least, abs=1e-12) and result.best.cost_bound == 1.0
    assert n_solved > 30


def test_a_sum_that_makes_up_for_rounding_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """As the built-in sum does since Python 3.12; by it a path could cost more than its own bound."""
    before = [ara_star(graph).paths for graph in map(_Grid, range(60))]
    monkeypatch.setattr(ara_star_module, "sum", fsum, raising=False)
    monkeypatch.setattr(ara_star_module, "repeat", lambda epsilon: repeat(epsilon, 20))  # it is to end anyway
    for graph, paths in zip(map(_Grid, range(60)), before, strict=True):
        result = ara_star(graph)
        assert result.paths == paths
        assert result.best is None or result.best.cost_bound == 1.0


def test_a_search_says_whether_its_expansions_ran_out() -> None:
    graph = _Grid(0)
    assert ara_star(graph, AraStarSettings(max_expansions=3)).ran_out
    assert not ara_star(graph, AraStarSettings((3.0,))).ran_out


@pytest.mark.parametrize(
    ("deflation", "most", "message"),
    [
        ((), 10, "values of epsilon"),
        ((1.0, 2.0), 10, "that fall"),
        ((2.0, 0.5), 10, "none below 1"),
        ((float("nan"),), 10, "values of epsilon"),
        ((2.0,), 0, "max_expansions 0"),
    ],
)
def test_effort_without_sense_is_refused(deflation: tuple[float, ...], most: int, message: str) -> None:
    with pytest.raises(InputError, match=message):
        AraStarSettings(deflation, most)
