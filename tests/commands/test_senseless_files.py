"""Files that keep all their checksums and hold what no build writes: refused with one message."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.pod_tolerance import PodValidity
from pickcli.cell.tool import MOVING
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.path import JointPath
from pickcli.motion.trajectory import Trajectory
from pickcli.roadmap.database_tables import DATABASE, database_content
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.roadmap_tables import ROADMAP, RoadmapGaps, roadmap_content
from pickcli.roadmap.store import write_roadmap
from pickcli.roadmap.trajectory_database import CoarseMotion, MotionKey, PayloadClass, TrajectoryDatabase
from pickcli.storage.table_format import FileContent
from pickcli.storage.table_writer import write_content
from support.command_line import apc, refused

MADE: Any = {"by": {}, "settings": {}, "result": {}}
BOULDER: Any = MotionKey("home", "bin_B", "boulder")  # type: ignore[arg-type]
SIDEWAYS: Any = ("sideways",) * 2
ELSEWHERE: Any = (PodValidity("elsewhere"),)  # type: ignore[arg-type]


@cache
def _ends() -> tuple[tuple[str, ...], Array]:
    """The joints, and two configurations (2, n)."""
    cell = load_cell("apc2016_delft")
    return cell.robot.joint_names, np.stack([cell.configurations[name].q for name in ("home", "bin_A")])


def _motions(missing: Any = (), made: Any = MADE, **changes: Any) -> FileContent:
    names, Q = _ends()
    timed = Trajectory(names, np.array([0.0, 2.0]), Q, np.zeros_like(Q), np.zeros_like(Q))
    key = MotionKey("home", "bin_A", PayloadClass.EMPTY)
    motion = CoarseMotion(key, MOVING, JointPath(names, Q), 2.0, timed)
    database = replace(TrajectoryDatabase.of(names, [motion]), **changes)
    return database_content(database, load_cell("apc2016_delft").fingerprint, made, missing)


def _edges(**changes: Any) -> FileContent:
    names, Q = _ends()
    roadmap = Roadmap.empty(names).with_nodes(Q).with_edge(0, 1, Q)
    fingerprint = load_cell("apc2016_delft").fingerprint
    return roadmap_content(replace(roadmap, **changes), fingerprint, MADE, RoadmapGaps())


def _with(content: FileContent, piece: str, change: Callable[[Array], Array]) -> FileContent:
    """The content with pieces of one kind changed."""
    changed = [change(part) for part in content.pieces[piece]]
    return replace(content, pieces={**content.pieces, piece: changed})


SENSELESS: dict[str, tuple[Callable[[], FileContent], str]] = {
    "payload": (lambda: _motions(keys=(BOULDER,)), "'boulder' is not a valid PayloadClass"),
    "tool state": (
        lambda: _motions(tool_states=SIDEWAYS[:1]),
        "the tool of the cell has no state 'sideways'",
    ),
    "pod poses": (lambda: _motions(validities=ELSEWHERE), "'elsewhere' is not a valid PodPoses"),
    "missing": (lambda: _motions([(BOULDER, Reason("no path"))]), "'boulder' is not a valid PayloadClass"),
    "columns": (lambda: _with(_motions(), "points", lambda p: p[:, :-1]), "timed points of 24 columns"),
    "duration": (lambda: _motions(durations=np.array([-1.0])), "a duration is not positive"),
    "no polyline": (lambda: _with(_motions(), "waypoints", lambda w: w[:0]), "do not divide the rows"),
    "made": (lambda: _motions(made=[["by", {}]]), "made is no JSON object"),
    "node tool state": (lambda: _edges(tool_states=SIDEWAYS), "the tool of the cell has no state 'sideways'"),
    "edge pod poses": (lambda: _edges(validities=ELSEWHERE), "'elsewhere' is not a valid PodPoses"),
    "index": (lambda: _edges(edges=np.array([[0, 7]])), "an edge leads to a node that is not there"),
    "not finite": (lambda: _with(_edges(), "waypoints", lambda w: np.nan * w), "not one finite number"),
    "empty edge": (lambda: _with(_edges(), "waypoints", lambda w: w[:0]), "do not divide the rows"),
}


@pytest.mark.parametrize("is_damaged", [False, True], ids=["whole", "damaged"])
@pytest.mark.parametrize("command", [("check",), ("check", "--repair"), ("refresh",)], ids=" ".join)
@pytest.mark.parametrize("what", SENSELESS)
def test_a_senseless_file_is_refused(
    what: str, command: tuple[str, ...], is_damaged: bool, tmp_path: Path
) -> None:
    content, told = SENSELESS[what]
    path = tmp_path / "file.h5"
    write_content(path, DATABASE if "points" in content().pieces else ROADMAP, content())
    if is_damaged:  # in the spare copy of its directory, which costs nothing
        damaged = bytearray(path.read_bytes())
        damaged[-60] ^= 1
        path.write_bytes(damaged)
    before = path.read_bytes()
    name, *options = command
    refused(apc(name, path, *options), 4, path, "its content is invalid", told, "build it again")
    assert path.read_bytes() == before and list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("content", [_motions, _edges])
def test_what_makes_sense_is_undamaged(content: Callable[[], FileContent], tmp_path: Path) -> None:
    path = tmp_path / "file.h5"
    write_content(path, DATABASE if content is _motions else ROADMAP, content())
    answer = apc("check", path)
    assert answer.code == 0 and "undamaged" in answer.out


@pytest.mark.parametrize("more", [(), ("--json",)])
def test_a_file_that_is_cut_off_is_one_line_and_what_to_do(tmp_path: Path, more: tuple[str, ...]) -> None:
    """Not a line for each of the blocks that are lost with its end; JSON has them all."""
    path = tmp_path / "file.h5"
    write_content(path, DATABASE, _motions())
    length = path.stat().st_size
    path.write_bytes(path.read_bytes()[: length // 2])
    answer = apc("check", path, *more)
    told = f"cut off at byte {length // 2} of at least "
    (error,) = answer.err.splitlines()
    assert answer.code == 4 and error.startswith(f"apc: error: {path}: {told}")
    assert error.endswith("; add --repair, or build it again")
    if more:
        assert len(json.loads(answer.out)["damage"]) >= 1
    else:
        (line,) = answer.out.splitlines()
        assert line.startswith(f"{path}: trajectory database, {told}") and "; intact: " in line


SETTINGS = (
    {"planner": "RRTConnect", "n_neighbours": "many"},
    {"planner": "RRTConnect", "n_neighbours": 1.5},
    {"planner": ["RRTConnect"]},
    ["RRTConnect"],
    None,
)


@pytest.mark.parametrize("settings", SETTINGS, ids=str)
def test_settings_that_make_no_sense_are_not_of_this_version(settings: object, tmp_path: Path) -> None:
    path = tmp_path / "file.h5"
    write_content(path, ROADMAP, replace(_edges(), made={"settings": settings}))
    refused(apc("refresh", path, "--jobs", "1"), 4, path, "its settings are not those of", "build it again")


def test_a_file_of_a_robot_with_other_joints_is_not_refreshed(tmp_path: Path) -> None:
    """Everything would be done again for the other robot, and the file would be lost."""
    path, cell = tmp_path / "file.h5", load_cell("panda_table")
    write_roadmap(path, Roadmap.empty(cell.robot.joint_names), cell.fingerprint, MADE)
    before = path.read_bytes()
    answer = apc("refresh", path, "--jobs", "1")
    refused(answer, 3, path, "is for a robot with the joints panda_joint1, ", "name its own cell with --cell")
    assert path.read_bytes() == before
