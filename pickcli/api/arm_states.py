"""States of the other arms of a cell while one moves, and a check that they are free of collision."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from pickcli.api.configurations import Configuration, start_of
from pickcli.cell.cell import ArmState
from pickcli.cell.cell_file import load_workcell
from pickcli.cell.workcell import Workcell
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import InputError
from pickcli.planning.start_state import Start
from pickcli.scene.scene import Scene


def states_of(workcell: Workcell, standing: Mapping[str, Configuration]) -> list[ArmState]:
    """Return the stated states of arms.

    Args:
        workcell: The cell with all its arms.
        standing: By arm the name of one of its configurations, or its joint positions in m and rad.

    Returns:
        One for each named arm.

    Raises:
        UnknownNameError: There is no such arm, or no such configuration of it.
        InputError: Positions are beyond the limits of the arm, or the cell has one arm.
    """
    states = []
    for name, configuration in standing.items():
        begin = start_of(workcell.arms[workcell.known(name)], configuration)
        states.append(ArmState(name, begin.q, begin.tool_state))
    return states


def refuse_standing(scene: Scene, start: Start) -> None:
    """Refuse a scene in which another arm is in collision.

    Args:
        scene: The scene.
        start: State of the moving arm.

    Raises:
        InputError: Another arm collides with something, with itself, or with the moving arm.
    """
    cell = scene.cell
    if not cell.others:
        return
    workcell = load_workcell(cell.path)
    states = (ArmState(cell.arm, start.q, start.tool_state), *cell.others)
    for state in cell.others:
        seen = workcell.cell(state.arm, [each for each in states if each.arm != state.arm])
        checker = SceneChecker(CollisionModel(seen), replace(scene, cell=seen), state.tool_state)
        if not checker.is_valid(state.q):
            raise InputError(
                f"arm {state.arm} cannot stand at {state}: {checker.explain(state.q)}; let it stand in "
                "another configuration (--standing), or park it elsewhere in the cell"
            )
