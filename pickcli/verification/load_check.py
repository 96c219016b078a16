"""Check the load on the cup at every millisecond while it holds, from differences of the executed curve.

The item is a rigid body of uniform density at the pose of the grasp. The verifier's own kinematics give its
position and orientation; Newton and Euler give the force and torque that move it. The cell states whether the
cup bears them together, for the heaviest mass that the item may have.

A cup that holds an item by its side gives way when it takes up the weight, and the item swings on it. The
speed limit for this is a property of the tool (docs/simulation.md), and is checked on the executed curve.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from pickcli.cell.item import Item
from pickcli.cell.robot import Robot
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Grasp, Plan
from pickcli.motion.segment import SegmentKind
from pickcli.scene.scene import Scene
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.quintic import motion
from pickcli.verification.tool_change_check import held_tip_poses

GRAVITY = np.array([0.0, 0.0, 9.81])  # m/s^2, upwards: the acceleration that resists gravity
SAMPLE_TIME = 1e-3  # s
SAME_SHARE, SAME_LEAST = 0.01, 0.01  # of a load, and N, Nm or ratio at least: the planner samples differently
# Share of what the cup bears. If the weight's torque takes more, it must be taken up slowly: an overshoot by
# a third would add more than a tenth of the limits.
SLOW_TAKE_UP_TORQUE = 0.3
# Sine of a slope: a cup whose axis slopes less than that holds the item by its side. It is a little less than
# the sine of 45 degrees from which on the planner is careful: a cup at 45 degrees, as computed here, may go
# either way.
SIDE_HOLD_SLOPE = 0.7


def check_load(plan: Plan, scene: Scene, T_tip_item: Array, vacuum_share: float) -> Iterator[Reason]:
    """Check that lip and friction of the cup bear the item from the contact to its release.

    Args:
        plan: The plan; it may have no segments that hold an item.
        scene: The plan's scene.
        T_tip_item: (4, 4) pose of the item in the tool frame.
        vacuum_share: Share of full vacuum that the face under the cup keeps.

    Yields:
        Where the load is over what the cup bears, at its worst.
    """
    if vacuum_share <= 0.0:  # reported by the seal check; avoids division by 0
        return
    times, wrenches = held_wrenches(plan, scene, T_tip_item)
    if len(times) == 0:
        return
    assert plan.grasp is not None
    item, limits = scene.item(plan.grasp.item), scene.cell.robot.tool.cup.limits
    for what, ratios in (
        ("pull and moment", limits.peel(wrenches, vacuum_share)),
        ("shear and twist", limits.slip(wrenches, vacuum_share)),
    ):
        i = int(np.argmax(ratios))
        if ratios[i] > 1.0:
            at = f"{ratios[i]:.2f} of what the cup bears at {times[i]:.3f} s: {_wrench_text(wrenches[i])}"
            yield Reason("does not hold", f"{item.name}, {what}", at)
    yield from _stated(plan.grasp, wrenches, float(limits.ratio(wrenches, vacuum_share).max()))
    yield from _taken_up(plan, scene, T_tip_item, vacuum_share)


def _taken_up(plan: Plan, scene: Scene, T_tip_item: Array, vacuum_share: float) -> Iterator[Reason]:
    """Check that the lift begins slowly if the weight turns the item on the cup."""
    k = next(i for i, segment in enumerate(plan.segments) if segment.held is not None)
    if k == 0 or plan.segments[k - 1].kind is not SegmentKind.CONTACT:
        return
    assert plan.grasp is not None
    lift, item, robot = plan.segments[k], scene.item(plan.grasp.item), scene.cell.robot
    tool, limits = robot.tool, robot.tool.cup.limits
    times = np.arange(lift.t_start, lift.t_end, SAMPLE_TIME)
    tips = tip_poses(robot, link_poses(robot, motion(plan.trajectory, times)[0]), lift.tool_state)
    torque = wrenches(tips[[0, 0, 0]], T_tip_item, item, SAMPLE_TIME)[0, 3:]
    share = max(np.hypot(*torque[:2]) / limits.max_moment, abs(torque[2]) / limits.max_twist) / vacuum_share
    if abs(tips[0, 2, 2]) > SIDE_HOLD_SLOPE or share < SLOW_TAKE_UP_TORQUE:
        return
    p = tips[:, :3, 3]
    speeds = np.linalg.norm(np.diff(p, axis=0), axis=1) / SAMPLE_TIME
    is_taking_up = np.linalg.norm(p[1:] - p[0], axis=1) <= tool.cup.take_up
    fastest = float(speeds[is_taking_up].max(initial=0.0))
    if fastest > tool.cup.take_up_speed:
        at = f"{fastest:.4f} m/s in its first {tool.cup.take_up} m, the cup takes {tool.cup.take_up_speed}"
        yield Reason("weight taken up too fast", f"segment {k} ({lift.kind})", at)


def _stated(grasp: Grasp, wrenches: Array, ratio: float) -> Iterator[Reason]:
    """Check that the load that the plan states is the computed one."""
    found = {
        "pull": float(np.maximum(0.0, -wrenches[:, 2]).max()),
        "shear": float(np.hypot(wrenches[:, 0], wrenches[:, 1]).max()),
        "moment": float(np.hypot(wrenches[:, 3], wrenches[:, 4]).max()),
        "twist": float(np.abs(wrenches[:, 5]).max()),
        "load_ratio": ratio,
    }
    for name, value in found.items():
        stated = float(getattr(grasp, name))
        if abs(value - stated) > max(SAME_LEAST, SAME_SHARE * value):
            yield Reason("load not as stated", f"grasp.{name}", f"{stated:.3f} stated, {value:.3f} found")


def held_wrenches(plan: Plan, scene: Scene, T_tip_item: Array) -> tuple[Array, Array]:
    """Compute the wrenches that the cup exerts on the item, for its heaviest mass.

    Args:
        plan: A plan with a grasp.
        scene: The plan's scene.
        T_tip_item: (4, 4) pose of the item in the tool frame.

    Returns:
        Times (N,) in s, every millisecond while it is held, and (N, 6) forces in N and torques in Nm about
        the cup's tip, in the tool frame.
    """
    times, tips = held_tips(plan, scene.cell.robot)
    if len(times) == 0:
        return times, np.empty((0, 6))
    assert plan.grasp is not None
    return times, wrenches(tips, T_tip_item, scene.item(plan.grasp.item), SAMPLE_TIME)


def held_tips(plan: Plan, robot: Robot) -> tuple[Array, Array]:
    """Compute the poses of the tool while it holds an item.

    Args:
        plan: A plan.
        robot: The robot.

    Returns:
        Times (N,) in s, every millisecond while the item is held, and the tool frame in the world (N + 2, 4,
        4), also a millisecond before and after.
    """
    held = [segment for segment in plan.segments if segment.held is not None]
    if not held:
        return np.empty(0), np.empty((0, 4, 4))
    # Before the start and after the end of the trajectory the arm is at rest.
    n = int(np.ceil((held[-1].t_end - held[0].t_start) / SAMPLE_TIME)) + 1
    times = np.asarray(held[0].t_start + SAMPLE_TIME * np.arange(-1, n + 1), dtype=np.float64)
    return times[1:-1], held_tip_poses(plan, robot, times)


def wrenches(tips: Array, T_tip_item: Array, item: Item, step: float) -> Array:
    """Compute force and torque on a held item at the tool's tip, by differences of neighbouring poses.

    Args:
        tips: (N, 4, 4) poses of the tool frame in the world, ``step`` s apart.
        T_tip_item: (4, 4) pose of the item in the tool frame.
        item: The item; its heaviest mass is used.
        step: s; the error of the differences is of second order in it.

    Returns:
        (N - 2, 6) at all poses except the first and last, in the tool frame: force, then torque about the
        tip.
    """
    R, centre = tips[:, :3, :3], tips[:, :3, :3] @ T_tip_item[:3, 3] + tips[:, :3, 3]
    acceleration = (centre[2:] - 2.0 * centre[1:-1] + centre[:-2]) / step**2
    force = item.heaviest * _turned_back(R[1:-1], acceleration + GRAVITY)
    # Angular velocities half-way between the poses, each in the frame of the middle pose.
    steps = Rotation.from_matrix(np.swapaxes(R[:-1], 1, 2) @ R[1:]).as_rotvec() / step
    before, after = steps[:-1], steps[1:]
    rate, change = (before + after) / 2.0, (after - before) / step
    axes = T_tip_item[:3, :3]
    inertia = axes @ (item.inertia * (1.0 + item.mass_error)) @ axes.T
    spin = change @ inertia + np.cross(rate, rate @ inertia)
    return np.hstack([force, spin + np.cross(T_tip_item[:3, 3], force)])


def _turned_back(R: Array, v: Array) -> Array:
    """Rotate world vectors (N, 3) into the frames R (N, 3, 3)."""
    return np.asarray(np.einsum("nji,nj->ni", R, v))


def _wrench_text(wrench: Array) -> str:
    fx, fy, fz, tx, ty, tz = wrench
    return (
        f"pull {max(0.0, -fz):.1f} N, shear {np.hypot(fx, fy):.1f} N, "
        f"moment {np.hypot(tx, ty):.2f} Nm, twist {abs(tz):.2f} Nm"
    )
