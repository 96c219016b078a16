"""Turns of several arms in one world: one arm moves while the others are stationary.

Stationary arms are fixed links of the robot, so contacts with them are judged like any other contact. Tools
on one flange take turns where the arm stands.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.errors import InputError
from pickcli.kinematics.continuous_joints import unwound_towards
from pickcli.simulation.start_check import START_TOLERANCE
from pickcli.simulation.world import World


def let_move(world: World, cell: Cell) -> None:
    """Switch to another arm, which moves from where it stands; the previous one stays where it is.

    An arm with the joints of the previous one, for another tool on the flange, stands where that one is.

    Args:
        world: The world.
        cell: The cell as seen by the other arm, with the previous one at its actual position.

    Raises:
        InputError: The previous arm holds an item, or is not where the cell has it.
    """
    before = world.scene.cell
    stood = next(state for state in before.others if state.arm == cell.arm)
    stated = next(state for state in cell.others if state.arm == before.arm)
    if world.held is not None:
        raise InputError(f"arm {before.arm} holds {world.held}; no other arm moves before it has let go")
    off = np.abs(unwound_towards(world.robot.limits, world.q, stated.q) - stated.q)
    if off.max() > START_TOLERANCE or world.tool_state != stated.tool_state:
        raise InputError(
            f"arm {before.arm} stands {off.max():.4f} rad or m from where it is to stand while arm "
            f"{cell.arm} moves, its tool {world.tool_state}; bring it to {stated} first"
        )
    is_same_arm = cell.robot.joint_names == before.robot.joint_names
    world.let_move(cell, world.q if is_same_arm else stood.q, stood.tool_state)
