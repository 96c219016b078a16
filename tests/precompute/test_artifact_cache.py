"""Where the precomputed files lie, and that they are made when they are missing or bad."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from pickcli.cell.cell import Cell
from pickcli.errors import InputError
from pickcli.jobs.journal import Journal
from pickcli.path_planning.planner_names import PlannerName
from pickcli.precompute import artifact_cache
from pickcli.precompute.artifact_cache import default_paths, ensure_artifacts
from pickcli.precompute.artifact_files import make_roadmap, make_trajectories
from pickcli.precompute.roadmap_settings import RoadmapSettings
from pickcli.roadmap.store import describe, read_database, read_roadmap
from support.small_cell import LEAST_EFFORT, small_cell


@pytest.fixture
def cell(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Cell:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return small_cell("home", "bin_A", "tote")


def test_the_folder_is_named_by_the_fingerprint(
    cell: Cell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    paths = default_paths(cell)
    assert paths.roadmap.parent == paths.trajectories.parent == tmp_path / "cache" / "apc" / cell.fingerprint
    assert default_paths(replace(cell, fingerprint="0" * 64)).roadmap != paths.roadmap
    for unusable in ("", "relative/path"):
        monkeypatch.setenv("XDG_CACHE_HOME", unusable)
        assert default_paths(cell).roadmap.parent.parent == Path.home() / ".cache" / "apc"


def test_what_is_missing_is_built_once(cell: Cell) -> None:
    asked: list[str] = []

    def progress(what: str):  # type: ignore[no-untyped-def]
        asked.append(what)
        return lambda progress: None

    paths = ensure_artifacts(cell, progress)
    assert asked == ["roadmap", "trajectories"]
    assert read_roadmap(paths.roadmap, cell).n_nodes == 3
    assert len(read_database(paths.trajectories, cell)) > 0
    ensure_artifacts(cell, progress)
    assert asked == ["roadmap", "trajectories"]


def test_what_is_damaged_or_stale_is_built_again_to_the_same_bytes(cell: Cell) -> None:
    paths = ensure_artifacts(cell)
    good = paths.roadmap.read_bytes()
    paths.roadmap.write_bytes(good[: len(good) // 2])
    make_trajectories(replace(cell, fingerprint="0" * 64), paths.trajectories)
    ensure_artifacts(cell)
    assert paths.roadmap.read_bytes() == good
    assert describe(paths.trajectories)["cell_fingerprint"] == cell.fingerprint


def test_other_named_configurations_make_other_files(cell: Cell) -> None:
    """They are not in the fingerprint, so the folder is the same."""
    ensure_artifacts(cell)
    paths = ensure_artifacts(small_cell("home", "bin_A", "drop_00"))
    assert "drop_00" in read_roadmap(paths.roadmap).names
    assert {key.goal for key in read_database(paths.trajectories).keys} == {"bin_A", "drop_00"}


def test_journals_of_other_versions_do_not_pile_up(cell: Cell) -> None:
    paths = default_paths(cell)
    paths.roadmap.parent.mkdir(parents=True)
    old = Journal(paths.roadmap, "e" * 64)
    old.append(("a", "b"), b"made by another version")
    ensure_artifacts(cell)
    assert sorted(paths.roadmap.parent.iterdir()) == [paths.roadmap, paths.trajectories]


def test_a_file_says_how_it_was_made(cell: Cell, tmp_path: Path) -> None:
    settings = RoadmapSettings(PlannerName.RRT_CONNECT, n_neighbours=1, seed=5)
    make_roadmap(cell, tmp_path / "r.h5", settings)
    made = describe(tmp_path / "r.h5")["made"]
    assert made["settings"]["planner"] == "RRTConnect" and made["settings"]["seed"] == 5
    assert {"apc", "ompl", "numpy", "h5py"} == set(made["by"])
    assert made["result"]["n_neighbours"] == 1


@pytest.mark.parametrize("make", [make_roadmap, make_trajectories])
def test_a_file_that_appeared_during_a_build_stays(make: Any, tmp_path: Path) -> None:
    path = tmp_path / "file.h5"
    path.write_bytes(b"theirs")
    with pytest.raises(InputError, match="exists by now"):
        make(small_cell("bin_E", "drop_00_down"), path, overwrite=False)
    assert path.read_bytes() == b"theirs"


def test_other_seeds_make_other_bytes(tmp_path: Path) -> None:
    cell = small_cell("bin_E", "drop_00_down")
    contents = []
    for i, seed in enumerate((0, 0, 1)):
        path = tmp_path / f"{i}.h5"
        make_trajectories(cell, path, replace(LEAST_EFFORT, seed=seed))
        contents.append(path.read_bytes())
    assert contents[0] == contents[1] != contents[2]


def test_a_cache_that_cannot_be_made_is_an_input_error(
    cell: Cell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("in the way")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    with pytest.raises(InputError, match="XDG_CACHE_HOME"):
        ensure_artifacts(cell)
    assert artifact_cache.default_paths(cell).roadmap.parent.exists() is False
