"""Check the cell's limit of the tool speed, which holds in every motion."""

from __future__ import annotations

from collections.abc import Iterator

from pickcli.cell.cell import Cell
from pickcli.errors import Reason
from pickcli.motion.plan import Plan
from pickcli.verification.straightness_check import SPEED_TOLERANCE, fastest_tip


def check_tool_speed(plan: Plan, cell: Cell) -> Iterator[Reason]:
    """Check that the tip never exceeds ``max_tool_speed``, for any state of the tool.

    Args:
        plan: The plan.
        cell: The cell.

    Yields:
        Faults.
    """
    limit = cell.max_tool_speed
    if limit is None:
        return
    for k, segment in enumerate(plan.segments):
        span = segment.t_start, segment.t_end
        speed = max(fastest_tip(plan, cell.robot, tool_state, *span) for tool_state in cell.robot.tool.states)
        if not speed <= limit * (1.0 + SPEED_TOLERANCE):
            where = f"segment {k} ({segment.kind})"
            yield Reason("tool speed", where, f"{speed:.4f} m/s, the cell allows {limit}")
