"""Checks that a plan may start: it is for this cell, and begins at the robot's configuration."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.cell.tool import MOVING, Tool, ToolState
from pickcli.errors import InputError, StaleError
from pickcli.kinematics.continuous_joints import unwound_towards
from pickcli.motion.plan import Plan, other_arm_elsewhere
from pickcli.simulation.driver import Driver

WIDTH_TOLERANCE = 2e-3  # m, tolerance of the width at which fingers are in a state
START_TOLERANCE = 0.01  # rad or m per joint between the robot and the plan's first point


class StartError(InputError):
    """The robot is not where the plan begins.

    Args:
        joint: Name of the joint with the largest offset.
        offset: Its offset.
        unit: Unit of the offset, "m" or "rad".
        advice: Advice for the user.
    """

    def __init__(self, joint: str, offset: float, unit: str, advice: str = "") -> None:
        super().__init__(
            f"refusing to start: {joint} is {offset:.4f} {unit} from the plan's first point (at most "
            f"{START_TOLERANCE} {unit}); plan a move from the measured configuration to it first"
            f"{advice and f' ({advice})'}"
        )
        self.joint, self.offset, self.unit = joint, offset, unit


def at_the_robot(plan: Plan, driver: Driver) -> Plan:
    """Shift a plan by whole turns of continuous joints towards the robot's configuration.

    Args:
        plan: The plan.
        driver: The robot.

    Returns:
        The same motion, with a first point within half a turn of the robot's configuration.
    """
    trajectory = plan.trajectory
    first = trajectory.positions[0]
    by = unwound_towards(driver.cell.robot.limits, first, driver.q) - first
    if not by.any():
        return plan
    return replace(plan, trajectory=replace(trajectory, positions=trajectory.positions + by))


def check_start(plan: Plan, driver: Driver) -> None:
    """Check that a plan is for this cell and begins at the robot's configuration and tool state.

    Args:
        plan: The plan.
        driver: The robot.

    Raises:
        StaleError: The plan is for another cell, or was made for other positions of the other arms.
        StartError: The robot is not where the plan begins.
        InputError: The tool is in another state than at the start of the plan.
    """
    cell = driver.cell
    if why := other_arm_elsewhere(plan, cell):
        raise StaleError(f"the plan was {why}")
    if plan.cell_fingerprint != cell.fingerprint:
        raise StaleError(
            f"the plan is for the cell {plan.cell_fingerprint[:12]}, this one is "
            f"{cell.fingerprint[:12]}; plan again"
        )
    offsets = np.abs(driver.q - plan.trajectory.positions[0])
    worst = int(np.argmax(offsets))
    if offsets[worst] > START_TOLERANCE:
        raise StartError(cell.robot.joint_names[worst], float(offsets[worst]), cell.robot.units[worst])
    wanted, now = plan.segments[0].tool_state, driver.tool_state
    if MOVING not in (wanted, now) and not _is_as(cell.robot.tool, wanted, now):
        what = cell.robot.tool.grip.holder
        raise InputError(f"refusing to start: the {what} is {now}, the plan begins with it {wanted}")


def _is_as(tool: Tool, wanted: ToolState, now: ToolState) -> bool:
    """Whether a tool is in a state; widths of fingers on an item are compared with a tolerance."""
    if not tool.grip.takes_widths:
        return wanted == now
    return abs(tool.position(wanted) - tool.position(now)) < WIDTH_TOLERANCE
