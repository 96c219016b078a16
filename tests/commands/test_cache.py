"""Where built files lie, what is there, and away with it: with everything in it, and nothing beside it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pickcli.cell.cell_file import load_cell
from support.command_line import apc, refused


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "apc"


def test_a_cache_that_is_not_there_is_empty(cache: Path) -> None:
    assert apc("cache").out == f"{cache}: 0.0 MB in 0 folders\n"
    assert apc("cache", "--clear").code == 0


def test_the_cache_is_shown_by_cell_and_deleted(cache: Path) -> None:
    fingerprint = load_cell("apc2016_delft").fingerprint
    for folder, n_bytes in ((fingerprint, 300_000), ("0" * 64, 100_000)):
        (cache / folder).mkdir(parents=True)
        (cache / folder / "roadmap.h5").write_bytes(bytes(n_bytes))
    (cache.parent / "other").write_text("of another program")
    assert apc("cache").out.splitlines() == [
        f"{cache}: 0.4 MB in 2 folders",
        f"  {'0' * 64}: 1 files, 0.1 MB",
        f"  {fingerprint}: 1 files, 0.3 MB, cell apc2016_delft",
    ]
    told = json.loads(apc("cache", "--json").out)
    assert told["path"] == str(cache) and [folder["bytes"] for folder in told["folders"]] == [
        100_000,
        300_000,
    ]
    assert "deleted 0.4 MB in 2 folders" in apc("cache", "--clear").out
    assert list(cache.iterdir()) == [] and (cache.parent / "other").exists()


def test_a_folder_that_cannot_be_deleted_is_named(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(folder: Path) -> None:
        raise PermissionError(13, "Permission denied")

    (cache / "a").mkdir(parents=True)
    monkeypatch.setattr("shutil.rmtree", fail)
    refused(apc("cache", "--clear"), 3, f"{cache / 'a'}: cannot be deleted: Permission denied")
