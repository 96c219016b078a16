"""Joints of the tool while a plan is carried out: they move by their device, and end on the item."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.tool import MOVING, ToolState
from pickcli.export.link_frames import LinkFrames, tool_motion
from pickcli.motion.event import Event
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.verification.forward_kinematics import link_poses
from support.exported_motions import ANYWHERE

WIDTH = 0.05  # m of the item
CLOSES, OPENS = 1.0, 3.0  # s


@pytest.fixture(scope="module")
def panda() -> Cell:
    return load_cell("panda_table")


def pinch(cell: Cell) -> Plan:
    """At rest for 4 s: the fingers close on an item from 1 s on, and open from 3 s on."""
    lead, opened, held = cell.devices["gripper"].lead, ToolState("open"), ToolState.of_width(WIDTH)
    segments = (
        Segment(SegmentKind.APPROACH, 0.0, CLOSES, opened, None),
        Segment(SegmentKind.CONTACT, CLOSES, CLOSES + lead, MOVING, None),
        Segment(SegmentKind.TRANSFER, CLOSES + lead, OPENS, held, "bar"),
        Segment(SegmentKind.DEPART, OPENS, 4.0, MOVING, None),
    )
    events = (
        Event("gripper", "closed", ANYWHERE, lead, CLOSES + lead, CLOSES),
        Event("gripper", "open", ANYWHERE, lead, OPENS + lead, OPENS),
    )
    q = np.tile(cell.configurations["home"].q, (2, 1))
    trajectory = Trajectory(cell.robot.joint_names, np.array([0.0, 4.0]), q, 0 * q, 0 * q)
    return Plan("pinch", cell.fingerprint, "", 0, segments, trajectory, events)


def test_fingers_end_on_the_item_and_open_again(panda: Cell) -> None:
    tool, lead = panda.robot.tool, panda.devices["gripper"].lead
    motion = tool_motion(pinch(panda), panda.robot, ("gripper",))
    times = np.array([0.0, CLOSES, CLOSES + lead / 2, CLOSES + lead, OPENS, OPENS + lead, 4.0])
    widths = [0.08, 0.08, (0.08 + WIDTH) / 2, WIDTH, WIDTH, 0.08, 0.08]
    expected = [[tool.joint_position(j, ToolState.of_width(w)) for j in tool.joints] for w in widths]
    np.testing.assert_allclose(motion.positions(times), expected, atol=1e-12)
    speed = (WIDTH - 0.08) / 2 / lead
    np.testing.assert_allclose(
        np.abs(motion.velocities(np.array([CLOSES + lead / 2]))), abs(speed), rtol=1e-6
    )
    np.testing.assert_array_equal(motion.velocities(np.array([0.5])), 0.0)


def test_links_of_fingers_stand_where_the_verifier_has_them(panda: Cell) -> None:
    robot, frames = panda.robot, LinkFrames(panda.robot)
    q = panda.configurations["home"].q
    at_zero = np.append(q, np.zeros(len(robot.tool.joints)))
    expected = dict(zip((link.name for link in robot.links), link_poses(robot, q[None])[:, 0], strict=True))
    for link in robot.links:
        if link.name not in robot.tool.contact_links:
            np.testing.assert_allclose(
                frames.T_world_link(link.name, at_zero), expected[link.name], atol=1e-9
            )
    one, other = robot.tool.contact_links
    opened = np.append(q, [robot.tool.joint_position(j, ToolState("open")) for j in robot.tool.joints])
    apart = [
        np.linalg.norm(frames.T_world_link(one, at)[:3, 3] - frames.T_world_link(other, at)[:3, 3])
        for at in (at_zero, opened)
    ]
    assert abs(apart[1] - apart[0] - 0.08) < 1e-9


def test_where_a_link_is_called_world_the_frame_of_the_world_is_map(panda: Cell, cell: Cell) -> None:
    assert LinkFrames(cell.robot).world == "world"
    named = panda.robot.links[0]
    assert LinkFrames(panda.robot).world == ("map" if named.name == "world" else "world")
