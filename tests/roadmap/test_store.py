"""HDF5 files: exact, repeatable, and no damage or malice goes unnoticed."""

from __future__ import annotations

import os
import resource
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import h5py
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.errors import ApcError, DamagedError, InputError, StaleError
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.roadmap_tables import ROADMAP
from pickcli.roadmap.store import (
    describe,
    read_database,
    read_roadmap,
    surveyed,
    write_database,
    write_roadmap,
)
from pickcli.storage.safe_open import _dataset
from support.stored_samples import FINGERPRINT, JOINTS, MADE, database, roadmap
from support.tool_states import ALL_STATES


@pytest.fixture
def path(tmp_path: Path) -> Path:
    target = tmp_path / "roadmap.h5"
    write_roadmap(target, roadmap(), FINGERPRINT, MADE)
    return target


def test_a_roadmap_comes_back_exactly(path: Path) -> None:
    _assert_same(read_roadmap(path), roadmap())


def test_an_empty_roadmap_comes_back(tmp_path: Path) -> None:
    target = tmp_path / "empty.h5"
    write_roadmap(target, Roadmap.empty(JOINTS), FINGERPRINT, {})
    _assert_same(read_roadmap(target), Roadmap.empty(JOINTS))


def test_a_database_comes_back_exactly_with_or_without_points(tmp_path: Path) -> None:
    target = tmp_path / "trajectories.h5"
    write_database(target, database(), FINGERPRINT, MADE)
    full, slim = read_database(target, points=True), read_database(target)
    for stored in (full, slim):
        assert (stored.keys, stored.tool_states, stored.joint_names) == (
            database().keys,
            database().tool_states,
            JOINTS,
        )
        np.testing.assert_array_equal(stored.waypoints, database().waypoints)
        np.testing.assert_array_equal(stored.offsets, database().offsets)
    assert slim.points is None and full.points is not None
    for name, array in vars(database().points).items():
        np.testing.assert_array_equal(getattr(full.points, name), array)


def test_same_content_same_bytes_wherever_it_lies(path: Path, tmp_path: Path) -> None:
    other = tmp_path / "elsewhere.h5"
    write_roadmap(other, roadmap(), FINGERPRINT, dict(reversed(MADE.items())))
    assert other.read_bytes() == path.read_bytes()
    write_roadmap(other, roadmap(), FINGERPRINT, {"seed": 8})
    assert other.read_bytes() != path.read_bytes()


def test_truncation_is_found_or_harmless(path: Path, tmp_path: Path) -> None:
    """Only the spare copy of the directory, at the end, may be missing."""
    content = path.read_bytes()
    cut = tmp_path / "cut.h5"
    for size in sorted({*range(0, len(content), len(content) // 60), 1, 7, 8, len(content) - 1}):
        cut.write_bytes(content[:size])
        try:
            _assert_same(read_roadmap(cut), roadmap())
        except (DamagedError, InputError) as error:
            assert "cut.h5" in str(error)
        else:
            assert size > len(content) // 2


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(where=st.floats(0, 1, exclude_max=True), bit=st.integers(0, 7))
def test_a_flipped_bit_is_found_or_harmless(path: Path, where: float, bit: int) -> None:
    content = bytearray(path.read_bytes())
    content[int(where * len(content))] ^= 1 << bit
    flipped = path.with_name("flipped.h5")
    flipped.write_bytes(content)
    try:
        stored = read_roadmap(flipped)
    except ApcError:
        return
    _assert_same(stored, roadmap())


def test_a_file_of_another_cell_is_refused_with_both_fingerprints(path: Path) -> None:
    with pytest.raises(StaleError, match=f"{'f' * 16}.*{'0' * 16}"):
        read_roadmap(path, _cell("0" * 64))
    _assert_same(read_roadmap(path, _cell(FINGERPRINT)), roadmap())


def test_joints_and_limits_must_be_those_of_the_cell(path: Path) -> None:
    with pytest.raises(DamagedError, match="joints are x y z, not a b c"):
        read_roadmap(path, _cell(FINGERPRINT, names=("a", "b", "c")))
    with pytest.raises(DamagedError, match="outside of the joint limits"):
        read_roadmap(path, _cell(FINGERPRINT, size=0.1))


def test_missing_files_and_wrong_kinds_are_input_errors(path: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_roadmap(tmp_path / "nothing.h5")
    with pytest.raises(InputError, match="not a regular file"):
        read_roadmap(tmp_path)
    with pytest.raises(InputError, match="expected a trajectory database, found roadmap"):
        read_database(path)


def test_another_version_is_stale(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        file.attrs["version"] = np.bytes_(b"0")
    with pytest.raises(StaleError, match="version 0"):
        read_roadmap(path)


def test_a_place_that_cannot_be_written_is_an_input_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written"):
        write_roadmap(tmp_path / "no" / "such" / "folder.h5", roadmap(), FINGERPRINT, MADE)


def test_a_failed_write_leaves_the_old_file_and_nothing_else(path: Path, monkeypatch: Any) -> None:
    before = path.read_bytes()

    def full(*args: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="No space left"):
        write_roadmap(path, Roadmap.empty(JOINTS), FINGERPRINT, MADE)
    assert path.read_bytes() == before
    assert list(path.parent.iterdir()) == [path]


def test_a_file_size_limit_leaves_the_old_file_and_nothing_else(path: Path) -> None:
    """As a full disk does: an error of ours, not a crash of HDF5."""
    before, limits = path.read_bytes(), resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, limits[1]))
    try:
        with pytest.raises(InputError, match="File too large; it is left as it was"):
            write_roadmap(path, Roadmap.empty(JOINTS), FINGERPRINT, MADE)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert path.read_bytes() == before
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.parametrize(
    "kind", ["external link", "soft link", "virtual", "external storage", "bomb", "group", "gzip", "extra"]
)
def test_hostile_files_are_refused(path: Path, tmp_path: Path, kind: str) -> None:
    secret = tmp_path / "secret.h5"
    with h5py.File(secret, "w") as file:
        file["waypoints"] = np.zeros((4, 3))
    with h5py.File(path, "r+", libver="latest") as file:
        shape = file["waypoints"].shape
        if kind != "extra":
            del file["waypoints"]
        if kind == "external link":
            file["waypoints"] = h5py.ExternalLink(str(secret), "/waypoints")
        elif kind == "soft link":
            file["waypoints"] = h5py.SoftLink("/configurations")
        elif kind == "virtual":
            layout = h5py.VirtualLayout((4, 3), "<f8")
            layout[:] = h5py.VirtualSource(str(secret), "waypoints", (4, 3))
            file.create_virtual_dataset("waypoints", layout)
        elif kind == "external storage":
            raw = [(str(secret), 0, h5py.h5f.UNLIMITED)]
            file.create_dataset("waypoints", shape, "<f8", external=raw)
        elif kind == "bomb":
            file.create_dataset("waypoints", (10**9, 3), "<f8", chunks=(1000, 3), fletcher32=True)
        elif kind == "group":
            file.create_group("waypoints")
        elif kind == "gzip":
            file.create_dataset("waypoints", shape, "<f8", compression="gzip", fletcher32=True)
        else:
            file["more"] = np.zeros(3)
    with pytest.raises(DamagedError):
        read_roadmap(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"edges": np.full((5, 2), 99)}, "not there"),
        ({"edges": np.array([[0, 2]] * 5)}, "does not join"),
        ({"lengths": np.ones(5)}, "length"),
        ({"offsets": np.array([0, 3, 2, 9, 12, 15])}, "do not divide"),
        ({"configurations": np.full((6, 3), np.nan)}, "finite"),
        ({"names": ("a",) * 6}, "same name"),
    ],
)
def test_contents_that_make_no_sense_are_refused(path: Path, change: dict[str, Any], message: str) -> None:
    """As written by someone who keeps the checksums right."""
    write_roadmap(path, replace(roadmap(), **change), FINGERPRINT, MADE)
    with pytest.raises(DamagedError, match=message):
        read_roadmap(path)


def test_a_file_describes_itself(path: Path) -> None:
    told = describe(path)
    assert (told["format"], told["cell_fingerprint"], told["made"]) == ("roadmap", FINGERPRINT, MADE)
    assert told["rows"]["nodes"] == told["rows"]["configurations"] == 6
    assert set(told["rows"]) == {*ROADMAP.tables, *ROADMAP.owners}


def _assert_same(a: Roadmap, b: Roadmap) -> None:
    assert (a.joint_names, a.names, a.tool_states, a.proven_for) == (
        b.joint_names,
        b.names,
        b.tool_states,
        b.proven_for,
    )
    for name in ("configurations", "edges", "lengths", "waypoints", "offsets"):
        np.testing.assert_array_equal(getattr(a, name), getattr(b, name))


def _cell(fingerprint: str, names: tuple[str, ...] = JOINTS, size: float = 1.0) -> Cell:
    """As much of a cell as reading needs."""
    box = np.full(3, size)
    limits = SimpleNamespace(lower=-box, upper=box, velocity=box, acceleration=box)
    robot = SimpleNamespace(
        joint_names=names, limits=limits, tool=SimpleNamespace(states_and_moving=ALL_STATES)
    )
    return cast(Cell, SimpleNamespace(fingerprint=fingerprint, robot=robot))


def test_a_description_of_any_cell_can_be_read_again(tmp_path: Path) -> None:
    """What is written of a cell with two thousand obstacles is read; what is not read is not written."""
    target = tmp_path / "roadmap.h5"
    parts = {f"obstacle {i:05d}": [["box", [0.1, 0.2, 0.3]], np.eye(4).tolist()] for i in range(2000)}
    write_roadmap(target, roadmap(), FINGERPRINT, MADE | {"parts": parts})
    assert describe(target)["made"]["parts"] == parts
    assert surveyed(target).damage == ()
    with pytest.raises(InputError, match="made takes over 8 MB"):
        write_roadmap(tmp_path / "more.h5", roadmap(), FINGERPRINT, MADE | {"parts": "x" * (9 << 20)})
    assert not (tmp_path / "more.h5").exists()


def test_a_description_that_was_edited_is_refused(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        made = file.attrs["made"]
        file.attrs.modify("made", np.bytes_(bytes(made).replace(b"7", b"8")))
    with pytest.raises(DamagedError, match="SHA-256"):
        read_roadmap(path)


def test_data_in_another_file_are_refused_before_they_are_read(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "store.h5", "w", libver="latest") as file:
        raw = [(str(tmp_path / "secret"), 0, h5py.h5f.UNLIMITED)]
        file.create_dataset("elsewhere", (4, 3), "<f8", external=raw)
        file.create_dataset("here", data=np.zeros((4, 3)))
        assert len(_dataset(file, "here", None, 10**6)) == 4
        with pytest.raises(ValueError, match="elsewhere"):
            _dataset(file, "elsewhere", None, 10**6)


def test_an_edge_of_one_waypoint_is_refused(path: Path) -> None:
    whole = roadmap()
    dot: dict[str, Any] = {"edges": np.array([[0, 0]]), "lengths": np.zeros(1), "offsets": np.array([0, 1])}
    dot |= {"waypoints": whole.configurations[:1], "validities": whole.validities[:1]}
    write_roadmap(path, replace(whole, **dot), FINGERPRINT, MADE)
    with pytest.raises(DamagedError, match="do not divide"):
        read_roadmap(path)
