"""A cell file of the version before is refused with what to rename; its page has a command for that."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable
from pathlib import Path

from pickcli.cell.cell import Cell
from support.cell_copies import CellCopy

Refused = Callable[[Callable[[], object]], str]

PAGE = Path(__file__).parents[2] / "docs" / "formats" / "cell.md"


def to_version_1(text: str) -> str:
    """A cell file of today with the keys that version 1 had."""
    for now, before in (
        (r"^version: 2", "version: 1"),
        (r"^  joint:", "  pivot_joint:"),
        (r"^  states:", "  pivot_positions:"),
        (r"kind: tool_actuator", "kind: pivot"),
        (r", tool_state: ", ", pivot: "),
    ):
        text, n = re.subn(now, before, text, flags=re.MULTILINE)
        assert n, now
    return text


def test_a_cell_of_version_1_is_told_in_one_line_what_to_rename(
    cell_copy: CellCopy, refused: Refused
) -> None:
    path = cell_copy.yaml.path
    path.write_text(to_version_1(path.read_text()))
    assert refused(cell_copy.load) == (
        f"{path}:11:1: version: 1 is the version before; rename tool.pivot_joint to joint, "
        "tool.pivot_positions to states, pivot of configurations to tool_state, "
        "the kind pivot of devices to tool_actuator, and write 2"
    )


def test_the_command_of_the_page_brings_version_1_up_to_date(cell: Cell, cell_copy: CellCopy) -> None:
    path = cell_copy.yaml.path
    today = path.read_text()
    path.write_text(to_version_1(today))
    (command,) = re.findall(r"^sed -i .*?cell\.yaml$", PAGE.read_text(), re.DOTALL | re.MULTILINE)
    subprocess.run(command, shell=True, cwd=cell_copy.folder, check=True)
    assert path.read_text() == today
    assert cell_copy.load().fingerprint == cell.fingerprint
