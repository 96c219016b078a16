"""Recorded grasps: pregrasp, grasp and postgrasp of an item, as the PR2 system of 2013 kept them (IV-A).

They are poses of the tool in the frame of the item, stated by hand or taken from a plan that was verified,
and are used wherever the item lies.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.errors import InputError, StaleError
from pickcli.geometry import Array, inverse, pose
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind

USUAL_DISTANCE = (
    0.1  # m from the grasp back along the tool's axis to a pregrasp or postgrasp that is not stated
)


@dataclass(frozen=True, eq=False)
class RecordedGrasp:
    """A grasp of one kind of item.

    Attributes:
        item: Name of the item.
        year: Its year.
        tool_state: Name of the tool's state in which it reaches the item.
        T_item_pregrasp: (4, 4) pose of the tool frame from which it goes straight to the grasp.
        T_item_grasp: (4, 4) its pose at the grasp.
        T_item_postgrasp: (4, 4) its pose after the lift, in the frame of the item as it was at the grasp.
        source: Where it is from, in words.
    """

    item: str
    year: int
    tool_state: str
    T_item_pregrasp: Array
    T_item_grasp: Array
    T_item_postgrasp: Array
    source: str = ""


def recorded_along_axis(
    item: tuple[str, int], tool_state: str, T_item_grasp: Array, source: str
) -> RecordedGrasp:
    """Record a stated grasp that the tool reaches and leaves along its own axis.

    Args:
        item: Name and year.
        tool_state: Name of the tool's state.
        T_item_grasp: (4, 4) pose of the tool frame at the grasp.
        source: Where it is from.

    Returns:
        The grasp, its pregrasp and postgrasp ``USUAL_DISTANCE`` before it.
    """
    back = T_item_grasp @ pose((0.0, 0.0, -USUAL_DISTANCE))
    return RecordedGrasp(*item, tool_state, back, T_item_grasp, back, source)


def recorded_from_plan(plan: Plan, cell: Cell) -> RecordedGrasp:
    """Record the grasp of a plan that the verifier has certified.

    The pregrasp is where its approach begins, the postgrasp where its lift ends. On a running conveyor both
    are relative to the belt.

    Args:
        plan: The plan.
        cell: Its cell, as the moving arm sees it.

    Returns:
        The grasp.

    Raises:
        InputError: The plan has no grasp or no certificate.
        StaleError: It was made for another cell.
    """
    if plan.grasp is None:
        raise InputError(f"the plan ({plan.query}) has no grasp to record; name one of apc plan-pick")
    if plan.certificate is None:
        raise InputError(f"the plan ({plan.query}) was not verified; plan it again without --no-verify")
    if plan.cell_fingerprint != cell.fingerprint:
        raise StaleError(f"the plan ({plan.query}) was made for another cell than {cell.name}; plan it again")
    name = plan.grasp.item.partition("#")[0]
    years = sorted(
        (year for known, year in cell.items if known == name), key=lambda year: (year == 2016, year)
    )
    if not years:
        raise InputError(
            f"the plan's item {plan.grasp.item} is none of the cell's items; name them with --items"
        )
    contact = next(s for s in plan.segments if s.kind is SegmentKind.CONTACT)
    approach = next(s for s in plan.segments if s.kind is SegmentKind.APPROACH)
    lift = [s for s in plan.segments if s.kind is SegmentKind.LIFT and s.t_start >= contact.t_end][-1]
    T_world_grasp = _tip(plan, cell, contact, contact.t_end)
    before, after = (
        inverse(T_world_grasp) @ _beside(plan, cell, segment, t, contact.t_end)
        for segment, t in ((approach, approach.t_start), (lift, lift.t_end))
    )
    grasp = plan.grasp.T_item_tip
    state = plan.grasp.tool_state.name
    return RecordedGrasp(name, years[-1], state, grasp @ before, grasp, grasp @ after, plan.query)


def _tip(plan: Plan, cell: Cell, segment: Segment, t: float) -> Array:
    """Return the pose (4, 4) of the tool frame at a time (s) of a segment."""
    q = plan.trajectory.sample(np.array([t]))[0]
    return Arm(cell.robot).tip(q, segment.tool_state)


def _beside(plan: Plan, cell: Cell, segment: Segment, t: float, t_grasp: float) -> Array:
    """Return the pose (4, 4) of the tool frame at a time, beside the belt where it was at the grasp."""
    T = _tip(plan, cell, segment, t)
    if plan.tracking is not None:
        along = cell.carriers[plan.tracking.conveyor].T_world_carrier[:3, 0]
        T[:3, 3] += plan.tracking.speed * (t_grasp - t) * along
    return T
