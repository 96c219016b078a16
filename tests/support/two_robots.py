"""Two robots of the default cell on either side of its shelf, each with its suction lance."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import yaml

from pickcli.cell.data_path import data_path

SIDES = {"left": 1.0, "right": -1.0}
ASIDE = 1.0  # m of each rail from the middle of the shelf
PARKED = (0.25, 1.4, 0.3, 0.0, -1.9, 0.0, -0.9, 0.0)


def write_two_robots(folder: Path) -> Path:
    """A cell with two robots before the default shelf.

    Args:
        folder: Where to write it.

    Returns:
        The cell's folder, which is new.
    """
    cell = folder / "two_robots"
    cell.mkdir()
    shutil.copyfile(data_path() / "cells/apc2016_delft/robot.urdf", cell / "robot.urdf")
    (cell / "cell.yaml").write_text(json.dumps(content(), indent=1))
    return cell


def content() -> dict[str, Any]:
    """The cell file: the default cell's shelf and tote, its robot twice, each under names of its own."""
    default: dict[str, Any] = yaml.safe_load((data_path() / "cells/apc2016_delft/cell.yaml").read_text())
    robot, tool = default["robot"], default.pop("tool")
    x = robot["T_world_base"]["xyz"][0]
    configurations = {c["name"]: c for c in default["configurations"]}
    home = configurations["home"]
    parked = {
        side: [PARKED[0], sign * PARKED[1], *PARKED[2:]] for side, sign in SIDES.items()
    }  # turned away from the shelf
    arms = {
        side: {
            "joints": [f"{side}_{joint}" for joint in robot["joints"]],
            "tool": tool
            | {key: f"{side}_{tool[key]}" for key in ("flange_link", "lance_link", "cup_link", "joint")},
            "parked": "parked",
            "preference": 1 if side == "left" else 2,
        }
        for side in SIDES
    }
    for corners in (default["tote"]["inner"], default["tote"]["flange"]):
        for corner in corners.values():
            corner[1] = round(corner[1] + 0.616, 6)  # into the middle, where both reach it
    return default | {
        "name": "two_robots",
        "sensors": {},
        "robots": {
            side: {
                "urdf": "robot.urdf",
                "prefix": f"{side}_",
                "T_world_base": {"xyz": [x, ASIDE * sign, 0.0], "rpy": [0.0, 0.0, 0.0]},
            }
            for side, sign in SIDES.items()
        },
        "robot": {
            "motor_forces": {
                f"{side}_{joint}": force for side in SIDES for joint, force in robot["motor_forces"].items()
            }
        },
        "arms": arms,
        "joint_limits": {
            f"{side}_{joint}": limit for side in SIDES for joint, limit in default["joint_limits"].items()
        },
        "allowed_pairs": [
            {"a": f"{side}_link_b", "b": f"{side}_lance", "reason": "as in the default cell"}
            for side in SIDES
        ],
        "obstacles": [],
        "configurations": [
            configuration
            for side in SIDES
            for configuration in (
                {**home, "arm": side},
                {"name": "parked", "arm": side, "kind": "midway", "q": parked[side]},
            )
        ],
    }  # fmt: skip
