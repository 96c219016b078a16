"""From the files of six robots to a verified move, as their user does it: times, spheres, verification.

    python -m bench.robots [--only panda]

The robots, with meshes, are those of example-robot-data (a development dependency). Each command is a
process; times are of its processor, children included.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from importlib.metadata import files
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

LIMITS = ("--max-acceleration", "5", "--max-jerk", "50")  # what no URDF states
ROBOTS = {
    "panda": ("panda_description/urdf/panda.urdf", "--srdf", "panda_description/srdf/panda.srdf"),
    "ur5": ("ur_description/urdf/ur5_robot.urdf", "--srdf", "ur_description/srdf/ur5.srdf"),
    "ur10": ("ur_description/urdf/ur10_robot.urdf",),
    "xarm7": ("xarm_description/urdf/xarm7.urdf", "--srdf", "xarm_description/srdf/xarm7.srdf"),
    "jaco": ("kinova_description/robots/kinova.urdf", "--srdf", "kinova_description/srdf/kinova.srdf"),
    "baxter": (
        "baxter_description/urdf/baxter.urdf", "--srdf", "baxter_description/srdf/baxter_manipulation.srdf",
        "--tip", "left_gripper", "--accept-unshaped",
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Measured:
    """One robot's figures.

    Attributes:
        robot: Its name.
        seconds: Processor time of ``apc init``, ``plan-move`` and ``verify``, s.
        n_spheres: Spheres that contain its links.
        excess_mean: m by which they stick out, mean over their surface.
        excess_max: m, at most.
    """

    robot: str
    seconds: tuple[float, float, float]
    n_spheres: int
    excess_mean: float
    excess_max: float


def measure(name: str) -> Measured:
    """Lead one robot from its files to a verified move.

    Args:
        name: One of ``ROBOTS``.

    Returns:
        What it took.
    """
    with tempfile.TemporaryDirectory() as made:
        move = Path(made) / "move.json"
        cell, told, t_init = make_cell(name, Path(made))
        _, t_plan = _apc("plan-move", "--cell", cell, "--from", "home", "--to", "parked", "-o", move)
        _, t_verify = _apc("verify", move, "--cell", cell)
    said = json.loads(told)
    seconds = (t_init, t_plan, t_verify)
    return Measured(name, seconds, said["spheres"], said["mean_excess_m"], said["max_excess_m"])


def make_cell(name: str, folder: Path) -> tuple[Path, str, float]:
    """Make the cell of one robot by ``apc init``.

    Args:
        name: One of ``ROBOTS``.
        folder: Where the cell's folder is made.

    Returns:
        The cell, what the command prints, and its processor time in s.
    """
    listed = next(path for path in files("example-robot-data") or [] if path.name == "panda.urdf")
    robots = Path(str(listed.locate())).parents[2]
    urdf, *words = (robots / word if "/" in word else word for word in ROBOTS[name])
    return folder / name, *_apc("init", folder / name, "--urdf", urdf, *words, *LIMITS, "--json")


def _apc(*words: Any) -> tuple[str, float]:
    """Run one command; what it prints, and its processor time in s."""
    before = os.times()
    done = subprocess.run(
        [sys.executable, "-m", "pickcli", *map(str, words)], capture_output=True, text=True, check=True
    )
    after = os.times()
    spent = after.children_user - before.children_user + after.children_system - before.children_system
    return done.stdout, spent


def main() -> None:
    """Measure and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--only", choices=ROBOTS, action="append")
    asked = parser.parse_args()
    outside = ("spheres", "outside mean, mm", "at most, mm")
    table = Table("robot", "init, s", "plan-move, s", "verify, s", *outside)
    for name in asked.only or ROBOTS:
        found = measure(name)
        table.add_row(
            name, *(f"{t:.1f}" for t in found.seconds), str(found.n_spheres),
            f"{1e3 * found.excess_mean:.1f}", f"{1e3 * found.excess_max:.1f}",
        )  # fmt: skip
    Console().print(table)


if __name__ == "__main__":
    main()
