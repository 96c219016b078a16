"""Check the pushes of an empty tool that topples an item in an open box or a bin: which items, where, how.

Where they end up is not known. So they must be items that may lie anywhere in their box and cannot leave it.
A bin is open at its front: there one item may turn over to a side, with nothing on it or leaning on it, by
which nothing of it comes nearer to the mouth. The tool must be slow and weak against what it meets, and must
squeeze nothing onto the floor or a wall. It comes down onto an item only as far as the bellows give way,
first in a line, then only as it turns with it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pickcli.cell.place import Place
from pickcli.cell.tool import MOVING
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse, rotation_angle, transform_points
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.pile_statics import barrier, lying_on, may_leave, removal
from pickcli.verification.push_check import HEAVIEST, MOST_DESCENT, MOST_SPEED, pushed_by
from pickcli.verification.quintic import positions_at
from pickcli.verification.straightness_check import SPEED_TOLERANCE, every_millisecond, fastest_tip

MOST_PUSH = 0.15  # m of all pushes of a plan
STEEPEST = np.radians(50.0)  # rad, slope up to which a push still goes across and does not lift
ACROSS = 1e-3  # m that a push goes across at least; one that goes less presses downwards
MOST_ASKEW = np.radians(12.0)  # rad in a bin, between a push and its breadth
LEAST_TURN = np.radians(4.0)  # rad of the tool in a push that comes down with an item
N_AROUND = 16  # points on each of the two circles that stand for the front of the cup's rigid part


def is_toppling(plan: Plan) -> bool:
    """Whether a plan pushes with the empty tool.

    Args:
        plan: The plan.

    Returns:
        True if any of its segments is a push, or names pushed items without a held one.
    """
    return any(
        segment.kind is SegmentKind.PUSH or (segment.pushing and segment.held is None)
        for segment in plan.segments
    )


def check_topple(plan: Plan, scene: Scene) -> tuple[Reason, ...]:
    """Check every condition of toppling an item.

    Args:
        plan: The plan.
        scene: The plan's scene.

    Returns:
        The faults; () for a plan whose empty tool pushes nothing.
    """
    if not is_toppling(plan):
        return ()
    if reasons := tuple(_wrong_segments(plan, scene)):
        return reasons
    here = {placed.id: placed for placed in scene.items}
    unknown = sorted(pushed_by(plan) - here.keys())
    if unknown:
        return tuple(_fault(name, "it is not in the scene") for name in unknown)
    items = [here[name] for name in sorted(pushed_by(plan))]
    places = {placed.location for placed in items}
    place = scene.cell.places.get(items[0].location)
    if len(places) > 1 or place is None or (place.access.is_from_above and not place.is_open_box):
        at = ", ".join(sorted(places)) or "no place"
        return (Reason("pushes outside of a box", items[0].id, f"the pushed items are in {at}"),)
    not_safe = _not_toppled if place.is_open_box else _not_turned_over
    return (
        *not_safe(scene, place, items),
        *_too_fast(plan, scene),
        *_wrong_lines(plan, scene, place, items),
    )


def _wrong_segments(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Yield what is not an empty cup that pushes, and then leaves upwards."""
    if plan.grasp is not None or plan.recovery is not None or scene.held is not None:
        yield Reason(
            "pushing not allowed", "plan", "only the empty tool topples an item, and not in a recovery"
        )
        return
    if scene.cell.robot.tool.grip.takes_widths:
        yield Reason("pushing not allowed", "plan", "only a cup topples an item, not fingers")
    kinds = [segment.kind for segment in plan.segments]
    if SegmentKind.PUSH not in kinds:
        yield Reason("pushing not allowed", "plan", "nothing is held, and no segment is a push")
        return
    if not pushed_by(plan):
        yield Reason("pushing not allowed", "plan", "a push names no item")
    first = kinds.index(SegmentKind.PUSH)
    last = len(kinds) - 1 - kinds[::-1].index(SegmentKind.PUSH)
    for k, segment in enumerate(plan.segments):
        where = f"segment {k} ({segment.kind})"
        wanted = (SegmentKind.PUSH,) if first <= k <= last else (SegmentKind.DEPART,)
        if k < first and segment.pushing:
            yield Reason("pushing not allowed", where, "before the push everything keeps its distance")
        if k >= first and (segment.kind not in wanted or segment.tool_state == MOVING or segment.touching):
            yield Reason("pushing not allowed", where, "after a push the tool, as it is, only departs")
        if k >= first and set(segment.pushing) != pushed_by(plan):
            yield Reason("pushing not allowed", where, "from the push on, what is pushed may be anywhere")


def _not_toppled(scene: Scene, place: Place, items: Sequence[PlacedItem]) -> Iterator[Reason]:
    """Yield what is heavy, not known, or could leave the box, or carries or supports what may not move."""
    names = {placed.id for placed in items}
    for body in scene.unrecognised_in(place.name)[:1]:
        yield _fault(items[0].id, f"nobody recognised what is at {body.name}")
    mass = sum(placed.item.heaviest for placed in items)
    if mass > HEAVIEST:
        yield _fault(items[0].id, f"all that is pushed may have {mass:.2f} kg, at most {HEAVIEST}")
    for placed in items:
        # Turning over any of its corners, its middle is no higher above it than half the diagonal.
        shape, T = placed.item.shape, placed.T_world_item
        lowest = float(T[2, 3] - shape.reach(T[:3, :3])[2])
        highest = lowest + float(np.linalg.norm(shape.extents)) / 2 + scene.bound(placed)
        if not highest < (most := barrier(scene, place, placed)):
            over = 1e3 * (highest - most)
            why = f"it may get over the rim of {place.name}: its middle may come {over:.0f} mm too high"
            yield _fault(placed.id, why)
        for other in sorted(lying_on(scene, placed.id) - names):
            yield _fault(placed.id, f"{other} lies on it and is not named as pushed")
        for other in sorted(removal(scene, placed.id).falling - names):
            beside = scene.find(other)
            if may_leave(scene, place, beside):
                yield _fault(placed.id, f"{other} leans on it and could fall over the rim")


def _not_turned_over(scene: Scene, place: Place, items: Sequence[PlacedItem]) -> Iterator[Reason]:
    """Yield what is heavy, not known, not wholly inside of its bin, or needed by others there."""
    for body in scene.unrecognised_in(place.name)[:1]:
        yield _fault(items[0].id, f"nobody recognised what is at {body.name}")
    for placed in items[1:]:
        yield _fault(placed.id, "in a bin only one item turns over at a time")
    placed = items[0]
    if placed.item.heaviest > HEAVIEST:
        yield _fault(placed.id, f"it may have {placed.item.heaviest:.2f} kg, at most {HEAVIEST}")
    T = inverse(scene.T_world_place(place)) @ placed.T_world_item
    front = float(T[0, 3] - placed.item.shape.reach(T[:3, :3])[0]) - scene.bound(placed)
    if not front >= 0.0:
        yield _fault(placed.id, f"it may reach {-1e3 * front:.0f} mm out of {place.name}")
    for other in sorted(lying_on(scene, placed.id) | removal(scene, placed.id).falling):
        yield _fault(placed.id, f"{other} rests or leans on it")


def _too_fast(plan: Plan, scene: Scene) -> Iterator[Reason]:
    """Yield the segments in which items may be met at more than the speed allowed."""
    for k, segment in enumerate(plan.segments):
        if segment.pushing:
            speed = fastest_tip(plan, scene.cell.robot, segment.tool_state, segment.t_start, segment.t_end)
            if not speed <= MOST_SPEED * (1.0 + SPEED_TOLERANCE):
                detail = f"{speed:.4f} m/s, at most {MOST_SPEED}"
                yield Reason("pushes too fast", f"segment {k} ({segment.kind})", detail)


def _wrong_lines(plan: Plan, scene: Scene, place: Place, items: Sequence[PlacedItem]) -> Iterator[Reason]:
    """Yield pushes that lead down or up, leave the box, go far, meet items low or squeeze them."""
    total = 0.0
    for k, segment in enumerate(plan.segments):
        if not segment.pushing:
            continue
        where = f"segment {k} ({segment.kind})"
        tips = _tips(plan, scene, segment)
        heights = tips[:, 2, 3]
        descent = float((np.maximum.accumulate(heights) - heights).max())
        if descent > MOST_DESCENT:
            met = _pressed_hard(scene, items, tips)
            is_first = not any(earlier.pushing for earlier in plan.segments[:k])
            if met or not (is_first or _turns(tips)):
                onto = f", with its rigid part onto {met}" if met else ""
                detail = f"the tool comes down by {1e3 * descent:.1f} mm{onto}"
                yield Reason("pushes downwards", where, detail)
        if segment.kind is not SegmentKind.PUSH:
            continue
        way = tips[-1, :3, 3] - tips[0, :3, 3]
        across = float(np.linalg.norm(way[:2]))
        total += float(np.linalg.norm(way))
        if np.arctan2(way[2], across) > STEEPEST:
            detail = f"{1e3 * way[2]:.1f} mm up, {1e3 * across:.1f} across"
            yield Reason("lifts instead of pushing", where, detail)
        if not _is_inside(scene, place, tips):
            detail = f"the tool is not over the floor of {place.name}"
            yield Reason("pushes outside of a box", where, detail)
        if not place.is_open_box and across >= ACROSS and (askew := _askew(scene, place, way)) > MOST_ASKEW:
            detail = f"{np.degrees(askew):.0f} degrees off the breadth of {place.name}"
            yield Reason("pushes inwards or outwards", where, detail)
        rigid = float(heights[0]) + scene.cell.robot.tool.grip.gives_way
        if all(rigid < placed.T_world_item[2, 3] for placed in items):
            yield Reason("pushes too low", where, "the cup meets all pushed items below their middle")
        yield from _squeezed(scene, place, items, tips, where)
    if total > MOST_PUSH:
        yield Reason("pushes too far", "plan", f"{1e3 * total:.0f} mm, at most {1e3 * MOST_PUSH:.0f}")


def _tips(plan: Plan, scene: Scene, segment: Segment) -> Array:
    """Return the tool frame (N, 4, 4) at every millisecond of a segment."""
    robot = scene.cell.robot
    times = every_millisecond(segment.t_start, segment.t_end)
    links = link_poses(robot, positions_at(plan.trajectory, times))
    return np.asarray(tip_poses(robot, links, segment.tool_state))


def _is_inside(scene: Scene, place: Place, tips: Array) -> bool:
    """Whether the tip stays between the walls of a box."""
    p = (inverse(scene.T_world_place(place)) @ tips)[:, :2, 3]
    low, high = place.room.low[:2], place.room.high[:2]
    return bool(((low <= p) & (p <= high)).all())


def _askew(scene: Scene, place: Place, way: Array) -> float:
    """Return the angle in rad between the level part of a way (3,) and the breadth of a bin."""
    x, y, _ = scene.T_world_place(place)[:3, :3].T @ way
    return float(np.arctan2(abs(x), abs(y)))


def _turns(tips: Array) -> bool:
    """Whether the tool turns, as it does with an item that it turns over."""
    return bool(rotation_angle(tips[0, :3, :3].T @ tips[-1, :3, :3]) >= LEAST_TURN)


def _pressed_hard(scene: Scene, items: Sequence[PlacedItem], tips: Array) -> str:
    """Return the id of an item that the rigid part of the cup may meet where it stands, "" if there is none.

    The item that turns with the cup gives way further than that.
    """
    grip = scene.cell.robot.tool.grip
    turn = 2.0 * np.pi * np.arange(N_AROUND) / N_AROUND
    circle = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(N_AROUND)])
    front = grip.tip_radius * np.vstack([np.zeros(3), circle / 2.0, circle]) - [0.0, 0.0, grip.gives_way]
    points = (tips[:, :3, :3] @ front.T).swapaxes(1, 2) + tips[:, None, :3, 3]
    for placed in items:
        local = transform_points(inverse(placed.T_world_item), points.reshape(-1, 3))
        bound = scene.noise_of(placed).at(np.linalg.norm(local, axis=1))
        beyond = np.abs(local) - placed.item.shape.extents / 2.0 - bound[:, None]
        if (beyond.max(axis=1) < 0.0).any():
            return placed.id
    return ""


def _squeezed(
    scene: Scene, place: Place, items: Sequence[PlacedItem], tips: Array, where: str
) -> Iterator[Reason]:
    """Yield a fault if the tool ends nearer to the wall ahead than an item is thick."""
    T_place = inverse(scene.T_world_place(place))
    p = (T_place @ tips[-1])[:2, 3]
    way = (T_place[:3, :3] @ (tips[-1, :3, 3] - tips[0, :3, 3]))[:2]
    length = float(np.linalg.norm(way))
    if length < ACROSS:
        return
    ahead = way / length
    walls = np.where(ahead > 0.0, place.room.high[:2], place.room.low[:2])
    with np.errstate(divide="ignore", invalid="ignore"):
        ways = np.where(np.abs(ahead) > 1e-9, (walls - p) / ahead, np.inf)
    left = float(ways.min()) - scene.cell.robot.tool.grip.tip_radius
    thickness = max(float(placed.item.shape.extents.min()) for placed in items)
    if left < thickness:
        detail = f"{1e3 * left:.0f} mm are left to the wall ahead, an item is {1e3 * thickness:.0f} mm thick"
        yield Reason("squeezes onto a wall", where, detail)


def _fault(name: str, why: str) -> Reason:
    return Reason("may not be toppled", name, why, name)
