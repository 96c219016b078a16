"""Tables of a roadmap in its file. See docs/formats/hdf5.md."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from pickcli.cell.tool import MOVING, ToolState
from pickcli.errors import Reason
from pickcli.roadmap.common_columns import (
    VALIDITY,
    reason_columns,
    reason_rows,
    reason_table,
    validities_of,
    validity_columns,
)
from pickcli.roadmap.graph import Roadmap
from pickcli.storage.table_format import INDEX, NUMBER, TEXT, Columns, FileContent, FileFormat, Table
from pickcli.storage.table_reader import StoredFile

Names = tuple[str, ...]

ROADMAP = FileFormat(
    "roadmap",
    5,
    {
        "nodes": Table({"name": TEXT, "tool_state": TEXT}, pieces=("configurations",)),
        "edges": Table(
            {"a": INDEX, "b": INDEX, "length": NUMBER, **dict.fromkeys(("proven_for", *VALIDITY), TEXT)},
            pieces=("waypoints",),
        ),
        "refused": reason_table("name"),
        "missing": reason_table("start", "goal"),
        "alone": reason_table("start", "goal"),
    },
)


@dataclass(frozen=True)
class RoadmapGaps:
    """Gaps that a build left.

    Attributes:
        refused: Named configurations (one name each) that are not free, and why.
        missing: Pairs of names without an edge, and why.
        without_second_route: Critical pairs without a second, edge-disjoint route, and why.
    """

    refused: tuple[tuple[Names, Reason], ...] = ()
    missing: tuple[tuple[Names, Reason], ...] = ()
    without_second_route: tuple[tuple[Names, Reason], ...] = ()


def roadmap_content(
    roadmap: Roadmap, fingerprint: str, made: Mapping[str, Any], gaps: RoadmapGaps
) -> FileContent:
    """Lay out a roadmap as the content of its file.

    Args:
        roadmap: The roadmap.
        fingerprint: Fingerprint of the roadmap's cell.
        made: How it was built, as JSON values.
        gaps: Gaps that the build left.

    Returns:
        The content to be written.
    """
    tables: dict[str, Columns] = {
        "nodes": {"name": roadmap.names, "tool_state": roadmap.tool_states},
        "edges": {
            "a": roadmap.edges[:, 0],
            "b": roadmap.edges[:, 1],
            "length": roadmap.lengths,
            "proven_for": [roadmap.proven_for] * roadmap.n_edges,
            **validity_columns(roadmap.validities),
        },
        "refused": reason_columns(("name",), gaps.refused),
        "missing": reason_columns(("start", "goal"), gaps.missing),
        "alone": reason_columns(("start", "goal"), gaps.without_second_route),
    }
    pieces = {
        "configurations": list(roadmap.configurations[:, None]),
        "waypoints": [roadmap.edge_path(edge) for edge in range(roadmap.n_edges)],
    }
    return FileContent(fingerprint, made, roadmap.joint_names, tables, pieces)


def roadmap_of(file: StoredFile) -> Roadmap:
    """Read the roadmap of a file.

    Args:
        file: The open file.

    Returns:
        The roadmap.

    Raises:
        ValueError: The content is inconsistent.
    """
    nodes, edges = file.tables["nodes"], file.tables["edges"]
    configurations, first = file.pieces("configurations")
    waypoints, offsets = file.pieces("waypoints")
    if np.any(np.diff(first) != 1) or len(nodes) != len(configurations):
        raise ValueError("a node has not exactly one configuration")
    return Roadmap(
        file.joint_names, configurations, file.texts("nodes", "name"),
        tuple(ToolState(text) for text in file.texts("nodes", "tool_state")),
        np.column_stack([edges["a"], edges["b"]]), edges["length"], waypoints, offsets,
        one_state(file.texts("edges", "proven_for")), validities_of(file, "edges"),
    )  # fmt: skip


def one_state(texts: Iterable[str]) -> ToolState:
    """Return the tool state that all edges are proven for.

    Args:
        texts: Name of the state of each edge.

    Returns:
        The state, ``MOVING`` if there is no edge.

    Raises:
        ValueError: There are several, or one is unknown.
    """
    states = {ToolState(text) for text in texts} or {MOVING}
    if len(states) != 1:
        raise ValueError("edges are proven for different tool states")
    return states.pop()


def gaps_of(file: StoredFile) -> RoadmapGaps:
    """Read the gaps that the build of a roadmap left.

    Args:
        file: The open file.

    Returns:
        Configurations and pairs, each with the reason.
    """
    tables = file.tables
    return RoadmapGaps(
        reason_rows(("name",), tables["refused"]),
        reason_rows(("start", "goal"), tables["missing"]),
        reason_rows(("start", "goal"), tables["alone"]),
    )
