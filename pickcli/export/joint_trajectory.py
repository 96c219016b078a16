"""Exports trajectory_msgs/JointTrajectory as JSON, with the device events in the same file."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

from pickcli.errors import InputError
from pickcli.export.device_events import device_events
from pickcli.export.exporter import Exporter, ExportRequest
from pickcli.export.samples import MotionSamples, interpolation_error, sampled, stamp
from pickcli.motion.plan_file import motion_hash

FORMAT, VERSION = "apc joint trajectory", 1
MAX_ERROR = 1e-3  # rad or m, largest deviation of a controller's interpolation from the verified motion


def trajectory_message(joint_names: tuple[str, ...], samples: MotionSamples) -> dict[str, Any]:
    """Make a trajectory_msgs/JointTrajectory message.

    Args:
        joint_names: Names of the n joints.
        samples: The motion.

    Returns:
        Fields of the message. Its stamp is 0: it starts when it is received.
    """
    rows = zip(samples.positions, samples.velocities, samples.accelerations, samples.nanoseconds, strict=True)
    return {
        "header": {"stamp": stamp(0), "frame_id": ""},
        "joint_names": list(joint_names),
        "points": [
            {
                "positions": q.tolist(),
                "velocities": dq.tolist(),
                "accelerations": ddq.tolist(),
                "effort": [],
                "time_from_start": stamp(t),
            }
            for q, dq, ddq, t in rows
        ],
    }


def _encode(request: ExportRequest) -> bytes:
    plan, cell = request.plan, request.scene.cell
    samples = sampled(plan.trajectory, request.rate)
    _refuse_coarse(request, samples)
    message = trajectory_message(plan.trajectory.joint_names, samples)
    events = [
        {
            "time_from_start": stamp(event.nanoseconds),
            "device": event.device,
            "action": event.action,
            "kind": event.kind.value,
            "lead": event.lead,
        }
        for event in device_events(plan, cell)
    ]
    made_from = {
        "query": plan.query,
        "cell": cell.name,
        "arm": plan.arm,
        "cell_fingerprint": plan.cell_fingerprint,
        "scene_hash": plan.scene_hash,
        "motion_hash": motion_hash(plan),
    }
    head = {"format": FORMAT, "version": VERSION, "plan": made_from}
    points = _lines(message.pop("points"), "    ")
    lines = [
        *(f"  {_text(key)}: {_text(value)}," for key, value in head.items()),
        '  "trajectory": {',
        *(f"    {_text(key)}: {_text(value)}," for key, value in message.items()),
        f'    "points": {points}',
        "  },",
        f'  "events": {_lines(events, "  ")}',
    ]
    return "\n".join(["{", *lines, "}", ""]).encode()


def _refuse_coarse(request: ExportRequest, samples: MotionSamples) -> None:
    """Raise InputError if interpolation of the samples would deviate too much from the verified motion."""
    trajectory = request.plan.trajectory
    if request.rate is None or len(samples.nanoseconds) < 2:
        return
    error, joint = interpolation_error(trajectory, samples)
    if error > MAX_ERROR:
        name, unit = trajectory.joint_names[joint], request.scene.cell.robot.units[joint]
        raise InputError(
            f"rate: with {request.rate:g} Hz a controller would leave the verified motion by {error:.2g} "
            f"{unit} in {name}, {MAX_ERROR:g} at most; name a higher rate, or none for the plan's own points"
        )


def _text(value: Any) -> str:
    return json.dumps(value, allow_nan=False)


def _lines(values: Iterable[Any], indent: str) -> str:
    """Format a JSON array with one line per value."""
    rows = [f"{indent}  {_text(value)}" for value in values]
    return "[\n" + ",\n".join(rows) + f"\n{indent}]" if rows else "[]"


EXPORTER = Exporter("trajectory_msgs/JointTrajectory as JSON, device events beside it", ".json", _encode)
