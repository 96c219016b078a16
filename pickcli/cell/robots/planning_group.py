"""The part of a robot that a cell plans: the tree of its URDF, all other joints fixed where they stand."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from pickcli.cell.robot import Joint, JointType, Link, joint_motion
from pickcli.cell.robots.urdf import Urdf
from pickcli.geometry import Array


def mounted(robot: Urdf, tool: Urdf, flange: str, T_flange_tool: Array) -> Urdf:
    """A robot with a tool that has a URDF of its own.

    Args:
        robot: The robot.
        tool: The tool; none of its links or joints has a name of the robot's.
        flange: The robot's link that carries it.
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
    """A robot with a frame between the fingers of its hand, as a link without a shape.

    Args:
        robot: The robot.
        hand: Name of the link of the hand.
        tip: Name of the new link, none of the robot's.
        T_hand_tip: (4, 4) its pose in the hand.

    Returns:
        The robot with the link.
    """
    link = Link(name=tip, shapes=(), mass=0.0, T_link_inertia=np.eye(4))
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


def stripped(robot: Urdf, without: Iterable[str]) -> Urdf:
    """A robot without some links and all that hangs on them.

    Args:
        robot: The robot.
        without: Names of links, none of them the root.

    Returns:
        What is left.
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
    """Links and joints of a robot in which only the joints of one chain move.

    Every other joint becomes a fixed one, at its position in the posture; one that mimics another follows it.
    Off the chain, links that carry no shape are left out.

    Args:
        robot: The robot.
        tip: Name of the link at the end of the chain.
        moving: Names of the joints that stay as they are: of the chain, and of the tool's fingers.
        posture: Positions in rad or m of all other joints that neither are fixed nor mimic one.

    Returns:
        The links, and the joints that carry them: ``links[i + 1]`` is the child of ``joints[i]``. Both are
        ordered from the root outwards, branches before the chain goes on, so that the tip comes last.
    """
    kept = set(moving)
    on_chain = {joint.child for joint in robot.way(tip)}
    joints = tuple(
        joint if joint.name in kept else _fixed(joint, _position(robot, joint, posture))
        for joint in _outwards(robot, robot.root, on_chain)
    )
    return (robot.links[robot.root], *(robot.links[joint.child] for joint in joints)), joints


def _outwards(robot: Urdf, link: str, on_chain: set[str]) -> Iterator[Joint]:
    """The joints behind a link, those of the chain after all others."""
    for joint in sorted(robot.children(link), key=lambda joint: joint.child in on_chain):
        behind = tuple(_outwards(robot, joint.child, on_chain))
        if behind or joint.child in on_chain or robot.links[joint.child].shapes:
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
