"""``apc inspect --motion``: single motions of a trajectory database."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pickcli.commands.options.arm_options import ArmRequest, open_cell

if TYPE_CHECKING:
    from pickcli.roadmap.trajectory_database import CoarseMotion


def motions_between(
    path: Path, start: str, goal: str, cell_name: str | None, arms: ArmRequest
) -> dict[str, Any]:
    """Read the motions of a database from one named configuration to another; no others are read.

    Args:
        path: The file of the database.
        start: Name of the start configuration.
        goal: Name of the goal configuration.
        cell_name: The cell that the file must belong to; None for any.
        arms: The arms stated on the command line.

    Returns:
        JSON values: the two names, and the motions by payload class.

    Raises:
        InputError: The file is missing or of another kind, or holds no such motion.
        DamagedError: The data that were read are not those that were written.
        StaleError: It was made for another cell or by another version of the format.
    """
    from pickcli.errors import InputError
    from pickcli.name_suggestion import shortened
    from pickcli.roadmap.store import read_motion
    from pickcli.roadmap.trajectory_database import MotionKey, PayloadClass

    cell = None if cell_name is None else open_cell(cell_name, arms)
    found = {load: read_motion(path, MotionKey(start, goal, load), cell) for load in PayloadClass}
    values = {str(load): _values(motion) for load, motion in found.items() if motion is not None}
    if not values:
        ends = f"{shortened(start)!r} and {shortened(goal)!r}"
        raise InputError(
            f"{path}: contains no motion between {ends}; without --motion, --all lists what is missing "
            "and why, and apc inspect CELL the names of configurations"
        )
    return {"format": "trajectory database", "start": start, "goal": goal, "motions": values}


def _values(motion: CoarseMotion) -> dict[str, Any]:
    """Convert a stored motion with its timed points, as in trajectory_msgs/JointTrajectory."""
    timed = motion.trajectory
    assert timed is not None  # read_motion reads the points too
    rows = zip(timed.times, timed.positions, timed.velocities, timed.accelerations, strict=True)
    return {
        "tool_state": str(motion.tool_state),
        "duration_s": motion.duration,
        "lower_bound_s": motion.lower_bound,
        "clearance_mm": 1e3 * motion.clearance,
        "pod_poses": str(motion.validity.pod_poses),
        "why_nominal": motion.validity.why_nominal,
        "waypoints": motion.path.waypoints.tolist(),
        "joint_names": list(timed.joint_names),
        "points": [
            {"time_from_start": float(t), "positions": q.tolist(), "velocities": v.tolist(),
             "accelerations": a.tolist()}
            for t, q, v, a in rows
        ],
    }  # fmt: skip


def motion_text(values: Mapping[str, Any]) -> str:
    """Describe a stored motion in a sentence.

    Args:
        values: Its JSON values from ``motions_between``.

    Returns:
        The sentence.
    """
    why = f" ({values['why_nominal']})" if values["why_nominal"] else ""
    return (
        f"{values['duration_s']:.3f} s, {values['lower_bound_s']:.3f} s at least; "
        f"{len(values['waypoints'])} waypoints, {len(values['points'])} timed points; "
        f"tool {values['tool_state']}, {values['clearance_mm']:.0f} mm clear, pod {values['pod_poses']}{why}"
    )
