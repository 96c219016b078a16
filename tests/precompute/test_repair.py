"""A damaged file becomes the bytes that it was, and only what is lost is computed again."""

from __future__ import annotations

import json
import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from pickcli.cell import cell_file
from pickcli.cell.cell import Cell
from pickcli.commands.check import command as check
from pickcli.errors import DamagedError, StaleError
from pickcli.motion.path import JointPath
from pickcli.motion.trajectory import Trajectory
from pickcli.precompute import artifact_files
from pickcli.precompute.repair import Repair, repair
from pickcli.roadmap.store import read_database, read_provenance, surveyed, write_database
from pickcli.roadmap.trajectory_database import CoarseMotion, TrajectoryDatabase
from support.small_cell import alone, small_cell
from support.stored_kind import KINDS
from support.stored_kind import cell as stored_cell


@pytest.fixture(scope="module")
def cell() -> Cell:
    return stored_cell()


@pytest.fixture(scope="module")
def good() -> dict[str, bytes]:
    return {name: kind.good() for name, kind in KINDS.items()}


def _damaged(path: Path, content: bytes, *places: int) -> Path:
    changed = bytearray(content)
    for place in places:
        changed[place] ^= 0x10
    path.write_bytes(changed)
    return path


@pytest.mark.parametrize("kind", ["edges", "motions"])
def test_any_flipped_bit_is_repaired_to_the_same_bytes(
    kind: str, good: dict[str, bytes], cell: Cell, tmp_path: Path
) -> None:
    rng, content = random.Random(3), good[kind]
    for _ in range(12):
        path = _damaged(tmp_path / kind, content, rng.randrange(len(content)))
        found = surveyed(path)
        n_lost = sum(bool(damage.lost) for damage in found.damage)
        done = repair(path, found, cell)
        assert path.read_bytes() == content and done.is_same
        assert done.n_done <= n_lost
    assert [file.name for file in tmp_path.iterdir()] == [kind]


@pytest.mark.parametrize("kind", ["edges", "motions"])
def test_much_damage_and_a_lost_end_are_repaired_too(
    kind: str, good: dict[str, bytes], cell: Cell, tmp_path: Path
) -> None:
    content = good[kind]
    path = tmp_path / kind
    path.write_bytes(content[: len(content) * 5 // 6])
    done = repair(path, surveyed(path), cell)
    assert path.read_bytes() == content
    assert done.n_kept > 0 or kind == "edges"  # whose polylines all lie in the lost end


def test_damage_to_the_directory_alone_costs_no_task(
    good: dict[str, bytes], cell: Cell, tmp_path: Path
) -> None:
    for place in (20, len(good["motions"]) - 80):
        path = _damaged(tmp_path / "motions", good["motions"], place)
        done = repair(path, surveyed(path), cell)
        assert done == Repair(done.n_kept, 0, True)
        assert path.read_bytes() == good["motions"]


def _other_fingerprint(cell: Cell) -> Cell:
    return replace(cell, fingerprint="0" * 64)


def _other_configurations(cell: Cell) -> Cell:
    return small_cell("home", "bin_A")


@pytest.mark.parametrize(
    ("other", "told"),
    [(_other_fingerprint, "fingerprint"), (_other_configurations, "named configurations")],
)
def test_another_cell_is_refused(
    other: Callable[[Cell], Cell], told: str, good: dict[str, bytes], cell: Cell, tmp_path: Path
) -> None:
    path = _damaged(tmp_path / "motions", good["motions"], 20)
    before = path.read_bytes()
    with pytest.raises(StaleError, match=f"{told}.*cannot be repaired"):
        repair(path, surveyed(path), other(cell))
    assert path.read_bytes() == before


def test_other_versions_are_refused(
    good: dict[str, bytes], cell: Cell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = _damaged(tmp_path / "motions", good["motions"], 20)
    monkeypatch.setattr(
        "pickcli.precompute.repair.versions", lambda: artifact_files.versions() | {"ompl": "0"}
    )
    with pytest.raises(StaleError, match="versions"):
        repair(path, surveyed(path), cell)


def test_of_a_file_with_other_joints_nothing_is_kept(
    good: dict[str, bytes], cell: Cell, tmp_path: Path
) -> None:
    """Although it says that it was made for this cell."""
    path = tmp_path / "motions"
    path.write_bytes(good["motions"])
    motions = [_without_last_joint(motion) for motion in read_database(path, points=True)]
    other = TrajectoryDatabase.of(cell.robot.joint_names[:-1], motions)
    write_database(path, other, cell.fingerprint, read_provenance(path))
    assert repair(path, surveyed(path), cell).n_kept == 0
    assert path.read_bytes() == good["motions"]


def _without_last_joint(motion: CoarseMotion) -> CoarseMotion:
    timed, names = motion.trajectory, motion.path.joint_names[:-1]
    assert timed is not None
    arrays = (part[:, :-1] for part in (timed.positions, timed.velocities, timed.accelerations))
    path = JointPath(names, motion.path.waypoints[:, :-1])
    return replace(motion, path=path, trajectory=Trajectory(names, timed.times, *arrays))


def test_the_command_names_the_damage_and_repairs_it(
    good: dict[str, bytes], cell: Cell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cell_file, "load_workcell", lambda *_: alone(cell))
    content = good["motions"]
    path = _damaged(tmp_path / "motions.h5", content, len(content) // 2, 20)
    first = CliRunner().invoke(check, [str(path), "--json"])
    told = json.loads(first.stdout)
    assert isinstance(first.exception, DamagedError) and "--repair" in str(first.exception)
    assert told["damage"][0] == {"where": "directory", "lost": None}
    assert told["damage"][1]["lost"].startswith("motions: ") and told["repair"] is None
    second = CliRunner().invoke(check, [str(path), "--repair", "--jobs", "1"])
    assert second.exit_code == 0 and path.read_bytes() == content
    assert "1 computed again; the same bytes as when it was made" in second.stdout
    third = CliRunner().invoke(check, [str(path)])
    assert third.exit_code == 0 and "undamaged" in third.stdout
