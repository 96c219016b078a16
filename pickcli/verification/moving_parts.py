"""Solids of robot and held item, which move, and of the world, which stands, in each segment."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.robot import JointType, Robot
from pickcli.cell.shapes import Body, Shape
from pickcli.cell.tool import MOVING, ToolState
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment
from pickcli.scene.scene import Scene
from pickcli.verification.fcl_solids import CoveringSpheres, Solid, cover
from pickcli.verification.forward_kinematics import (
    T_parent_child,
    joint_position,
    last_joint_index,
    parent_index,
    reaches,
    stated_position,
    touching_joints,
)

SWEEP_STEP = 0.003  # m that a point moves between two checked positions of the moving cup


@dataclass(frozen=True, eq=False)
class Part:
    """One solid of the robot, or the held item.

    The cup and what it holds, and the fingers, are posed in the link that they hang on, at the position they
    stand at; while they move there is one part for each of many positions.

    Attributes:
        name: Name of the link, or id of the held item.
        link: Index of the link that it is fixed to.
        T_link_shape: (4, 4) pose in that link.
        shape: The shape.
        solid: The shape as fcl knows it.
        spheres: Spheres that contain it.
        reach: (n,) m per unit of each joint, see ``reaches``.
        slack: m that any point of the part may be outside of its shape, for the positions in between and for
            what the pose of a held item may be off.
        is_cup: Whether it is the cup.
        is_finger: Whether it is of a finger of a gripper.
        is_held: Whether it is the held item.
    """

    name: str
    link: int
    T_link_shape: Array
    shape: Shape
    solid: Solid
    spheres: CoveringSpheres
    reach: Array
    slack: float = 0.0
    is_cup: bool = False
    is_finger: bool = False
    is_held: bool = False


@dataclass(frozen=True, eq=False)
class Fixture:
    """One solid of the world that stands still.

    Attributes:
        name: Name of the body, or id of the item.
        T_world_shape: (4, 4) pose.
        shape: The shape.
        solid: The shape as fcl knows it.
        slack: m that any point may be outside of its shape.
    """

    name: str
    T_world_shape: Array
    shape: Shape
    solid: Solid
    slack: float = 0.0


def fixtures(scene: Scene) -> tuple[Fixture, ...]:
    """Carriers, obstacles and items: carriers grown by what their poses may be off, items with a slack of it.

    Args:
        scene: The scene.

    Returns:
        The fixtures.
    """
    found = [_fixture(body.name, T @ body.T_parent_shape, body.shape) for body, T in scene.grown]
    for placed in scene.items:
        bound = scene.noise.bound(placed.item)
        found.append(_fixture(placed.id, placed.T_world_item, placed.item.shape, bound))
    return tuple(found)


def _fixture(name: str, T: Array, shape: Shape, slack: float = 0.0) -> Fixture:
    solid = Solid(shape)
    solid.place(T)
    return Fixture(name, T, shape, solid, slack)


def parts(scene: Scene, segment: Segment, T_tip_item: Array | None) -> tuple[Part, ...]:
    """Everything that the arm moves in a segment.

    Args:
        scene: The plan's scene.
        segment: The segment.
        T_tip_item: (4, 4) the item in the tool frame where one is held.

    Returns:
        The parts.
    """
    robot = scene.cell.robot
    cup, joints = last_joint_index(robot) + 1, touching_joints(robot)
    found = [
        _part(robot, i, replace(body, name=link.name))
        for i, link in enumerate(robot.links)
        if i < cup and i - 1 not in joints
        for body in link.shapes
    ]
    for joint in joints:
        for body in robot.links[joint + 1].shapes:
            named = replace(body, name=robot.links[joint + 1].name)
            found += _in_states(robot, joint, segment.tool_state, named)
    if segment.held is not None and T_tip_item is not None:
        bound = scene.noise.bound(scene.item(segment.held))
        held = held_body(scene, segment.held, T_tip_item)
        found += _in_states(robot, cup - 1, segment.tool_state, held, bound, True)
    return tuple(found)


def parts_of_segments(plan: Plan, scene: Scene, T_tip_item: Array | None) -> list[tuple[Part, ...]]:
    """The parts of every segment; segments with the same tool state and held item share theirs.

    Args:
        plan: The plan.
        scene: The plan's scene.
        T_tip_item: (4, 4) the item in the tool frame where one is held.

    Returns:
        Parts by segment.
    """
    known: dict[tuple[ToolState, str | None], tuple[Part, ...]] = {}
    for segment in plan.segments:
        key = (segment.tool_state, segment.held)
        if key not in known:
            known[key] = parts(scene, segment, T_tip_item)
    return [known[segment.tool_state, segment.held] for segment in plan.segments]


def farthest(moving: tuple[Part, ...]) -> Array:
    """How far any of several parts moves per unit of each joint, at most.

    Args:
        moving: The parts.

    Returns:
        (n,) m.
    """
    return np.asarray(np.max([part.reach for part in moving], axis=0))


def held_body(scene: Scene, item_id: str, T_tip_item: Array) -> Body:
    """The held item in the cup link.

    Args:
        scene: The plan's scene.
        item_id: Id of the item.
        T_tip_item: (4, 4) the item in the tool frame.

    Returns:
        The body.
    """
    return Body(item_id, scene.item(item_id).shape, scene.cell.robot.tool.T_last_tip @ T_tip_item)


def _in_states(
    robot: Robot, index: int, tool_state: ToolState, body: Body, slack: float = 0.0, is_held: bool = False
) -> list[Part]:
    """A body that hangs on one of the tool's joints as parts of the link before that, many where it moves."""
    parent, joint = parent_index(robot, index), robot.joints[index]
    is_finger = joint.name in robot.tool.grip.finger_joints
    positions = [joint_position(robot, index, stated_position(robot, tool_state))]
    ends = [joint_position(robot, index, stated) for stated in robot.tool.positions.values()]
    least, most = min(ends), max(ends)
    if tool_state == MOVING and most > least:
        radius = _radius(body.T_parent_shape, body.shape)
        lever = 1.0 if joint.type is JointType.PRISMATIC else radius  # m per rad or m
        n = int(np.ceil((most - least) * lever / SWEEP_STEP)) + 1
        positions = list(np.linspace(least, most, n))
        slack += (most - least) / (n - 1) * (lever + (slack if lever is radius else 0.0)) / 2
    poses = (T_parent_child(robot, index, position) @ body.T_parent_shape for position in positions)
    placed = (_part(robot, parent, Body(body.name, body.shape, T)) for T in poses)
    is_cup, is_of_finger = not (is_held or is_finger), is_finger and not is_held
    return [
        replace(part, slack=slack, is_cup=is_cup, is_finger=is_of_finger, is_held=is_held) for part in placed
    ]


def _part(robot: Robot, link: int, body: Body) -> Part:
    """A body of a link, as it is known where it is fixed to the link, and neither cup nor item."""
    shape, T = body.shape, body.T_parent_shape
    reach = reaches(robot, link, _radius(T, shape))
    return Part(body.name, link, T, shape, Solid(shape), cover(shape), reach)


def _radius(T: Array, shape: Shape) -> float:
    """Greatest distance in m of a point of the posed shape from the frame it stands in."""
    spheres = cover(shape)
    centers = spheres.centers @ T[:3, :3].T + T[:3, 3]
    return float(np.linalg.norm(centers, axis=1).max()) + spheres.radius
