"""ARA*: anytime search with a proven bound on the cost (Likhachev, Gordon and Thrun, NIPS 2003).

A* with its heuristic inflated by epsilon finds a path soon, which costs at most epsilon times the least.
ARA* then lowers epsilon and repairs the search: states keep their costs, and only those that became cheaper
since they were expanded are expanded again.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import pairwise, repeat
from typing import Protocol

import numpy as np

from pickcli.errors import InputError

# Values of epsilon, one search each, the last one repeated for what rounding left. The first is large:
# a first path matters more than its cost.
DEFLATION = (20.0, 8.0, 4.0, 2.5, 1.8, 1.4, 1.2, 1.1, 1.0)


class SearchGraph(Protocol):
    """A graph with numbered nodes, which may be made as they are reached."""

    start: int
    goal: int

    def successors(self, node: int) -> Sequence[tuple[int, float]]:
        """Return the edges out of a node; the same whenever it is asked.

        Args:
            node: The node.

        Returns:
            The node at the end of each edge, and its cost, not negative.
        """

    def heuristic(self, node: int) -> float:
        """Return a lower bound on the cost from a node to the goal.

        It must be consistent: at most the cost of any edge out of the node plus the bound at its end, and 0
        at the goal.

        Args:
            node: The node.

        Returns:
            The bound.
        """


@dataclass(frozen=True)
class AraStarSettings:
    """Effort of the search: counts, never times.

    Attributes:
        deflation: Values of epsilon, falling, at least 1.
        max_expansions: Most expansions of all searches together.
    """

    deflation: tuple[float, ...] = DEFLATION
    max_expansions: int = 2000

    def __post_init__(self) -> None:
        """Refuse values of epsilon by which the search bounds nothing, or does not get better."""
        falls = all(a > b for a, b in pairwise(self.deflation))
        if not self.deflation or not falls or not all(1.0 <= e < np.inf for e in self.deflation):
            raise InputError(f"deflation {self.deflation}: give values of epsilon that fall, none below 1")
        if self.max_expansions < 1:
            raise InputError(f"max_expansions {self.max_expansions}: at least 1")


@dataclass(frozen=True)
class AraStarPath:
    """A path, as it was known after one of the searches.

    Attributes:
        nodes: From the start to the goal.
        cost: Sum of the costs of its edges.
        epsilon: Inflation of the heuristic in that search.
        lower_bound: Proven: no path of the graph costs less.
        n_expanded: Expansions until then.
    """

    nodes: tuple[int, ...]
    cost: float
    epsilon: float
    lower_bound: float
    n_expanded: int

    @property
    def cost_bound(self) -> float:
        """The proven bound on the cost: at most this times the least, 1 where the path is proven the best."""
        return 1.0 if self.cost <= self.lower_bound else self.cost / self.lower_bound


@dataclass(frozen=True)
class AraStarResult:
    """What the searches found.

    Attributes:
        paths: One after each search that expanded anything and ended with a path, the last one the best.
        n_expanded: Expansions of all searches.
        ran_out: Whether the expansions ran out before the last search ended.
    """

    paths: tuple[AraStarPath, ...]
    n_expanded: int
    ran_out: bool

    @property
    def best(self) -> AraStarPath | None:
        """The best path, None if none was found."""
        return self.paths[-1] if self.paths else None


def ara_star(graph: SearchGraph, settings: AraStarSettings | None = None) -> AraStarResult:
    """Search a graph, first greedily, then for better paths until the cost is proven least.

    Args:
        graph: The graph.
        settings: The effort.

    Returns:
        The paths found. If the expansions run out during a search, its path so far is the last one, with the
        bound that holds for it. If they do not, and epsilon falls to 1, the last path is proven the best.
    """
    search = _Search(graph, settings or AraStarSettings())
    paths = tuple(search.run())
    return AraStarResult(paths, search.n_expanded, search.ran_out)


class _Search:
    """The state of the searches: costs ``g``, the frontier ``open``, and what waits for the next search.

    A state is inconsistent if it became cheaper since it was expanded; all such are in ``open`` or, expanded
    in this search already, in ``waiting`` (INCONS in the paper).
    """

    def __init__(self, graph: SearchGraph, settings: AraStarSettings) -> None:
        self.graph, self.settings = graph, settings
        self.g = {graph.start: 0.0}
        self.parent: dict[int, tuple[int, float]] = {}  # and the cost of the edge from it
        self.open: dict[int, float] = {}  # priorities
        self.waiting: set[int] = set()
        self.closed: set[int] = set()
        self.queue: list[tuple[float, int]] = []  # of open, with entries that are out of date
        self.n_expanded, self.ran_out = 0, False

    def run(self) -> Iterator[AraStarPath]:
        self.waiting.add(self.graph.start)
        n_before = 0
        for epsilon in self._inflations():
            self._begin(epsilon)
            self._improve(epsilon)
            is_best = False
            if (path := self._path(epsilon)) is not None:
                if self.n_expanded > n_before:
                    yield path
                is_best = path.cost_bound == 1.0
            has_settled = epsilon == 1.0 and self.n_expanded == n_before
            if self.ran_out or is_best or has_settled or not (self.open or self.waiting):
                return
            n_before = self.n_expanded

    def _inflations(self) -> Iterator[float]:
        """Yield the values of epsilon, the last one again and again if it is 1.

        Without inflation a state that was expanded never becomes cheaper, but for the rounding of sums: of
        ways of one length one may be less by the last digit. Such states wait, below the cost of the goal.
        """
        yield from self.settings.deflation
        if self.settings.deflation[-1] == 1.0:
            yield from repeat(1.0)

    def _begin(self, epsilon: float) -> None:
        """Take up all inconsistent states at a value of epsilon."""
        inconsistent = sorted({*self.open, *self.waiting})
        self.open, self.queue = {}, []
        self.waiting, self.closed = set(), set()
        for node in inconsistent:
            self._push(node, epsilon)

    def _push(self, node: int, epsilon: float) -> None:
        priority = self.g[node] + epsilon * self.graph.heuristic(node)
        if priority == np.inf:
            return  # no way to the goal
        self.open[node] = priority
        heappush(self.queue, (priority, node))

    def _improve(self, epsilon: float) -> None:
        """Expand until the path to the goal costs at most epsilon times the least, or expansions run out."""
        goal = self.graph.goal
        while self.queue:
            priority, node = self.queue[0]
            if self.open.get(node) != priority:
                heappop(self.queue)
                continue
            if self.g.get(goal, np.inf) <= priority:
                return
            if self.n_expanded >= self.settings.max_expansions:
                self.ran_out = True
                return
            heappop(self.queue)
            del self.open[node]
            self.closed.add(node)
            self.n_expanded += 1
            self._expand(node, epsilon)

    def _expand(self, node: int, epsilon: float) -> None:
        here = self.g[node]
        for after, cost in self.graph.successors(node):
            if here + cost >= self.g.get(after, np.inf):
                continue
            self.g[after], self.parent[after] = here + cost, (node, cost)
            if after in self.closed:
                self.waiting.add(after)
            else:
                self._push(after, epsilon)

    def _path(self, epsilon: float) -> AraStarPath | None:
        goal = self.graph.goal
        if goal not in self.g:
            return None
        # The first inconsistent state on a best path has its least cost already (consistent heuristic).
        ahead = (self.g[node] + self.graph.heuristic(node) for node in {*self.open, *self.waiting})
        bound = min(min(ahead, default=np.inf), self.g[goal])
        nodes, steps = [goal], list[float]()
        while nodes[-1] != self.graph.start:
            before, cost = self.parent[nodes[-1]]
            nodes.append(before)
            steps.append(cost)
        # Costs of states on the path may have become less since the goal's was computed. The built-in sum
        # makes up for rounding, and could be more than the goal's cost by the last digit.
        total = 0.0
        for step in reversed(steps):
            total += step
        return AraStarPath(tuple(reversed(nodes)), total, epsilon, bound, self.n_expanded)
