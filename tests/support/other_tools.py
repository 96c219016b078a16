"""Copies of the default cell with another tool: a cup that no joint moves, and one with a third state."""

from __future__ import annotations

import re

import numpy as np

from support.cell_copies import CellCopy

SLANT = 0.5  # rad, the third state

ONE_STATE, THREE_STATES = "one state", "three states"


def with_tool(copy: CellCopy, kind: str) -> CellCopy:
    """The copy with ONE_STATE or THREE_STATES."""
    return {ONE_STATE: _rigid, THREE_STATES: _with_slanted_state}[kind](copy)


def _rigid(copy: CellCopy) -> CellCopy:
    """The cup fixed straight to the lance: no joint, no device, no configuration for a cup that is down."""
    copy.urdf.replace('<joint name="cup_pivot" type="revolute">', '<joint name="cup_pivot" type="fixed">')
    copy.yaml.replace("  joint: cup_pivot\n", "")
    copy.yaml.replace(f"  states: {{straight: 0.0, down: {np.pi / 2}}}\n", "")
    copy.yaml.replace(", cup_pivot: 20}", "}")
    copy.yaml.replace('  cup_pivot: {kind: tool_actuator, lead: 0.4, actions: ["straight", "down"]}\n', "")
    text = re.sub(r"  - \{name: \w+, kind: \w+, tool_state: down, [^\n]*\n", "", copy.yaml.path.read_text())
    copy.yaml.path.write_text(text.replace("tool_state: straight, ", ""))
    return copy


def _with_slanted_state(copy: CellCopy) -> CellCopy:
    """A state between the two of the default cell, named after them in the file."""
    copy.yaml.replace(f"down: {np.pi / 2}}}", f"down: {np.pi / 2}, slanted: {SLANT}}}")
    copy.yaml.replace('actions: ["straight", "down"]', 'actions: ["straight", "down", "slanted"]')
    return copy
