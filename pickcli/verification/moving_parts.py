"""Moving solids (robot and held item) and static solids of the world, for each segment."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from pickcli.cell.robot import JointType, Robot
from pickcli.cell.shapes import Body, Shape
from pickcli.cell.tool import MOVING, ToolState
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment
from pickcli.scene.scene import PoseNoise, Scene
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
from pickcli.verification.hollow_walls import farthest_point, opened

SWEEP_STEP = 0.003  # m that a point moves between two checked positions of the moving cup


class TestedPairs(StrEnum):
    """Pairs in which a part is tested."""

    ALL = "all"
    WORLD = "world"
    ROBOT = "robot"


@dataclass(frozen=True, eq=False)
class Part:
    """One solid of the robot, or the held item.

    Cup, held item and fingers are posed in their parent link, at the joint position of the tool state; while
    the tool moves, there is one part for each of many positions.

    Attributes:
        name: Name of the link, or id of the held item.
        link: Index of the link that it is fixed to.
        T_link_shape: (4, 4) pose in that link.
        shape: The shape.
        solid: The shape in fcl.
        spheres: Spheres that contain the shape.
        reach: (n,) m per unit of each joint, see ``reaches``.
        slack: m that any point of the part may be outside of its shape: for positions in between, and for the
            pose error of a held item.
        is_cup: Whether it is the cup.
        is_finger: Whether it belongs to a finger of a gripper.
        is_held: Whether it is the held item.
        against: What it is tested against: the outer shape of an item that is held by the bottom of a hollow
            only against the world, and its body around that hollow only against the robot.
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
    against: TestedPairs = TestedPairs.ALL


@dataclass(frozen=True, eq=False)
class Fixture:
    """One static solid of the world.

    Attributes:
        name: Name of the body, or id of the item.
        T_world_shape: (4, 4) pose.
        shape: The shape.
        solid: The shape in fcl.
        slack: m that any point may be outside of its shape.
        is_wall: Whether it is a wall of the hollow by which its item is taken, which nothing may touch.
    """

    name: str
    T_world_shape: Array
    shape: Shape
    solid: Solid
    slack: float = 0.0
    is_wall: bool = False


def fixtures(scene: Scene) -> tuple[Fixture, ...]:
    """Return carriers, obstacles and items; carriers enlarged by their pose error, items with it as slack.

    Args:
        scene: The scene.

    Returns:
        The fixtures.
    """
    found = [_fixture(body.name, T @ body.T_parent_shape, body.shape) for body, T in scene.grown]
    for placed in scene.items:
        bound = scene.bound(placed)
        found.append(_fixture(placed.id, placed.T_world_item, placed.item.shape, bound))
    return tuple(found)


def around_hollow(found: Iterable[Fixture], plan: Plan, scene: Scene) -> tuple[Fixture, ...]:
    """Open the item that a plan takes by the bottom of a hollow: the tool may enter that one alone.

    Args:
        found: Fixtures, the items as their outer shapes.
        plan: The plan.
        scene: The plan's scene.

    Returns:
        The fixtures, the outer shape of that item replaced by the solids around its hollow.
    """
    found = tuple(found)
    body = None if plan.grasp is None else opened(scene.item(plan.grasp.item), plan.grasp.face)
    if plan.grasp is None or body is None:
        return found
    name = plan.grasp.item
    noise = scene.noise_of(scene.instance(name))
    pieces = []
    for each in (each for each in found if each.name == name):
        for k, piece in enumerate(body.all):
            slack = min(each.slack, _error_of(piece, noise))
            T = each.T_world_shape @ piece.T_parent_shape
            pieces.append(replace(_fixture(name, T, piece.shape, slack), is_wall=k > 0))
    return (*(each for each in found if each.name != name), *pieces)


def _fixture(name: str, T: Array, shape: Shape, slack: float = 0.0) -> Fixture:
    solid = Solid(shape)
    solid.place(T)
    return Fixture(name, T, shape, solid, slack)


def parts(scene: Scene, segment: Segment, T_tip_item: Array | None, face: str = "") -> tuple[Part, ...]:
    """Return all solids that the arm moves in a segment.

    Args:
        scene: The plan's scene.
        segment: The segment.
        T_tip_item: (4, 4) pose of the item in the tool frame, if one is held.
        face: Face by which it is held.

    Returns:
        The parts.
    """
    robot = scene.cell.robot
    cup, joints = last_joint_index(robot) + 1, touching_joints(robot)
    found = [
        _part(robot, i, replace(body, name=link.name))
        for i, link in enumerate(robot.links)
        if i <= cup and i - 1 not in joints
        for body in link.bodies
    ]
    for joint in joints:
        for body in robot.links[joint + 1].bodies:
            named = replace(body, name=robot.links[joint + 1].name)
            found += _in_states(robot, joint, segment.tool_state, named)
    if segment.held is not None and T_tip_item is not None:
        found += _held(scene, segment, T_tip_item, face)
    return tuple(found)


def _error_of(piece: Body, noise: PoseNoise) -> float:
    """Bound the error in m of the points of a solid in the item frame: less where it is near the middle."""
    return float(noise.at(np.array(farthest_point(piece))))


def _held(scene: Scene, segment: Segment, T_tip_item: Array, face: str) -> list[Part]:
    """Return the held item, on the joint of the cup; held in a hollow, with its body around that."""
    assert segment.held is not None
    robot, name = scene.cell.robot, segment.held
    joint, bound = last_joint_index(robot), scene.bound(scene.instance(name))
    whole, around = held_body(scene, name, T_tip_item), opened(scene.item(name), face)
    outer = _in_states(robot, joint, segment.tool_state, whole, bound, True)
    if around is None:
        return outer
    found = [replace(part, against=TestedPairs.WORLD) for part in outer]
    for piece in around.all:
        body = Body(name, piece.shape, whole.T_parent_shape @ piece.T_parent_shape)
        near = min(bound, _error_of(piece, scene.noise_of(scene.instance(name))))
        pieces = _in_states(robot, joint, segment.tool_state, body, near, True)
        found += [replace(part, against=TestedPairs.ROBOT) for part in pieces]
    return found


def parts_of_segments(plan: Plan, scene: Scene, T_tip_item: Array | None) -> list[tuple[Part, ...]]:
    """Return the parts of every segment; segments with the same tool state and held item share them.

    Args:
        plan: The plan.
        scene: The plan's scene.
        T_tip_item: (4, 4) pose of the item in the tool frame, if one is held.

    Returns:
        Parts by segment.
    """
    known: dict[tuple[ToolState, str | None], tuple[Part, ...]] = {}
    for segment in plan.segments:
        key = (segment.tool_state, segment.held)
        if key not in known:
            face = "" if plan.grasp is None or plan.grasp.item != segment.held else plan.grasp.face
            known[key] = parts(scene, segment, T_tip_item, face)
    return [known[segment.tool_state, segment.held] for segment in plan.segments]


def farthest(moving: tuple[Part, ...]) -> Array:
    """Return how far any of several parts moves per unit of each joint, at most.

    Args:
        moving: The parts.

    Returns:
        (n,) m.
    """
    return np.asarray(np.max([part.reach for part in moving], axis=0))


def held_body(scene: Scene, item_id: str, T_tip_item: Array) -> Body:
    """Return the held item as a body in the cup link.

    Args:
        scene: The plan's scene.
        item_id: Id of the item.
        T_tip_item: (4, 4) pose of the item in the tool frame.

    Returns:
        The body.
    """
    return Body(item_id, scene.item(item_id).shape, scene.cell.robot.tool.T_last_tip @ T_tip_item)


def _in_states(
    robot: Robot, index: int, tool_state: ToolState, body: Body, slack: float = 0.0, is_held: bool = False
) -> list[Part]:
    """Return a body on one of the tool's joints as parts of the parent link, several while it moves."""
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
    """Return a body of a link as a part that is neither cup, finger nor item."""
    shape, T = body.shape, body.T_parent_shape
    reach = reaches(robot, link, _radius(T, shape))
    return Part(body.name, link, T, shape, Solid(shape), cover(shape), reach)


def _radius(T: Array, shape: Shape) -> float:
    """Return the greatest distance in m of a point of the posed shape from the origin of its parent frame."""
    spheres = cover(shape)
    centers = spheres.centers @ T[:3, :3].T + T[:3, 3]
    return float(np.linalg.norm(centers, axis=1).max()) + spheres.radius
