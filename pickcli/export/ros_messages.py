"""Definitions of ROS 2 messages, unchanged since Humble, and messages as plain values."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from pickcli.geometry import Array, to_quaternion

SEPARATOR = "=" * 80
_MARKER_TYPES = (
    "ARROW", "CUBE", "SPHERE", "CYLINDER", "LINE_STRIP", "LINE_LIST", "CUBE_LIST", "SPHERE_LIST", "POINTS",
    "TEXT_VIEW_FACING", "MESH_RESOURCE", "TRIANGLE_LIST",
)  # fmt: skip
_MARKER_ACTIONS = {"ADD": 0, "MODIFY": 0, "DELETE": 2, "DELETEALL": 3}

# Fields of each message, one per line.
_FIELDS = {
    "builtin_interfaces/Duration": "int32 sec\nuint32 nanosec",
    "builtin_interfaces/Time": "int32 sec\nuint32 nanosec",
    "diagnostic_msgs/KeyValue": "string key\nstring value",
    "geometry_msgs/Point": "float64 x\nfloat64 y\nfloat64 z",
    "geometry_msgs/Pose": "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "geometry_msgs/Quaternion": "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    "geometry_msgs/Transform": "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
    "geometry_msgs/TransformStamped": (
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform"
    ),
    "geometry_msgs/Vector3": "float64 x\nfloat64 y\nfloat64 z",
    "sensor_msgs/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data",
    "sensor_msgs/JointState": (
        "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort"
    ),
    "std_msgs/ColorRGBA": "float32 r\nfloat32 g\nfloat32 b\nfloat32 a",
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id",
    "std_msgs/String": "string data",
    "tf2_msgs/TFMessage": "geometry_msgs/TransformStamped[] transforms",
    "trajectory_msgs/JointTrajectory": (
        "std_msgs/Header header\nstring[] joint_names\ntrajectory_msgs/JointTrajectoryPoint[] points"
    ),
    "trajectory_msgs/JointTrajectoryPoint": (
        "float64[] positions\nfloat64[] velocities\nfloat64[] accelerations\nfloat64[] effort\n"
        "builtin_interfaces/Duration time_from_start"
    ),
    "visualization_msgs/Marker": "\n".join([
        *(f"int32 {name}={number}" for number, name in enumerate(_MARKER_TYPES)),
        *(f"int32 {name}={number}" for name, number in _MARKER_ACTIONS.items()),
        "std_msgs/Header header", "string ns", "int32 id", "int32 type", "int32 action",
        "geometry_msgs/Pose pose", "geometry_msgs/Vector3 scale", "std_msgs/ColorRGBA color",
        "builtin_interfaces/Duration lifetime", "bool frame_locked", "geometry_msgs/Point[] points",
        "std_msgs/ColorRGBA[] colors", "string texture_resource", "sensor_msgs/CompressedImage texture",
        "visualization_msgs/UVCoordinate[] uv_coordinates", "string text", "string mesh_resource",
        "visualization_msgs/MeshFile mesh_file", "bool mesh_use_embedded_materials",
    ]),
    "visualization_msgs/MarkerArray": "visualization_msgs/Marker[] markers",
    "visualization_msgs/MeshFile": "string filename\nuint8[] data",
    "visualization_msgs/UVCoordinate": "float32 u\nfloat32 v",
}  # fmt: skip


def definition(name: str) -> str:
    """Return the definition of a message with those of all its parts, as stored in logs.

    Args:
        name: E.g. ``std_msgs/String``.

    Returns:
        The text in ROS's own format.
    """
    parts = [f"{_FIELDS[name]}\n", *(f"MSG: {part}\n{_FIELDS[part]}\n" for part in _made_of(name, [])[1:])]
    return f"{SEPARATOR}\n".join(parts)


def _made_of(name: str, found: list[str]) -> list[str]:
    """A message and all its parts, each once, in order of occurrence."""
    if name not in found:
        found.append(name)
        for part in re.findall(r"^(\w+/\w+)", _FIELDS[name], re.MULTILINE):
            _made_of(part, found)
    return found


def header(frame: str, stamp: dict[str, int]) -> dict[str, Any]:
    """Make a std_msgs/Header message.

    Args:
        frame: Name of a frame.
        stamp: ``sec`` and ``nanosec``.

    Returns:
        The message by its fields.
    """
    return {"stamp": stamp, "frame_id": frame}


def point(p: Array) -> dict[str, float]:
    """Make a geometry_msgs/Point or Vector3 message.

    Args:
        p: (3,) m.

    Returns:
        The message by its fields.
    """
    return dict(zip("xyz", p.tolist(), strict=True))


def quaternion(R: Array) -> dict[str, float]:
    """Make a geometry_msgs/Quaternion message.

    Args:
        R: (3, 3) rotation matrix.

    Returns:
        The message by its fields.
    """
    return dict(zip("xyzw", to_quaternion(R).tolist(), strict=True))


def ros_pose(T: Array) -> dict[str, Any]:
    """Make a geometry_msgs/Pose message.

    Args:
        T: (4, 4) pose.

    Returns:
        The message by its fields.
    """
    return {"position": point(T[:3, 3]), "orientation": quaternion(T[:3, :3])}


def transform(parent: str, child: str, T: Array, stamp: dict[str, int]) -> dict[str, Any]:
    """Make a geometry_msgs/TransformStamped message.

    Args:
        parent: Name of a frame.
        child: Name of a frame.
        T: (4, 4) pose of the child in the parent.
        stamp: ``sec`` and ``nanosec``.

    Returns:
        The message by its fields.
    """
    moved = {"translation": point(T[:3, 3]), "rotation": quaternion(T[:3, :3])}
    return {"header": header(parent, stamp), "child_frame_id": child, "transform": moved}


def colour(rgba: tuple[float, float, float, float]) -> dict[str, float]:
    """Make a std_msgs/ColorRGBA message.

    Args:
        rgba: Red, green, blue and opacity.

    Returns:
        The message by its fields.
    """
    return dict(zip("rgba", np.asarray(rgba).tolist(), strict=True))
