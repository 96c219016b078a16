"""Checkers of a cell without items, for computations that are done once per cell."""

from __future__ import annotations

from functools import cache
from itertools import product
from typing import TypeAlias

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.pod_tolerance import PodPoses
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tool import ToolState
from pickcli.collision.attached_item import AttachedItem
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import pose
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.scene.scene import empty_scene

# Delft generated their motions with such a cube attached: a motion that is free with it is free with most
# items.
CUBE_EDGE = 0.2  # m

# Additional clearance in planning. Short paths touch the margin, and whether an edge that touches it is
# proven can depend on where it is cut: stored paths must be provable whole, in parts and with blended
# corners, at every use.
STORED_RESERVE = 0.001  # m

CheckerKey: TypeAlias = tuple[PodPoses, ToolState, PayloadClass]  # key of a checker


def checker(
    model: CollisionModel,
    tool_state: ToolState,
    payload: PayloadClass,
    reserve: float = 0.0,
    pod_poses: PodPoses = PodPoses.NOMINAL,
) -> SceneChecker:
    """Make a checker of the empty scene for one tool state and payload class.

    Proofs with ``DISPLACED`` hold for all pod poses within the tolerance.

    Args:
        model: Collision model of the cell's robot.
        tool_state: State of the tool.
        payload: Payload class of the held item.
        reserve: m, additional to the cell's clearance.
        pod_poses: Poses of the pod.

    Returns:
        The checker.
    """
    scene, margin = empty_scene(model.cell, pod_poses), model.cell.clearance + reserve
    return SceneChecker(model, scene, tool_state, held=representative_item(payload), margin=margin)


def checkers(
    model: CollisionModel, reserve: float = 0.0, cell: Cell | None = None
) -> dict[CheckerKey, SceneChecker]:
    """Make the checkers of the empty scene for every combination of pod poses, tool state and payload class.

    Args:
        model: Collision model of the cell's robot.
        reserve: m, additional to the cell's clearance.
        cell: Variant of the model's cell with other solids around the robot; None for the model's cell.

    Returns:
        Checkers by poses of the pod, tool state and payload class.
    """
    scenes = {pod_poses: empty_scene(cell or model.cell, pod_poses) for pod_poses in PodPoses}
    margin = model.cell.clearance + reserve
    return {
        (pod_poses, tool_state, load): SceneChecker(
            model, scenes[pod_poses], tool_state, representative_item(load), margin=margin
        )
        for pod_poses, tool_state, load in product(PodPoses, model.robot.tool.states_and_moving, PayloadClass)
    }


def why_not_free(cell: Cell) -> dict[str, str]:
    """Explain why named configurations of the empty cell are not free.

    Args:
        cell: The cell.

    Returns:
        By name of every configuration that is not free: its tool state, and the collision.
    """
    model = CollisionModel(cell)
    by_state = {state: checker(model, state, PayloadClass.EMPTY) for state in cell.robot.tool.states}
    return {
        named.name: f"tool {named.tool_state}: {by_state[named.tool_state].explain(named.q)}"
        for named in cell.configurations.values()
        if not by_state[named.tool_state].is_valid(named.q)
    }


@cache
def representative_item(payload: PayloadClass) -> AttachedItem | None:
    """Make the item that represents a payload class: a cube with a face on the cup, or its centre there.

    Args:
        payload: The class.

    Returns:
        The cube, or None for the empty cup.
    """
    if payload is PayloadClass.EMPTY:
        return None
    shape = Shape(ShapeKind.BOX, (CUBE_EDGE,) * 3)
    seals, source = dict.fromkeys(shape.face_names, 1.0), "a stand-in for the payload class"
    cube = Item("cube", 2016, shape, 1.0, 0, seals, source, "", 0.0, 1.0, "", source)
    return AttachedItem(cube, pose((0.0, 0.0, CUBE_EDGE / 2 if payload is PayloadClass.CUBE else 0.0)))
