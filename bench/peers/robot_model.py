"""Our robot as the peers get it: a chain with the cup at rest and what it holds, as JSON and as URDF."""

from __future__ import annotations

from itertools import combinations, pairwise
from typing import Any
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.robot import Joint, JointType
from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.cell.tool import ToolState
from pickcli.collision.attached_item import AttachedItem
from pickcli.geometry import Array, pose, rotation_axis_angle
from pickcli.kinematics.chain import bodies_of_frames, is_planned

BASE, HELD = "world_base", "held_item"


def robot_json(cell: Cell, tool_state: ToolState, held: AttachedItem | None) -> dict[str, Any]:
    """What a peer needs to know of the robot in one state.

    links: from the base outwards; each with its joint to the link before it (``kind``, ``T`` (4, 4),
        ``axis``, ``q`` index into a configuration or -1) and its shapes
    untested: pairs of links that are not tested against each other, as for us
    allowed: pairs of a link and a body of the world, the same
    """
    robot = cell.robot
    links: list[dict[str, Any]] = [
        {"name": BASE, "joint": None, "shapes": _shapes(robot.links[0].bodies, robot.T_world_base)}
    ]
    origins = [joint.T_parent_joint @ _turned(cell, joint, tool_state) for joint in robot.joints]
    origins[0] = robot.T_world_base @ origins[0]
    for joint, link, T in zip(robot.joints, robot.links[1:], origins, strict=True):
        shapes = _shapes(link.bodies, np.eye(4))
        links.append({"name": link.name, "joint": _joint(cell, joint, T), "shapes": shapes})
    bodies = [0, *bodies_of_frames(robot)]
    allowed = {frozenset((pair.a, pair.b)) for pair in cell.allowed_pairs}
    names = [link["name"] for link in links]
    pairs = list(combinations(range(len(names)), 2))
    untested = [(i, j) for i, j in pairs if bodies[j] - bodies[i] < 2 or {names[i], names[j]} in allowed]
    if held is not None:
        links.append({"name": HELD, "joint": _fixed(robot.tool.T_last_tip), "shapes": [_held(held)]})
        rigid = [i for i, body in enumerate(bodies) if body in (0, bodies[-1])]
        untested += [(i, len(names)) for i in rigid]
        names.append(HELD)
    return {
        "links": links,
        "untested": [[names[i], names[j]] for i, j in untested],
        "allowed": sorted(sorted(pair) for pair in allowed if len(pair & set(names)) == 1),
        "urdf": urdf(links, robot.joint_names, robot.limits.lower, robot.limits.upper),
    }


def shape_json(shape: Shape, T: Array) -> dict[str, Any]:
    """A posed shape: kind, size as ``Shape`` has it, pose in its parent as (4, 4) and as URDF's origin."""
    return {"kind": str(shape.kind), "size": list(shape.size), "T": T.tolist(), "origin": _origin(T)}


def urdf(links: list[dict[str, Any]], joint_names: tuple[str, ...], lower: Array, upper: Array) -> str:
    """The same chain as URDF text; masses are there because pybullet wants some."""
    robot = Element("robot", name="robot")
    for link in links:
        _urdf_link(robot, link)
    for parent, link in pairwise(links):
        kind, q = link["joint"]["kind"], link["joint"]["q"]
        name = joint_names[q] if q >= 0 else f"to_{link['name']}"
        joint = SubElement(robot, "joint", name=name, type=kind)
        SubElement(joint, "parent", link=parent["name"])
        SubElement(joint, "child", link=link["name"])
        SubElement(joint, "origin", _origin(np.array(link["joint"]["T"])))
        if q >= 0:
            SubElement(joint, "axis", xyz=_numbers(link["joint"]["axis"]))
            bounds = {"lower": repr(float(lower[q])), "upper": repr(float(upper[q]))}
            SubElement(joint, "limit", bounds, velocity="1", effort="1000")
    return tostring(robot, encoding="unicode")


def _urdf_link(robot: Element, link: dict[str, Any]) -> None:
    element = SubElement(robot, "link", name=link["name"])
    inertial = SubElement(element, "inertial")
    SubElement(inertial, "mass", value="1")
    SubElement(inertial, "inertia", ixx="0.01", iyy="0.01", izz="0.01", ixy="0", ixz="0", iyz="0")
    for shape in link["shapes"]:
        collision = SubElement(element, "collision")
        SubElement(collision, "origin", shape["origin"])
        geometry, size = SubElement(collision, "geometry"), shape["size"]
        if shape["kind"] == ShapeKind.BOX:
            SubElement(geometry, "box", size=_numbers(size))
        elif shape["kind"] == ShapeKind.CYLINDER:
            SubElement(geometry, "cylinder", radius=repr(size[0]), length=repr(size[1]))
        else:
            SubElement(geometry, "sphere", radius=repr(size[0]))


def _origin(T_parent_child: Array) -> dict[str, str]:
    return {"xyz": _numbers(T_parent_child[:3, 3]), "rpy": _numbers(_rpy(T_parent_child[:3, :3]))}


def _rpy(R: Array) -> tuple[float, float, float]:
    """Roll, pitch, yaw of URDF; where pitch is a right angle, with a yaw of 0."""
    level = np.hypot(R[0, 0], R[1, 0])
    pitch = np.arctan2(-R[2, 0], level)
    if level < 1e-9:
        return float(np.arctan2(-R[1, 2], R[1, 1])), float(pitch), 0.0
    return float(np.arctan2(R[2, 1], R[2, 2])), float(pitch), float(np.arctan2(R[1, 0], R[0, 0]))


def _numbers(values: Any) -> str:
    return " ".join(repr(float(value)) for value in values)


def _joint(cell: Cell, joint: Joint, T: Array) -> dict[str, Any]:
    if not is_planned(cell.robot, joint):
        return _fixed(T)
    kind = "prismatic" if joint.type is JointType.PRISMATIC else "revolute"
    q = cell.robot.joint_names.index(joint.name)
    return {"kind": kind, "T": T.tolist(), "axis": joint.axis.tolist(), "q": q}


def _fixed(T: Array) -> dict[str, Any]:
    return {"kind": "fixed", "T": np.asarray(T).tolist(), "axis": [0.0, 0.0, 1.0], "q": -1}


def _turned(cell: Cell, joint: Joint, tool_state: ToolState) -> Array:
    if joint.name != cell.robot.tool.joint:
        return np.eye(4)
    return pose(R=rotation_axis_angle(joint.axis, cell.robot.tool.positions[tool_state]))


def _shapes(bodies: tuple[Body, ...], T: Array) -> list[dict[str, Any]]:
    return [shape_json(body.shape, T @ body.T_parent_shape) for body in bodies]


def _held(held: AttachedItem) -> dict[str, Any]:
    return shape_json(held.item.shape.inflated(held.inflate), held.T_tip_item)
