"""The MCAP log, read by code of others: rosbags, and the reader of the library that wrote it."""

from __future__ import annotations

import shutil
import subprocess
import warnings
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from mcap.reader import make_reader
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from pickcli.cell.cell import Cell
from pickcli.cell.tool import MOVING
from pickcli.export.exporter import ExportRequest
from pickcli.export.mcap_log import EXPORTER, LATCHED, TOPICS
from pickcli.export.ros_messages import definition
from pickcli.export.samples import SECOND
from pickcli.geometry import Array, from_quaternion, inverse, pose
from pickcli.verification.forward_kinematics import link_poses
from support.exported_motions import at_rate, handmade_pick, ur_request
from support.handmade_plans import CRAYOLA


@dataclass(frozen=True)
class Log:
    """What rosbags reads: messages of each topic with their times in ns."""

    path: Path
    messages: dict[str, list[tuple[int, Any]]]


def read(request: ExportRequest, folder: Path) -> Log:
    """Write a log and read it by rosbags with the definitions that it carries. No warning may be raised."""
    path = folder / "plan.mcap"
    path.write_bytes(EXPORTER.encode(request))
    store, found = get_typestore(Stores.EMPTY), defaultdict(list)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with Reader(path) as reader:
            types: dict[str, Any] = {}
            for connection in reader.connections:
                types.update(get_types_from_msg(connection.msgdef.data, connection.msgtype))
            store.register(types)
            for connection, t, data in reader.messages():
                found[connection.topic].append((t, store.deserialize_cdr(data, connection.msgtype)))
    return Log(path, dict(found))


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Log:
    return read(handmade_pick(), tmp_path_factory.mktemp("log"))


def nanoseconds(stamp: Any) -> int:
    return int(stamp.sec) * SECOND + int(stamp.nanosec)


def as_pose(position: Any, q: Any) -> Array:
    R = from_quaternion((q.x, q.y, q.z, q.w))
    return pose((position.x, position.y, position.z), R=R)


@pytest.mark.parametrize("kind", sorted(set(TOPICS.values())))
def test_definitions_are_those_of_ros(kind: str) -> None:
    text, _ = get_typestore(Stores.ROS2_HUMBLE).generate_msgdef(kind.replace("/", "/msg/"), ros_version=2)
    assert definition(kind) == text


def test_every_topic_is_there_and_in_order(log: Log) -> None:
    assert set(log.messages) == set(TOPICS)
    for topic, messages in log.messages.items():
        times = [t for t, _ in messages]
        assert times == sorted(times)
        assert (len(times) == 1) == (topic in LATCHED and topic != "/item_markers")


def test_its_own_reader_finds_every_checksum_right(log: Log) -> None:
    with log.path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        count = sum(1 for _ in reader.iter_messages())
        summary, head = reader.get_summary(), reader.get_header()
        metadata = {each.name: each.metadata for each in reader.iter_metadata()}
    assert summary is not None and summary.statistics is not None
    assert summary.statistics.message_count == count == sum(map(len, log.messages.values()))
    assert head.profile == "ros2"
    assert metadata["apc"]["query"] == handmade_pick().plan.query
    latched = {c.topic for c in summary.channels.values() if c.metadata["offered_qos_profiles"]}
    assert latched == set(LATCHED)


def test_rosbags_knows_what_is_latched(log: Log) -> None:
    with Reader(log.path) as reader:
        assert {connection.topic for connection in reader.connections} == set(TOPICS)
        for connection in reader.connections:
            profiles = connection.ext.offered_qos_profiles  # type: ignore[union-attr]
            durable = [profile.durability.value for profile in profiles]
            assert durable == ([1] if connection.topic in LATCHED else [])


def test_mcap_doctor_has_nothing_to_say(log: Log) -> None:
    doctor = shutil.which("mcap")
    if doctor is None:
        pytest.skip("the mcap command line tool, a program in Go, is not installed")
    done = subprocess.run([doctor, "doctor", str(log.path)], capture_output=True, text=True)
    assert done.returncode == 0 and "warn" not in (done.stdout + done.stderr).lower()


@pytest.mark.parametrize("rate", [None, 100.0])
def test_joint_states_are_the_plan(rate: float | None, tmp_path: Path) -> None:
    request = at_rate(handmade_pick(), rate)
    trajectory = request.plan.trajectory
    states = read(request, tmp_path).messages["/joint_states"]
    times = np.array([t for t, _ in states])
    assert times[0] == 0 and np.all(np.diff(times) > 0)
    assert [nanoseconds(state.header.stamp) for _, state in states] == times.tolist()
    assert abs(times[-1] / SECOND - trajectory.duration) <= 1e-9
    names = (*trajectory.joint_names, "cup_pivot")
    assert {tuple(state.name) for _, state in states} == {names}
    for column, derivative, bound in (("position", 0, 1e-8), ("velocity", 1, 1e-6)):
        rows = np.array([getattr(state, column) for _, state in states])[:, : len(trajectory.joint_names)]
        np.testing.assert_allclose(rows, trajectory.sample(times / SECOND, derivative), rtol=0.0, atol=bound)
    if rate is None:
        rows = np.array([state.position for _, state in states])[:, : len(trajectory.joint_names)]
        np.testing.assert_array_equal(rows, trajectory.positions)


def test_the_trajectory_message_is_the_plan(log: Log) -> None:
    ((_, message),) = log.messages["/joint_trajectory"]
    trajectory = handmade_pick().plan.trajectory
    assert tuple(message.joint_names) == trajectory.joint_names
    for name, rows in (
        ("positions", trajectory.positions),
        ("velocities", trajectory.velocities),
        ("accelerations", trajectory.accelerations),
    ):
        np.testing.assert_array_equal(np.array([getattr(p, name) for p in message.points]), rows)
    times = np.array([nanoseconds(p.time_from_start) for p in message.points])
    np.testing.assert_allclose(times / SECOND, trajectory.times, rtol=0.0, atol=1e-9)


def test_events_come_at_their_times(log: Log) -> None:
    found = [(message.key, message.value, t / SECOND) for t, message in log.messages["/device_events"]]
    planned = sorted(
        ((e.device, e.action, e.t_trigger or 0.0) for e in handmade_pick().plan.events), key=lambda e: e[2]
    )
    assert [each[:2] for each in found] == [each[:2] for each in planned]
    np.testing.assert_allclose([e[2] for e in found], [e[2] for e in planned], rtol=0.0, atol=1e-9)


class Frames:
    """Poses of frames in the world by tf, as tf2 chains them."""

    def __init__(self, log: Log) -> None:
        self.static = self._edges(log.messages["/tf_static"][0][1])
        self.moving = {t: self._edges(message) for t, message in log.messages["/tf"]}

    @staticmethod
    def _edges(message: Any) -> dict[str, tuple[str, Array]]:
        return {
            each.child_frame_id: (
                each.header.frame_id,
                as_pose(each.transform.translation, each.transform.rotation),
            )
            for each in message.transforms
        }

    def pose(self, frame: str, t: int) -> Array:
        edges, T = {**self.static, **self.moving[t]}, np.eye(4)
        while frame in edges:
            frame, T_parent = edges[frame]
            T = T_parent @ T
        assert frame == "world"
        return np.asarray(T)


def test_frames_stand_where_the_verifier_has_the_links(log: Log) -> None:
    request, frames = handmade_pick(), Frames(log)
    robot, plan = request.scene.cell.robot, request.plan
    resting = [s for s in plan.segments if s.tool_state != MOVING]
    compared = 0
    for t, state in log.messages["/joint_states"][::37]:
        segment = next((s for s in resting if s.t_start <= t / SECOND < s.t_end), None)
        if segment is None:
            continue
        q = np.array([state.position[: robot.n_joints]])
        expected = dict(zip((link.name for link in robot.links), link_poses(robot, q)[:, 0], strict=True))
        for link in robot.links[: -len(robot.tool.joints) or None]:
            np.testing.assert_allclose(frames.pose(link.name, t), expected[link.name], atol=1e-9)
            compared += 1
        assert abs(state.position[robot.n_joints] - robot.tool.position(segment.tool_state)) < 1e-12
    assert compared > 50


def test_the_robot_is_described_with_the_frames_that_move(log: Log, cell: Cell) -> None:
    ((_, message),) = log.messages["/robot_description"]
    root, frames = ElementTree.fromstring(message.data), Frames(log)
    links = {link.attrib["name"] for link in root.findall("link")}
    children = {joint.find("child").attrib["link"] for joint in root.findall("joint")}  # type: ignore[union-attr]
    assert links == {link.name for link in cell.robot.links}
    told = {*frames.static, *next(iter(frames.moving.values()))}
    assert told == links and links - children == {cell.robot.links[0].name}
    shapes = {link.attrib["name"]: len(link.findall("visual")) for link in root.findall("link")}
    assert shapes == {link.name: len(link.bodies) for link in cell.robot.links}


def test_everything_that_stands_is_shown_where_it_stands(log: Log) -> None:
    ((_, message),) = log.messages["/cell_markers"]
    bodies = [
        (carrier.name, k, carrier.T_world_carrier @ body.T_parent_shape, body.shape.extents)
        for carrier in handmade_pick().scene.posed_carriers
        for k, body in enumerate(carrier.bodies)
    ]
    assert [(m.ns, m.id) for m in message.markers] == [(name, k) for name, k, _, _ in bodies]
    for marker, (_, _, T, extents) in zip(message.markers, bodies, strict=True):
        assert marker.header.frame_id == "world"
        np.testing.assert_allclose(as_pose(marker.pose.position, marker.pose.orientation), T, atol=1e-9)
        np.testing.assert_allclose((marker.scale.x, marker.scale.y, marker.scale.z), extents)


def test_the_item_hangs_on_the_tool_from_the_lift_to_the_release(log: Log) -> None:
    request, frames = handmade_pick(), Frames(log)
    plan, scene = request.plan, request.scene
    assert plan.grasp is not None
    taken = [s for s in plan.segments if s.held == CRAYOLA]
    lying, hanging, released = [
        (t, next(m for m in message.markers if m.id == 0)) for t, message in log.messages["/item_markers"]
    ]
    T_lying = as_pose(lying[1].pose.position, lying[1].pose.orientation)
    np.testing.assert_allclose(T_lying, scene.find(CRAYOLA).T_world_item, atol=1e-9)
    assert hanging[1].header.frame_id == scene.cell.robot.tool.last_link
    for (t, _), expected in ((hanging, taken[0].t_start), (released, taken[-1].t_end)):
        assert abs(t / SECOND - expected) <= 1e-9
    T_cup_item = as_pose(hanging[1].pose.position, hanging[1].pose.orientation)
    T_expected = scene.cell.robot.tool.T_last_tip @ inverse(plan.grasp.T_item_tip)
    np.testing.assert_allclose(T_cup_item, T_expected, atol=1e-9)
    before = min(frames.moving, key=lambda t: abs(t - released[0]))
    T_world_item = frames.pose(hanging[1].header.frame_id, before) @ T_cup_item
    assert released[1].header.frame_id == "world"
    T_released = as_pose(released[1].pose.position, released[1].pose.orientation)
    np.testing.assert_allclose(T_released, T_world_item, atol=2e-3)


def test_the_same_plan_gives_the_same_bytes() -> None:
    assert EXPORTER.encode(handmade_pick()) == EXPORTER.encode(handmade_pick())


def test_a_cell_without_items_and_joints_of_the_tool_is_recorded(tmp_path: Path) -> None:
    found = read(ur_request(50.0), tmp_path)
    assert found.messages["/item_markers"][0][1].markers == []
    assert max(t for t, _ in found.messages["/device_events"]) == round(2.05 * SECOND)
    assert len(found.messages["/joint_states"][0][1].name) == 6
