"""Checkers of a cell without items, for what is computed once per cell."""

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
from pickcli.scene.scene import PoseNoise, Scene

# Delft generated their motions with such a cube attached: what is free with it is free with most items.
CUBE_EDGE = 0.2  # m

# Kept on top of the cell's clearance while planning. Short paths touch the margin, and whether an edge that
# touches it is proven can depend on where it is cut: what is stored must be provable whole, in parts and
# with its corners blended, each time that it is used.
RESERVE = 0.001  # m

CheckerKey: TypeAlias = tuple[PodPoses, ToolState, PayloadClass]  # what a checker is for


def empty_scene(cell: Cell, pod_poses: PodPoses = PodPoses.NOMINAL) -> Scene:
    """Make a scene of a cell with nothing in its places.

    Args:
        cell: The cell.
        pod_poses: Whether the carriers stand in their places or, for a proof, everywhere that they may.

    Returns:
        The scene.
    """
    if pod_poses is PodPoses.DISPLACED:
        cell = cell.swept()
    return Scene(cell, cell.T_world_pod, (), PoseNoise())


def checker(
    model: CollisionModel,
    tool_state: ToolState,
    payload: PayloadClass,
    reserve: float = 0.0,
    pod_poses: PodPoses = PodPoses.NOMINAL,
) -> SceneChecker:
    """Make a checker of the empty scene for one tool state and payload class.

    What it proves for ``DISPLACED`` holds wherever the pod stands within its bounds.

    Args:
        model: The solids of the cell's robot.
        tool_state: State of the tool.
        payload: Class of what is held.
        reserve: m to keep beyond the cell's clearance.
        pod_poses: Where the pod stands.

    Returns:
        The checker.
    """
    scene, margin = empty_scene(model.cell, pod_poses), model.cell.clearance + reserve
    return SceneChecker(model, scene, tool_state, held=representative_item(payload), margin=margin)


def checkers(
    model: CollisionModel, reserve: float = 0.0, cell: Cell | None = None
) -> dict[CheckerKey, SceneChecker]:
    """Make the checkers of the empty scene for every case.

    Args:
        model: The solids of the cell's robot.
        reserve: m to keep beyond the cell's clearance.
        cell: The model's own with other solids around the robot; None for the model's own as it is.

    Returns:
        Checkers by poses of the pod, tool state and payload class.
    """
    scenes = {pod_poses: empty_scene(cell or model.cell, pod_poses) for pod_poses in PodPoses}
    margin = model.cell.clearance + reserve
    return {
        (pod_poses, tool_state, load): SceneChecker(
            model, scenes[pod_poses], tool_state, representative_item(load), margin=margin
        )
        for pod_poses, tool_state, load in product(PodPoses, model.robot.tool.shapes, PayloadClass)
    }


def why_not_free(cell: Cell) -> dict[str, str]:
    """Tell why the arm cannot stand in named configurations of the empty cell.

    Args:
        cell: The cell.

    Returns:
        By name of every configuration that is not free: the state of its tool, and what meets what.
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
    """Make what is held for a payload class: a cube with a face on the cup or its centre there.

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
