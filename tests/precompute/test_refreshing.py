"""A refreshed file against a build from nothing, and how little of it is done again."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from pickcli.cell import cell_file
from pickcli.cell.cell import Cell
from pickcli.cell.cell_diff import change_since, parts_of
from pickcli.cell.pod_tolerance import ANY_POD, UNMOVED, PodPoses
from pickcli.collision.robot_model import CollisionModel
from pickcli.commands.refresh import command
from pickcli.errors import StaleError
from pickcli.jobs.executors import Finished
from pickcli.jobs.job import Job, Key
from pickcli.jobs.job_run import RunOptions
from pickcli.precompute import artifact_files
from pickcli.precompute.artifact_files import make_trajectories
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.precompute.refreshing import refresh
from pickcli.roadmap.database_tables import DATABASE
from pickcli.roadmap.store import read_database, read_gaps, read_missing, read_roadmap, surveyed
from pickcli.roadmap.trajectory_database import MotionKey, PayloadClass
from support.changed_cell import built, moved_divider, new_obstacle, no_tote, refreshed, with_parts
from support.small_cell import LEAST_EFFORT, alone, small_cell

NAMES = ("home", "bin_A", "bin_E", "cam_A", "cam_E", "tote", "tote_10h")


CHANGES = {"a wall moved": moved_divider, "something new": new_obstacle, "something gone": no_tote}
Change = Callable[[Cell], Cell]


@pytest.fixture(scope="module")
def cell() -> Cell:
    return small_cell(*NAMES)


@pytest.fixture(scope="module")
def old(cell: Cell, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    return built(cell, tmp_path_factory.mktemp("old"))


@pytest.fixture(scope="module", params=CHANGES)
def changed(request: pytest.FixtureRequest, cell: Cell) -> Cell:
    made: Cell = CHANGES[request.param](cell)
    return made


@pytest.fixture(scope="module")
def fresh(changed: Cell, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fresh")
    built(changed, folder)
    return folder


def _verdicts(path: Path, cell: Cell) -> tuple[set[MotionKey], set[MotionKey], set[MotionKey]]:
    """Which pairs have a motion, which have one for any pod, and which have none."""
    database = read_database(path, cell)
    wide = {
        key for key, validity in zip(database.keys, database.validities, strict=True) if validity == ANY_POD
    }
    return set(database.keys), wide, {key for key, _ in read_missing(path)}


def test_a_refreshed_database_says_what_a_new_one_says(
    changed: Cell, fresh: Path, old: dict[str, bytes], tmp_path: Path
) -> None:
    done = refreshed(tmp_path / "motions", old["motions"], changed)
    ours, theirs = (_verdicts(folder / "motions", changed) for folder in (tmp_path, fresh))
    assert (ours[0], ours[2]) == (theirs[0], theirs[2])
    assert ours[1] >= theirs[1]  # what holds for any pod is kept, also where a quicker one would not
    assert done.n_kept > 0 and done.n_kept + done.n_planned == len(read_database(fresh / "motions")) + len(
        read_missing(fresh / "motions")
    )


def test_every_motion_of_it_keeps_the_clearance_that_it_tells(
    changed: Cell, old: dict[str, bytes], tmp_path: Path
) -> None:
    refreshed(tmp_path / "motions", old["motions"], changed)
    model = CollisionModel(changed)
    database = read_database(tmp_path / "motions", changed, points=True)
    assert len(database) > 0
    for motion in database:
        tests = checker(model, motion.tool_state, motion.key.payload, pod_poses=motion.validity.pod_poses)
        assert motion.trajectory is not None
        Q = motion.trajectory.sample(np.arange(0.0, motion.duration, 0.005))
        assert tests.kernel.clearances(Q).min() >= motion.clearance >= changed.clearance


def test_a_refreshed_roadmap_says_what_a_new_one_says(
    changed: Cell, fresh: Path, old: dict[str, bytes], tmp_path: Path
) -> None:
    refreshed(tmp_path / "edges", old["edges"], changed)
    ours, theirs = (read_roadmap(folder / "edges", changed) for folder in (tmp_path, fresh))
    assert ours.names == theirs.names and ours.edges.tolist() == theirs.edges.tolist()
    assert ours.n_edges > 0
    assert all(a == ANY_POD or b != ANY_POD for a, b in zip(ours.validities, theirs.validities, strict=True))
    gaps = (read_gaps(folder / "edges") for folder in (tmp_path, fresh))
    assert len({tuple(name for name, _ in gap.refused) for gap in gaps}) == 1
    model = CollisionModel(changed)
    for edge, validity in enumerate(ours.validities):
        tests = checker(model, ours.proven_for, PayloadClass.EMPTY, pod_poses=validity.pod_poses)
        assert tests.is_valid_path(ours.edge_path(edge))


def test_a_wall_that_is_far_from_all_motions_touches_few(
    cell: Cell, old: dict[str, bytes], tmp_path: Path
) -> None:
    done = refreshed(tmp_path / "motions", old["motions"], moved_divider(cell))
    assert done.changed == ("pod row_DEF_divider_left",) and not done.why_rebuilt
    assert done.n_proven <= 0.15 * done.n_stored


def test_something_in_the_way_is_found_and_planned_around(
    cell: Cell, old: dict[str, bytes], tmp_path: Path
) -> None:
    done = refreshed(tmp_path / "motions", old["motions"], new_obstacle(cell))
    assert done.changed == ("obstacle post",)
    assert 0 < done.n_planned <= done.n_proven < done.n_stored


@pytest.mark.parametrize("kind", ["edges", "motions"])
def test_nothing_changed_nothing_done_same_bytes(
    kind: str, cell: Cell, old: dict[str, bytes], tmp_path: Path
) -> None:
    done = refreshed(tmp_path / kind, old[kind], cell)
    assert (done.n_proven, done.n_planned, done.changed) == (0, 0, ())
    assert (tmp_path / kind).read_bytes() == old[kind]


def _other_limits(cell: Cell) -> Cell:
    limits = replace(cell.robot.limits, velocity=0.9 * cell.robot.limits.velocity)
    return with_parts(cell, robot=replace(cell.robot, limits=limits))


def _fixed_pod(cell: Cell) -> Cell:
    return with_parts(cell, pod=replace(cell.pod, displacement=UNMOVED))


@pytest.mark.parametrize(
    ("change", "told"),
    [(_other_limits, "the robot, its joint limits or its tool"), (_fixed_pod, "the pod may be displaced")],
)
def test_what_every_motion_depends_on_leaves_nothing(
    change: Change, told: str, cell: Cell, old: dict[str, bytes], tmp_path: Path
) -> None:
    other = change(cell)
    done = refreshed(tmp_path / "motions", old["motions"], other)
    assert done.why_rebuilt.startswith("not as it was: ") and told in done.why_rebuilt and done.n_kept == 0
    make_trajectories(other, tmp_path / "new", LEAST_EFFORT)
    assert (tmp_path / "motions").read_bytes() == (tmp_path / "new").read_bytes()


def test_a_file_of_other_versions_is_done_anew(
    cell: Cell, old: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "pickcli.precompute.refreshing.versions", lambda: artifact_files.versions() | {"ompl": "0"}
    )
    done = refreshed(tmp_path / "edges", old["edges"], cell)
    assert "other versions" in done.why_rebuilt and done.n_kept == 0


@pytest.mark.parametrize("parts", [None, [], {"solids": {}}, {"rules": {}, "T_world_pod": [1], "solids": {}}])
def test_a_file_that_does_not_say_what_its_cell_was_is_done_anew(
    parts: object, cell: Cell, old: dict[str, bytes], tmp_path: Path
) -> None:
    path = tmp_path / "edges"
    path.write_bytes(old["edges"])
    found = surveyed(path)
    attributes = {**found.attributes, "made": json.dumps(found.made | {"parts": parts})}
    done = refresh(path, replace(found, attributes=attributes), cell)
    assert done.why_rebuilt == "the file does not say what its cell was" and done.n_kept == 0
    assert path.read_bytes() == old["edges"]


def test_another_named_configuration_costs_its_motions_alone(
    cell: Cell, old: dict[str, bytes], tmp_path: Path
) -> None:
    home = cell.configurations["home"]
    elsewhere = replace(home, q=home.q + 0.01)
    other = replace(cell, configurations=cell.configurations | {"home": elsewhere})
    done = refreshed(tmp_path / "motions", old["motions"], other)
    database = read_database(tmp_path / "motions", other)
    assert done.n_kept == sum("home" not in (key.start, key.goal) for key in database.keys)
    assert done.n_kept < len(database)
    for motion in database:
        for name, q in zip((motion.key.start, motion.key.goal), motion.path.waypoints[[0, -1]], strict=True):
            np.testing.assert_array_equal(q, other.configurations[name].q)


class _Stopping:
    """A runner that is interrupted after one task."""

    def run(self, job: Job, keys: Sequence[Key]) -> Finished:
        for key in keys[:1]:
            yield key, job.make(key).to_bytes()
        raise KeyboardInterrupt


def test_an_interrupted_refresh_leaves_the_old_file_and_goes_on(
    cell: Cell, old: dict[str, bytes], tmp_path: Path
) -> None:
    path, other = tmp_path / "motions", new_obstacle(cell)
    with pytest.raises(KeyboardInterrupt):
        refreshed(path, old["motions"], other, RunOptions(_Stopping()))
    assert path.read_bytes() == old["motions"]
    again = refresh(path, surveyed(path), other)
    at_once = refreshed(tmp_path / "at_once", old["motions"], other)
    assert again.n_planned == at_once.n_planned - 1
    assert path.read_bytes() == (tmp_path / "at_once").read_bytes()
    assert sorted(file.name for file in tmp_path.iterdir()) == ["at_once", "motions"]


def test_a_file_of_another_format_version_is_refused(
    cell: Cell, old: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "motions"
    path.write_bytes(old["motions"])
    later = replace(DATABASE, version=DATABASE.version + 1)
    monkeypatch.setattr("pickcli.roadmap.store.FORMATS", (later,))
    monkeypatch.setattr(cell_file, "load_workcell", lambda *_: alone(cell))
    outcome = CliRunner().invoke(command, [str(path)])
    assert isinstance(outcome.exception, StaleError)
    assert f"of version {DATABASE.version}, this is version {later.version}" in str(outcome.exception)
    assert path.read_bytes() == old["motions"]


def test_the_command_tells_what_changed(
    cell: Cell, old: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "motions.h5"
    for arguments in (["--jobs", "1"], ["--jobs", "1", "--json"]):
        path.write_bytes(old["motions"])
        monkeypatch.setattr(cell_file, "load_workcell", lambda *_: alone(moved_divider(cell)))
        outcome = CliRunner().invoke(command, [str(path), *arguments])
        assert outcome.exit_code == 0
        if "--json" in arguments:
            told = json.loads(outcome.stdout)
            assert told["changed"] == ["pod row_DEF_divider_left"] and told["rebuilt_because"] is None
            assert told["tasks_kept"] > 0
        else:
            assert "changed: pod row_DEF_divider_left" in outcome.stdout


def test_parts_name_what_changed_and_nothing_else(cell: Cell) -> None:
    before = parts_of(cell)
    assert change_since(before, cell).solids == () and change_since(before, cell).rules == ()
    assert change_since(before, new_obstacle(cell)).added == ("obstacle post",)
    gone = change_since(before, no_tote(cell))
    assert gone.added == () and gone.removed and all(name.startswith("tote ") for name in gone.removed)
    T = cell.T_world_pod + 0.01 * (np.arange(16) == 3).reshape(4, 4)
    shifted = change_since(before, with_parts(cell, T_world_pod=T))
    assert len(shifted.added) == len(shifted.removed) == len(cell.pod.bodies)
    assert change_since(before, _other_limits(cell)).rules == ("the robot, its joint limits or its tool",)


def test_marks_travel_through_the_file(cell: Cell, old: dict[str, bytes], tmp_path: Path) -> None:
    (tmp_path / "motions").write_bytes(old["motions"])
    validities = read_database(tmp_path / "motions", cell).validities
    assert ANY_POD in validities
    assert all(
        bool(validity.why_nominal) == (validity.pod_poses is PodPoses.NOMINAL) for validity in validities
    )
