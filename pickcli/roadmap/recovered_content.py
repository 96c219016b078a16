"""Motions and edges that an integrity scan found intact, and a check of their consistency.

A file with correct checksums can still hold data that no build writes: an unknown tool state, polylines that
join no nodes. Content is checked for that when it is read; so is the content recovered by a scan.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.roadmap import validate
from pickcli.roadmap.common_columns import reason_row, row_validity
from pickcli.roadmap.database_tables import DATABASE, Missing, missing_row, motion_of
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.roadmap_tables import one_state
from pickcli.roadmap.trajectory_database import CoarseMotion, TrajectoryDatabase
from pickcli.storage.integrity_scan import IntegrityReport


def check_intact(found: IntegrityReport, cell: Cell | None) -> None:
    """Check that the intact content of a file is consistent.

    Args:
        found: Result of an integrity scan of the file.
        cell: If the file is of this cell, its tool states must be the cell's; None for any.

    Raises:
        ValueError: The content is inconsistent; other errors in ``SYMPTOMS`` may be raised, too.
    """
    _ = found.made
    if cell is not None and cell.fingerprint != found.fingerprint:
        cell = None
    if found.kind is DATABASE:
        intact_missing(found)
        motions = intact_motions(found)
        validate.tool_states({motion.tool_state for motion in motions}, cell)
        validate.database(TrajectoryDatabase.of(found.joint_names, motions), None)
    else:
        roadmap = intact_roadmap(found)
        validate.tool_states({*roadmap.tool_states, roadmap.proven_for}, cell)
        validate.roadmap(roadmap, None)
        for names in ("refused", "missing", "alone"):
            for entry in found.intact[names]:
                reason_row((), entry.row)


def intact_motions(found: IntegrityReport) -> list[CoarseMotion]:
    """Read the intact motions of a database.

    Args:
        found: Result of an integrity scan of the file.

    Returns:
        The motions, with their timed points.
    """
    names, rows = found.joint_names, found.intact["motions"]
    return [motion_of(names, entry.row, entry.pieces["waypoints"], entry.pieces["points"]) for entry in rows]


def intact_missing(found: IntegrityReport) -> list[Missing]:
    """Read the intact entries of a database for motions that its build did not find.

    Args:
        found: Result of an integrity scan of the file.

    Returns:
        The motions, each with the reason.
    """
    return [missing_row(entry.row) for entry in found.intact["missing"]]


def intact_roadmap(found: IntegrityReport) -> Roadmap:
    """Read the intact nodes and edges of a roadmap.

    Edges refer to nodes by row, which is undefined if some nodes are lost: then each gets two nodes of its
    own.

    Args:
        found: Result of an integrity scan of the file.

    Returns:
        The roadmap.

    Raises:
        ValueError: The content is inconsistent.
    """
    nodes, edges = found.intact["nodes"], found.intact["edges"]
    none = np.zeros((0, len(found.joint_names)))
    configurations = [node.pieces["configurations"] for node in nodes]
    if any(len(q) != 1 for q in configurations):
        raise ValueError("a node has not exactly one configuration")
    ways = [edge.pieces["waypoints"] for edge in edges]
    roadmap = Roadmap(
        found.joint_names,
        np.concatenate([none, *configurations]),
        tuple(bytes(node.row["name"]).decode() for node in nodes),
        tuple(ToolState(bytes(node.row["tool_state"]).decode()) for node in nodes),
        np.array([(edge.row["a"], edge.row["b"]) for edge in edges], dtype=np.int64).reshape(-1, 2),
        np.array([edge.row["length"] for edge in edges]),
        np.concatenate([none, *ways]),
        np.cumsum([0, *map(len, ways)]),
        one_state(bytes(edge.row["proven_for"]).decode() for edge in edges),
        tuple(row_validity(edge.row) for edge in edges),
    )
    return roadmap if found.is_whole else _on_own_nodes(roadmap)


def _on_own_nodes(roadmap: Roadmap) -> Roadmap:
    """Put each edge between two new nodes of its own."""
    ends = [roadmap.edge_path(edge)[[0, -1]] for edge in range(roadmap.n_edges)]
    grown = roadmap.with_nodes(np.concatenate([np.zeros((0, len(roadmap.joint_names))), *ends]))
    return replace(grown, edges=roadmap.n_nodes + np.arange(2 * len(ends)).reshape(-1, 2))
