"""Exports a plan as an MCAP log with ROS 2 messages in CDR, at the plan's times."""

from __future__ import annotations

import io
import json
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from pickcli import __version__
from pickcli.errors import not_installed
from pickcli.export.device_events import device_events
from pickcli.export.exporter import Exporter, ExportRequest
from pickcli.export.joint_trajectory import trajectory_message
from pickcli.export.link_frames import LinkFrames, ToolMotion, tool_motion
from pickcli.export.robot_description import robot_description
from pickcli.export.ros_messages import definition, header, transform
from pickcli.export.samples import SECOND, MotionSamples, sampled, stamp, to_nanoseconds
from pickcli.export.scene_markers import cell_markers, item_marker
from pickcli.geometry import Array, inverse
from pickcli.motion.plan_file import motion_hash

TOPICS = {  # topic -> type
    "/robot_description": "std_msgs/String",
    "/tf_static": "tf2_msgs/TFMessage",
    "/cell_markers": "visualization_msgs/MarkerArray",
    "/item_markers": "visualization_msgs/MarkerArray",
    "/joint_trajectory": "trajectory_msgs/JointTrajectory",
    "/joint_states": "sensor_msgs/JointState",
    "/tf": "tf2_msgs/TFMessage",
    "/device_events": "diagnostic_msgs/KeyValue",
}
LATCHED = ("/robot_description", "/tf_static", "/cell_markers", "/item_markers", "/joint_trajectory")
_FOREVER = "{sec: 9223372036, nsec: 854775807}"
_LATCHED_QOS = f"""\
- history: 1
  depth: 1
  reliability: 1
  durability: 1
  deadline: {_FOREVER}
  lifespan: {_FOREVER}
  liveliness: 1
  liveliness_lease_duration: {_FOREVER}
  avoid_ros_namespace_conventions: false
"""


@dataclass(frozen=True)
class Message:
    """A message of the log.

    Attributes:
        nanoseconds: Time since the start of the plan.
        topic: One of TOPICS.
        content: Fields of the message.
    """

    nanoseconds: int
    topic: str
    content: dict[str, Any]


@dataclass(frozen=True, eq=False)
class _Recording:
    """Data for the messages."""

    request: ExportRequest
    frames: LinkFrames
    tool: ToolMotion
    samples: MotionSamples
    positions: Array  # (K, m) of all moving joints, at the samples
    velocities: Array  # (K, m)


def _recording(request: ExportRequest) -> _Recording:
    plan, cell = request.plan, request.scene.cell
    movers = tuple(name for name, device in cell.devices.items() if device.kind is cell.robot.tool.mover)
    tool, samples = tool_motion(plan, cell.robot, movers), sampled(plan.trajectory, request.rate)
    times = samples.nanoseconds / SECOND
    positions = np.hstack([samples.positions, tool.positions(times)])
    velocities = np.hstack([samples.velocities, tool.velocities(times)])
    return _Recording(request, LinkFrames(cell.robot), tool, samples, positions, velocities)


def messages(request: ExportRequest) -> list[Message]:
    """Create all messages of the log.

    Args:
        request: The plan and its scene.

    Returns:
        The messages in the order of time; if equal, in the order of TOPICS.
    """
    recording = _recording(request)
    found = [
        *_standing(recording),
        *_items(recording),
        *_moving(recording),
        *(
            Message(event.nanoseconds, "/device_events", {"key": event.device, "value": event.action})
            for event in device_events(request.plan, request.scene.cell)
        ),
    ]
    order = list(TOPICS)
    return sorted(found, key=lambda message: (message.nanoseconds, order.index(message.topic)))


def _standing(recording: _Recording) -> Iterator[Message]:
    """Yield the messages that occur only once."""
    request, frames = recording.request, recording.frames
    standing = [transform(parent, child, T, stamp(0)) for parent, child, T in frames.standing]
    samples = sampled(request.plan.trajectory, None)
    yield Message(0, "/robot_description", {"data": robot_description(request.scene.cell.robot)})
    yield Message(0, "/tf_static", {"transforms": standing})
    yield Message(0, "/cell_markers", {"markers": cell_markers(request.scene, frames.world)})
    yield Message(0, "/joint_trajectory", trajectory_message(request.plan.trajectory.joint_names, samples))


def _moving(recording: _Recording) -> Iterator[Message]:
    """Yield joint states and link frames at every sample."""
    frames = recording.frames
    columns = [frames.joint_names.index(joint.name) for joint in frames.moving]
    for k, nanoseconds in enumerate(recording.samples.nanoseconds.tolist()):
        positions, now = recording.positions[k].tolist(), stamp(nanoseconds)
        state = {
            "header": header(frames.world, now),
            "name": list(frames.joint_names),
            "position": positions,
            "velocity": recording.velocities[k].tolist(),
            "effort": [],
        }
        yield Message(nanoseconds, "/joint_states", state)
        at = zip(frames.moving, recording.positions[k, columns].tolist(), strict=True)
        moved = [
            transform(joint.parent, joint.child, frames.T_parent_child(joint, position), now)
            for joint, position in at
        ]
        yield Message(nanoseconds, "/tf", {"transforms": moved})


def _items(recording: _Recording) -> Iterator[Message]:
    """Yield all items at the start, and again whenever one is taken or released."""
    request, frames = recording.request, recording.frames
    plan, scene = request.plan, request.scene
    at = {placed.id: (frames.world, placed.T_world_item) for placed in scene.items}
    yield _all_items(recording, at, 0)
    held: str | None = None
    for segment in plan.segments:
        if segment.held == held or plan.grasp is None:
            continue
        tool = frames.robot.tool
        T_last_item = tool.T_last_tip @ inverse(plan.grasp.T_item_tip)
        if segment.held is not None:
            at[segment.held] = (tool.last_link, T_last_item)
        elif held is not None:
            q = plan.trajectory.sample(segment.t_start)[0]
            joints = np.append(q, recording.tool.positions(np.array([segment.t_start]))[0])
            at[held] = (frames.world, frames.T_world_link(tool.last_link, joints) @ T_last_item)
        held = segment.held
        yield _all_items(recording, at, to_nanoseconds(segment.t_start))


def _all_items(recording: _Recording, at: dict[str, tuple[str, Array]], nanoseconds: int) -> Message:
    scene = recording.request.scene
    markers = [item_marker(scene, placed, at[placed.id], nanoseconds) for placed in scene.items]
    return Message(nanoseconds, "/item_markers", {"markers": markers})


def _encode(request: ExportRequest) -> bytes:
    try:
        from mcap.writer import Writer
        from mcap_ros2._dynamic import serialize_dynamic  # its own writer does not support latched topics
    except ImportError as error:
        raise not_installed("mcap", "export", "export to mcap") from error
    file = io.BytesIO()
    writer = Writer(file)
    writer.start(profile="ros2", library=f"apc {__version__}")
    schemas, encoders, channels = {}, {}, {}
    for kind in dict.fromkeys(TOPICS.values()):
        name, text = kind.replace("/", "/msg/"), definition(kind)
        schemas[kind] = writer.register_schema(name, "ros2msg", text.encode())
        encoders[kind] = serialize_dynamic(name, text)[name]
    for topic, kind in TOPICS.items():
        qos = {"offered_qos_profiles": _LATCHED_QOS if topic in LATCHED else ""}
        channels[topic] = writer.register_channel(topic, "cdr", schemas[kind], qos)
    writer.add_metadata("apc", _made_from(request))
    counts = dict.fromkeys(TOPICS, 0)
    for message in messages(request):
        topic, t = message.topic, message.nanoseconds
        data = encoders[TOPICS[topic]](message.content)
        writer.add_message(channels[topic], t, data, t, counts[topic])
        counts[topic] += 1
    writer.finish()  # type: ignore[no-untyped-call]  # of others
    return file.getvalue()


def _made_from(request: ExportRequest) -> dict[str, str]:
    plan = request.plan
    return {
        "query": plan.query,
        "cell": request.scene.cell.name,
        "cell_fingerprint": plan.cell_fingerprint,
        "scene_hash": plan.scene_hash,
        "motion_hash": motion_hash(plan),
        "segments": json.dumps([[s.kind.value, s.t_start, s.t_end, s.held] for s in plan.segments]),
    }


EXPORTER = Exporter(
    "a recording in MCAP for ROS 2: joints, frames, trajectory, robot, scene, events", ".mcap", _encode
)
