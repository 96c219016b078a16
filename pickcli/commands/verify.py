"""``apc verify``: independent verification of a plan of an arm, a stack on a pallet, or a drive."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.operations.pallet_verification import verify_pallet
from pickcli.commands.operations.verified_drive import verify_driven
from pickcli.commands.options.arm_options import ArmRequest, standing_option
from pickcli.commands.options.common_options import json_option
from pickcli.commands.options.option_types import PATH
from pickcli.commands.options.scene_options import scene_or_cell_options
from pickcli.commands.options.stream_options import StreamOptions, stream_options
from pickcli.files.file_kind import DRIVE, PLAN, STACKED, FileKind

if TYPE_CHECKING:
    from pickcli.verification.verdict import Verdict

OF_ALL = frozenset({"plan_path", "as_json"})
OF_KINDS = {STACKED: frozenset({"order_path", "drop_test"}), DRIVE: frozenset({"area_path", "detected"})}


@click.command("verify", cls=Command)
@click.argument("plan_path", metavar="PLAN", type=PATH)
@scene_or_cell_options
@stream_options
@click.option("--stopped", "stopped_path", type=PATH, metavar="PLAN",
              help="For a way back after a stop, the plan that was stopped.")  # fmt: skip
@standing_option
@click.option("--order", "order_path", type=PATH, metavar="ORDER",
              help="For a stacked pallet, the order that it must be a stack of.")  # fmt: skip
@click.option("--drop-test", is_flag=True,
              help="Put a stacked pallet up in the physics engine, too.")  # fmt: skip
@click.option("--area", "area_path", type=PATH, metavar="AREA",
              help="For a drive, the driving area that it was planned for.")  # fmt: skip
@click.option("--detected", "detected", type=PATH, metavar="FILE",
              help="For a drive into a pallet that apc detect-pallet saw, its answer.")  # fmt: skip
@click.option("--write", is_flag=True, help="Write the certificate into the plan's file.")
@json_option
def command(
    plan_path: Path, scene_path: Path | None, cell_name: str | None, items_path: Path | None,
    stopped_path: Path | None, standing: tuple[str, ...], order_path: Path | None, drop_test: bool,
    area_path: Path | None, detected: Path | None, write: bool, as_json: bool, request: StreamOptions,
) -> None:  # fmt: skip
    """Check a plan, a stacked pallet or a drive with the independent verifier.

    The verifier uses exact shapes, its own kinematics and proven bounds, in the scene that the plan was made
    for; name only --cell if it was made without one. Of a plan for a running conveyor, name the stream and
    the time at which it starts.

    Of a stacked pallet it checks room, ways down, balance at any time and loads; name its order to compare
    with that, too. Of a drive it checks the distance from everything all along, the end, and the truck's
    limits; name its area.

    Exit code 0 when it may be executed, 4 when it is rejected, damaged or made for another scene.

    \b
    Example:
      apc verify plan.json --scene scene.json --write
      apc verify move.json --cell my_robot
      apc verify plan.json --stream stream.json --now 1.5
      apc verify stack.json --order pallet.json --drop-test
      apc verify drive.json --area hall.yaml
    """
    from pickcli.errors import InputError, RejectedError, StaleError
    from pickcli.files.bounded_reading import read_kind
    from pickcli.motion.plan_file import read_plan, write_plan
    from pickcli.verification.verify import verify

    kind = read_kind(plan_path) if plan_path.is_file() else None
    if kind is STACKED:
        _refuse_options_of_others(STACKED)
        verify_pallet(plan_path, order_path, drop_test, as_json)
        return
    if kind is DRIVE:
        _refuse_options_of_others(DRIVE)
        verify_driven(plan_path, area_path, detected, as_json)
        return
    plan = read_plan(plan_path)
    _refuse_options_of_others(PLAN)
    stopped = None if stopped_path is None else read_plan(stopped_path).trajectory
    if stopped is not None and plan.recovery is None:
        raise InputError(f"{plan_path}: is no way back after a stop, as --stopped says; leave that out")
    request.refuse_scene(scene_path)
    arms = ArmRequest.of_plan(plan, standing, items_path)
    scene = request.surroundings(plan, scene_path, cell_name, arms)
    try:
        with stage("verification"):
            verdict = verify(plan, scene, stopped)
    except StaleError as error:
        raise StaleError(
            f"{plan_path} in {request.stream_path or scene_path or cell_name}: {error}"
        ) from None
    if verdict.certificate is not None and write:
        write_plan(replace(plan, certificate=verdict.certificate), plan_path)
    if as_json:
        emit_json(_summary(verdict, plan_path, write))
    elif verdict.certificate is not None:
        click.echo(_text(verdict))
    if verdict.certificate is None:
        raise RejectedError(str(plan_path), verdict.reasons)


def _refuse_options_of_others(kind: FileKind) -> None:
    """Refuse options for another kind of file than the one that is named. Raises UsageError."""
    ctx = click.get_current_context()
    for parameter in ctx.command.params:
        name = str(parameter.name)
        if name in OF_ALL or ctx.get_parameter_source(name) is not ParameterSource.COMMANDLINE:
            continue
        owner = next((each for each, names in OF_KINDS.items() if name in names), PLAN)
        if owner is not kind:
            raise click.UsageError(f"{parameter.opts[0]} applies only to {owner.name}; leave it out")


def _summary(verdict: Verdict, path: Path, write: bool) -> dict[str, Any]:
    """Convert the verdict to JSON values."""
    certificate = verdict.certificate
    return {
        "path": str(path),
        "accepted": certificate is not None,
        "min_clearance_m": None if certificate is None else certificate.min_clearance,
        "certificate": None if certificate is None else asdict(certificate),
        "written": certificate is not None and write,
    }


def _text(verdict: Verdict) -> str:
    """Describe what was checked, in a few lines."""
    certificate = verdict.certificate
    assert certificate is not None
    rows = (
        ("accepted", f"{certificate.n_states} states, at most {certificate.max_step * 1e3:.1f} mm apart"),
        ("clearance", f"at least {certificate.clearance_mm:.1f} mm outside of planned contacts"),
        ("velocity", f"{certificate.max_velocity_ratio:.1%} of the limit"),
        ("acceleration", f"{certificate.max_acceleration_ratio:.1%} of the limit"),
        ("jerk", f"{certificate.max_jerk_ratio:.1%} of the limit"),
        *(("checked", check) for check in certificate.checks),
        (
            "claim",
            f"holds in this model (cell {certificate.cell_fingerprint[:12]}); not a statement about safety",
        ),
    )
    return "\n".join(f"{key:>14}: {value}" for key, value in rows)
