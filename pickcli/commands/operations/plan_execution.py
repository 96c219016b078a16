"""Execution of plans, in the simulated world or by another driver, with its progress and animation."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from pickcli.commands.output.progress_bar import progress

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.motion.plan import Plan
    from pickcli.progress import ProgressObserver
    from pickcli.simulation.camera import GifRecorder
    from pickcli.simulation.driver import Driver
    from pickcli.simulation.execution import Execution
    from pickcli.simulation.operator_stop import OperatorSignal
    from pickcli.simulation.plan_record import PlanRecord
    from pickcli.simulation.world import World


def film_of(video: Path | None, cell: Cell, plans: list[Plan]) -> GifRecorder | None:
    """Create the recorder of an animation, with a view of all motions.

    Args:
        video: The file; None for no animation.
        cell: The cell.
        plans: The plans that are executed.

    Returns:
        The recorder; None without a file.
    """
    if video is None:
        return None
    import numpy as np

    from pickcli.simulation.camera import GifRecorder
    from pickcli.simulation.camera_view import view_of_motion

    Q = np.concatenate([plan.trajectory.positions for plan in plans])
    return GifRecorder.named(video, view_of_motion(cell, Q))


def run_plans(
    plans: list[Plan], carry_out: Callable[[Plan, ProgressObserver], PlanRecord], advice: str
) -> list[PlanRecord]:
    """Execute plans in order until one fails; the world is left as it is then.

    Args:
        plans: The plans.
        carry_out: Executes a plan, as from ``driven`` or ``simulated``.
        advice: What to do if the robot is not where a plan begins.

    Returns:
        The executions, the last of which may have failed.

    Raises:
        StartError: The robot is not where the plan begins.
    """
    from pickcli.simulation.start_check import StartError

    runs: list[PlanRecord] = []
    with progress("executing") as report:
        for plan in plans:
            try:
                run = carry_out(plan, report)
            except StartError as error:
                raise StartError(error.joint, error.offset, error.unit, advice) from None
            runs.append(run)
            if not run.is_clean:
                break
    return runs


def driven(driver: Driver, operator: OperatorSignal | None) -> Callable[[Plan, ProgressObserver], PlanRecord]:
    """Return the function that executes a plan by a driver.

    Args:
        driver: Any driver.
        operator: Whether the operator stops the robot; None if never.

    Returns:
        Function of a plan and an observer of its progress.
    """
    from pickcli.simulation.drive import drive
    from pickcli.simulation.operator_stop import never

    return lambda plan, report: drive(plan, driver, operator=operator or never, on_progress=report)


def simulated(
    world: World, film: GifRecorder | None, operator: OperatorSignal | None = None
) -> Callable[[Plan, ProgressObserver], Execution]:
    """Return the function that executes a plan in the simulated world, with its additional records.

    Args:
        world: The world.
        film: Recorder of an animation; None for none.
        operator: Whether the operator stops the robot; None for random stops by the level of its reality.

    Returns:
        Function of a plan and an observer of its progress.
    """
    from pickcli.simulation.execute import execute

    def look(world: World) -> None:
        if film is not None:
            film.look(world.engine, world.t)

    return lambda plan, report: execute(
        plan, world, operator=operator, on_progress=report, on_step=look if film is not None else None
    )
