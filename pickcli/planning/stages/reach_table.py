"""Says at once that an item on a running belt cannot be met: from a table of where the arm reaches the belt.

The table has configurations of the arm over direction of the tool, place across the belt and height. Along
the belt, where a linear axis carries the whole arm, each stands for all places there. From these, and from
the least time that the joints, the lines and the devices need in any plan, follow bounds: the earliest
contact from a start, and the latest one within the window and the axis. Where no configuration leaves time
between them, no plan exists; the search would take a hundred times as long to say so.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from pickcli.cell.device import DeviceKind
from pickcli.cell.station import Carrier
from pickcli.collision.motion_segment import Mode
from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import PlacedItem, Scene, empty_scene
from pickcli.seeds import derived_rng

ACROSS = np.array([-0.2, -0.1, 0.0, 0.1, 0.2])  # m from the middle of the belt
HEIGHTS = np.array([0.02, 0.1, 0.2, 0.3])  # m over it
NEAR = 0.11  # m within which the places of the table stand for one in between
ALIKE = 0.8  # cosine of the angle up to which its directions do
N_YAWS = 6  # of the tool about its axis
N_SEEDS = 16
N_AROUND = 12  # horizontal directions
MARGIN = 0.25  # s that a bound may be off, as the arm also has configurations between those of the table
PACE = 0.9  # of the limits, the most in any motion to a belt
SAME_TURN = 2.0 * np.pi
DOWN = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True)
class BeltTimes:
    """Bounds of the time of a meeting, in s from the start of the plan.

    Attributes:
        travel: m of the item's middle from the infeed at the start.
        speed: m/s of the belt.
        along: m/s of the axis that keeps up with it, negative against its direction.
        axis: Index of the axis.
        first: s from which on contact may be made.
        last: s until which the item has to be off the belt.
        ramp: s in which the axis comes up to the speed.
    """

    travel: float
    speed: float
    along: float
    axis: int
    first: float
    last: float
    ramp: float


def too_late_by(
    context: PlanningContext, carrier: Carrier, placed: PlacedItem, q: Array, times: BeltTimes
) -> float:
    """Bound from below by how much every meeting with an item is too late.

    Args:
        context: The cell and its models.
        carrier: The conveyor.
        placed: The item at the start.
        q: (n,) configuration at the start.
        times: The times of the belt.

    Returns:
        s, positive if the item can never be met; -inf if the table says nothing.
    """
    if context.method.closes_at_rest:  # fingers take items from more sides than the named faces
        return -np.inf
    found = [rows for normal in _normals(placed) if len(rows := _near(context, carrier, -normal, placed)) > 0]
    if not found:
        return -np.inf
    rows = np.concatenate(found)
    settings, tool = context.settings, context.cell.robot.tool
    pumps = [each.lead for each in context.cell.devices.values() if each.kind is DeviceKind.PUMP]
    rests = context.method.rests(context.cell.devices, settings.release_time)
    lowered = settings.approach_offset / max(settings.approach_speed, tool.contact_speed)
    lasts = rests.taking + settings.first_stretch / settings.lift_speed
    v, k, limits = times.along, times.axis, context.arm.limits
    contact = np.maximum(
        max(times.first, *pumps), _least_times(context, q, rows[:, 1:], k) + times.ramp + lowered
    )
    # The axis at the contact: the item's place along the belt less what the arm reaches ahead of the axis.
    ahead = times.travel - rows[:, 0]
    # The place on the item is off its middle by less than its half length.
    off = float(_halves(placed, carrier)[0]) / times.speed
    ends = limits.upper[k] if v > 0.0 else limits.lower[k]
    begins = limits.lower[k] if v > 0.0 else limits.upper[k]
    sign = float(np.sign(v))
    latest = np.minimum(times.last, (sign * (ends - rows[:, 1 + k]) - ahead) / times.speed + off) - lasts
    earliest = np.maximum(contact, (sign * (begins - rows[:, 1 + k]) - ahead) / times.speed - off)
    return float((earliest - latest).min()) - MARGIN


def _normals(placed: PlacedItem) -> list[Array]:
    """Return the outward normals (3,) in the world of the faces that may be taken."""
    R = placed.T_world_item[:3, :3]
    found = []
    for name in placed.item.seals:
        if len(name) == 2 and name[0] in "+-" and name[1] in "xyz":
            normal = R[:, "xyz".index(name[1])] * (1.0 if name[0] == "+" else -1.0)
            if normal[2] > -ALIKE:  # no cup comes from below
                found.append(normal)
        else:  # round: from every side
            found += [*_around(), -DOWN]
    return found


def _around() -> list[Array]:
    angles = np.arange(N_AROUND) * 2.0 * np.pi / N_AROUND
    return [np.array([np.cos(a), np.sin(a), 0.0]) for a in angles]


def _halves(placed: PlacedItem, carrier: Carrier) -> Array:
    """Return half extents (3,) in m of an item along the axes of the belt."""
    R = carrier.T_world_carrier[:3, :3].T @ placed.T_world_item[:3, :3]
    return placed.item.shape.reach(R)


def _near(context: PlanningContext, carrier: Carrier, direction: Array, placed: PlacedItem) -> Array:
    """Return the rows of the table for a direction (3,) of the tool near an item."""
    across = float(
        (placed.T_world_item[:3, 3] - carrier.T_world_carrier[:3, 3]) @ carrier.T_world_carrier[:3, 1]
    )
    half = _halves(placed, carrier)
    top = float(placed.T_world_item[2, 3] - carrier.T_world_carrier[2, 3] + half[2])
    directions = [DOWN, *_around()]
    rows = [
        _configurations(context, carrier, k, float(y), float(z))
        for k, known in enumerate(directions)
        if float(known @ direction) > ALIKE
        for y in ACROSS[np.abs(ACROSS - across) <= NEAR + float(half[1])]
        for z in HEIGHTS[top + NEAR >= HEIGHTS]
    ]
    return np.concatenate(rows) if rows else np.empty((0, 1 + context.arm.n))


@lru_cache(maxsize=4096)
def _configurations(context: PlanningContext, carrier: Carrier, direction: int, y: float, z: float) -> Array:
    """Solve for one place of the table.

    Returns (M, 1 + n): m along the belt of the tool's tip, and the configuration.
    """
    arm, known = context.arm, [DOWN, *_around()][direction]
    rng = derived_rng("reach of a belt", carrier.name, direction, y, z)
    middle = sum(carrier.conveyor.window) / 2.0 if carrier.conveyor is not None else 0.0
    T = carrier.T_world_carrier @ pose((middle, y, z))
    x = np.array([1.0, 0.0, 0.0]) if abs(known[2]) > ALIKE else np.array([0.0, 0.0, 1.0])
    R = np.column_stack([x, np.cross(known, x), known])
    found, empty = [], _empty(context)
    for state in context.cell.robot.tool.states:
        for yaw in np.arange(N_YAWS) * 2.0 * np.pi / N_YAWS:
            tip = pose(T[:3, 3], R=R @ rotation_axis_angle((0.0, 0.0, 1.0), float(yaw)))
            solved = arm.solve_spread(tip, state, rng, N_SEEDS)
            if len(solved):
                solved = solved[context.checker_for(empty, Mode(state)).are_valid(solved)]
            found.append(np.column_stack([np.full(len(solved), middle), solved]))
    return np.concatenate(found)


@lru_cache(maxsize=4)
def _empty(context: PlanningContext) -> Scene:
    return empty_scene(context.cell)


def _least_times(context: PlanningContext, q: Array, goals: Array, axis: int) -> Array:
    """Return (M,) s that all joints but the axis need at least from rest at q (n,) to goals (M, n)."""
    limits, scale = context.arm.limits, context.cell.speed_scale
    d = np.abs(goals - q)
    turns = limits.upper - limits.lower > SAME_TURN
    d = np.where(turns, np.minimum(d % SAME_TURN, SAME_TURN - d % SAME_TURN), d)
    v, a = PACE * scale * limits.velocity, PACE**2 * scale * limits.acceleration
    t = np.where(d > v**2 / a, d / v + v / a, 2.0 * np.sqrt(d / a))
    t[:, axis] = 0.0
    return np.asarray(t.max(axis=1))
