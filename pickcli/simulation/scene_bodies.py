"""Adds static bodies and items of a scene to an engine, and finds rigidly connected links."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from pickcli.cell.robot import JointType, Robot
from pickcli.cell.station import UNKNOWN
from pickcli.geometry import Array
from pickcli.scene.colours import STATIC_COLOURS, item_colour, static_colour
from pickcli.scene.scene import Scene
from pickcli.seeds import derived_rng
from pickcli.simulation.engine import Engine
from pickcli.simulation.places import bounds
from pickcli.simulation.reality import Reality

MAX_CUBES = 500  # number of cubes that represent a cloud
MIN_CUBE = 0.01  # m


def ground_of(scene: Scene) -> tuple[Array, Array]:
    """Compute the box around all static bodies.

    Args:
        scene: The scene.

    Returns:
        Lower and upper corner (3,), m in the world; infinite without static bodies.
    """
    if not scene.standing:
        return np.full(3, -np.inf), np.full(3, np.inf)
    corners = [bounds(body.shape, T @ body.T_parent_shape) for body, T in scene.standing]
    return np.min([low for low, _ in corners], axis=0), np.max([high for _, high in corners], axis=0)


def is_over(ground: tuple[Array, Array], point: Array) -> bool:
    """Whether a point is above or in a box; outside, nothing supports an item.

    Args:
        ground: Lower and upper corner (3,), m in the world.
        point: (3,) m in the world.

    Returns:
        True if it is.
    """
    low, high = ground
    return bool(np.all(low[:2] <= point[:2]) and np.all(point[:2] <= high[:2]) and low[2] <= point[2])


def add_statics(engine: Engine, scene: Scene) -> None:
    """Add carriers at their actual poses and obstacles, with one body per box.

    A cloud is only drawn, without collision shapes, because its objects are unknown. Unknown space is left
    out.

    Args:
        engine: The engine.
        scene: The scene.
    """
    for carrier in scene.posed_carriers:
        for body in carrier.bodies if carrier.name != UNKNOWN else ():
            engine.add_static(body, carrier.T_world_carrier, static_colour(carrier.name))
    if scene.cloud is not None:
        engine.add_cubes(*_thinned(scene.cloud.points), STATIC_COLOURS["cloud"])


def _thinned(points: Array) -> tuple[Array, float]:
    """Centres (K, 3) of at most MAX_CUBES grid cells occupied by points (N, 3), and their width in m."""
    width = MIN_CUBE
    while len(cells := np.unique(np.floor(points / width), axis=0)) > MAX_CUBES:
        width *= 1.25
    return (cells + 0.5) * width, width


def add_items(engine: Engine, scene: Scene, masses: Mapping[str, float] | None = None) -> None:
    """Add all items of a scene, named by their ids.

    Args:
        engine: The engine.
        scene: The scene.
        masses: True masses by id, kg; the stated masses if None.
    """
    for placed in scene.items:
        mass = masses[placed.id] if masses else placed.item.mass
        engine.add_item(placed.id, placed.item, placed.T_world_item, item_colour(placed.item), mass)


def true_masses(scene: Scene, reality: Reality, seed: int) -> dict[str, float]:
    """Draw the true masses of all items, uniformly around the stated ones.

    Args:
        scene: The scene.
        reality: Levels, for the bound of mass errors.
        seed: Seed of all random choices.

    Returns:
        kg by id.
    """
    return {
        placed.id: placed.item.mass
        * (1.0 + reality.mass_error * float(derived_rng(seed, "mass", placed.id).uniform(-1.0, 1.0)))
        for placed in scene.items
    }


def rigid_pairs(robot: Robot) -> list[tuple[str, str]]:
    """Find pairs of links connected only by fixed joints, and the two fingers of a gripper, which meet.

    Args:
        robot: The robot.

    Returns:
        Names of both links.
    """
    root = robot.links[0].name
    group_of, groups = {root: root}, {root: [root]}
    for joint in robot.joints:
        first = group_of[joint.parent] if joint.type is JointType.FIXED else joint.child
        group_of[joint.child] = first
        groups.setdefault(first, []).append(joint.child)
    rigid = [pair for group in groups.values() for pair in combinations(group, 2)]
    return [*rigid, *combinations(robot.tool.grip.finger_links, 2)]


def jointed_pairs(robot: Robot) -> list[tuple[str, str]]:
    """Find pairs of links that one joint moves against each other, with no shape between them.

    Planner and verifier do not test these against each other; the engine leaves out a link and its parent
    only.

    Args:
        robot: The robot.

    Returns:
        Names of both links, the outer one first.
    """
    shaped = {link.name for link in robot.links if link.bodies}
    by_child = {joint.child: joint for joint in robot.joints}
    found = []
    for first in robot.joints:
        n_moving, joint = int(first.type is not JointType.FIXED), first
        while joint.parent not in shaped and joint.parent in by_child:
            joint = by_child[joint.parent]
            n_moving += joint.type is not JointType.FIXED
        if n_moving <= 1:
            found.append((first.child, joint.parent))
    return found


def standing_links(robot: Robot) -> list[str]:
    """Return the links that no joint moves; they may touch static bodies around them.

    Args:
        robot: The robot.

    Returns:
        Names, from the root outwards.
    """
    names = [robot.links[0].name]
    for joint in robot.joints:
        if joint.type is JointType.FIXED and joint.parent in names:
            names.append(joint.child)
    return names
