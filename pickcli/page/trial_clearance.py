"""Computes the robot's clearance in a trial, with every item at its pose at that time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.robot import Robot
from pickcli.geometry import Array, from_quaternion, inverse, pose
from pickcli.kinematics.arm import Arm
from pickcli.page.page_motion import Carried, PathClearance
from pickcli.page.page_scene import posed
from pickcli.page.path_clearance import NearestPairs
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.trial.motion_record import RecordedExecution, RecordedMotion

SAMPLE_TIME = 0.04  # s between samples


def trial_clearance(scene: Scene, cells: Sequence[Cell], motion: RecordedMotion) -> PathClearance | None:
    """Compute the distance to the nearest solid during executions, except for planned contacts.

    Args:
        scene: The true scene at the start.
        cells: The cell as seen by each arm that plays.
        motion: The recorded motion.

    Returns:
        The clearance, a lower bound; None without executions.
    """
    moves = [execution for execution in motion.executions if execution.segments]
    if not moves:
        return None
    pairs, by_arm = NearestPairs(scene.cell.clearance), {cell.arm: cell for cell in cells}
    for move in moves:
        times = np.arange(move.segments[0].t_start, move.segments[-1].t_end, SAMPLE_TIME)
        here = replace(_scene_at(scene, motion, move.t_start), cell=by_arm[move.arm])
        Q = _joints_at(motion, here.cell.robot, times)
        pairs.add(here, move.segments, times, Q, _carried(here, motion, move))
    return pairs.clearance()


def _scene_at(scene: Scene, motion: RecordedMotion, t: float) -> Scene:
    """The true scene at a time, by the recorded poses."""
    items = tuple(
        replace(placed, T_world_item=_item_at(motion, placed.id, t)) if placed.id in motion.items else placed
        for placed in scene.items
    )
    return replace(scene, items=items, noise=PoseNoise())


def _carried(scene: Scene, motion: RecordedMotion, move: RecordedExecution) -> tuple[Carried, ...]:
    """The item held in a motion, with its pose in the tool in the middle of that time."""
    held = [segment for segment in move.segments if segment.held is not None]
    if not held or held[0].held not in motion.items:
        return ()
    t = (held[0].t_start + held[0].t_end) / 2
    item = held[0].held
    (q,) = _joints_at(motion, scene.cell.robot, np.array([t]))
    tip = Arm(scene.cell.robot).tip(q, held[0].tool_state)
    T_tip_item = inverse(tip) @ _item_at(motion, item, t)
    return (Carried(item, held[0].t_start, held[-1].t_end, posed(T_tip_item)),)


def _joints_at(motion: RecordedMotion, robot: Robot, times: Array) -> Array:
    """The planned joints (N, n) of a robot at times (N,)."""
    columns = [motion.joints[:, motion.joint_names.index(name)] for name in robot.joint_names]
    return np.column_stack([np.interp(times, motion.times, column) for column in columns])


def _item_at(motion: RecordedMotion, item: str, t: float) -> Array:
    times, poses = motion.items[item]
    row = np.array([np.interp(t, times, column) for column in poses.T])
    return pose(row[:3], R=from_quaternion(row[3:]))
