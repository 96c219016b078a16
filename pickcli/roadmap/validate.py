"""Consistency checks of the content of roadmap and database files.

They raise ValueError with the fault; the store converts it to a DamagedError.
"""

from __future__ import annotations

from collections.abc import Set

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array
from pickcli.path_planning.state_space import LIMIT_TOLERANCE, JointSpace
from pickcli.roadmap.graph import IntArray, Roadmap
from pickcli.roadmap.trajectory_database import TrajectoryDatabase


def roadmap(roadmap: Roadmap, cell: Cell | None) -> None:
    """Check a roadmap: shapes, indices, polylines that join their nodes, lengths.

    Args:
        roadmap: Content of a file.
        cell: The cell whose joints, limits and tool states it must have; None for any.

    Raises:
        ValueError: The content is inconsistent.
    """
    n_nodes = roadmap.n_nodes
    _joints(roadmap.joint_names, cell, roadmap.configurations, roadmap.waypoints)
    _same_count("nodes", n_nodes, len(roadmap.names), len(roadmap.tool_states))
    tool_states({*roadmap.tool_states, roadmap.proven_for}, cell)
    _same_count(
        "edges", roadmap.n_edges, len(roadmap.lengths), len(roadmap.offsets) - 1, len(roadmap.validities)
    )
    _offsets("offsets", roadmap.offsets, len(roadmap.waypoints), least=2)
    if roadmap.n_edges and not (roadmap.edges.min() >= 0 and roadmap.edges.max() < n_nodes):
        raise ValueError("an edge leads to a node that is not there")
    named = [name for name in roadmap.names if name]
    if len(set(named)) != len(named):
        raise ValueError("two nodes have the same name")
    firsts, lasts = roadmap.waypoints[roadmap.offsets[:-1]], roadmap.waypoints[roadmap.offsets[1:] - 1]
    ends = roadmap.configurations[roadmap.edges]
    if not (np.array_equal(firsts, ends[:, 0]) and np.array_equal(lasts, ends[:, 1])):
        raise ValueError("the polyline of an edge does not join its nodes")
    if not np.allclose(roadmap.lengths, _lengths(roadmap.waypoints, roadmap.offsets), rtol=0.0, atol=1e-9):
        raise ValueError("the length of an edge is not that of its polyline")


def database(database: TrajectoryDatabase, cell: Cell | None) -> None:
    """Check a database: shapes, offsets, unique keys, durations and their bounds, timed points.

    Args:
        database: Content of a file.
        cell: The cell whose joints, limits and tool states it must have; None for any.

    Raises:
        ValueError: The content is inconsistent.
    """
    count = len(database)
    _joints(database.joint_names, cell, database.waypoints)
    tool_states(set(database.tool_states), cell)
    _same_count(
        "motions", count, len(database.tool_states), len(database.durations), len(database.offsets) - 1
    )
    _offsets("offsets", database.offsets, len(database.waypoints), least=2)
    if len({key for k in database.keys for key in (k, k.reversed())}) != 2 * count:
        raise ValueError("a motion is stored twice")
    if not (np.all(np.isfinite(database.durations)) and np.all(database.durations > 0.0)):
        raise ValueError("a duration is not positive")
    bounds, kept = database.lower_bounds, database.clearances
    _same_count("motions", count, len(bounds), len(kept))
    if not (np.all(bounds >= 0.0) and np.all(bounds <= database.durations) and np.all(np.isfinite(kept))):
        raise ValueError("a motion is faster than its bound, or its clearance no number")
    points = database.points
    if points is not None:
        _same_count(
            "points",
            len(points.times),
            len(points.positions),
            len(points.velocities),
            len(points.accelerations),
        )
        _same_count("motions", count, len(points.offsets) - 1)
        _offsets("point_offsets", points.offsets, len(points.times), least=2)
        _joints(database.joint_names, cell, points.positions, points.velocities, points.accelerations)
        _times(points.times, points.offsets)


def tool_states(states: Set[ToolState], cell: Cell | None) -> None:
    """Check that the tool of a cell has all given states.

    Args:
        states: The tool states of a file.
        cell: The cell; None allows any state.

    Raises:
        ValueError: The tool does not have one of them.
    """
    known = states if cell is None else cell.robot.tool.states_and_moving
    for state in sorted(states):
        if state not in known:
            raise ValueError(f"the tool of the cell has no state {state.name!r}")


def _joints(names: tuple[str, ...], cell: Cell | None, configurations: Array, *others: Array) -> None:
    """Check that every row has one finite number per joint; with a cell, its joints and limits."""
    for rows in (configurations, *others):
        if rows.shape[1] != len(names) or not np.all(np.isfinite(rows)):
            raise ValueError("a configuration is not one finite number per joint")
    if cell is None:
        return
    if names != cell.robot.joint_names:
        raise ValueError(f"its joints are {' '.join(names)}, not {' '.join(cell.robot.joint_names)}")
    space = JointSpace.of(cell.robot)
    inside = (configurations >= space.lower - LIMIT_TOLERANCE) & (
        configurations <= space.upper + LIMIT_TOLERANCE
    )
    if not np.all(inside):
        raise ValueError("a configuration is outside of the joint limits")


def _same_count(what: str, *counts: int) -> None:
    if len(set(counts)) != 1:
        raise ValueError(f"the number of {what} is not the same everywhere: {counts}")


def _offsets(what: str, offsets: IntArray, n_rows: int, least: int) -> None:
    """Check that offsets run from 0 to the number of rows, each piece with a least length."""
    if len(offsets) == 0 or offsets[0] != 0 or offsets[-1] != n_rows or np.any(np.diff(offsets) < least):
        raise ValueError(f"{what} do not divide the rows")


def _lengths(waypoints: Array, offsets: IntArray) -> Array:
    """Return (M,) the Euclidean length of each polyline."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(waypoints, axis=0), axis=1))])
    return np.asarray(along[offsets[1:] - 1] - along[offsets[:-1]])


def _times(times: Array, offsets: IntArray) -> None:
    """Check that each trajectory starts at 0 and its times increase strictly."""
    steps = np.diff(times)
    steps = np.delete(steps, offsets[1:-1] - 1)
    if np.any(times[offsets[:-1]] != 0.0) or not np.all(steps > 0.0):
        raise ValueError("the times of a trajectory do not increase from 0")
