"""Check that the motors are strong enough for the robot's own weight, what it holds, and the motion.

A motor that cannot exert what the motion requires lags behind its set points: the arm leaves the path that
was proven free. Friction is not modelled; it and what the tool presses against have the rest of the effort.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pickcli.cell.inertial import Inertial
from pickcli.cell.item import Item
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment
from pickcli.scene.scene import Scene
from pickcli.verification.forward_kinematics import tip_poses
from pickcli.verification.inverse_dynamics import CarriedBody, body_motions, carried_links, efforts
from pickcli.verification.quintic import motion
from pickcli.verification.state_sampling import States

# Share of a motor's largest effort that a motion may use. The planner uses 0.9; it samples differently.
MOTOR_SHARE = 0.92
LEAST_STEP = 0.004  # s between two of the states that are looked at: efforts change with the jerk


def check_efforts(plan: Plan, scene: Scene, states: States, T_tip_item: Array | None) -> Iterator[Reason]:
    """Check the efforts of all motors over a plan.

    Args:
        plan: The plan.
        scene: The plan's scene.
        states: States of the plan.
        T_tip_item: (4, 4) pose in the tool frame of the item that it carries.

    Yields:
        A reason for each motor that is too weak, where it lacks most.
    """
    robot = scene.cell.robot
    chosen = np.unique(np.searchsorted(states.times, np.arange(0.0, states.times[-1], LEAST_STEP)))
    times, links = states.times[chosen], states.links[:, chosen]
    _, velocities, accelerations = motion(plan.trajectory, times)
    motions = body_motions(robot, links, velocities, accelerations)
    needed = efforts(robot, motions, carried_links(robot, links))
    last, is_carrying = len(motions) - 1, np.zeros(len(times), dtype=bool)
    for segment in plan.segments:
        if segment.held is None or T_tip_item is None:
            continue
        during = (times >= segment.t_start) & (times <= segment.t_end) & ~is_carrying
        is_carrying |= during  # an instant between two segments is of both
        tips = tip_poses(robot, links[:, during], segment.tool_state)
        some = [each.during(during) for each in motions]
        held = CarriedBody(last, tips @ T_tip_item, _inertial(scene.item(segment.held)))
        needed[during] += efforts(robot, some, [held])
    ratios = np.abs(needed) / [robot.motor_forces[name] for name in robot.joint_names]
    for j, (name, unit) in enumerate(zip(robot.joint_names, robot.units, strict=True)):
        i = int(ratios[:, j].argmax())
        if not ratios[i, j] <= MOTOR_SHARE:
            k, segment = _segment_at(plan, float(times[i]))
            figures = f"{name}: {abs(needed[i, j]):.1f} of {robot.motor_forces[name]:g} {_unit(unit)}"
            where = f"segment {k} ({segment.kind}) at {times[i]:.3f} s"
            yield Reason("motor too weak", where, f"{figures}; at most {MOTOR_SHARE:.0%} may be used")


def _inertial(item: Item) -> Inertial:
    """Mass properties of an item that is as heavy as it may be, in its own frame."""
    return Inertial(item.heaviest, np.zeros(3), item.inertia * (1.0 + item.mass_error))


def _segment_at(plan: Plan, t: float) -> tuple[int, Segment]:
    return next((k, s) for k, s in enumerate(plan.segments) if t <= s.t_end + 1e-9)


def _unit(position_unit: str) -> str:
    return "N" if position_unit == "m" else "Nm"
