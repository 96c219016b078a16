"""Says at once that an item on a running belt cannot be met: from a table of where the arm reaches the belt.

The table has configurations of the arm over direction of the tool, place across the belt and height: those to
which inverse kinematics leads from the configurations that the cell names for the belt, which are those in
which the arm takes items there. Along the belt, where a linear axis carries the whole arm, each stands for
all places.
From these, and from the least time that the joints, the lines and the devices need in any plan, follow
estimates: of the earliest contact from a start, and the latest one within the window and the axis. Where no
configuration leaves time between them, the item is too late; the search would take a hundred times as long
to say so. They would be bounds for the configurations of the table; the arm has others between these, for
which ``MARGIN`` is left.

Lines are longer where neighbours that are still to come are higher than the item: they ride on under the
arm, which has to wait above them, and the item has to be lifted over them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np

from pickcli.cartesian.corridor import LEAST_LIFT
from pickcli.cartesian.key_waypoints import CONTACT_DISTANCE
from pickcli.cell.station import Carrier
from pickcli.cell.tool import ACROSS as ACROSS_CUP
from pickcli.cell.tool import IN_LINE
from pickcli.collision.motion_segment import Mode
from pickcli.geometry import Array, inverse, pose, rotation_axis_angle
from pickcli.planning.belt_picks.belt_query import PACED_COMING, pumped_from
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import PlacedItem, Scene, empty_scene
from pickcli.seeds import derived_rng

ACROSS = np.array([-0.2, -0.1, 0.0, 0.1, 0.2])  # m from the middle of the belt
HEIGHTS = np.array([0.02, 0.1, 0.2, 0.3, 0.4])  # m over it
NEAR = 0.06  # m within which the places of the table stand for one in between
ALIKE = 0.8  # cosine of the angle up to which its directions do
N_YAWS = 6  # of a tool from above about its axis
LEANS = np.radians([-30.0, 0.0, 30.0])  # of a lance beside the item
ALONG = (0.0, 0.5, 1.0)  # shares of the window
N_SEEDS = 16  # random ones, in a cell that names none
N_AROUND = 12  # horizontal directions
MARGIN = 0.1  # s that a bound may be off, as the arm also has configurations between those of the table
SAME_TURN = 2.0 * np.pi
DOWN = np.array([0.0, 0.0, -1.0])


@dataclass(frozen=True)
class BeltTimes:
    """An item, the belt and the axis that follows it; times are in s from the start of the plan.

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
    context: PlanningContext,
    carrier: Carrier,
    scene: Scene,
    placed: PlacedItem,
    q: Array,
    times: BeltTimes,
) -> float:
    """Estimate by how much every meeting with an item is too late at least.

    Args:
        context: The cell and its models.
        carrier: The conveyor.
        scene: The scene at the start.
        placed: The item in it.
        q: (n,) configuration at the start.
        times: The times of the belt.

    Returns:
        s, positive if the item is too late for all of them; -inf if the table says nothing.
    """
    if context.method.closes_at_rest:  # fingers take items from more sides than the named faces
        return -np.inf
    neighbours = _Neighbours.of(scene, carrier, placed)
    bounds = [_bound(context, carrier, placed, -normal, neighbours, q, times) for normal in _normals(placed)]
    return min(bounds, default=np.inf) - MARGIN if np.isfinite(bounds).any() else -np.inf


def _bound(
    context: PlanningContext,
    carrier: Carrier,
    placed: PlacedItem,
    direction: Array,
    neighbours: _Neighbours,
    q: Array,
    times: BeltTimes,
) -> float:
    """Estimate by how many s meetings with the tool in a direction (3,) are too late; inf without any."""
    rows = _near(context, carrier, direction, placed)
    if len(rows) == 0:
        return np.inf
    settings, tool = context.settings, context.cell.robot.tool
    rests = context.method.rests(context.cell.devices, settings.release_time)
    lowered = CONTACT_DISTANCE / tool.contact_speed
    if direction[2] < -ALIKE:
        lowered += max(0.0, neighbours.over_tool - CONTACT_DISTANCE) / settings.preapproach_speed
    lifted = settings.first_stretch + LEAST_LIFT
    lasts = rests.taking + lifted / settings.lift_speed
    lasts += max(0.0, neighbours.over_item - lifted) / settings.retreat_speed
    v, k, limits = times.along, times.axis, context.arm.limits
    contact = np.maximum(
        max(times.first, pumped_from(context.cell)),
        np.maximum(least_times(context, q, rows[:, 1:], k), times.ramp) + lowered,
    )
    # The axis at the contact: the item's place along the belt less what the arm reaches ahead of the axis.
    ahead = times.travel - rows[:, 0]
    # The place on the item is off its middle by less than its half length. The axis goes on for half a ramp's
    # travel, and begins as long before.
    off = float(_halves(placed, carrier)[0]) / times.speed - times.ramp / 2.0
    ends = limits.upper[k] if v > 0.0 else limits.lower[k]
    begins = limits.lower[k] if v > 0.0 else limits.upper[k]
    sign = float(np.sign(v))
    latest = np.minimum(times.last, (sign * (ends - rows[:, 1 + k]) - ahead) / times.speed + off) - lasts
    earliest = np.maximum(contact, (sign * (begins - rows[:, 1 + k]) - ahead) / times.speed - off)
    return float((earliest - latest).min())


@dataclass(frozen=True)
class _Neighbours:
    """What the items that are still to come ask of the lines.

    over_tool: m that a tool from above has to rise at least from the item until none of them can touch it
    over_item: m that the item has to be moved at least until none of them can touch it
    """

    over_tool: float
    over_item: float

    @classmethod
    def of(cls, scene: Scene, carrier: Carrier, placed: PlacedItem) -> _Neighbours:
        """Look at the items upstream of one, as boxes along the belt; each passes where that is now."""
        low, high = _box(placed, carrier)
        over_tool = over_item = 0.0
        for other in scene.items:
            if other.id == placed.id or other.location not in carrier.places:
                continue
            theirs, tops = _box(other, carrier)
            if theirs[0] > low[0]:
                continue
            # Boxes part along one of their axes. Behind it, the item would have to go upstream.
            aside = min(float(high[1] - theirs[1]), float(tops[1] - low[1]))
            behind = float(high[0] - theirs[0])
            over_item = max(over_item, min(float(tops[2] - low[2]), aside, behind))
            beside = min(float(low[1] - theirs[1]), float(tops[1] - high[1]))
            over_tool = max(over_tool, min(float(tops[2] - high[2]), beside, float(low[0] - theirs[0])))
        return cls(over_tool, over_item)


def _box(placed: PlacedItem, carrier: Carrier) -> tuple[Array, Array]:
    """Return lower and upper corner (3,) in m of an item in the frame of the belt."""
    middle = (inverse(carrier.T_world_carrier) @ placed.T_world_item)[:3, 3]
    half = _halves(placed, carrier)
    return middle - half, middle + half


def _normals(placed: PlacedItem) -> list[Array]:
    """Return the outward normals (3,) in the world of the faces that may be taken."""
    R = placed.T_world_item[:3, :3]
    found = []
    for name, share in placed.item.seals.items():
        if share == 0.0:
            continue
        if name[0] in "+-":  # also the bottom of a hollow
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
    # From above the arm is at the top of the item, or higher where the lines begin.
    heights = HEIGHTS[top - NEAR <= HEIGHTS] if direction[2] < -ALIKE else HEIGHTS
    rows = [
        _configurations(context, carrier, k, float(y), float(z))
        for k, known in enumerate(directions)
        if float(known @ direction) > ALIKE
        for y in ACROSS[np.abs(ACROSS - across) <= NEAR + float(half[1])]
        for z in heights
    ]
    return np.concatenate(rows) if rows else np.empty((0, 1 + context.arm.n))


@lru_cache(maxsize=4096)
def _configurations(context: PlanningContext, carrier: Carrier, direction: int, y: float, z: float) -> Array:
    """Solve for one place of the table.

    Returns (M, 1 + n): m along the belt of the tool's tip, and the configuration.
    """
    arm, known = context.arm, [DOWN, *_around()][direction]
    rng = derived_rng("reach of a belt", carrier.name, direction, y, z)
    window = (0.0, 0.0) if carrier.conveyor is None else carrier.conveyor.window
    x = np.array([1.0, 0.0, 0.0]) if abs(known[2]) > ALIKE else np.array([0.0, 0.0, 1.0])
    R = np.column_stack([x, np.cross(known, x), known])
    found, empty, seeds = [], _empty(context), _named(context, carrier)
    tool, is_down = context.cell.robot.tool, abs(known[2]) > ALIKE
    # As grasps have it: a lance from above in line with the cup in any turn, or across the cup and upright.
    state = tool.state_with_lance(IN_LINE if is_down else ACROSS_CUP)
    if state is None:
        return np.empty((0, 1 + arm.n))
    angles = np.arange(N_YAWS) * 2.0 * np.pi / N_YAWS if is_down else LEANS
    turns = [R @ rotation_axis_angle((0.0, 0.0, 1.0), float(angle)) for angle in angles]
    for share, turned in product(ALONG, turns):
        along = window[0] + share * (window[1] - window[0])
        tip = pose((carrier.T_world_carrier @ pose((along, y, z)))[:3, 3], R=turned)
        solved = arm.solve(tip, state, seeds) if len(seeds) else arm.solve_spread(tip, state, rng, N_SEEDS)
        if len(solved):
            solved = solved[context.checker_for(empty, Mode(state)).are_valid(solved)]
        found.append(np.column_stack([np.full(len(solved), along), solved]))
    return np.concatenate(found)


def _named(context: PlanningContext, carrier: Carrier) -> Array:
    """Return the configurations (N, n) that the cell names for a belt."""
    return np.array([q for place in carrier.places.values() for q in context.configurations_at(place)])


@lru_cache(maxsize=4)
def _empty(context: PlanningContext) -> Scene:
    return empty_scene(context.cell)


def least_times(context: PlanningContext, q: Array, goals: Array, axis: int) -> Array:
    """Bound from below how long all joints but one need from rest to rest, on the way to a belt.

    Args:
        context: The cell and its models.
        q: (n,) configuration at the start.
        goals: (M, n) configurations.
        axis: Index of the joint that is left out.

    Returns:
        (M,) s.
    """
    limits, scale = context.arm.limits, context.cell.speed_scale
    d = np.abs(goals - q)
    turns = limits.upper - limits.lower > SAME_TURN
    d = np.where(turns, np.minimum(d % SAME_TURN, SAME_TURN - d % SAME_TURN), d)
    v, a = PACED_COMING * scale * limits.velocity, PACED_COMING * scale * limits.acceleration
    t = np.where(d > v**2 / a, d / v + v / a, 2.0 * np.sqrt(d / a))
    t[:, axis] = 0.0
    return np.asarray(t.max(axis=1))
