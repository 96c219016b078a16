"""Displacement of the tote in a trial, and what the robot knows of where it stands.

Team KTH's tote was put in place by hand and then touched (paper 000, section III-A). A displaced tote is
known by an estimate with bounds of its error, or located by touching it at the start of the trial; if no
touch finds it, it may be anywhere within the tolerance of touches.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from pickcli.calibration.tote_location import (
    RANDOM,
    TOLERANCE,
    LocatedTote,
    tote_offset,
    tote_pose_in_simulation,
)
from pickcli.calibration.tote_shape import tote_shape
from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import Displacement, displaced
from pickcli.cell.station import TOTE
from pickcli.errors import InputError
from pickcli.geometry import inverse
from pickcli.scene.scene import CarrierPose, Scene, tote_pose
from pickcli.seeds import derived_rng
from pickcli.simulation.reality import Reality
from pickcli.trial.pod_shift import NONE, random_displacement

if TYPE_CHECKING:
    from pickcli.trial.order import Order


@dataclass(frozen=True, eq=False)
class ToteTouches:
    """What touching the tote at the start of a trial told.

    Attributes:
        at: Where the tote is believed to stand since.
        duration: s, simulated.
        n_planned: Number of planning calls.
        located: The estimate and its touches; None if it was not located.
        reason: Why it was not; "" if it was.
    """

    at: CarrierPose
    duration: float
    n_planned: int
    located: LocatedTote | None = None
    reason: str = ""

    def off(self, true: Scene) -> dict[str, float]:
        """Return by how much the estimate is truly off.

        Args:
            true: The true scene.

        Returns:
            x, y, z in m and yaw in rad by name, in the frame of the estimate; none if it was not located.
        """
        if self.located is None:
            return {}
        place, estimate = true.cell.places[TOTE], self.located.estimate
        return tote_offset(estimate.T_world_tote, true.T_world_place(place), estimate.names)


def tote_stands(
    stated: Displacement | str | None, reality: Reality, cell: Cell, seed: int
) -> tuple[CarrierPose | None, Reality]:
    """Compute where the tote truly stands in a trial.

    Args:
        stated: A displacement, "random" or "none"; None if not stated.
        reality: Levels, used if no displacement is stated.
        cell: The cell.
        seed: Seed of a random displacement.

    Returns:
        Its pose, None at its place in the cell; and the levels with the resulting ``tote_shift``.

    Raises:
        InputError: The displacement is beyond what touches reach, or the cell has no tote.
    """
    shift = stated or (RANDOM if reality.tote_shift else NONE)
    reality = replace(reality, tote_shift=shift == RANDOM)
    if shift == NONE:
        return None, reality
    return tote_pose(cell, tote_pose_in_simulation(cell, shift, seed)), reality


def tote_displacement(true: Scene) -> dict[str, float]:
    """Return how far the true tote is off its place.

    Args:
        true: The true scene.

    Returns:
        x, y in m and yaw in rad by name, in the frame of its place in the cell.
    """
    cell = true.cell
    return tote_offset(
        cell.T_world_place(cell.places[TOTE]), true.T_world_place(cell.places[TOTE]), ("x", "y", "yaw")
    )


def refuse_touches(cell: Cell, order: Order) -> None:
    """Refuse, before any work, to touch a tote that cannot be.

    Args:
        cell: The cell as seen by the arm that moves first.
        order: The order.

    Raises:
        InputError: The cell has no tote, or its tool no cup, or items are in the tote at the start.
    """
    tote_shape(cell)
    if cell.robot.tool.grip.gives_way == 0.0:
        raise InputError(
            f"--locate-tote: the tool of cell {cell.name} has no cup, by the lip of which the tote is felt; "
            "leave it out, then an estimate is known"
        )
    if order.contents.get(TOTE):
        raise InputError(
            "--locate-tote: the tote is touched from inside, and this order has items in it; leave it out, "
            "then an estimate is known"
        )


def estimated_tote(true: Scene, reality: Reality, seed: int) -> CarrierPose:
    """Estimate where a displaced tote stands, once for a trial.

    Args:
        true: The true scene.
        reality: Levels of the error of the estimate.
        seed: Seed of the trial.

    Returns:
        The estimate. Its bounds hold the true pose relative to it.
    """
    error = Displacement(reality.tote_position_error, reality.tote_position_error, reality.tote_angle_error)
    off = random_displacement(error, derived_rng("tote estimate", seed))
    T_true = true.T_world_place(true.cell.places[TOTE])
    return tote_pose(true.cell, T_true @ inverse(displaced(np.eye(4), off.x, off.y, off.yaw)), error)


def unlocated_tote(cell: Cell) -> CarrierPose:
    """Return what is known of a tote that nobody located.

    Args:
        cell: A cell with a tote.

    Returns:
        Its place in the cell, with the tolerance of touches as bounds.
    """
    return tote_pose(cell, tote_shape(cell).T_world_tote, TOLERANCE)


def felt_tote(located: LocatedTote, cell: Cell) -> CarrierPose:
    """Return where touches found the tote.

    Args:
        located: The estimate.
        cell: Its cell.

    Returns:
        The pose for the carriers of a scene, with bounds.
    """
    estimate = located.estimate
    return tote_pose(
        cell, estimate.T_world_tote, Displacement(*(estimate.bound(name) for name in ("x", "y", "yaw")))
    )
