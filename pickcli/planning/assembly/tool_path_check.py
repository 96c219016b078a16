"""Checks of the tool's path on the final trajectory: straight lines and contact speed.

Waypoints lie on their lines and blends are bounded in joint units; the resulting path of the tool is measured
here before the plan is returned, and corrected by narrower blends or a lower speed.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.collision.motion_segment import MotionSegment
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.grasping.grasp_method import ContactLimit
from pickcli.kernel import line_deviation
from pickcli.kinematics.arm import Arm
from pickcli.motion.segment import SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.timing.timed_run import TimedRun
from pickcli.timing.trajectory_sampling import states_at

CURVED = (SegmentKind.TRANSIT, SegmentKind.TRANSFER)  # all other segments are straight lines
SAMPLE_TIME = 0.006  # s between two measured poses
OFF_LINE = 0.0018  # m; the verifier allows 0.002
OFF_ANGLE = np.radians(0.9)  # the verifier allows 1 degree
NARROWER = 0.4  # factor of a blend if the tool left its line
SLOWER = 0.98  # additional factor of a speed that was exceeded
SPEED_STEP = 1e-3  # s over which a speed is measured


def mended(
    arm: Arm, coming: ContactLimit, run: TimedRun, segments: Sequence[MotionSegment]
) -> list[MotionSegment] | None:
    """Adjust the limits of segments if a run breaks a promise.

    Args:
        arm: Kinematics of the tool.
        coming: Limit of the speed at which the tool approaches an item.
        run: The timed run.
        segments: Segments that the run was timed from.

    Returns:
        All segments of the run, with narrower blends on and beside a line that is not straight, and a lower
        speed for a contact that is too fast; None if the run keeps all promises.
    """
    limits = [segment.limits for segment in segments]
    for k, _ in not_straight(arm, run, segments):
        for j in range(max(0, k - 1), min(len(segments), k + 2)):
            wide = min(segments[i].limits.blend_tolerance for i in (k, j))
            limits[j] = replace(limits[j], blend_tolerance=min(limits[j].blend_tolerance, NARROWER * wide))
    for k, speed in _too_fast(arm, coming, run, segments):
        slower = SLOWER * (segments[k].limits.max_tool_speed or speed) * coming.speed / speed
        limits[k] = replace(limits[k], max_tool_speed=slower)
    if limits == [segment.limits for segment in segments]:
        return None
    return [replace(segment, limits=new) for segment, new in zip(segments, limits, strict=True)]


def broken_promise(
    arm: Arm, coming: ContactLimit, run: TimedRun, segments: Sequence[MotionSegment]
) -> Reason | None:
    """Return the first promise that a run breaks.

    Args:
        arm: Kinematics of the tool.
        coming: Limit of the speed at which the tool approaches an item.
        run: The timed run.
        segments: Segments that the run was timed from.

    Returns:
        The promise, the segment and the amount; None if the run keeps all.
    """
    for k, off in not_straight(arm, run, segments):
        return Reason("not straight", f"{segments[k].kind}", off)
    for k, speed in _too_fast(arm, coming, run, segments):
        return Reason(
            "contact speed", f"{segments[k].kind}", f"{speed:.4f} m/s, the tool takes {coming.speed}"
        )
    return None


def not_straight(arm: Arm, run: TimedRun, segments: Sequence[MotionSegment]) -> Iterator[tuple[int, str]]:
    """Find every segment on which the tool leaves its line.

    Args:
        arm: Kinematics of the tool.
        run: The timed run.
        segments: Segments that the run was timed from.

    Yields:
        Index of the segment, and a text that says how far the tool is off.
    """
    spans = list(zip(run.part_times[:-1], run.part_times[1:], strict=True))
    lines = [k for k, (start, end) in enumerate(spans) if segments[k].kind not in CURVED and end > start]
    if not lines:
        return
    times = [np.linspace(*spans[k], int(np.diff(spans[k])[0] / SAMPLE_TIME) + 2) for k in lines]
    # The tool changes its state on coarse motions only: all lines of a run have the same state.
    tips = _tips(arm, run.trajectory, np.concatenate(times), segments[lines[0]].mode.tool_state)
    for k, mine in zip(lines, np.split(tips, np.cumsum([len(t) for t in times])[:-1]), strict=True):
        distance, angle = line_deviation(mine)
        if distance > OFF_LINE or angle > OFF_ANGLE:
            yield k, f"{distance * 1e3:.2f} mm and {np.degrees(angle):.2f} deg off the line"


def _too_fast(
    arm: Arm, coming: ContactLimit, run: TimedRun, segments: Sequence[MotionSegment]
) -> Iterator[tuple[int, float]]:
    """Yield the index of every approach that is faster than allowed, and its greatest speed in m/s."""
    for k, segment in enumerate(segments):
        if segment.kind is not coming.kind:
            continue
        start, end = run.part_times[k], run.part_times[k + 1]
        times = np.linspace(start, end, max(2, int(np.ceil((end - start) / SPEED_STEP)) + 1))
        p = _tips(arm, run.trajectory, times, segment.mode.tool_state)[:, :3, 3]
        speed = float((np.linalg.norm(np.diff(p, axis=0), axis=1) / np.diff(times)).max(initial=0.0))
        if speed > coming.speed:
            yield k, speed


def _tips(arm: Arm, trajectory: Trajectory, times: Array, tool_state: ToolState) -> Array:
    """Return poses (N, 4, 4) of the tool on a trajectory."""
    return arm.tips(states_at(trajectory, times, highest=0)[0], tool_state)
