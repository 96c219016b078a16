"""Reads and writes files of recorded grasps, as JSON. See docs/formats/grasps.md."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.errors import InputError
from pickcli.files.atomic_write import write_text
from pickcli.files.file_kind import GRASPS
from pickcli.files.schema import validate
from pickcli.files.source import Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.grasping.recorded_grasp import RecordedGrasp
from pickcli.grasping.recorded_grasp_schema import MOST_GRASPS, RecordedGraspModel, RecordedGraspsModel
from pickcli.name_suggestion import suggestion
from pickcli.scene.scene_checks import check_item
from pickcli.scene.scene_file import pose_of_model, pose_values

# m between pregrasp or postgrasp and grasp: less is no direction, and farther off is not about the item.
LEAST_APART, MOST_APART = 1e-3, 0.5
FARTHEST = 0.5  # m that the tool frame may be from the middle of the item at the grasp


def read_recorded_grasps(path: Path, cell: Cell) -> tuple[RecordedGrasp, ...]:
    """Read a file of recorded grasps.

    Args:
        path: The file.
        cell: The cell whose tool is to grasp.

    Returns:
        The grasps, in their order.

    Raises:
        InputError: With every mistake and its position.
    """
    source = read_yaml(Path(path), GRASPS, is_json=True)
    model = validate(source, RecordedGraspsModel)
    if model.cell != cell.name:
        text = (
            f"the grasps are of the tool of cell {model.cell}, not of {cell.name}; name its file, or its cell"
        )
        source.add(("cell",), text)
        source.check()
    found = tuple(_grasp(source, ("grasps", i), given, cell) for i, given in enumerate(model.grasps))
    source.check()
    return found


def write_recorded_grasps(
    grasps: Sequence[RecordedGrasp], cell: Cell, path: Path, replace: bool = True
) -> None:
    """Write a file of recorded grasps atomically; what could not be read again is refused.

    Args:
        grasps: The grasps, at least one.
        cell: The cell whose tool they are of.
        path: The file.
        replace: Whether an existing file may be replaced.

    Raises:
        InputError: The file cannot be written, has too many grasps, or one is out of range.
    """
    if len(grasps) > MOST_GRASPS:
        raise InputError(f"{path}: {len(grasps)} grasps, {MOST_GRASPS} at most; begin another file")
    for grasp in grasps:
        if faults := _faults(grasp):
            raise InputError(
                f"grasp of {grasp.item}: {'; '.join(f'{key}: {text}' for key, text in faults.items())}"
            )
    head = {"format": "apc grasps", "version": 1, "cell": cell.name}
    lines = [f"  {json.dumps(key)}: {json.dumps(value)}," for key, value in head.items()]
    rows = ",\n".join("    " + json.dumps(_values(grasp)) for grasp in grasps)
    write_text(Path(path), "\n".join(["{", *lines, '  "grasps": [', rows, "  ]", "}"]) + "\n", replace)


def _grasp(
    source: Source, key: tuple[str | int, ...], given: RecordedGraspModel, cell: Cell
) -> RecordedGrasp:
    """Return a grasp, and report what is wrong with it."""
    check_item(source, (*key, "name"), given, cell)
    states = [state.name for state in cell.robot.tool.states]
    if given.tool_state not in states:
        hint = suggestion(given.tool_state, states)
        source.add((*key, "tool_state"), f"unknown state of the tool {given.tool_state!r}; {hint}")
    before, at, after = (
        pose_of_model(source, (*key, name), getattr(given, name))
        for name in ("pregrasp", "grasp", "postgrasp")
    )
    grasp = RecordedGrasp(given.name, given.year, given.tool_state, before, at, after, given.source)
    for name, text in _faults(grasp).items():
        source.add((*key, name), text)
    return grasp


def _faults(grasp: RecordedGrasp) -> dict[str, str]:
    """Say which poses of a grasp are out of range, and why."""
    faults, at = {}, grasp.T_item_grasp[:3, 3]
    if (off := float(np.linalg.norm(at))) > FARTHEST:
        faults["grasp"] = f"{off:.2f} m from the middle of the item, {FARTHEST:g} at most; it is in its frame"
    for name, T in (("pregrasp", grasp.T_item_pregrasp), ("postgrasp", grasp.T_item_postgrasp)):
        apart = float(np.linalg.norm(T[:3, 3] - at))
        if not LEAST_APART <= apart <= MOST_APART:
            span = f"{1e3 * LEAST_APART:g} to {1e3 * MOST_APART:g}"
            faults[name] = f"{1e3 * apart:.1f} mm from the grasp; state it {span} mm off"
    return faults


def _values(grasp: RecordedGrasp) -> dict[str, Any]:
    return {
        "name": grasp.item,
        "year": grasp.year,
        "tool_state": grasp.tool_state,
        "pregrasp": pose_values(grasp.T_item_pregrasp),
        "grasp": pose_values(grasp.T_item_grasp),
        "postgrasp": pose_values(grasp.T_item_postgrasp),
        "source": grasp.source,
    }
