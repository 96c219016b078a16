"""State of the robot at the start of a query (MoveIt: the start state)."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.cell.tool import ToolState
from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class Start:
    """State of the robot at rest at the start of a query.

    Attributes:
        q: (n,) configuration, m and rad.
        tool_state: State of the tool.
    """

    q: Array
    tool_state: ToolState
