"""``drive``: carries out a plan by any driver."""

from __future__ import annotations

from pickcli.motion.plan import Plan
from pickcli.progress import ProgressObserver
from pickcli.simulation.belt_run import BeltRun
from pickcli.simulation.driver import Driver
from pickcli.simulation.operator_stop import OperatorSignal, never
from pickcli.simulation.plan_record import PlanRecord
from pickcli.simulation.start_check import at_the_robot, check_start
from pickcli.simulation.stream import Pace, full_speed


def drive(
    plan: Plan,
    driver: Driver,
    *,
    pace: Pace = full_speed,
    operator: OperatorSignal = never,
    on_progress: ProgressObserver | None = None,
) -> PlanRecord:
    """Carry out a plan, to its end or to a stop on its path.

    On the item the robot waits until a sensor says that it is held, at most ``SEAL_TIME`` longer than
    planned. It stops if a joint does not follow, or if an event reads that nothing is held.

    Args:
        plan: The plan.
        driver: The driver that carries it out.
        pace: Speed of the plan's time.
        operator: Whether the operator stops the robot, asked at every set point. It stays at rest on its path
            as long as that is so, and then goes on; over a running belt it leaves that first, and ends if the
            item was not met yet.
        on_progress: Called every 100 set points with the seconds of the plan and its segment.

    Returns:
        The record of the execution.

    Raises:
        StaleError: The plan is for another cell.
        StartError: The robot is not where the plan begins.
        InputError: The tool is in another state than at the start of the plan.
    """
    plan = at_the_robot(plan, driver)
    check_start(plan, driver)
    run = BeltRun(plan, driver, pace, on_progress)
    run.operator = operator
    run.play()
    return run.record()
