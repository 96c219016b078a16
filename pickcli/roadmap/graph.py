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

    The polylines are stored one after the other in ``waypoints``; edge m has rows offsets[m]:offsets[m + 1],
    ends included, from node edges[m, 0] to node edges[m, 1].

    Attributes:
        joint_names: Names of the n joints.
        configurations: (N, n) configurations of the nodes.
        names: (N,), "" for a node without a name.
        tool_states: (N,) tool state that each node is meant for.
        edges: (M, 2) indices of the nodes that each edge joins.
        lengths: (M,) Euclidean length of the polyline (mixed m and rad), the cost.
        waypoints: (W, n) of all polylines.
        offsets: (M + 1,) rows at which the polylines begin, and W.
        proven_for: The tool state in which every edge was proven.
        validities: (M,) pod validity of each edge.
    """

    joint_names: tuple[str, ...]
    configurations: Array
    names: tuple[str, ...]
    tool_states: tuple[ToolState, ...]
    edges: IntArray
    lengths: Array
    waypoints: Array
    offsets: IntArray
    proven_for: ToolState = MOVING
    validities: tuple[PodValidity, ...] = ()

    @classmethod
    def empty(cls, joint_names: tuple[str, ...], proven_for: ToolState = MOVING) -> Roadmap:
        """Make a roadmap without nodes.

        Args:
            joint_names: Names of the n joints.
            proven_for: The tool state in which its edges will be proven.

        Returns:
            The roadmap.
        """
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
        """For each node its pairs (edge, other node), in order of the edges."""
        lists: list[list[tuple[int, int]]] = [[] for _ in range(self.n_nodes)]
        for m, (a, b) in enumerate(self.edges.tolist()):
            lists[a].append((m, b))
            lists[b].append((m, a))
        return tuple(tuple(entries) for entries in lists)

    def edge_path(self, edge: int, start: int | None = None) -> Array:
        """Read the polyline of an edge.

        Args:
            edge: Index of the edge.
            start: The node at which the polyline starts; None for the stored direction.

        Returns:
            (K, n) configurations, both ends included.
        """
        path = self.waypoints[self.offsets[edge] : self.offsets[edge + 1]]
        return path[::-1] if start is not None and start == self.edges[edge, 1] else path

    def index(self, name: str) -> int | None:
        """Find a node by its name.

        Args:
            name: Name of a configuration.

        Returns:
            Index of the node, or None if no node has that name.
        """
        return self.names.index(name) if name and name in self.names else None

    def nearest(self, q: Array, k: int) -> list[int]:
        """Find the nodes nearest to a configuration by Euclidean distance.

        Args:
            q: (n,) configuration.
            k: Most nodes.

        Returns:
            Indices, nearest first; ties by index.
        """
        distances = np.linalg.norm(self.configurations - q, axis=1)
        return [int(i) for i in np.argsort(distances, kind="stable")[:k]]

    def with_nodes(self, Q: Array) -> Roadmap:
        """Add nodes without names.

        Args:
            Q: (K, n) configurations.

        Returns:
            The larger roadmap; the new nodes have the last indices.
        """
        return replace(
            self,
            configurations=np.vstack([self.configurations, Q]),
            names=(*self.names, *[""] * len(Q)),
            tool_states=(*self.tool_states, *[MOVING] * len(Q)),
        )

    def with_node(self, q: Array, name: str = "", tool_state: ToolState = MOVING) -> tuple[Roadmap, int]:
        """Add one node.

        Args:
            q: (n,) configuration.
            name: Its name, "" for none.
            tool_state: The tool state that it is meant for.

        Returns:
            The larger roadmap, and the index of the node.
        """
        enlarged = replace(
            self,
            configurations=np.vstack([self.configurations, np.asarray(q, dtype=float)[None]]),
            names=(*self.names, name),
            tool_states=(*self.tool_states, tool_state),
        )
        return enlarged, self.n_nodes

    def with_edge(self, a: int, b: int, waypoints: Array, validity: PodValidity = NOMINAL_POD) -> Roadmap:
        """Add one edge.

        Args:
            a: Index of the node at which the polyline starts.
            b: Index of the node at which it ends.
            waypoints: (K, n) proven polyline.
            validity: Pod validity of the edge.

        Returns:
            The larger roadmap; the new edge has the last index.

        Raises:
            ValueError: The polyline does not join the two nodes.
        """
        enlarged = self.with_edges([(a, b, waypoints)])
        return replace(enlarged, validities=(*self.validities, validity))

    def with_edges(self, new: Sequence[tuple[int, int, Array]]) -> Roadmap:
        """Add at least one edge, proven for the nominal pod pose.

        Args:
            new: Each (node a, node b, proven polyline (K, n) from a to b).

        Returns:
            The larger roadmap; the new edges have the last indices, in their order.

        Raises:
            ValueError: A polyline does not join its two nodes.
        """
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
            validities=(*self.validities, *[NOMINAL_POD] * len(new)),
        )

    def components(self) -> IntArray:
        """Find the connected components.

        Returns:
            (N,) for each node the smallest index in its component.
        """
        label = np.arange(self.n_nodes, dtype=np.int64)
        for a, b in self.edges.tolist():
            low, high = sorted((int(label[a]), int(label[b])))
            label[label == high] = low
        return label
