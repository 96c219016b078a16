"""Selects the planned joints of a robot and fixes all others in their posture."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from pickcli.cell.robot import Joint, JointType, Link, joint_motion, massless_link
from pickcli.cell.robots.urdf import Urdf
from pickcli.geometry import Array


def mounted(robot: Urdf, tool: Urdf, flange: str, T_flange_tool: Array) -> Urdf:
    """Mount a tool with a separate URDF on a robot.

    Args:
        robot: The robot.
        tool: The tool; its link and joint names differ from the robot's.
        flange: Name of the robot link that carries the tool.
        T_flange_tool: (4, 4) pose of the tool's root link in the flange.

    Returns:
        Both as one tree.
    """
    mount = Joint(
        name=f"{flange}_{tool.root}",
        type=JointType.FIXED,
        parent=flange,
        child=tool.root,
        T_parent_joint=T_flange_tool,
        axis=next(iter(robot.joints.values())).axis,
        lower=0.0,
        upper=0.0,
    )
    return Urdf(
        name=robot.name,
        root=robot.root,
        links={**robot.links, **tool.links},
        joints={**robot.joints, tool.root: mount, **tool.joints},
        mimics={**robot.mimics, **tool.mimics},
        unshaped={**robot.unshaped, **tool.unshaped},
    )


def with_tip(robot: Urdf, hand: str, tip: str, T_hand_tip: Array) -> Urdf:
    """Add a frame between the fingers of a hand, as a link without a shape.

    Args:
        robot: The robot.
        hand: Name of the hand's link.
        tip: Name of the new link, different from the robot's.
        T_hand_tip: (4, 4) pose of the new link in the hand.

    Returns:
        The robot with the link.
    """
    link = massless_link(tip)
    joint = Joint(
        name=f"{tip}_joint",
        type=JointType.FIXED,
        parent=hand,
        child=tip,
        T_parent_joint=T_hand_tip,
        axis=np.array([0.0, 0.0, 1.0]),
        lower=0.0,
        upper=0.0,
    )
    return replace(robot, links={**robot.links, tip: link}, joints={**robot.joints, tip: joint})


def with_whole_finger(robot: Urdf, finger: str) -> Urdf:
    """Move the shapes of links that are fixed to a finger, such as its tip, to the finger.

    The links stay, without shapes: whatever moves or measures a finger then has all of it.

    Args:
        robot: The robot.
        finger: Name of the finger's link.

    Returns:
        The robot with one solid finger.
    """
    links, ahead = dict(robot.links), [(finger, np.eye(4))]
    while ahead:
        above, T_finger_above = ahead.pop()
        for joint in robot.children(above):
            if joint.type is JointType.FIXED:
                T, link, whole = T_finger_above @ joint.T_parent_joint, links[joint.child], links[finger]
                moved = (replace(b, T_parent_shape=T @ b.T_parent_shape) for b in link.bodies)
                links[finger] = replace(whole, bodies=(*whole.bodies, *moved))
                links[joint.child] = replace(link, bodies=())
                ahead.append((joint.child, T))
    return replace(robot, links=links)


def stripped(robot: Urdf, without: Iterable[str]) -> Urdf:
    """Remove links with everything that is attached to them.

    Args:
        robot: The robot.
        without: Names of links, none of them the root.

    Returns:
        The remaining robot.
    """
    removed = set(without)
    gone = {name for name in robot.links if removed & {name, *(j.child for j in robot.way(name))}}
    joints = {child: joint for child, joint in robot.joints.items() if child not in gone}
    names = {joint.name for joint in joints.values()}
    return replace(
        robot,
        links={name: link for name, link in robot.links.items() if name not in gone},
        joints=joints,
        mimics={name: mimic for name, mimic in robot.mimics.items() if name in names},
        unshaped={name: line for name, line in robot.unshaped.items() if name not in gone},
    )


def planning_group(
    robot: Urdf, tip: str, moving: Iterable[str], posture: Mapping[str, float]
) -> tuple[tuple[Link, ...], tuple[Joint, ...]]:
    """Return the links and joints of a robot in which only the joints of one chain move.

    All other joints become fixed, at their position in the posture or as their mimic relation gives it. Links
    outside the chain that carry no shape are left out.

    Args:
        robot: The robot.
        tip: Name of the link at the end of the chain.
        moving: Names of the joints that stay movable: those of the chain and of the tool's fingers.
        posture: Positions in rad or m of all other joints that are neither fixed nor mimics.

    Returns:
        The links and their parent joints: ``links[i + 1]`` is the child of ``joints[i]``. Both are ordered
        from the root outwards, side branches before the rest of the chain, so that the tip comes last.
    """
    kept = set(moving)
    on_chain = {joint.child for joint in robot.way(tip)}
    joints = tuple(
        joint if joint.name in kept else _fixed(joint, _position(robot, joint, posture))
        for joint in _outwards(robot, robot.root, on_chain)
    )
    return (robot.links[robot.root], *(robot.links[joint.child] for joint in joints)), joints


def _outwards(robot: Urdf, link: str, on_chain: set[str]) -> Iterator[Joint]:
    """Yield the joints below a link, those of the chain after all others."""
    for joint in sorted(robot.children(link), key=lambda joint: joint.child in on_chain):
        behind = tuple(_outwards(robot, joint.child, on_chain))
        if behind or joint.child in on_chain or robot.links[joint.child].bodies:
            yield joint
            yield from behind


def _position(robot: Urdf, joint: Joint, posture: Mapping[str, float]) -> float:
    if joint.type is JointType.FIXED:
        return 0.0
    mimic = robot.mimics.get(joint.name)
    if mimic is None:
        return posture[joint.name]
    return mimic.multiplier * posture[mimic.joint] + mimic.offset


def _fixed(joint: Joint, position: float) -> Joint:
    if joint.type is JointType.FIXED:
        return joint
    T = joint.T_parent_joint @ joint_motion(joint, position)
    return replace(joint, type=JointType.FIXED, T_parent_joint=T, lower=0.0, upper=0.0)
