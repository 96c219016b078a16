"""A refreshed file against a build from nothing, and how little of it is done again."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from small_cell import LEAST_EFFORT, small_cell
from stored_kind import FEW_EDGES

from pickcli.cell import load
from pickcli.cell.change import change_since, parts_of
from pickcli.cell.displacement import ANY_POD, UNMOVED, PodStand
from pickcli.cell.fingerprint import fingerprint
from pickcli.cell.model import Cell
from pickcli.cell.robot import PivotState
from pickcli.cell.shapes import Body, box
from pickcli.cell.station import Obstacles
from pickcli.collision.model import CollisionModel
from pickcli.commands.refresh import command
from pickcli.errors import StaleError
from pickcli.geometry import pose
from pickcli.precompute import make
from pickcli.precompute.build import Means
from pickcli.precompute.empty_scene import checker
from pickcli.precompute.make import make_roadmap, make_trajectories
from pickcli.precompute.recipe import Key, Recipe
from pickcli.precompute.refresh import Refresh, refresh
from pickcli.precompute.reproof import Reproof
from pickcli.precompute.runner import Finished
from pickcli.roadmap.database import MotionKey, PayloadClass
from pickcli.roadmap.store import read_database, read_gaps, read_missing, read_roadmap, surveyed
from pickcli.roadmap.stored_database import DATABASE

NAMES = ("home", "bin_A", "bin_E", "cam_A", "cam_E", "tote", "tote_10h")


def _with(cell: Cell, **parts: object) -> Cell:
    """The cell with some parts replaced, and the fingerprint that it has then."""
    changed = replace(cell, **parts)  # type: ignore[arg-type]
    return replace(changed, fingerprint=fingerprint(changed))


def _shifted(body: Body, *by: float) -> Body:
    """A solid that stands elsewhere by x, y, z in m."""
    return replace(body, T_parent_shape=pose(by) @ body.T_parent_shape)


def _moved_divider(cell: Cell) -> Cell:
    """One wall between two bins, 10 mm to the side."""
    bodies = tuple(
        _shifted(body, 0.0, 0.01, 0.0) if body.name == "row_DEF_divider_left" else body
        for body in cell.pod.bodies
    )
    return _with(cell, pod=replace(cell.pod, bodies=bodies))


def _new_obstacle(cell: Cell) -> Cell:
    """A post that hangs between home and the tote, in the way of many."""
    post = box("post", (-0.9, -0.36, 1.3), (-0.8, -0.30, 2.0))
    return _with(cell, obstacles=Obstacles((*cell.obstacles.bodies, post)))


def _no_tote(cell: Cell) -> Cell:
    """Nothing that tote_10h could stand in."""
    return _with(cell, tote=replace(cell.tote, bodies=()))


CHANGES = {"a wall moved": _moved_divider, "something new": _new_obstacle, "something gone": _no_tote}
Change = Callable[[Cell], Cell]


@pytest.fixture(scope="module")
def cell() -> Cell:
    return small_cell(*NAMES)


@pytest.fixture(scope="module")
def old(cell: Cell, tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    return _built(cell, tmp_path_factory.mktemp("old"))


@pytest.fixture(scope="module", params=CHANGES)
def changed(request: pytest.FixtureRequest, cell: Cell) -> Cell:
    made: Cell = CHANGES[request.param](cell)
    return made


@pytest.fixture(scope="module")
def fresh(changed: Cell, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fresh")
    _built(changed, folder)
    return folder


def _built(cell: Cell, folder: Path) -> dict[str, bytes]:
    make_roadmap(cell, folder / "edges", FEW_EDGES)
    make_trajectories(cell, folder / "motions", LEAST_EFFORT)
    return {kind: (folder / kind).read_bytes() for kind in ("edges", "motions")}


def _refreshed(path: Path, content: bytes, cell: Cell, means: Means | None = None) -> Refresh:
    path.write_bytes(content)
    return refresh(path, surveyed(path), cell, means)


def _verdicts(path: Path, cell: Cell) -> tuple[set[MotionKey], set[MotionKey], set[MotionKey]]:
    """Which pairs have a motion, which have one for any pod, and which have none."""
    database = read_database(path, cell)
    wide = {key for key, mark in zip(database.keys, database.marks, strict=True) if mark == ANY_POD}
    return set(database.keys), wide, {key for key, _ in read_missing(path)}


def test_a_refreshed_database_says_what_a_new_one_says(
    changed: Cell, fresh: Path, old: dict[str, bytes], tmp_path: Path
) -> None:
    done = _refreshed(tmp_path / "motions", old["motions"], changed)
    ours, theirs = (_verdicts(folder / "motions", changed) for folder in (tmp_path, fresh))
    assert (ours[0], ours[2]) == (theirs[0], theirs[2])
    assert ours[1] >= theirs[1]  # what holds for any pod is kept, also where a quicker one would not
    assert done.n_kept > 0 and done.n_kept + done.n_planned == len(read_database(fresh / "motions")) + len(
        read_missing(fresh / "motions")
    )


def test_every_motion_of_it_keeps_the_clearance_that_it_tells(
    changed: Cell, old: dict[str, bytes], tmp_path: Path
) -> None:
    _refreshed(tmp_path / "motions", old["motions"], changed)
    model = CollisionModel(changed)
    for motion in read_database(tmp_path / "motions", changed, points=True):
        tests = checker(model, motion.pivot, motion.key.payload, stand=motion.mark.stand)
        assert motion.trajectory is not None
        Q = motion.trajectory.sample(np.arange(0.0, motion.duration, 0.005))
        assert tests.kernel.clearances(Q).min() >= motion.clearance >= changed.clearance


def test_a_refreshed_roadmap_says_what_a_new_one_says(
    changed: Cell, fresh: Path, old: dict[str, bytes], tmp_path: Path
) -> None:
    _refreshed(tmp_path / "edges", old["edges"], changed)
    ours, theirs = (read_roadmap(folder / "edges", changed) for folder in (tmp_path, fresh))
    assert ours.names == theirs.names and ours.edges.tolist() == theirs.edges.tolist()
    assert all(a == ANY_POD or b != ANY_POD for a, b in zip(ours.marks, theirs.marks, strict=True))
    gaps = (read_gaps(folder / "edges") for folder in (tmp_path, fresh))
    assert len({tuple(name for name, _ in gap.refused) for gap in gaps}) == 1
    model = CollisionModel(changed)
    for edge, mark in enumerate(ours.marks):
        tests = checker(model, ours.proven_for, PayloadClass.EMPTY, stand=mark.stand)
        assert tests.path_is_free(ours.edge_path(edge)) == -1


# Each stands in the way around the sweep of the pod between two configurations, and not in the way that is
# free for the pod in its place: so that is what is stored while they stand.
POSTS = (
    box("post_at_KL", (-0.62, -0.25, 0.80), (-0.43, -0.13, 0.96)),
    box("post_at_KB", (-0.65, 0.38, 1.28), (-0.49, 0.54, 1.44)),
)
AMONG_POSTS = ("bin_K", "cam_B", "cam_K", "cam_L")


def _posts_as_obstacles(cell: Cell) -> Cell:
    return _with(cell, obstacles=Obstacles((*cell.obstacles.bodies, *POSTS)))


def _posts_of_the_pod(cell: Cell) -> Cell:
    return _with(cell, pod=replace(cell.pod, bodies=(*cell.pod.bodies, *POSTS)))


def _stands(folder: Path, cell: Cell) -> dict[str, dict[object, PodStand]]:
    """For which pods each edge and each motion of a folder's files holds."""
    motions, roadmap = read_database(folder / "motions", cell), read_roadmap(folder / "edges", cell)
    pairs = [tuple(roadmap.names[node] for node in edge) for edge in roadmap.edges]
    return {
        "edges": {pair: mark.stand for pair, mark in zip(pairs, roadmap.marks, strict=True)},
        "motions": {motion.key: motion.mark.stand for motion in motions},
    }


@pytest.mark.parametrize("posts", [_posts_as_obstacles, _posts_of_the_pod])
def test_what_went_away_makes_room_for_any_pod(posts: Change, tmp_path: Path) -> None:
    """Also where it was not in the way that is stored."""
    bare = small_cell(*AMONG_POSTS)
    old, new = _built(posts(bare), tmp_path), tmp_path / "new"
    before = _stands(tmp_path, posts(bare))
    for kind, content in old.items():
        done = _refreshed(tmp_path / kind, content, bare)
        assert done.n_kept > 0 and done.n_proven == 0
    new.mkdir()
    _built(bare, new)
    ours, fresh = _stands(tmp_path, bare), _stands(new, bare)
    for kind, stands in before.items():
        nominal = [key for key, stand in stands.items() if stand is PodStand.NOMINAL]
        assert {key: ours[kind][key] for key in nominal} == {key: fresh[kind][key] for key in nominal}
        assert any(ours[kind][key] is PodStand.DISPLACED for key in nominal)
        assert all(stand is PodStand.DISPLACED for key, stand in ours[kind].items() if key not in nominal)


# As a part of the pod, its sweep is in the way from bin_K to cam_B, and free of both.
FLAP = box("flap", (-0.59, 0.12, 1.06), (-0.45, 0.20, 1.24))


@pytest.mark.parametrize(("by", "stand"), [(1.0, PodStand.DISPLACED), (-0.01, PodStand.NOMINAL)])
def test_a_part_of_the_pod_that_moved_makes_room_if_it_leaves_the_way(
    by: float, stand: PodStand, tmp_path: Path
) -> None:
    bare, path = small_cell("bin_K", "cam_B"), tmp_path / "edges"
    then, now = (
        _with(bare, pod=replace(bare.pod, bodies=(*bare.pod.bodies, _shifted(FLAP, 0.0, 0.0, z))))
        for z in (0.0, by)
    )
    make_roadmap(then, path, FEW_EDGES)
    assert [mark.stand for mark in read_roadmap(path, then).marks] == [PodStand.NOMINAL]
    done = refresh(path, surveyed(path), now)
    assert (done.changed, done.n_planned) == (("pod flap",), int(stand is PodStand.DISPLACED))
    assert [mark.stand for mark in read_roadmap(path, now).marks] == [stand]


def test_room_for_any_pod_is_looked_for_where_it_may_be() -> None:
    cell = small_cell("home", "cam_E")
    ends = np.stack([cell.configurations[name].q for name in ("home", "cam_E")])
    bare, posts = parts_of(cell), _posts_as_obstacles(cell)
    tote = replace(cell.tote, bodies=tuple(_shifted(body, 0.0, 0.01, 0.0) for body in cell.tote.bodies))

    def is_relieved(cell: Cell, before: object, payload: PayloadClass = PayloadClass.EMPTY) -> bool:
        pivot = PivotState.MOVING if payload is PayloadClass.EMPTY else PivotState.STRAIGHT
        return Reproof(cell, change_since(before, cell)).is_relieved(ends, pivot, payload)  # type: ignore[arg-type]

    assert is_relieved(cell, parts_of(posts)), "what was there went"
    assert not is_relieved(cell, parts_of(posts), PayloadClass.CENTRED_CUBE), "an end is within the sweep"
    assert not is_relieved(posts, bare), "nothing went"
    assert is_relieved(_with(cell, tote=tote), bare), "the tote moved"
    assert not is_relieved(_moved_divider(cell), bare), "a part of the pod moved that was not in the way"


def test_a_wall_that_is_far_from_all_motions_touches_few(
    cell: Cell, old: dict[str, bytes], tmp_path: Path
) -> None:
    done = _refreshed(tmp_path / "motions", old["motions"], _moved_divider(cell))
    assert done.changed == ("pod row_DEF_divider_left",) and not done.why_anew
    assert done.n_proven <= 0.15 * done.n_stored


def test_something_in_the_way_is_found_and_planned_around(
    cell: Cell, old: dict[str, bytes], tmp_path: Path
) -> None:
    done = _refreshed(tmp_path / "motions", old["motions"], _new_obstacle(cell))
    assert done.changed == ("obstacle post",)
    assert 0 < done.n_planned <= done.n_proven < done.n_stored


@pytest.mark.parametrize("kind", ["edges", "motions"])
def test_nothing_changed_nothing_done_same_bytes(
    kind: str, cell: Cell, old: dict[str, bytes], tmp_path: Path
) -> None:
    done = _refreshed(tmp_path / kind, old[kind], cell)
    assert (done.n_proven, done.n_planned, done.changed) == (0, 0, ())
    assert (tmp_path / kind).read_bytes() == old[kind]


def _other_limits(cell: Cell) -> Cell:
    limits = replace(cell.robot.limits, velocity=0.9 * cell.robot.limits.velocity)
    return _with(cell, robot=replace(cell.robot, limits=limits))


def _fixed_pod(cell: Cell) -> Cell:
    return _with(cell, pod=replace(cell.pod, displacement=UNMOVED))


@pytest.mark.parametrize(
    ("change", "told"),
    [(_other_limits, "the robot, its joint limits or its tool"), (_fixed_pod, "the pod may be displaced")],
)
def test_what_every_motion_depends_on_leaves_nothing(
    change: Change, told: str, cell: Cell, old: dict[str, bytes], tmp_path: Path
) -> None:
    other = change(cell)
    done = _refreshed(tmp_path / "motions", old["motions"], other)
    assert done.why_anew.startswith("not as it was: ") and told in done.why_anew and done.n_kept == 0
    make_trajectories(other, tmp_path / "new", LEAST_EFFORT)
    assert (tmp_path / "motions").read_bytes() == (tmp_path / "new").read_bytes()


def test_a_file_of_other_versions_is_done_anew(
    cell: Cell, old: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pickcli.precompute.refresh.versions", lambda: make.versions() | {"ompl": "0"})
    done = _refreshed(tmp_path / "edges", old["edges"], cell)
    assert "other versions" in done.why_anew and done.n_kept == 0


@pytest.mark.parametrize("parts", [None, [], {"solids": {}}, {"rules": {}, "T_world_pod": [1], "solids": {}}])
def test_a_file_that_does_not_say_what_its_cell_was_is_done_anew(
    parts: object, cell: Cell, old: dict[str, bytes], tmp_path: Path
) -> None:
    path = tmp_path / "edges"
    path.write_bytes(old["edges"])
    found = surveyed(path)
    attributes = {**found.attributes, "made": json.dumps(found.made | {"parts": parts})}
    done = refresh(path, replace(found, attributes=attributes), cell)
    assert done.why_anew == "the file does not say what its cell was" and done.n_kept == 0
    assert path.read_bytes() == old["edges"]


def test_another_named_configuration_costs_its_motions_alone(
    cell: Cell, old: dict[str, bytes], tmp_path: Path
) -> None:
    home = cell.configurations["home"]
    elsewhere = replace(home, q=home.q + 0.01)
    other = replace(cell, configurations=cell.configurations | {"home": elsewhere})
    done = _refreshed(tmp_path / "motions", old["motions"], other)
    database = read_database(tmp_path / "motions", other)
    assert done.n_kept == sum("home" not in (key.start, key.goal) for key in database.keys)
    for motion in database:
        for name, q in zip((motion.key.start, motion.key.goal), motion.path.waypoints[[0, -1]], strict=True):
            np.testing.assert_array_equal(q, other.configurations[name].q)


class _Stopping:
    """A runner that is interrupted after one task."""

    def run(self, recipe: Recipe, keys: Sequence[Key]) -> Finished:
        for key in keys[:1]:
            yield key, recipe.make(key).to_bytes()
        raise KeyboardInterrupt


def test_an_interrupted_refresh_leaves_the_old_file_and_goes_on(
    cell: Cell, old: dict[str, bytes], tmp_path: Path
) -> None:
    path, other = tmp_path / "motions", _new_obstacle(cell)
    with pytest.raises(KeyboardInterrupt):
        _refreshed(path, old["motions"], other, Means(_Stopping()))
    assert path.read_bytes() == old["motions"]
    again = refresh(path, surveyed(path), other)
    at_once = _refreshed(tmp_path / "at_once", old["motions"], other)
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
    monkeypatch.setattr(load, "load_cell", lambda name: cell)
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
        monkeypatch.setattr(load, "load_cell", lambda name: _moved_divider(cell))
        outcome = CliRunner().invoke(command, [str(path), *arguments])
        assert outcome.exit_code == 0
        if "--json" in arguments:
            told = json.loads(outcome.stdout)
            assert told["changed"] == ["pod row_DEF_divider_left"] and told["all_anew_because"] is None
            assert told["tasks_kept"] > 0
        else:
            assert "changed: pod row_DEF_divider_left" in outcome.stdout


def test_parts_name_what_changed_and_nothing_else(cell: Cell) -> None:
    before = parts_of(cell)
    assert change_since(before, cell).solids == () and change_since(before, cell).rules == ()
    assert change_since(before, _new_obstacle(cell)).came == ("obstacle post",)
    gone = change_since(before, _no_tote(cell))
    assert gone.came == () and all(name.startswith("tote ") for name in gone.went)
    T = cell.T_world_pod + 0.01 * (np.arange(16) == 3).reshape(4, 4)
    shifted = change_since(before, _with(cell, T_world_pod=T))
    assert len(shifted.came) == len(shifted.went) == len(cell.pod.bodies)
    assert change_since(before, _other_limits(cell)).rules == ("the robot, its joint limits or its tool",)


def test_marks_travel_through_the_file(cell: Cell, old: dict[str, bytes], tmp_path: Path) -> None:
    (tmp_path / "motions").write_bytes(old["motions"])
    marks = read_database(tmp_path / "motions", cell).marks
    assert ANY_POD in marks
    assert all(bool(mark.why_nominal) == (mark.stand is PodStand.NOMINAL) for mark in marks)
