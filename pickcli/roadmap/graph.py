"""The roadmap: configurations, and proven paths between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.pod_tolerance import NOMINAL_POD, PodValidity
from pickcli.cell.tool import MOVING, ToolState
from pickcli.geometry import Array
from pickcli.motion.path import JointPath

IntArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Roadmap:
    """An undirected graph after KTH (section IV): each edge carries its own polyline.

    The polylines lie one after the other in ``waypoints``; edge m owns rows offsets[m]:offsets[m + 1],
    its ends included, from node edges[m, 0] to node edges[m, 1].
    """

    joint_names: tuple[str, ...]
    configurations: Array  # (N, n)
    names: tuple[str, ...]  # (N,), "" for a node without a name
    tool_states: tuple[ToolState, ...]  # (N,), the state that the node is meant for
    edges: IntArray  # (M, 2)
    lengths: Array  # (M,), Euclidean length of the polyline (mixed m and rad), the cost
    waypoints: Array  # (W, n)
    offsets: IntArray  # (M + 1,)
    proven_for: ToolState = MOVING  # the state in which every edge was proven when it was made
    marks: tuple[PodValidity, ...] = ()  # (M,), for which pods each edge was proven

    @classmethod
    def empty(cls, joint_names: tuple[str, ...], proven_for: ToolState = MOVING) -> Roadmap:
        """A roadmap without nodes."""
        n = len(joint_names)
        return cls(
            joint_names, np.zeros((0, n)), (), (), np.zeros((0, 2), np.int64), np.zeros(0),
            np.zeros((0, n)), np.zeros(1, np.int64), proven_for,
        )  # fmt: skip

    @property
    def n_nodes(self) -> int:
        """Number of nodes."""
        return len(self.configurations)

    @property
    def n_edges(self) -> int:
        """Number of edges."""
        return len(self.edges)

    @cached_property
    def neighbours(self) -> tuple[tuple[tuple[int, int], ...], ...]:
        """For each node its (edge, other node), in order of the edges."""
        lists: list[list[tuple[int, int]]] = [[] for _ in range(self.n_nodes)]
        for m, (a, b) in enumerate(self.edges.tolist()):
            lists[a].append((m, b))
            lists[b].append((m, a))
        return tuple(tuple(entries) for entries in lists)

    def edge_path(self, edge: int, start: int | None = None) -> Array:
        """Polyline (K, n) of an edge, as stored or, with ``start`` (one of its ends), leaving that node."""
        path = self.waypoints[self.offsets[edge] : self.offsets[edge + 1]]
        return path[::-1] if start is not None and start == self.edges[edge, 1] else path

    def index(self, name: str) -> int | None:
        """The node of that name, or None."""
        return self.names.index(name) if name and name in self.names else None

    def nearest(self, q: Array, k: int) -> list[int]:
        """The k nodes nearest to q (n,) by Euclidean distance, nearest first; ties by index."""
        distances = np.linalg.norm(self.configurations - q, axis=1)
        return [int(i) for i in np.argsort(distances, kind="stable")[:k]]

    def with_nodes(self, Q: Array) -> Roadmap:
        """A roadmap with more nodes (K, n), without names."""
        return replace(
            self,
            configurations=np.vstack([self.configurations, Q]),
            names=(*self.names, *[""] * len(Q)),
            tool_states=(*self.tool_states, *[MOVING] * len(Q)),
        )

    def with_node(self, q: Array, name: str = "", tool_state: ToolState = MOVING) -> tuple[Roadmap, int]:
        """A roadmap with one more node, and the node's index."""
        enlarged = replace(
            self,
            configurations=np.vstack([self.configurations, np.asarray(q, dtype=float)[None]]),
            names=(*self.names, name),
            tool_states=(*self.tool_states, tool_state),
        )
        return enlarged, self.n_nodes

    def with_edge(self, a: int, b: int, waypoints: Array, mark: PodValidity = NOMINAL_POD) -> Roadmap:
        """A roadmap with one more edge along a proven polyline (K, n) from node a to node b.

        Raises ValueError if the polyline does not join the two nodes.
        """
        enlarged = self.with_edges([(a, b, waypoints)])
        return replace(enlarged, marks=(*self.marks, mark))

    def with_edges(self, new: Sequence[tuple[int, int, Array]]) -> Roadmap:
        """A roadmap with at least one more edge (node a, node b, polyline), as ``with_edge`` adds one."""
        for a, b, waypoints in new:
            if not np.array_equal(waypoints[[0, -1]], self.configurations[[a, b]]):
                raise ValueError(f"the polyline does not lead from node {a} to node {b}")
        paths = [waypoints for _, _, waypoints in new]
        lengths = [JointPath(self.joint_names, path).length for path in paths]
        ends = self.offsets[-1] + np.cumsum([len(path) for path in paths], dtype=np.int64)
        return replace(
            self,
            edges=np.vstack([self.edges, np.array([new_edge[:2] for new_edge in new], dtype=np.int64)]),
            lengths=np.append(self.lengths, lengths),
            waypoints=np.vstack([self.waypoints, *paths]),
            offsets=np.concatenate([self.offsets, ends]),
            marks=(*self.marks, *[NOMINAL_POD] * len(new)),
        )

    def components(self) -> IntArray:
        """(N,): for each node the smallest index of the nodes that it is connected with."""
        label = np.arange(self.n_nodes, dtype=np.int64)
        for a, b in self.edges.tolist():
            low, high = sorted((int(label[a]), int(label[b])))
            label[label == high] = low
        return label
