"""``--learn`` keeps what is found; without it nothing changes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from pickcli.commands.options import artifact_options
from pickcli.errors import DamagedError
from pickcli.precompute.experience import ExperienceFiles
from support.command_line import ITEM, Made, apc, refused


def _pick(made: Made, folder: Path, name: str, *options: object) -> tuple[dict[str, Any], str]:
    """A plan without its wall-clock figures, and what was said on stderr."""
    plan = folder / f"{name}.json"
    files = ("--roadmap", folder / "roadmap.h5") if (folder / "roadmap.h5").exists() else ()
    answer = apc(
        "plan-pick", "--scene", made.scene, "--bin", "bin_C", "--item", ITEM, "--from", "cam_K",
        "-o", plan, *files, *options,
    )  # fmt: skip
    assert answer.code == 0, answer.err
    return {k: v for k, v in json.loads(plan.read_text()).items() if k != "statistics"}, answer.err


def test_a_pick_learns_and_only_who_asks_uses_it(made: Made, empty_cache: Path, tmp_path: Path) -> None:
    before, _ = _pick(made, tmp_path, "before")
    _, said = _pick(made, tmp_path, "learning", "--learn")
    assert "note: learned" in said
    (learned,) = empty_cache.rglob("roadmap.learned.h5")
    content = learned.read_bytes()
    assert _pick(made, tmp_path, "without")[0] == before
    assert learned.read_bytes() == content
    first, _ = _pick(made, tmp_path, "first", "--learn")
    assert apc("check", learned).code == 0
    told = json.loads(apc("inspect", learned, "--json").out)
    assert told["made"]["settings"] == {"learned": True} and told["edges"] >= 1
    assert first["certificate"] is not None


def test_a_damaged_learned_file_is_named_and_can_be_deleted(
    made: Made, empty_cache: Path, tmp_path: Path
) -> None:
    _pick(made, tmp_path, "learning", "--learn")
    (learned,) = empty_cache.rglob("roadmap.learned.h5")
    whole = learned.read_bytes()
    learned.write_bytes(whole[:1000])
    options = ("--scene", made.scene, "--from", "home", "--to", "bin_C", "-o", tmp_path / "move.json")
    answer = apc("plan-move", *options, "--learn")
    assert answer.code == 4 and learned.name in answer.err and "delete it" in answer.err
    learned.write_bytes(whole[:-10] + bytes(10))
    repaired = apc("check", learned, "--repair")
    assert repaired.code == 4 and "learned again" in repaired.err
    learned.unlink()
    assert apc("plan-move", *options, "--learn").code == 0


def test_where_nothing_can_be_kept_it_is_said_at_once(
    made: Made, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "/proc/none")
    plan = tmp_path / "plan.json"
    answer = apc(
        "plan-move", "--scene", made.scene, "--from", "home", "--to", "bin_C", "-o", plan, "--learn"
    )  # fmt: skip
    refused(answer, 3, "learned.h5: nothing can be written in /proc", "--roadmap and --trajectories")
    assert not plan.exists()


@pytest.mark.parametrize("command", ["plan-pick", "plan-move", "run-trial"])
def test_what_was_asked_for_is_written_before_learning_fails(
    command: str, made: Made, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def damaged(self: ExperienceFiles, lessons: object) -> None:
        raise DamagedError("roadmap.learned.h5: damaged meanwhile")

    monkeypatch.setattr(ExperienceFiles, "learn_edges", damaged)
    monkeypatch.setattr(artifact_options, "_build_missing", lambda cell, jobs: None)
    out = tmp_path / "out"
    argv = {
        "plan-pick": ("--scene", made.scene, "--bin", "bin_C", "--item", ITEM),
        "plan-move": ("--scene", made.scene, "--from", "home", "--to", "bin_C"),
        "run-trial": (made.order, "--seed", 3, "--perception", "noise"),
    }[command]
    answer = apc(command, *argv, "-o", out, "--learn")
    assert answer.code == 4 and "damaged meanwhile" in answer.err
    assert out.exists() and answer.out != ""
