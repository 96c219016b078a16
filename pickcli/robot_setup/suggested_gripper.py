"""Finds a parallel gripper in a robot's URDF: two fingers that slide in a hand at the end of the arm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.checks.gripper_consistency import MIN_ALONG_COSINE
from pickcli.cell.robot import Joint, JointType
from pickcli.cell.robots.urdf import Urdf
from pickcli.cell.shapes import Body
from pickcli.errors import InputError
from pickcli.geometry import Array, cross, pose
from pickcli.robot_setup.finger_pads import MIN_PAD_WIDTH, find_pads

MAX_PAD_LENGTH = 0.02  # m along the fingers, whose ends grip: longer ones would meet the floor first

_SNAP = 0.9  # least cosine to an axis of the hand, to which the finger direction is then snapped
_DECIMALS = 4  # of m, as in the cell file
_AHEAD = 0.005  # m, least distance of the fingers from the hand that shows their direction


@dataclass(frozen=True, eq=False)
class SuggestedGripper:
    """A parallel gripper found in a URDF.

    Attributes:
        flange: Name of the link that the hand is fixed to.
        hand: Name of the link in which the fingers slide.
        fingers: Names of the finger links.
        joints: Names of the finger joints.
        T_hand_tip: (4, 4) pose of the tool frame: between the pads, z out of the hand, y in the closing
            direction.
        pad_size: m, sides of the pads along x and z of the tool frame.
        pad_gap: m between the pads with both joints at 0.
        widths: m, least and greatest by the joint limits.
    """

    flange: str
    hand: str
    fingers: tuple[str, str]
    joints: tuple[str, str]
    T_hand_tip: Array
    pad_size: tuple[float, float]
    pad_gap: float
    widths: tuple[float, float]


def find_gripper(robot: Urdf, ends: Sequence[str]) -> SuggestedGripper:
    """Find the gripper at the end of an arm.

    Args:
        robot: The robot.
        ends: Names of the links that the arm's last joint moves and no later joint.

    Returns:
        The gripper.

    Raises:
        InputError: There is no or more than one gripper, or it is not a parallel gripper; with advice.
    """
    one, other = _fingers(robot, ends)
    hand, mount = one.parent, robot.joints.get(one.parent)
    if mount is None or mount.type is not JointType.FIXED:
        raise _no_gripper(
            f"{hand}, in which the fingers slide, is moved by the arm's last joint itself; put a link "
            "without a shape between them, and a fixed joint"
        )
    axis = _in_hand(one)
    if abs(float(axis @ _in_hand(other))) < MIN_ALONG_COSINE:
        raise _no_gripper(
            f"{one.name} and {other.name} do not move along one line; only parallel grippers are known"
        )
    for joint in (one, other):
        _check_finger(robot, joint)
    R = _axes(robot, (one, other), axis)
    shapes = [_shapes_in(robot, joint, R) for joint in (one, other)]
    if _middle(shapes[0])[1] < _middle(shapes[1])[1]:
        R = np.column_stack([-R[:, 0], -R[:, 1], R[:, 2]])
        shapes = [_shapes_in(robot, joint, R) for joint in (one, other)]
    pads = find_pads(*shapes)
    if pads is None:
        raise _no_gripper(
            f"the collision shapes of {one.child} and {other.child} face each other with nothing that is "
            f"flat over {1e3 * MIN_PAD_WIDTH:g} mm; give them a <collision> with a pad"
        )
    pads = pads.ending(MAX_PAD_LENGTH)
    gap = max(0.0, round(pads.gap, _DECIMALS))  # closed fingers may overlap by rounding
    return SuggestedGripper(
        flange=mount.parent,
        hand=hand,
        fingers=(one.child, other.child),
        joints=(one.name, other.name),
        T_hand_tip=pose(R @ pads.middle, R=R),
        pad_size=pads.size,
        pad_gap=gap,
        widths=_widths(gap, ((one, 1.0), (other, -1.0)), R[:, 1]),
    )


def _no_gripper(why: str) -> InputError:
    return InputError(f"--tool gripper: {why}")


def _fingers(robot: Urdf, ends: Sequence[str]) -> tuple[Joint, Joint]:
    """The two prismatic joints on a link at the end of the arm. Raises InputError unless there are two."""
    hands = {link: [j for j in robot.children(link) if j.type is JointType.PRISMATIC] for link in ends}
    sliding = {link: joints for link, joints in hands.items() if joints}
    pairs = [joints for joints in sliding.values() if len(joints) == 2]
    if len(pairs) == 1 and len(sliding) == 1:
        return pairs[0][0], pairs[0][1]
    if not sliding:
        turning = [j.name for link in ends for j in robot.children(link) if j.type is not JointType.FIXED]
        met = f", there only turn {', '.join(turning)}" if turning else ""
        raise _no_gripper(
            f"no finger slides in what is beyond the arm ({', '.join(ends)}){met}; name a URDF that has the "
            "gripper, two fingers each on a prismatic joint of one hand, or take --tool suction"
        )
    listed = "; ".join(f"{', '.join(j.name for j in joints)} in {link}" for link, joints in sliding.items())
    raise _no_gripper(
        f"expected two fingers in one hand, got {listed}; leave out the other links with --without LINK"
    )


def _check_finger(robot: Urdf, joint: Joint) -> None:
    """Check that a finger has shapes, and no moving parts with shapes. Raises InputError.

    Shapes of links fixed to it have been moved onto it (``finger_shapes``).
    """
    if not robot.links[joint.child].bodies:
        raise _no_gripper(f"{joint.child} has no collision shape; add <collision> to the URDF")
    hanging = [link for link in robot.links if robot.links[link].bodies and joint in robot.way(link)[:-1]]
    if hanging:
        raise _no_gripper(
            f"{', '.join(hanging)} moves against {joint.child}, and a finger is one rigid body; make its "
            "joint fixed, or leave it out with --without"
        )


def _in_hand(joint: Joint) -> Array:
    """Sliding direction (3,) of a finger in the hand's frame."""
    return np.asarray(joint.T_parent_joint[:3, :3] @ joint.axis)


def _axes(robot: Urdf, fingers: Sequence[Joint], closing: Array) -> Array:
    """Orientation (3, 3) of the tool frame in the hand: y along ``closing``, z along the fingers."""
    middle = np.mean([_middle(_shapes_in(robot, joint, np.eye(3))) for joint in fingers], axis=0)
    ahead = middle - (middle @ closing) * closing
    if np.linalg.norm(ahead) < _AHEAD:
        raise _no_gripper(
            f"the fingers stand around the origin of {fingers[0].parent}, so that it does not show which way "
            "is out of the hand; move that frame into the hand"
        )
    z = ahead / np.linalg.norm(ahead)
    nearest = np.eye(3)[np.argmax(np.abs(z))] * np.sign(z[np.argmax(np.abs(z))])
    if z @ nearest > _SNAP:
        z = nearest - (nearest @ closing) * closing
        z /= np.linalg.norm(z)
    return np.column_stack([cross(closing, z), closing, z])


def _shapes_in(robot: Urdf, joint: Joint, R_hand_axes: Array) -> list[Body]:
    """Shapes of a finger at joint position 0, in axes (3, 3) at the hand's origin."""
    T = pose(R=R_hand_axes.T) @ joint.T_parent_joint
    return [replace(b, T_parent_shape=T @ b.T_parent_shape) for b in robot.links[joint.child].bodies]


def _middle(shapes: Sequence[Body]) -> Array:
    return np.asarray(np.mean([body.T_parent_shape[:3, 3] for body in shapes], axis=0))


def _widths(gap: float, fingers: Sequence[tuple[Joint, float]], y: Array) -> tuple[float, float]:
    """Least and greatest width in m within both joints' limits, not below 0."""
    least, most = 0.0, np.inf
    for joint, side in fingers:
        opening = side * float(np.sign(_in_hand(joint) @ y))
        ends = sorted(gap + 2.0 * opening * limit for limit in (joint.lower, joint.upper))
        least, most = max(least, ends[0]), min(most, ends[1])
    return least, most
