"""Where the robot is when a query is asked (MoveIt: the start state)."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.cell.tool import ToolState
from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class Start:
    """State of the robot at rest, from which a query starts.

    Attributes:
        q: (n,) configuration, m and rad.
        tool_state: State of the tool.
    """

    q: Array
    tool_state: ToolState
