"""Selects the chain to be planned: that of an SRDF group, else the longest one that is not a finger."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from pickcli.cell.robot import Joint, JointType
from pickcli.cell.robots.srdf import Group, Srdf
from pickcli.cell.robots.urdf import Urdf
from pickcli.errors import InputError, UnknownNameError

FLANGES = ("tool0", "tcp", "ee_link", "flange")  # makers' names of the frame that tools are mounted on
LEAST_JOINTS = 2  # of an arm's group; groups of one joint are grippers or rails


@dataclass(frozen=True)
class PlannedChain:
    """The planned joints of a robot, and the frame at their end.

    Attributes:
        joints: Names of the planned joints, base outwards.
        tip: Name of the link at the end.
        group: Name of the SRDF group that states them; empty without one.
        other_tips: Links rigidly connected to the tip and without a shape, which could be the tip as well.
    """

    joints: tuple[str, ...]
    tip: str
    group: str
    other_tips: tuple[str, ...]


def choose_chain(robot: Urdf, srdf: Srdf | None, group: str | None, tip: str | None) -> PlannedChain:
    """Choose the chain to be planned.

    Args:
        robot: The robot.
        srdf: The SRDF, if there is one.
        group: Name of the requested SRDF group.
        tip: Name of the requested last link.

    Returns:
        The chain.

    Raises:
        UnknownNameError: There is no such group or link.
        InputError: The choice is ambiguous, with all candidates; or the group is not a chain.
    """
    fingers = finger_joints(robot, srdf)
    if tip is not None and tip not in robot.links:
        raise UnknownNameError("link", tip, list(robot.links), "--tip")
    if group is not None:
        joints = _group_chain(robot, srdf, group, fingers)
    elif tip is not None:
        group, joints = "", _without(robot.driven(robot.way(tip)), fingers)
    else:
        group, joints = _likeliest(robot, srdf, fingers)
    if not joints:
        raise InputError(f"--tip {tip}: no joint moves this link; name one at the end of the arm")
    ends = rigid_with(robot, joints[-1])
    if tip is not None and not set(joints) <= robot.driven(robot.way(tip)).keys():
        listed = ", ".join(ends)
        raise InputError(f"--tip {tip}: is not at the end of {_joint_names(joints)}; name one of {listed}")
    behind = _without(
        (name for end in ends for j in robot.children(end) for name in _below(robot, j)), fingers
    )
    if tip is not None and behind:
        listed = ", ".join(rigid_with(robot, behind[-1]))
        raise InputError(
            f"--tip {tip}: is in the middle of the arm, before {_joint_names(behind)}; name a link at its "
            f"end: {listed}"
        )
    chosen = tip or _likeliest_tip(robot, srdf, group, ends)
    frames = tuple(link for link in ends if not robot.links[link].bodies and link != chosen)
    return PlannedChain(joints, chosen, group, frames)


def mimicked_joints(robot: Urdf, tip: str) -> dict[str, tuple[str, ...]]:
    """Find joints that move the tip, but cannot be planned, as other joints mimic them.

    Args:
        robot: The robot.
        tip: Name of the link at the end of the planned chain.

    Returns:
        By name of the joint those that mimic it.
    """
    mimics = {
        name: tuple(follower for follower, mimic in robot.mimics.items() if mimic.joint == name)
        for name in robot.driven(robot.way(tip))
    }
    return {name: followers for name, followers in mimics.items() if followers}


def group_joints(robot: Urdf, srdf: Srdf, name: str) -> tuple[str, ...]:
    """Return the joints of a group that are neither fixed nor mimics.

    Args:
        robot: The robot.
        srdf: The SRDF with the group.
        name: Name of the group.

    Returns:
        Their names in the order of the robot. Joints that the robot does not have are left out.
    """
    found = set(_members(robot, srdf.groups, name, frozenset()))
    return tuple(joint for joint in robot.driven(robot.joints.values()) if joint in found)


def finger_joints(robot: Urdf, srdf: Srdf | None) -> frozenset[str]:
    """Find the joints that move fingers.

    These are joints that another one mimics, joints of an SRDF end effector, and branches of a hand: a link
    with two or more subchains, each shorter than the chain that leads to it.

    Args:
        robot: The robot.
        srdf: The SRDF, if there is one.

    Returns:
        Names of joints.
    """
    found = {mimic.joint for mimic in robot.mimics.values()}
    for effector in () if srdf is None else srdf.end_effectors:
        assert srdf is not None
        joints = set(group_joints(robot, srdf, effector.group)) if effector.group in srdf.groups else set()
        if not joints & robot.driven(robot.way(effector.parent_link)).keys():
            found |= joints
    for link in robot.links:
        before = len(_without(robot.driven(robot.way(link)), found))
        chains = [_longest_below(robot, joint.child, found) for joint in robot.children(link)]
        branches = [chain for chain in chains if chain]
        if len(branches) > 1 and all(len(branch) < before for branch in branches):
            found |= {name for joint in robot.children(link) for name in _below(robot, joint)}
    return frozenset(found)


def rigid_with(robot: Urdf, last: str) -> tuple[str, ...]:
    """Return the links that a joint moves and no later joint.

    Args:
        robot: The robot.
        last: Name of the joint.

    Returns:
        Names of the links, the joint's own first.
    """
    ahead = [next(joint.child for joint in robot.joints.values() if joint.name == last)]
    found = []
    while ahead:
        found.append(ahead.pop(0))
        ahead += [j.child for j in robot.children(found[-1]) if j.type is JointType.FIXED]
    return tuple(found)


def _members(robot: Urdf, groups: Mapping[str, Group], name: str, within: frozenset[str]) -> Iterable[str]:
    """Names of the joints of a group and its subgroups; a group that contains itself is read once."""
    if name not in groups or name in within:
        return
    group = groups[name]
    yield from group.joints
    yield from (robot.joints[link].name for link in group.links if link in robot.joints)
    for base, tip in group.chains:
        before = {joint.name for joint in robot.way(base)}
        yield from (joint.name for joint in robot.way(tip) if joint.name not in before)
    for other in group.groups:
        yield from _members(robot, groups, other, within | {name})


def _without(joints: Iterable[str], fingers: Iterable[str]) -> tuple[str, ...]:
    left_out = set(fingers)
    return tuple(name for name in joints if name not in left_out)


def _below(robot: Urdf, joint: Joint) -> list[str]:
    """Driven joints of the branch that begins with a joint."""
    behind = (name for child in robot.children(joint.child) for name in _below(robot, child))
    return [*robot.driven([joint]), *behind]


def _longest_below(robot: Urdf, link: str, fingers: Iterable[str]) -> tuple[str, ...]:
    """Longest chain of driven joints in a branch, without fingers."""
    behind = (_longest_below(robot, child.child, fingers) for child in robot.children(link))
    return _without(robot.driven([robot.joints[link]]), fingers) + max(behind, key=len, default=())


def _group_chain(robot: Urdf, srdf: Srdf | None, name: str, fingers: frozenset[str]) -> tuple[str, ...]:
    """The joints of a requested group. Raises InputError unless they are a chain."""
    if srdf is None:
        raise InputError(f"--group {name}: groups stand in an SRDF file; name it with --srdf")
    if name not in srdf.groups:
        raise UnknownNameError("group", name, list(srdf.groups), "--group")
    joints = group_joints(robot, srdf, name)
    if not joints:
        raise InputError(f"--group {name}: none of its joints moves this robot; is the SRDF of another one?")
    arms, listed = _without(joints, fingers), _candidates(_group_chains(robot, srdf, fingers))
    if not arms:
        raise InputError(f"--group {name}: is a gripper's, {_joint_names(joints)}; name an arm's, {listed}")
    chain = _as_chain(robot, arms)
    if chain is None:
        raise InputError(f"--group {name}: its joints are no single chain ({_joint_names(joints)}); {listed}")
    return chain


def _likeliest(robot: Urdf, srdf: Srdf | None, fingers: frozenset[str]) -> tuple[str, tuple[str, ...]]:
    """The only arm group and its joints, else the longest chain. Raises InputError if ambiguous."""
    named = {} if srdf is None else _group_chains(robot, srdf, fingers)
    if len(set(named.values())) > 1:
        raise InputError(f"which arm? name its group with --group; {_candidates(named)}")
    if named:
        return next(iter(named.items()))
    chains = {link: _without(robot.driven(robot.way(link)), fingers) for link in robot.links}
    most = max(map(len, chains.values()))
    if most == 0:
        raise InputError("no joint of the robot moves by itself, so nothing can be planned")
    longest = {link: chain for link, chain in chains.items() if len(chain) == most}
    if len(set(longest.values())) > 1:
        ends = {_likeliest_tip(robot, srdf, "", rigid_with(robot, c[-1])): c for c in longest.values()}
        raise InputError(f"which arm? name the link at its end with --tip; {_candidates(ends)}")
    return "", next(iter(longest.values()))


def _group_chains(robot: Urdf, srdf: Srdf, fingers: frozenset[str]) -> dict[str, tuple[str, ...]]:
    """Groups that form an arm, with their joints."""
    found = {}
    for name in srdf.groups:
        chain = _as_chain(robot, _without(group_joints(robot, srdf, name), fingers))
        if chain is not None and len(chain) >= LEAST_JOINTS:
            found[name] = chain
    return found


def _as_chain(robot: Urdf, joints: tuple[str, ...]) -> tuple[str, ...] | None:
    """The joints in the order of their common chain; None if they have none."""
    for link in robot.links:
        chain = tuple(name for name in robot.driven(robot.way(link)) if name in joints)
        if joints and len(chain) == len(joints):
            return chain
    return None


def _likeliest_tip(robot: Urdf, srdf: Srdf | None, group: str, ends: tuple[str, ...]) -> str:
    """The group's stated tip, the end effector's parent, a flange by name, or else the last frame."""
    if srdf is not None:
        stated = [tip for _, tip in srdf.groups[group].chains] if group else []
        stated += [effector.parent_link for effector in srdf.end_effectors]
        for link in stated:
            if link in ends:
                return link
    for name in FLANGES:
        for link in ends:
            if name in link.lower():
                return link
    bare = [link for link in ends if not robot.links[link].bodies]
    return (bare or list(ends))[-1]


def _candidates(chains: Mapping[str, tuple[str, ...]]) -> str:
    listed = ", ".join(f"{name} ({_joint_names(chain)})" for name, chain in chains.items())
    return f"there are: {listed}" if listed else "no group of it is"


def _joint_names(joints: tuple[str, ...]) -> str:
    if len(joints) < 3:
        return " and ".join(joints)
    return f"{joints[0]} to {joints[-1]}, {len(joints)} joints"
