"""Merging of new polylines into a roadmap, without duplicates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from pickcli.geometry import Array
from pickcli.roadmap.graph import Roadmap

# Euclidean, rad and m: polylines whose ends are within this distance count as joining the same places.
SAME_ENDS_DISTANCE = 0.05


def with_polylines(roadmap: Roadmap, polylines: Sequence[Array]) -> Roadmap:
    """Add proven polylines as edges, except for those that duplicate another edge.

    Their ends become nodes without names, unless nodes with exactly these configurations exist.

    Args:
        roadmap: The roadmap.
        polylines: Each (K, n).

    Returns:
        The larger roadmap.
    """
    stored = [roadmap.edge_path(edge) for edge in range(roadmap.n_edges)]
    fresh = without_doubles(stored, polylines)
    node_of = {q.tobytes(): node for node, q in enumerate(roadmap.configurations)}
    nodes: list[Array] = []
    for q in (polyline[end] for polyline in fresh for end in (0, -1)):
        if q.tobytes() not in node_of:
            node_of[q.tobytes()] = roadmap.n_nodes + len(nodes)
            nodes.append(q)
    if not fresh:
        return roadmap
    edges = [(node_of[p[0].tobytes()], node_of[p[-1].tobytes()], p) for p in fresh]
    return (roadmap.with_nodes(np.stack(nodes)) if nodes else roadmap).with_edges(edges)


def without_doubles(stored: Sequence[Array], polylines: Sequence[Array]) -> list[Array]:
    """Drop polylines whose ends are already joined by another polyline, in either direction.

    Args:
        stored: Existing polylines, each (K, n).
        polylines: New polylines, each (K, n).

    Returns:
        Those of ``polylines`` whose ends no polyline of ``stored``, and none before them, joins.
    """
    every = [*stored, *polylines]
    ends = np.array([polyline[[0, -1]] for polyline in every])  # (M, 2, n)
    counts = np.arange(len(every)) < len(stored)
    fresh = []
    for k in range(len(stored), len(every)):
        there, back = (_distances(ends[:k], ends[k, order]) for order in ([0, 1], [1, 0]))
        leads_nowhere = np.linalg.norm(ends[k, 0] - ends[k, 1]) <= SAME_ENDS_DISTANCE
        is_double = np.any(counts[:k] & (np.minimum(there, back) <= SAME_ENDS_DISTANCE))
        counts[k] = not leads_nowhere and not is_double
        if counts[k]:
            fresh.append(np.asarray(every[k]))
    return fresh


def _distances(ends: Array, pair: Array) -> Array:
    """Return (M,) the larger distance of the ends of each pair (M, 2, n) from those of a pair (2, n)."""
    return np.asarray(np.linalg.norm(ends - pair, axis=2).max(axis=1))
