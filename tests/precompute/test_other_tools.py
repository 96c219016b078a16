"""The files of cells whose tool has one state or three: what is made, stored, and read again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.tool import MOVING
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import DamagedError
from pickcli.path_planning.planner_names import PlannerName
from pickcli.precompute.coarse_motion_planner import CoarseMotionPlanner
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.precompute.roadmap_builder import build_roadmap
from pickcli.precompute.roadmap_edge_job import RoadmapEdgeJob
from pickcli.precompute.roadmap_settings import RoadmapSettings
from pickcli.roadmap.store import read_database, read_roadmap, write_database, write_roadmap
from pickcli.roadmap.trajectory_database import CoarseMotion, MotionKey, PayloadClass, TrajectoryDatabase
from support.cell_copies import CellCopy
from support.other_tools import ONE_STATE, THREE_STATES, with_tool
from support.small_cell import FEW, LEAST_EFFORT
from support.tool_states import STRAIGHT

QUICK = RoadmapSettings(PlannerName.RRT_CONNECT, n_neighbours=2, max_iterations=2000, n_shortcuts=50)
BOTH = pytest.mark.parametrize("kind", [ONE_STATE, THREE_STATES])


def _small(copy: CellCopy, kind: str) -> Cell:
    cell = with_tool(copy, kind).load()
    return replace(cell, configurations={k: v for k, v in cell.configurations.items() if k in FEW})


@BOTH
def test_a_roadmap_holds_in_every_state_and_comes_back_from_its_file(
    cell_copy: CellCopy, kind: str, tmp_path: Path
) -> None:
    cell = _small(cell_copy, kind)
    roadmap, report = build_roadmap(RoadmapEdgeJob(cell, QUICK))
    assert roadmap.n_edges > 0 and report.n_components == 1
    assert set(roadmap.tool_states) <= set(cell.robot.tool.states) and roadmap.proven_for == MOVING
    for state in cell.robot.tool.states_and_moving:
        tests = checker(CollisionModel(cell), state, PayloadClass.EMPTY)
        assert all(tests.is_valid_path(roadmap.edge_path(edge)) for edge in range(roadmap.n_edges))
    path = tmp_path / "roadmap.h5"
    write_roadmap(path, roadmap, cell.fingerprint, {})
    assert read_roadmap(path, cell).tool_states == roadmap.tool_states


@BOTH
def test_a_coarse_motion_is_made_and_comes_back_from_its_file(
    cell_copy: CellCopy, kind: str, tmp_path: Path
) -> None:
    cell = _small(cell_copy, kind)
    key = MotionKey("home", "bin_A", PayloadClass.EMPTY)
    motion = CoarseMotionPlanner(cell, LEAST_EFFORT).make(key)
    assert isinstance(motion, CoarseMotion), motion
    assert motion.tool_state in cell.robot.tool.states_and_moving
    path = tmp_path / "trajectories.h5"
    database = TrajectoryDatabase.of(cell.robot.joint_names, [motion])
    write_database(path, database, cell.fingerprint, {})
    assert read_database(path, cell).tool_states == (motion.tool_state,)


def test_a_file_that_names_a_state_of_another_tool_is_refused(cell_copy: CellCopy, tmp_path: Path) -> None:
    cell = _small(cell_copy, ONE_STATE)
    roadmap, _ = build_roadmap(RoadmapEdgeJob(cell, QUICK))
    foreign = replace(roadmap, tool_states=(STRAIGHT,) * roadmap.n_nodes)
    path = tmp_path / "roadmap.h5"
    write_roadmap(path, foreign, cell.fingerprint, {})
    with pytest.raises(DamagedError, match="the tool of the cell has no state 'straight'"):
        read_roadmap(path, cell)
