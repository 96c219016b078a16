"""Fingers of a gripper: planner and verifier pose them alike, and spheres contain them at every width."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

from pickcli.cell.cell import Cell
from pickcli.cell.tool import MOVING, ToolState
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import inverse, pose
from pickcli.kinematics.arm import Arm
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.moving_parts import Part, parts
from support.cell_copies import CellCopy
from support.gripper_cell import CLOSED, HALF, OPEN, WIDEST, gripper_urdf, with_gripper
from support.tool_frame import tip_in_flange

STATES = (OPEN, HALF, CLOSED, ToolState.of_width(0.0317))
FINGERS = ("left_finger", "right_finger")


@pytest.fixture
def gripper(cell_copy: CellCopy) -> Cell:
    return with_gripper(cell_copy).load()


def fingers(cell: Cell, state: ToolState) -> list[Part]:
    """The parts of both fingers in a state."""
    segment = Segment(SegmentKind.TRANSIT, 0.0, 1.0, state, None)
    scene = Scene(cell, cell.T_world_pod, (), PoseNoise())
    return [part for part in parts(scene, segment, None) if part.is_finger]


@pytest.mark.parametrize("state", STATES, ids=str)
def test_planner_and_verifier_pose_fingers_and_tip_alike(gripper: Cell, state: ToolState) -> None:
    robot, rng = gripper.robot, np.random.default_rng(3)
    Q = np.array([rng.uniform(*robot.limits.window) for _ in range(5)])
    arm, links = Arm(robot), link_poses(robot, Q)
    assert_allclose(arm.tips(Q, state), tip_poses(robot, links, state), atol=1e-9)
    names = CollisionModel(gripper).frame_names
    for n, q in enumerate(Q):
        frames = np.asarray(arm.chain(state).fk(q))
        for part in fingers(gripper, state):
            body = robot.link(part.name).bodies[0]
            T_planner = frames[names.index(part.name)] @ body.T_parent_shape
            assert_allclose(links[part.link, n] @ part.T_link_shape, T_planner, atol=1e-9)


@pytest.mark.parametrize("state", STATES, ids=str)
def test_planner_and_verifier_pose_alike_what_is_fixed_to_a_finger(
    cell_copy: CellCopy, state: ToolState
) -> None:
    copy = with_gripper(cell_copy)
    gripper_urdf(copy).replace(
        '<link name="right_finger">',
        '<link name="tip"><collision><geometry><box size="0.01 0.01 0.02"/></geometry></collision></link>\n'
        '<joint name="tipped" type="fixed"><parent link="left_finger"/><child link="tip"/>'
        '<origin xyz="0 0.05 0.09"/></joint>\n<link name="right_finger">',
    )
    cell = copy.load()
    Q = cell.robot.limits.window[0][None]
    names, frames = CollisionModel(cell).frame_names, np.asarray(Arm(cell.robot).chain(state).fk(Q[0]))
    T_world_tip = frames[names.index("left_finger")] @ pose((0.0, 0.05, 0.09))
    of_left = [part for part in fingers(cell, state) if part.name == "left_finger"]
    links = link_poses(cell.robot, Q)
    posed = [links[part.link, 0] @ part.T_link_shape for part in of_left]
    assert len(posed) == 2 and any(np.allclose(T, T_world_tip, atol=1e-9) for T in posed)


@pytest.mark.parametrize("state", STATES, ids=str)
def test_pads_stand_as_far_apart_as_the_state_says(gripper: Cell, state: ToolState) -> None:
    tool = gripper.robot.tool
    T_tip_hand = inverse(tip_in_flange(gripper, state))
    inner = {part.name: (T_tip_hand @ part.T_link_shape)[1, 3] for part in fingers(gripper, state)}
    thickness = 0.012
    assert_allclose(
        inner["left_finger"] - inner["right_finger"] - thickness, tool.position(state), atol=1e-12
    )


@pytest.mark.parametrize("width", [0.0, 0.013, 0.04, WIDEST])
def test_what_the_closing_fingers_sweep_holds_them_at_every_width(gripper: Cell, width: float) -> None:
    model = CollisionModel(gripper)
    swept, at_width = model.state(MOVING), model.state(ToolState.of_width(width))
    q = np.zeros(gripper.robot.n_joints)
    T_swept, T = (np.asarray(state.chain.fk(q)) for state in (swept, at_width))
    for frame in model.tool_frames:
        mine = swept.spheres.frames == frame
        centers = swept.spheres.centers[mine] @ T_swept[frame, :3, :3].T + T_swept[frame, :3, 3]
        body = gripper.robot.link(model.frame_names[frame]).bodies[0]
        corners = np.array(np.meshgrid(*[(-0.5, 0.0, 0.5)] * 3)).reshape(3, -1).T * body.shape.extents
        at = T[frame] @ body.T_parent_shape
        for corner in corners @ at[:3, :3].T + at[:3, 3]:
            assert (np.linalg.norm(centers - corner, axis=1) <= swept.spheres.radii[mine] + 1e-9).any()


def test_the_verifier_looks_at_fingers_that_move_every_three_millimetres(gripper: Cell) -> None:
    moving = fingers(gripper, MOVING)
    for name in FINGERS:
        at = np.sort([part.T_link_shape[1, 3] for part in moving if part.name == name])
        assert np.diff(at).max() <= 0.003 + 1e-9 and np.ptp(at) == pytest.approx(WIDEST / 2)
        slack = {part.slack for part in moving if part.name == name}
        assert min(slack) >= np.diff(at).max() / 2 - 1e-9
