"""``apc check-driver``: a test of a driver against the protocol."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.operations.plan_verification import refuse_tracking, trusted
from pickcli.commands.options.arm_options import ArmRequest, standing_option
from pickcli.commands.options.common_options import json_option
from pickcli.commands.options.configuration_option import start_state_of
from pickcli.commands.options.option_types import PATH
from pickcli.commands.options.scene_options import refuse_held, scene_or_cell_options, scene_or_empty
from pickcli.simulation.installed_drivers import driver_factory

if TYPE_CHECKING:
    from pickcli.simulation.driver_check import DriverReport


@click.command("check-driver", cls=Command)
@click.argument("driver_name", metavar="DRIVER")
@click.argument("plan_path", metavar="PLAN", type=PATH)
@scene_or_cell_options
@standing_option
@json_option
def command(
    driver_name: str, plan_path: Path, scene_path: Path | None, cell_name: str | None,
    items_path: Path | None, standing: tuple[str, ...], as_json: bool,
) -> None:  # fmt: skip
    """Execute a plan by a driver, and check that the driver keeps to the protocol.

    The robot moves. The plan is verified first, and has to begin where the robot stands. A short move is
    enough; a pick also tests devices and sensors. Nothing moves after a failed check.

    \b
    Example:
      apc check-driver recorder plan.json --scene scene.json
    """
    from pickcli.errors import InputError
    from pickcli.motion.plan_file import read_plan
    from pickcli.simulation.driver import DriverRequest
    from pickcli.simulation.driver_check import check_driver
    from pickcli.simulation.guarded_driver import connected

    connect, plan = driver_factory(driver_name), read_plan(plan_path)
    refuse_tracking(plan, plan_path)
    scene = scene_or_empty(scene_path, cell_name, ArmRequest.of_plan(plan, standing, items_path))
    refuse_held(scene, scene_path)
    plan = trusted(plan, plan_path, scene, "plan it again", scene_path)
    q, tool_state = start_state_of(plan, scene, None)
    with stage("check of the driver"):
        report = check_driver(connected(driver_name, connect, DriverRequest(scene, q, tool_state)), plan)
    if as_json:
        emit_json(_summary(driver_name, report))
    else:
        click.echo(_text(report))
    if not report.is_passed:
        fault = next(check for check in report.checks if check.fault)
        raise InputError(f"driver {driver_name}: {fault.what}: {fault.fault}; correct the driver")


def _summary(name: str, report: DriverReport) -> dict[str, Any]:
    checks = [{**asdict(check), "is_passed": check.is_passed} for check in report.checks]
    return {"driver": name, "is_passed": report.is_passed, "checks": checks}


def _text(report: DriverReport) -> str:
    """Describe each check in a line."""
    outcomes = {True: "passed", False: "not tried"}
    return "\n".join(
        f"{'FAILED' if check.fault else outcomes[check.is_passed]:>10}  {check.what}"
        for check in report.checks
    )
