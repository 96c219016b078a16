"""Second routes: edges are added until critical pairs have a route that shares no edge with the first.

A single RRT* is a tree: one blocked edge disconnects it. Joining the k nearest is better, but no guarantee.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from pickcli.cell.pod_tolerance import PodPoses
from pickcli.errors import Reason
from pickcli.precompute.critical_pairs import NamePair
from pickcli.roadmap.edge_disjoint import EdgeDisjoint, crossing
from pickcli.roadmap.graph import Roadmap

NodePair = tuple[int, int]  # indices of two nodes

# Failures across one cut after which no more edges are tried: by then the node is probably walled in, and
# each try costs a whole run of the planner.
MOST_TRIES = 24


@dataclass(frozen=True)
class RouteRedundancy:
    """Second routes of the critical pairs.

    Attributes:
        detours: Pairs with a second route, and its length over that of the first.
        without_second_route: Pairs without one, and why.
        added: Edges that were added for second routes.
        n_for_any_pod: Number of pairs with a second route for all pod poses.
    """

    detours: tuple[tuple[NamePair, float], ...] = ()
    without_second_route: tuple[tuple[NamePair, Reason], ...] = ()
    added: tuple[NamePair, ...] = ()
    n_for_any_pod: int = 0

    def summary(self) -> dict[str, Any]:
        """Summarise the routes.

        Returns:
            The figures as JSON values.
        """
        (a, b), worst = max(self.detours, key=lambda entry: entry[1], default=(("", ""), 0.0))
        median = float(np.median([ratio for _, ratio in self.detours])) if self.detours else None
        return {
            "n_important": len(self.detours) + len(self.without_second_route),
            "n_with_second_route": len(self.detours),
            "n_for_any_displaced_pod": self.n_for_any_pod,
            "second_over_first_length": None
            if median is None
            else {"median": round(median, 3), "worst": round(worst, 3), "worst_pair": f"{a} to {b}"},
            "added": [f"{a} to {b}" for a, b in self.added],
        }


def edge_to_try(roadmap: Roadmap, side: frozenset[int], failed: Collection[NodePair]) -> NodePair | None:
    """Choose the nearest two nodes on the two sides of a cut that could still be joined.

    Args:
        roadmap: The roadmap so far.
        side: Nodes on one side of the cut.
        failed: Pairs that have no path.

    Returns:
        Indices (i < j), None if too many pairs failed or none is left.
    """
    if len(_across(side, failed)) >= MOST_TRIES:
        return None
    q, known = roadmap.configurations, {*failed, *((min(e), max(e)) for e in roadmap.edges.tolist())}
    pairs = {(min(i, j), max(i, j)) for i in side for j in range(len(q)) if j not in side} - known
    return min(pairs, key=lambda p: (float(np.linalg.norm(q[p[0]] - q[p[1]])), p), default=None)


def missing_redundancy(roadmap: Roadmap, found: EdgeDisjoint, failed: Mapping[NodePair, Reason]) -> Reason:
    """Explain why two nodes have fewer than two routes: the edge that all need, and what else was tried.

    Args:
        roadmap: The roadmap.
        found: The existing routes, and the cut.
        failed: Pairs that have no path, and why.

    Returns:
        The reason.
    """
    needed = [_named(roadmap, roadmap.edges[edge].tolist()) for edge in crossing(roadmap, found.side)]
    what = f"one route only: all need the edge {needed[0]}" if needed else "no route"
    tried = _across(found.side, failed)
    if not tried:
        return Reason(what, detail="no other pair is left that could lead round it")
    example = f"{_named(roadmap, tried[0])}: {failed[tried[0]]}"
    return Reason(what, detail=f"{len(tried)} pairs beside it were tried, none has a path, e.g. {example}")


def for_any_pod(roadmap: Roadmap) -> Roadmap:
    """Drop the edges that are not proven for all pod poses.

    Args:
        roadmap: The roadmap.

    Returns:
        The same nodes with the remaining edges.
    """
    kept = [m for m, validity in enumerate(roadmap.validities) if validity.pod_poses is PodPoses.DISPLACED]
    part = replace(
        roadmap, edges=roadmap.edges[:0], lengths=roadmap.lengths[:0], waypoints=roadmap.waypoints[:0],
        offsets=roadmap.offsets[:1], validities=(),
    )  # fmt: skip
    edges = [(*roadmap.edges[m].tolist(), roadmap.edge_path(m)) for m in kept]
    validities = tuple(roadmap.validities[m] for m in kept)
    return replace(part.with_edges(edges), validities=validities) if edges else part


def detour(found: EdgeDisjoint) -> float:
    """Return the ratio of the two routes of a pair.

    Args:
        found: Two routes.

    Returns:
        Length of the second over that of the first.
    """
    first, second = (route.cost for route in found.routes)
    return second / first


def _across(side: frozenset[int], pairs: Iterable[NodePair]) -> list[NodePair]:
    return [pair for pair in pairs if (pair[0] in side) != (pair[1] in side)]


def _named(roadmap: Roadmap, pair: Sequence[int]) -> str:
    return " to ".join(roadmap.names[node] for node in pair)
