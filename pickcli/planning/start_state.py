"""Where the robot is when a query is asked (MoveIt: the start state)."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.cell.tool import ToolState
from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class Start:
    """At rest, in one configuration.

    Attributes:
        q: Configuration (n,).
        tool_state: State of the tool.
    """

    q: Array
    tool_state: ToolState
