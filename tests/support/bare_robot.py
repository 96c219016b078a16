"""A cell of the branching robot alone: no tool on its flange, no pod, no tote."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from support.other_robots import write_robot


def write_bare_robot(folder: Path) -> Path:
    """A cell without places and tool.

    Args:
        folder: Where to write it.

    Returns:
        The cell's folder.
    """
    cell = write_robot(folder)
    content: dict[str, Any] = yaml.safe_load((cell / "cell.yaml").read_text())
    for key in ("tool", "pod", "tote"):
        del content[key]
    content["devices"] = {}
    content["accepted_warnings"] = ["no_mass"]
    content["robot"] |= {"tip": "flange", "unshaped": ["flange"]}
    (cell / "cell.yaml").write_text(yaml.safe_dump(content, sort_keys=False))
    return cell
