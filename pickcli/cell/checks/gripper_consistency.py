"""Consistency of a parallel gripper with its URDF: fingers, joints, pads and widths."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from pickcli.cell.checks.references import refer
from pickcli.cell.item import Item
from pickcli.cell.robot import Joint, JointType, joint_motion
from pickcli.cell.robots.urdf import Urdf
from pickcli.cell.schemas.cell_schema import CellModel
from pickcli.cell.schemas.tool_schema import GripperModel
from pickcli.cell.shapes import Body, ShapeKind
from pickcli.cell.tool import MOVING
from pickcli.files.source import Source
from pickcli.geometry import Array, inverse

MIN_ALONG_COSINE = 0.999  # least cosine between a direction and an axis that it is along: 2.5 degrees
PAD_DEPTH = 0.001  # m behind a pad's face, at which the finger must be solid
PAD_OVERHANG = 0.0005  # m by which a pad may be larger than the finger's shapes, for rounded figures
IN_FRONT = 0.002  # m in front of a pad's face, at which there must be no part of the finger
_ROUNDING = 1e-9


def check_hand(source: Source, tool: GripperModel, robot: Urdf) -> None:
    """Check that the gripper's links exist, and that its fingers slide in its hand.

    Args:
        source: Collects the mistakes with their places in the file.
        tool: The tool as it stands in the file.
        robot: The robot with the tool, without the frame between the pads.

    Raises:
        InputError: With every mistake; further checks need these links.
    """
    names = list(robot.links)
    refer(source, ("tool", "flange_link"), "link", tool.flange_link, names)
    refer(source, ("tool", "hand_link"), "link", tool.hand_link, names)
    if tool.last_link in robot.links:
        text = f"{tool.last_link!r} is what the frame between the pads is called; rename the robot's link"
        source.add(("robot", "urdf"), text)
    for k, link in enumerate(tool.fingers):
        refer(source, ("tool", "fingers", k), "link", link, names)
    if tool.fingers[0] == tool.fingers[1]:
        source.add(("tool", "fingers"), "expected two links, got one twice; name both fingers")
    source.check()
    for k, link in enumerate(tool.fingers):
        joint = robot.joints.get(link)
        if joint is None or joint.parent != tool.hand_link or joint.type is not JointType.PRISMATIC:
            got = "the root link" if joint is None else f"a {joint.type} joint on {joint.parent!r}"
            text = f"expected {link!r} to slide in {tool.hand_link!r} on a prismatic joint, got {got}"
            source.add(("tool", "fingers", k), f"{text}; only parallel grippers are known")
        elif not robot.links[link].bodies:
            source.add(
                ("tool", "fingers", k), f"{link!r} has no collision shape; add <collision> to the URDF"
            )
        for moving in (each for each in robot.joints.values() if each.type is not JointType.FIXED):
            if link in {above.child for above in robot.way(moving.parent)}:
                text = f"{moving.name!r} moves {moving.child!r} on {link!r}; a finger is rigid: make it fixed"
                source.add(("tool", "fingers", k), text)
    source.check()


def check_gripper(source: Source, tool: GripperModel, robot: Urdf) -> None:
    """Check that the chain ends with flange, hand and tip, and that fingers, pads and widths are consistent.

    Args:
        source: Collects the mistakes with their places in the file.
        tool: The tool as it stands in the file.
        robot: The robot with the tool and the frame between its pads.
    """
    last = [robot.root, *(joint.child for joint in robot.way(tool.last_link))][-3:]
    if last[:2] != [tool.flange_link, tool.hand_link]:
        text = f"expected the hand to hang on the flange, {tool.flange_link!r}; the chain ends with "
        source.add(("tool", "hand_link"), text + ", ".join(last[:2]))
    if MOVING.name in tool.states:
        text = f"{MOVING} means that the tool is between two states; give this one another name"
        source.add(("tool", "states", MOVING.name), text)
    axes = [_axis(tool, robot, link) for link in tool.fingers]
    for k, axis in enumerate(axes):
        if abs(axis[1]) < MIN_ALONG_COSINE:
            text = "moves across the y axis of T_hand_tip; turn that so that y points along which it closes"
            source.add(("tool", "fingers", k), f"{tool.fingers[k]!r} {text}")
    if any(abs(axis[1]) < MIN_ALONG_COSINE for axis in axes):
        return
    if finger_sign(tool, robot, tool.fingers[0]) == finger_sign(tool, robot, tool.fingers[1]):
        text = "both stand on one side of T_hand_tip; put its origin in the middle between the pads"
        source.add(("tool", "fingers"), text)
        return
    _check_mirrored(source, tool, robot)
    _check_widths(source, tool, robot)
    for link in tool.fingers:
        _check_pad(source, tool, robot, link)


def check_stroke(source: Source, model: CellModel, items: Iterable[Item]) -> None:
    """Check that a gripper opens wider than the thinnest item.

    Args:
        source: Collects the mistakes with their places in the file.
        model: The cell as it stands in the file.
        items: The known items.

    Raises:
        InputError: The gripper does not open wide enough.
    """
    if not isinstance(model.tool, GripperModel):
        return
    widest = max(model.tool.states.values())
    thinnest = min(items, key=lambda item: item.shape.extents.min())
    thin = float(thinnest.shape.extents.min())
    if widest <= thin:
        text = f"the widest is {widest:g} m, the thinnest item ({thinnest.name}) is {thin:g} m thick; "
        source.add(("tool", "states"), text + "nothing fits between the pads: widths are in m, not mm")
    source.check()


def finger_joints(model: CellModel, robot: Urdf) -> tuple[str, ...]:
    """Names of the joints of a gripper's fingers, empty for any other tool.

    Args:
        model: The cell as it stands in the file.
        robot: The robot with the tool.

    Returns:
        Two names, or none.
    """
    if not isinstance(model.tool, GripperModel):
        return ()
    return tuple(finger_joint(robot, link).name for link in model.tool.fingers)


def finger_joint(robot: Urdf, link: str) -> Joint:
    """The joint that moves a finger.

    Args:
        robot: The robot with the tool.
        link: The finger's link.

    Returns:
        The joint.
    """
    return robot.joints[link]


def finger_sign(tool: GripperModel, robot: Urdf, link: str) -> float:
    """Side of the tool frame that a finger is on, by the mean of its shapes at joint position 0.

    Args:
        tool: The tool as it stands in the file.
        robot: The robot with the tool.
        link: The finger's link.

    Returns:
        +1 on the side of +y, else -1.
    """
    T_tip_finger = _T_tip_finger(tool, robot, link, 0.0)
    middle = np.mean([(T_tip_finger @ body.T_parent_shape)[1, 3] for body in robot.links[link].bodies])
    return 1.0 if middle > 0.0 else -1.0


def opening_sign(tool: GripperModel, robot: Urdf, link: str) -> float:
    """Sign with which a finger's joint moves when the gripper opens.

    Args:
        tool: The tool as it stands in the file.
        robot: The robot with the tool.
        link: The finger's link.

    Returns:
        +1 if its position increases, else -1.
    """
    return float(np.sign(_axis(tool, robot, link)[1])) * finger_sign(tool, robot, link)


def _axis(tool: GripperModel, robot: Urdf, link: str) -> Array:
    """(3,) direction of a finger's joint in the tool frame."""
    joint = finger_joint(robot, link)
    R_tip_hand = inverse(tool.T_hand_tip.T)[:3, :3]
    return np.asarray(R_tip_hand @ joint.T_parent_joint[:3, :3] @ joint.axis)


def _T_tip_finger(tool: GripperModel, robot: Urdf, link: str, position: float) -> Array:
    """Pose (4, 4) of a finger in the tool frame at a joint position in m."""
    joint = finger_joint(robot, link)
    return np.asarray(inverse(tool.T_hand_tip.T) @ joint.T_parent_joint @ joint_motion(joint, position))


def _check_mirrored(source: Source, tool: GripperModel, robot: Urdf) -> None:
    """Check that a finger that mimics the other one mirrors its motion."""
    joints = {finger_joint(robot, link).name: link for link in tool.fingers}
    for name, link in joints.items():
        mimic = robot.mimics.get(name)
        if mimic is None:
            continue
        if mimic.joint not in joints:
            text = (
                f"mimics {mimic.joint!r}, which is no finger's joint; the fingers have to mirror each other"
            )
            source.add(("tool", "fingers"), f"joint {name!r} {text}")
            continue
        signs = [opening_sign(tool, robot, of) for of in (link, joints[mimic.joint])]
        if mimic.multiplier * signs[0] * signs[1] != 1.0 or mimic.offset != 0.0:
            text = (
                f"mimics {mimic.joint!r} by {mimic.multiplier:g} and {mimic.offset:g} m, so that they do not "
            )
            text += "mirror each other; in a parallel gripper the middle between the pads stays where it is"
            source.add(("tool", "fingers"), f"joint {name!r} {text}")


def _check_widths(source: Source, tool: GripperModel, robot: Urdf) -> None:
    """Check that all widths are within the joint limits and differ, and that the first is not the least."""
    least, most = 0.0, np.inf
    for link in tool.fingers:
        joint, sign = finger_joint(robot, link), opening_sign(tool, robot, link)
        ends = sorted(tool.pad_gap + 2.0 * sign * limit for limit in (joint.lower, joint.upper))
        least, most = max(least, ends[0]), min(most, ends[1])
    for name, width in tool.states.items():
        if not least - _ROUNDING <= width <= most + _ROUNDING:
            text = f"expected {least:g} to {most:g} m, as far as the joints of the fingers go, got {width:g}"
            source.add(("tool", "states", name), f"{text}; widths are between the pads, in m")
    if len(set(tool.states.values())) < len(tool.states):
        source.add(("tool", "states"), "two are the same width; leave one out")
    elif (first := next(iter(tool.states))) == min(tool.states, key=tool.states.__getitem__):
        text = (
            f"the first is the default, and {first} is the narrowest, so that the hand would come to an item "
        )
        widest = max(tool.states, key=tool.states.__getitem__)
        source.add(("tool", "states"), f"{text}with its fingers shut; put an open one first, e.g. {widest}")


def _check_pad(source: Source, tool: GripperModel, robot: Urdf, link: str) -> None:
    """Check that a finger is solid behind its pad and does not reach over the pad's face."""
    T_finger_tip = inverse(_T_tip_finger(tool, robot, link, 0.0))
    side, half = finger_sign(tool, robot, link), np.array(tool.pad_size) / 2 - PAD_OVERHANG
    face, shapes = side * tool.pad_gap / 2, robot.links[link].bodies

    def is_solid(x: float, y: float, z: float) -> bool:
        p = T_finger_tip @ (x, y, z, 1.0)
        return any(_holds(body, p) for body in shapes)

    corners = [(i * half[0], j * half[1]) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    if not all(is_solid(x, face + side * PAD_DEPTH, z) for x, z in corners):
        size = " x ".join(f"{side:g}" for side in tool.pad_size)
        text = f"a pad of {size} m is not all on {link!r}, whose shapes do not fill what is behind it; "
        source.add(("tool", "pad_size"), text + "correct pad_size, pad_gap or T_hand_tip")
    elif is_solid(0.0, face - side * IN_FRONT, 0.0):
        text = (
            f"{link!r} reaches over the face of its pad by {1e3 * IN_FRONT:g} mm and more; correct pad_gap, "
        )
        source.add(("tool", "pad_gap"), text + "the width where both joints stand at 0")


def _holds(body: Body, p: Array) -> bool:
    """Whether a solid contains a point (4,), given in its parent's frame."""
    x = (inverse(body.T_parent_shape) @ p)[:3]
    kind, size = body.shape.kind, body.shape.size
    if kind is ShapeKind.BOX:
        return bool((np.abs(x) <= np.array(size) / 2).all())
    if kind is ShapeKind.SPHERE:
        return bool(np.linalg.norm(x) <= size[0])
    if kind is ShapeKind.CYLINDER:
        return bool(np.hypot(x[0], x[1]) <= size[0] and abs(x[2]) <= size[1] / 2)
    corners = np.array(body.shape.vertices)
    return _in_hull(corners, x)


def _in_hull(corners: Array, x: Array) -> bool:
    """Whether a point (3,) is in the convex hull of points (V, 3)."""
    from scipy.spatial import ConvexHull  # slow to import; only for fingers with meshes

    planes = ConvexHull(corners).equations
    return bool((planes[:, :3] @ x + planes[:, 3] <= _ROUNDING).all())
