"""Check the grasp of a cup: it meets the item as planned, seals inside a face, and holds in motion."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pickcli.cell.item import LEAST_SHARE, Item
from pickcli.cell.shapes import ShapeKind
from pickcli.cell.tool import MOVING, Tool
from pickcli.cell.tools.suction_cup import SuctionCup
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse, rotation_angle
from pickcli.motion.plan import Grasp, Plan
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.load_check import check_load
from pickcli.verification.quintic import positions_at

ON_SURFACE = 0.001  # m between the grasp's tip and the item's surface
MAX_GRASP_OFFSET = 0.002  # m between grasp and tip at contact, across the tool axis
MAX_GRASP_TURN = np.radians(1.0)  # rad between grasp and tip at contact
SAME_AXIS = 1e-6  # of a unit vector: between two axes of the place, either kind is accepted
SAME_EDGE = 1e-6  # m between a lip and the edge that it may reach
ON_NORMAL = np.radians(1.0)  # between the tool axis and a face's normal, besides what the cup tolerates


def check_seal(plan: Plan, scene: Scene, T_tip_item: Array) -> tuple[Reason, ...]:
    """Check everything that concerns the cup and the item.

    Args:
        plan: A plan with a grasp.
        scene: The plan's scene, of a cell with a cup.
        T_tip_item: (4, 4) pose of the held item in the tool frame.

    Returns:
        The faults.
    """
    assert plan.grasp is not None
    grasp, item = plan.grasp, scene.item(plan.grasp.item)
    tool, noise = scene.cell.robot.tool, scene.noise_of(scene.instance(grasp.item))
    reasons = [*_face(grasp, item), *_seal(grasp, item, tool, noise)]
    if grasp.tool_state == MOVING:
        reasons.append(
            Reason("wrong tool state", "grasp", "the cup holds while it stands still, not while it moves")
        )
    for k, segment in enumerate(plan.segments):
        if segment.kind is SegmentKind.CONTACT:
            if segment.tool_state != grasp.tool_state:
                reasons.append(
                    Reason(
                        "wrong tool state", f"segment {k} (contact)", f"the grasp is for {grasp.tool_state}"
                    )
                )
            reasons += _meets(plan, scene, grasp, segment.t_end, f"segment {k} (contact)")
            reasons += check_kind(scene, grasp)
    if plan.segments[0].held is not None and scene.held is not None:
        reasons += _as_grasped(scene, grasp, inverse(scene.held.T_tip_item), "in the cup")
    if not item.suction:
        reasons.append(Reason("cannot be held by suction", grasp.item, item.why_not))
    return (*reasons, *check_load(plan, scene, T_tip_item, _share_at(item, grasp, tool, noise)))


def cup_loads(plan: Plan, scene: Scene, wrenches: Array) -> Array:
    """Compute the load on the cup.

    Args:
        plan: A plan with a grasp.
        scene: The plan's scene, of a cell with a cup.
        wrenches: (..., 6) that the cup exerts on the item at the tip, in the tool frame.

    Returns:
        The loads (...) as shares of what the cup bears.
    """
    assert plan.grasp is not None
    instance, tool = scene.instance(plan.grasp.item), scene.cell.robot.tool
    share = _share_at(instance.item, plan.grasp, tool, scene.noise_of(instance))
    return tool.cup.limits.ratio(wrenches, share)


def _face(grasp: Grasp, item: Item) -> Iterator[Reason]:
    """Check that the stated face is the one that the tip is on."""
    face = _face_at(item, grasp.T_item_tip[:3, 3])[0]
    if grasp.face != face:
        yield Reason("wrong face", "grasp", f"{grasp.face} stated, the tip is on {face}")


def _seal(grasp: Grasp, item: Item, tool: Tool, noise: PoseNoise) -> Iterator[Reason]:
    """Check that the tip is on the surface, points inwards, and that the cup is inside the face.

    It may stand over the edges of a box's face if the pump keeps enough vacuum all the same.
    """
    tip, axis = grasp.T_item_tip[:3, 3], grasp.T_item_tip[:3, 2]
    face, off, normal, _ = _face_at(item, tip)
    if abs(off) > ON_SURFACE:
        yield Reason("grasp off the surface", grasp.item, f"{off * 1e3:.1f} mm")
    if axis @ -normal < np.cos(ON_NORMAL + tool.cup.tilt):
        yield Reason(
            "cup not square on the face", grasp.item, f"{np.degrees(np.arccos(axis @ -normal)):.1f} deg"
        )
    if item.seals[face] <= 0.0:
        yield Reason("cup not on a face that seals", grasp.item, f"{face}; {item.seal_source}")
    yield from _on_the_face(grasp, item, tool.cup, noise)


def _on_the_face(grasp: Grasp, item: Item, cup: SuctionCup, noise: PoseNoise) -> Iterator[Reason]:
    """Check that the lip is inside the face, or across a narrow one, and seals at the largest pose error."""
    tip, inset = grasp.T_item_tip[:3, 3], cup.radius + item.seal_inset
    face, _, _, to_edge = _face_at(item, tip)
    is_inside = to_edge >= inset - SAME_EDGE
    if item.shape.kind is ShapeKind.BOX:
        rooms = _rooms(item, face, tip)
        is_wide = rooms.sum(axis=1) >= 2.0 * inset - SAME_EDGE
        is_inside = is_inside or bool(
            not is_wide.all() and rooms[is_wide].min(initial=inset) >= inset - SAME_EDGE
        )
        kept = cup.kept_vacuum(item.seals[face], rooms, _off(tip, noise))
        if is_inside and kept < min(LEAST_SHARE, item.seals[face]):
            told = f"beside the edges the pump keeps {kept:.1%} of the vacuum, needs {LEAST_SHARE:.1%}"
            yield Reason("cup beyond the edge", grasp.item, told)
    if not is_inside:
        told = f"{to_edge * 1e3:.1f} mm from the edge, needs {inset * 1e3:.1f}"
        yield Reason("cup beyond the edge", grasp.item, told)


def _share_at(item: Item, grasp: Grasp, tool: Tool, noise: PoseNoise) -> float:
    """Return the share of its limits that the cup bears on the face under it.

    Over the edges of a box's face, where pose errors may lead it, the lip leaks, and its lever is as short as
    the face reaches under it.
    """
    tip, cup = grasp.T_item_tip[:3, 3], tool.cup
    face = _face_at(item, tip)[0]
    if item.shape.kind is not ShapeKind.BOX:
        return item.seals[face]
    rooms, off = _rooms(item, face, tip), _off(tip, noise)
    return cup.kept_vacuum(item.seals[face], rooms, off) * cup.covered(rooms, off)


def _off(tip: Array, noise: PoseNoise) -> float:
    """Return how far (m) a cup may be off its place (3,) on the item, by the error of the item's pose."""
    return float(noise.at(np.asarray(np.linalg.norm(tip))))


def _rooms(item: Item, face: str, tip: Array) -> Array:
    """Return (2, 2) m from a tip (3,) to both ends of the sealing part of a box's face, along its axes."""
    rooms = []
    for axis in "xyz":
        if axis != face[1]:
            k = "xyz".index(axis)
            half = float(item.shape.extents[k]) / 2
            low, high = _sides(item, face).get(axis, (-half, half))
            least, greatest = item.areas.get(face, {}).get(axis, (-half, half))
            rooms.append([tip[k] - max(least, low), min(greatest, high) - tip[k]])
    return np.array(rooms)


def _sides(item: Item, face: str) -> dict[str, tuple[float, float]]:
    """Return the sides by axis, m, of the rectangular hollow with a bottom; {} for outer faces."""
    for hollow in item.hollows:
        if f"{hollow.face}/{hollow.name}" == face:
            return dict(zip("xyz".replace(face[1], ""), hollow.sides, strict=False))
    return {}


def _face_at(item: Item, p: Array) -> tuple[str, float, Array, float]:
    """Return the face nearest to a point (3,): name, height (m) of the point over it, normal, room (m).

    The room is the distance of the point to the edge of the sealing part.
    """
    shape, half = item.shape, item.shape.extents / 2
    bottom = _bottom_at(item, p)
    if bottom is not None:
        return bottom
    if shape.kind is ShapeKind.SPHERE:
        r = float(np.linalg.norm(p))
        return "sphere", r - shape.size[0], p / max(r, 1e-9), np.inf
    if shape.kind is ShapeKind.BOX:
        axis = int(np.argmax(np.abs(p) - half))
        normal = np.sign(p[axis]) * np.eye(3)[axis]
        name = _sign(p[axis]) + "xyz"[axis]
        to_edge = min(float(np.delete(half - np.abs(p), axis).min()), _to_the_end(item, name, p))
        return name, float(abs(p[axis]) - half[axis]), normal, to_edge
    radius, length = shape.size
    r = float(np.hypot(p[0], p[1]))
    if abs(p[2]) - length / 2 > r - radius:  # an end face
        normal = np.array([0.0, 0.0, np.sign(p[2])])
        name = _sign(p[2]) + "z"
        to_edge = min(radius - r, _to_the_end(item, name, p))
        return name, float(abs(p[2]) - length / 2), normal, to_edge
    normal = np.array([p[0], p[1], 0.0]) / max(r, 1e-9)
    return "mantle", r - radius, normal, min(float(length / 2 - abs(p[2])), _to_the_end(item, "mantle", p))


def _bottom_at(item: Item, p: Array) -> tuple[str, float, Array, float] | None:
    """Return the bottom of the hollow that a point (3,) is nearest to, likewise; None if it is at none.

    A point is nearest to it in the lower half of the hollow, and in the upper half of what is left under it.
    """
    found: list[tuple[str, float, Array, float]] = []
    for hollow in item.hollows:
        k, side = "xyz".index(hollow.face[1]), 1.0 if hollow.face[0] == "+" else -1.0
        half = float(item.shape.extents[k]) / 2
        height = float(side * p[k]) - (half - hollow.depth)
        if hollow.radius is not None:
            room = hollow.radius - float(np.hypot(p[0], p[1]))
        else:
            others = [axis for axis in range(3) if axis != k]
            sides = zip(others, hollow.sides, strict=True)
            room = min(min(float(p[a]) - least, greatest - float(p[a])) for a, (least, greatest) in sides)
        name = f"{hollow.face}/{hollow.name}"
        if room >= 0.0 and hollow.depth / 2 - half < height < hollow.depth / 2:
            found.append((name, height, side * np.eye(3)[k], min(room, _to_the_end(item, name, p))))
    return min(found, key=lambda each: abs(each[1]), default=None)


def _to_the_end(item: Item, face: str, p: Array) -> float:
    """Return how far (m) a point (3,) is inside the sealing part of a face; infinite if all of it seals."""
    distances = [
        min(float(p["xyz".index(axis)]) - least, greatest - float(p["xyz".index(axis)]))
        for axis, (least, greatest) in item.areas.get(face, {}).items()
    ]
    return min(distances, default=np.inf)


def _sign(value: float) -> str:
    return "+" if value > 0.0 else "-"


def _meets(plan: Plan, scene: Scene, grasp: Grasp, t: float, where: str) -> Iterator[Reason]:
    """Check that the tip is at the grasp's pose at the end of contact."""
    robot = scene.cell.robot
    tip = tip_poses(robot, link_poses(robot, positions_at(plan.trajectory, t)), grasp.tool_state)[0]
    yield from _as_grasped(scene, grasp, inverse(scene.find(grasp.item).T_world_item) @ tip, where)


def check_kind(scene: Scene, grasp: Grasp) -> Iterator[Reason]:
    """Check that the grasp's kind names the axis of the place that the tool axis is nearest to.

    Args:
        scene: The scene.
        grasp: The grasp.

    Yields:
        The fault.
    """
    placed = scene.find(grasp.item)
    T_world_place = scene.T_world_place(scene.cell.places[placed.location])
    into, aside, up = (inverse(T_world_place) @ placed.T_world_item @ grasp.T_item_tip)[:3, 2]
    along = {"frontal": into, "top-down": -up, "side": abs(aside)}
    kind = max(along, key=along.__getitem__)
    if along.get(grasp.kind, -1.0) < along[kind] - SAME_AXIS:
        yield Reason("wrong kind", "grasp", f"{grasp.kind} stated, by the cup's axis it is {kind}")


def _as_grasped(scene: Scene, grasp: Grasp, T_item_tip: Array, where: str) -> Iterator[Reason]:
    """Check that the tip (4, 4) is at the grasp's pose, pressed on as far as noise and bellows allow."""
    off = inverse(grasp.T_item_tip) @ T_item_tip
    aside, pressed = float(np.hypot(*off[:2, 3])), float(off[2, 3])
    most = scene.bound(scene.instance(grasp.item)) + scene.cell.robot.tool.grip.gives_way
    if not -ON_SURFACE <= pressed <= most:
        yield Reason(
            "misses the item", where, f"pressed on by {pressed * 1e3:.1f} mm, expected 0..{most * 1e3:.1f}"
        )
    if aside > MAX_GRASP_OFFSET or rotation_angle(off[:3, :3]) > MAX_GRASP_TURN:
        turned = np.degrees(rotation_angle(off[:3, :3]))
        yield Reason("misses the item", where, f"{aside * 1e3:.1f} mm aside, turned {turned:.1f} deg")
