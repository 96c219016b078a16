"""Without an extra, a command that needs it says in one sentence how to get it; all others go on."""

from __future__ import annotations

import importlib.metadata
import subprocess
import sys
from pathlib import Path

import pytest

from pickcli.precompute.artifact_files import versions
from support.bare_robot import write_bare_robot

PROGRAM = """
import sys
sys.modules.update(dict.fromkeys(sys.argv.pop(1).split(",")))  # None: importing it fails
from pickcli.commands.main import main
main()
"""
NONE = "pybullet,ompl,matplotlib,distributed,xacro,mcap,mcap_ros2,cv2"
MODULES = {"opencv-python-headless": "cv2"}  # of packages with another name


def without(packages: str, *argv: object) -> subprocess.CompletedProcess[str]:
    words = [sys.executable, "-c", PROGRAM, packages, *map(str, argv)]
    return subprocess.run(words, capture_output=True, text=True)


@pytest.mark.parametrize(
    ("package", "extra", "words"),
    [
        ("pybullet", "sim", ("make-scene", "jsk_pick_sample", "-o", "x.json")),
        ("pybullet", "sim", ("run-trial", "jsk_pick_sample", "-o", "x")),
        ("matplotlib", "view", ("inspect", "apc2016_delft", "--picture", "x.png")),
        (
            "opencv-python-headless",
            "perception",
            (
                "perceive",
                "--cell",
                "apc2016_delft",
                "--recorded",
                "x.json",
                "--sift",
                "each-view",
                "-o",
                "y.json",
            ),
        ),
        (
            "opencv-python-headless",
            "perception",
            ("run-trial", "jsk_pick_sample", "-o", "x"),
        ),
        ("ompl", "plan-offline", ("build-roadmap", "--jobs", "2", "-o", "x.h5")),
        ("ompl", "plan-offline", ("build-trajectories", "--planner", "RRTstar", "--jobs", "2", "-o", "x.h5")),
    ],
)
def test_the_extra_that_is_missing_is_named(
    package: str, extra: str, words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    done = without(MODULES.get(package, package), *words)
    assert done.returncode == 3, done.stderr
    assert f"needs {package}; install it with: pip install 'apc-pick[{extra}]'" in done.stderr
    assert "Traceback" not in done.stderr and done.stdout == ""
    assert list(tmp_path.iterdir()) == []  # nothing was begun


def test_a_library_that_is_not_installed_has_no_version(monkeypatch: pytest.MonkeyPatch) -> None:
    found = importlib.metadata.version

    def version(name: str) -> str:
        if name == "ompl":
            raise importlib.metadata.PackageNotFoundError(name)
        return found(name)

    monkeypatch.setattr(importlib.metadata, "version", version)
    assert versions()["ompl"] == "none" and versions()["numpy"] == found("numpy")


@pytest.mark.slow
def test_moves_are_planned_and_verified_without_any_extra(tmp_path: Path) -> None:
    cell = write_bare_robot(tmp_path)
    move = tmp_path / "move.json"
    assert without(NONE, "check", cell).returncode == 0
    planned = without(NONE, "plan-move", "--cell", cell, "--from", "home", "--to", "away", "-o", move)
    assert planned.returncode == 0, planned.stderr
    assert without(NONE, "verify", move, "--cell", cell).returncode == 0
    driven = without(NONE, "execute", move, "--cell", cell, "--driver", "recorder")
    assert driven.returncode == 0, driven.stderr
    assert without(NONE, "check-driver", "recorder", move, "--cell", cell).returncode == 0
    simulated = without(NONE, "execute", move, "--cell", cell)
    assert simulated.returncode == 3 and "pip install 'apc-pick[sim]'" in simulated.stderr
    to = ("export", move, "--cell", cell, "--format")
    assert without(NONE, *to, "joint-trajectory", "-o", tmp_path / "x.json").returncode == 0
    assert without(NONE, *to, "csv", "-o", tmp_path / "x.csv").returncode == 0
    refused = without(NONE, *to, "mcap", "-o", tmp_path / "x.mcap")
    assert refused.returncode == 3 and not (tmp_path / "x.mcap").exists()
    assert "needs mcap; install it with: pip install 'apc-pick[export]'" in refused.stderr
    recorded = without(NONE.replace(",mcap,mcap_ros2", ""), *to, "mcap", "-o", tmp_path / "x.mcap")
    assert recorded.returncode == 0, recorded.stderr
    shown = without(NONE, "show", move, "--cell", cell, "-o", tmp_path / "move.html")
    assert shown.returncode == 0, shown.stderr
