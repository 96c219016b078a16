"""Options --arm and --standing of commands for one arm of a cell, and the cell as that arm sees it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.options.configuration_option import parse_configuration
from pickcli.commands.options.named_camera import named_camera
from pickcli.errors import InputError, StaleError

if TYPE_CHECKING:
    from pickcli.cell.cell import ArmState, Cell
    from pickcli.cell.workcell import Workcell
    from pickcli.motion.plan import Plan
    from pickcli.scene.scene import Scene

F = TypeVar("F", bound=Callable[..., Any])

ONLY_ARM = "the cell's only arm"


def arm_option(default: str = ONLY_ARM) -> Callable[[F], F]:
    """Give a command the option --arm NAME.

    Args:
        default: The arm if none is named, for the help.

    Returns:
        A decorator that adds the option.
    """
    return click.option("--arm", metavar="NAME", help=f"Arm of the cell that moves.  [default: {default}]")


def standing_option(function: F) -> F:
    """Give a command the option --standing ARM=NAME|q.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--standing", metavar="ARM=NAME|q", multiple=True,
        help="Configuration of another arm; may be repeated.  [default: parked]",
    )(function)  # fmt: skip


@dataclass(frozen=True)
class ArmRequest:
    """The arms stated on the command line.

    Attributes:
        arm: The arm that moves; None if not stated.
        standing: Configurations of other arms, as ``ARM=NAME|q``.
        configurations: Named configurations that the arm must have; they select it if none is stated.
        is_of_plan: Whether the arm is that of a plan, which is stale for a cell without that arm.
        items: The user's own items that the cell is loaded with.
        camera: A camera that the cell must have; told before arms are.
    """

    arm: str | None = None
    standing: tuple[str, ...] = ()
    configurations: tuple[str, ...] = ()
    is_of_plan: bool = False
    items: Path | None = None
    camera: str | None = None

    @classmethod
    def of_plan(cls, plan: Plan, standing: Sequence[str], items: Path | None = None) -> ArmRequest:
        """Build the request to see a cell as the arm of a plan does.

        Args:
            plan: The plan.
            standing: Configurations of other arms, as ``ARM=NAME|q``.
            items: The user's own items.

        Returns:
            The request.
        """
        return cls(plan.arm or None, tuple(standing), is_of_plan=True, items=items)

    def cell_of(self, workcell: Workcell) -> Cell:
        """Return the cell as the arm sees it.

        Args:
            workcell: The cell with all its arms.

        Returns:
            The cell.

        Raises:
            InputError: No arm is named although there are several, or a configuration of an arm is wrong.
            StaleError: The plan is of an arm that the cell does not have.
        """
        if self.camera is not None:
            named_camera(workcell.preferred, self.camera)
        if self.is_of_plan and (self.arm or "") not in workcell.arms:
            made_for = f"arm {self.arm}" if self.arm else "a cell with one arm"
            has = f"the arms {', '.join(workcell.arms)}" if workcell.parked else "one arm"
            raise StaleError(
                f"the plan was made for {made_for}, cell {workcell.name} has {has}; plan it again"
            )
        arm, states = self._arm_of(workcell), [_state(workcell, text) for text in self.standing]
        if self.arm is None:  # if it is selected, it stands where it starts
            states = [state for state in states if state.arm != arm]
        return workcell.cell(arm, states)

    def _arm_of(self, workcell: Workcell) -> str | None:
        """Return the named arm, else the preferred one of those that have all the configurations."""
        if self.arm is not None or not self.configurations:
            return self.arm
        named = {name for cell in workcell.arms.values() for name in cell.configurations}
        requested = named.intersection(self.configurations)
        if not requested:
            return None
        own = [arm for arm, cell in workcell.arms.items() if requested <= cell.configurations.keys()]
        if not own:
            raise InputError(
                f"no arm of the cell has {' and '.join(sorted(requested))}; name two of the same arm"
            )
        return own[0] or None


def open_cell(name: str, request: ArmRequest) -> Cell:
    """Load a cell as the requested arm sees it.

    Args:
        name: Name under data/cells, or path of the cell.
        request: The arms stated on the command line.

    Returns:
        The cell.

    Raises:
        InputError: The cell cannot be read, or the request does not fit it.
    """
    from pickcli.cell.cell_file import load_workcell

    return request.cell_of(load_workcell(name, request.items))


def open_alike(name: str, request: ArmRequest) -> Cell:
    """Load a cell for what is the same for all of its arms, so that none need be named.

    Args:
        name: Name under data/cells, or path of the cell.
        request: The arms stated on the command line.

    Returns:
        The cell, as the preferred arm sees it if none is named.

    Raises:
        InputError: The cell cannot be read, or the request does not fit it.
    """
    from pickcli.cell.cell_file import load_workcell

    workcell = load_workcell(name, request.items)
    return workcell.preferred if request.arm is None else request.cell_of(workcell)


def seen_by_others(scene: Scene, request: ArmRequest) -> list[Scene]:
    """Return the scene as seen by other arms that could also execute the request, if no arm is named.

    Args:
        scene: The scene as the selected arm sees it.
        request: The arms stated on the command line.

    Returns:
        The scene of every other arm that has the named configurations; none if an arm is named.
    """
    from pickcli.cell.cell_file import load_workcell

    if request.arm is not None or not scene.cell.others:
        return []
    workcell = load_workcell(scene.cell.path, request.items)
    names = [state.arm for state in scene.cell.others]
    able = [n for n in names if workcell.arms[n].configurations.keys() >= set(request.configurations)]
    standing = {n: tuple(s for s in request.standing if s.partition("=")[0] != n) for n in able}
    return [replace(scene, cell=ArmRequest(n, standing[n]).cell_of(workcell)) for n in able]


def preferences_of(cell: Cell) -> dict[str, int]:
    """Return the preferences that a cell states for its arms.

    Args:
        cell: The cell as one of them sees it.

    Returns:
        Preference by name of the arm.
    """
    from pickcli.cell.cell_file import load_workcell

    return load_workcell(cell.path).preferences


def refuse_arm_mismatch(plan: Plan, path: Path, scene_cell: Cell) -> None:
    """Refuse a plan for another arm, or for other states of the arms.

    Args:
        plan: The plan.
        path: Its file.
        scene_cell: The cell as the arm of the plan sees it.

    Raises:
        StaleError: Another arm stands elsewhere than when the plan was made.
    """
    from pickcli.motion.plan import other_arm_elsewhere

    if why := other_arm_elsewhere(plan, scene_cell):
        raise StaleError(f"{path}: {why}")


def _state(workcell: Workcell, text: str) -> ArmState:
    """Parse the configuration of an arm from the command line."""
    from pickcli.cell.cell import ArmState

    arm, equals, configuration = text.partition("=")
    if not equals:
        raise InputError(f"--standing {text!r}: expected ARM=NAME or ARM=q, e.g. right=home; correct it")
    cell = workcell.arms[workcell.known(arm)]
    q, tool_state = parse_configuration(cell, configuration)
    return ArmState(arm, q, tool_state or cell.robot.tool.default_state)
