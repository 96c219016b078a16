"""Check the grasp of two fingers: pads meet opposite sides of the item inside the friction cones, and hold.

The contact is found by rays through points all over the pads, along the closing direction. A pad rests on the
outermost points that they hit, and on all that are as far out within the compliance of its rubber; it presses
evenly there. Newton and Euler give the wrench that moves the item; what friction bears, and when a pad lifts
off, follows from those points.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tool import MOVING
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse, rotation_angle
from pickcli.motion.plan import Grasp, Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.scene.scene import Scene
from pickcli.verification.forward_kinematics import link_poses, stated_position, tip_poses
from pickcli.verification.load_check import held_wrenches
from pickcli.verification.quintic import positions_at
from pickcli.verification.ray_casting import cast_rays

N_PAD_POINTS = 15  # along each side of a pad
PAD_COMPRESSION = 0.0005  # m that the rubber of a pad gives way
LEAST_PATCH = 0.1  # of a pad that has to touch the item; round items touch little of it
OFF_WIDTH = 0.001  # m between the stated width and that of the item
MAX_GRASP_OFFSET, MAX_GRASP_TURN = 0.002, np.radians(1.0)  # between grasp and tip when the fingers close
SAME_SHARE, SAME_LEAST = 0.01, 0.01  # of a load, and N or Nm at least: the planner samples differently


@dataclass(frozen=True, eq=False)
class Pads:
    """Contact of two pads with an item.

    Attributes:
        width: m between them.
        points: (N, 2) m, x and z in the tool frame of the points at which both pads touch.
        steepest: rad, largest angle between the closing direction and a normal of the item there.
        share: Share of the pads that touches.
    """

    width: float
    points: Array
    steepest: float
    share: float

    def ratio(self, wrenches: Array, gripper: ParallelGripper) -> Array:
        """Return the load over what the pads bear.

        Args:
            wrenches: (N, 6) about the tip, in the tool frame.
            gripper: The gripper.

        Returns:
            (N,) the larger of the ratios for friction and for pressure.
        """
        middle = self.points.mean(axis=0)
        force, torque = wrenches[:, :3], wrenches[:, 3:]
        torque = torque - np.cross([middle[0], 0.0, middle[1]], force)
        both = 2.0 * gripper.limits.force
        grips = both * gripper.limits.friction
        off = self.points - middle
        lever = np.linalg.norm(off, axis=1).mean()
        slips = np.hypot(np.hypot(force[:, 0], force[:, 2]) / grips, torque[:, 1] / (grips * lever))
        half_x, half_z = np.abs(off).max(axis=0)
        tips = np.hypot(torque[:, 0] / (both * half_z), torque[:, 2] / (both * half_x))
        return np.asarray(np.maximum(slips, np.abs(force[:, 1]) / both + tips))


def check_pinch(plan: Plan, scene: Scene, T_tip_item: Array) -> tuple[Reason, ...]:
    """Check everything that concerns fingers and item.

    Args:
        plan: A plan with a grasp.
        scene: The plan's scene, of a cell with a gripper.
        T_tip_item: (4, 4) pose of the item in the tool frame.

    Returns:
        The faults.
    """
    assert plan.grasp is not None
    gripper = scene.cell.robot.tool.gripper
    assert gripper is not None
    grasp, item = plan.grasp, scene.item(plan.grasp.item)
    pads = pads_on(item.shape, grasp.T_item_tip, gripper)
    if pads is None:
        return (Reason("nothing between the pads", "grasp", f"{grasp.item} is not where they close"),)
    if pads.share < LEAST_PATCH:
        touching = f"{100 * pads.share:.0f} % of them touch, at least {100 * LEAST_PATCH:.0f}"
        return (Reason("pads beside the item", grasp.item, touching),)
    reasons = [
        *_face(grasp, item.shape), *_antipodal(grasp, pads, gripper), *_widths(plan, scene, pads),
    ]  # fmt: skip
    for k, segment in enumerate(plan.segments):
        if segment.kind is SegmentKind.CONTACT:
            reasons += _meets(plan, scene, grasp, segment, f"segment {k} (contact)")
    if plan.segments[0].held is not None and scene.held is not None:
        reasons += _as_grasped(grasp, inverse(scene.held.T_tip_item), "in the hand")
    return (*reasons, *_loads(plan, scene, T_tip_item, pads, gripper, item))


def pad_loads(plan: Plan, scene: Scene, wrenches: Array) -> Array:
    """Compute the load on the pads.

    Args:
        plan: A plan with a grasp.
        scene: The plan's scene, of a cell with a gripper.
        wrenches: (..., 6) that the pads exert on the item at the tip, in the tool frame.

    Returns:
        The loads (...) as shares of what the pads bear; infinite if they hold nothing.
    """
    gripper = scene.cell.robot.tool.gripper
    assert plan.grasp is not None and gripper is not None
    pads = pads_on(scene.item(plan.grasp.item).shape, plan.grasp.T_item_tip, gripper)
    if pads is None:
        return np.full(wrenches.shape[:-1], np.inf)
    return pads.ratio(wrenches.reshape(-1, 6), gripper).reshape(wrenches.shape[:-1])


def pads_on(shape: Shape, T_item_tip: Array, gripper: ParallelGripper) -> Pads | None:
    """Find where the pads meet an item as the fingers close.

    Args:
        shape: Shape of the item.
        T_item_tip: (4, 4) pose of the tool frame in the item's.
        gripper: The gripper.

    Returns:
        The contact, or None if either pad meets nothing.
    """
    at = (np.arange(N_PAD_POINTS) + 0.5) / N_PAD_POINTS - 0.5
    x, z = (grid.ravel() for grid in np.meshgrid(at * gripper.pad[0], at * gripper.pad[1]))
    R, along = T_item_tip[:3, :3], T_item_tip[:3, 1]
    starts = T_item_tip[:3, 3] + np.outer(x, R[:, 0]) + np.outer(z, R[:, 2])
    near, far = cast_rays(shape, starts, along)
    if np.isnan(near).all():
        return None
    out, back = np.nanmax(far), np.nanmin(near)
    touches = (far >= out - PAD_COMPRESSION) & (near <= back + PAD_COMPRESSION)
    if not touches.any():
        return None
    normals = [_normals(shape, starts[touches] + np.outer(s[touches], along)) for s in (far, near)]
    cosines = np.concatenate([normals[0] @ along, normals[1] @ -along])
    steepest = float(np.arccos(np.clip(cosines.min(), -1.0, 1.0)))
    points = np.column_stack([x, z])[touches]
    return Pads(float(out - back), points, steepest, float(touches.mean()))


def _normals(shape: Shape, points: Array) -> Array:
    """Return (N, 3) outward normals of a shape at points (N, 3) of its surface."""
    if shape.kind is ShapeKind.SPHERE:
        return np.asarray(points / np.linalg.norm(points, axis=1, keepdims=True))
    if shape.kind is ShapeKind.BOX:
        axis = np.argmax(np.abs(points) - shape.extents / 2, axis=1)
        return np.asarray(np.sign(points) * np.eye(3)[axis])
    radius, length = shape.size
    r = np.hypot(points[:, 0], points[:, 1])
    is_end: NDArray[np.bool_] = np.abs(points[:, 2]) - length / 2 > r - radius
    ends = np.sign(points) * (0.0, 0.0, 1.0)
    return np.where(is_end[:, None], ends, points * (1.0, 1.0, 0.0) / np.maximum(r, 1e-9)[:, None])


def _face(grasp: Grasp, shape: Shape) -> Iterator[Reason]:
    """Check that the stated faces are those that the pads close on."""
    along = np.abs(grasp.T_item_tip[:3, 1])
    face = "xyz"[int(np.argmax(along))]
    if shape.kind is ShapeKind.SPHERE:
        face = "sphere"
    elif shape.kind is ShapeKind.CYLINDER and face != "z":
        face = "mantle"
    if grasp.face != face:
        yield Reason("wrong face", "grasp", f"{grasp.face} stated, the pads close on {face}")


def _antipodal(grasp: Grasp, pads: Pads, gripper: ParallelGripper) -> Iterator[Reason]:
    """Check that the line between the pads lies in both friction cones."""
    cone = float(np.arctan(gripper.limits.friction))
    if pads.steepest > cone:
        angles = (
            f"{np.degrees(pads.steepest):.1f} degrees off a normal, the cone is {np.degrees(cone):.1f} wide"
        )
        yield Reason("outside of the friction cone", grasp.item, angles)


def _widths(plan: Plan, scene: Scene, pads: Pads) -> Iterator[Reason]:
    """Check that the fingers approach wider than the item, and hold it at its width in every segment."""
    robot = scene.cell.robot
    for k, segment in enumerate(plan.segments):
        where = f"segment {k} ({segment.kind})"
        if segment.held is not None and segment.tool_state != MOVING:
            width = stated_position(robot, segment.tool_state)
            if abs(width - pads.width) > OFF_WIDTH:
                detail = f"{1e3 * width:.1f} mm stated, between the pads are {1e3 * pads.width:.1f} mm"
                yield Reason("wrong width", where, detail)
        if segment.kind is SegmentKind.APPROACH and stated_position(robot, segment.tool_state) <= pads.width:
            detail = f"{segment.tool_state} is no wider than {1e3 * pads.width:.1f} mm"
            yield Reason("fingers not open", where, detail)


def _meets(plan: Plan, scene: Scene, grasp: Grasp, contact: Segment, where: str) -> Iterator[Reason]:
    """Check that the fingers close at the grasp's pose."""
    robot = scene.cell.robot
    q = positions_at(plan.trajectory, contact.t_end)
    tip = tip_poses(robot, link_poses(robot, q), contact.tool_state)[0]
    yield from _as_grasped(grasp, inverse(scene.find(grasp.item).T_world_item) @ tip, where)
    if contact.tool_state != MOVING:
        yield Reason("wrong tool state", where, f"the fingers close here, {contact.tool_state} is stated")


def _as_grasped(grasp: Grasp, T_item_tip: Array, where: str) -> Iterator[Reason]:
    off = inverse(grasp.T_item_tip) @ T_item_tip
    aside, turned = float(np.linalg.norm(off[:3, 3])), rotation_angle(off[:3, :3])
    if aside > MAX_GRASP_OFFSET or turned > MAX_GRASP_TURN:
        detail = f"{aside * 1e3:.1f} mm off, turned {np.degrees(turned):.1f} deg"
        yield Reason("misses the item", where, detail)


def _loads(
    plan: Plan, scene: Scene, T_tip_item: Array, pads: Pads, gripper: ParallelGripper, item: Item
) -> Iterator[Reason]:
    """Check that the pads bear the item from closing to opening, and that the plan states this load."""
    times, wrenches = held_wrenches(plan, scene, T_tip_item)
    if len(times) == 0:
        return
    assert plan.grasp is not None
    ratios = pads.ratio(wrenches, gripper)
    i = int(np.argmax(ratios))
    if ratios[i] > 1.0:
        fx, fy, fz, tx, ty, tz = wrenches[i]
        detail = f"{ratios[i]:.2f} of what the pads bear at {times[i]:.3f} s: "
        detail += f"force ({fx:.1f}, {fy:.1f}, {fz:.1f}) N, "
        yield Reason("does not hold", item.name, detail + f"torque ({tx:.3f}, {ty:.3f}, {tz:.3f}) Nm")
    found = {
        "pull": np.abs(wrenches[:, 1]),
        "shear": np.hypot(wrenches[:, 0], wrenches[:, 2]),
        "moment": np.hypot(wrenches[:, 3], wrenches[:, 5]),
        "twist": np.abs(wrenches[:, 4]),
    }
    for name, values in found.items():
        value, stated = float(values.max()), float(getattr(plan.grasp, name))
        if abs(value - stated) > max(SAME_LEAST, SAME_SHARE * value):
            yield Reason("load not as stated", f"grasp.{name}", f"{stated:.3f} stated, {value:.3f} found")
