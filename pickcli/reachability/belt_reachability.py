"""Where along a conveyor the arm can take items from above, by their height."""

from __future__ import annotations

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.station import Carrier
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import pose, rotation_rpy
from pickcli.kinematics.arm import Arm
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.seeds import derived_rng

HEIGHTS = (0.03, 0.14, 0.25)  # m of items over the running surface
FROM_EDGE = 0.05  # m from either edge of the belt, within which no item has its middle
YAWS = (0.0, 0.5 * np.pi, np.pi, -0.5 * np.pi)  # rad, of the tool about the vertical
SPACING = 0.05  # m between neighbouring places along the belt


def reached_travel(cell: Cell, carrier: Carrier, height: float) -> tuple[float, float] | None:
    """Find the longest stretch of a belt over whose whole width the arm can reach items from above.

    Args:
        cell: The cell, empty.
        carrier: A carrier with a conveyor.
        height: m of the items over the running surface.

    Returns:
        Its first and last place, m from the infeed; None if there is no such place.
    """
    belt = carrier.conveyor
    assert belt is not None
    arm, state = Arm(cell.robot), cell.robot.tool.default_state
    is_free = checker(CollisionModel(cell), state, PayloadClass.EMPTY)
    rng = derived_rng(0, "belt reach", carrier.name, height)
    edge = belt.width / 2 - FROM_EDGE

    def is_reached(x: float, y: float) -> bool:
        poses = (
            carrier.T_world_carrier @ pose((x, y, height), R=rotation_rpy(np.pi, 0.0, yaw)) for yaw in YAWS
        )
        return any(is_free.are_valid(arm.solve_spread(T, state, rng)).any() for T in poses)

    stretches: list[list[float]] = [[]]
    for x in np.arange(0.0, belt.length + SPACING / 2, SPACING).tolist():
        if all(is_reached(x, y) for y in (-edge, 0.0, edge)):
            stretches[-1].append(x)
        else:
            stretches.append([])
    longest = max(stretches, key=len)
    return (longest[0], longest[-1]) if longest else None
