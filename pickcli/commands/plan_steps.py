"""Steps that the planning commands share: artifacts, configurations by name or figures, the certificate."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.arm_options import refuse_arm_mismatch
from pickcli.commands.building import build_report
from pickcli.commands.command import emit_json
from pickcli.commands.logs import stage
from pickcli.commands.option_types import PATH
from pickcli.commands.report import plan_summary, plan_text
from pickcli.errors import Failures, InputError, RejectedError

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.cell.tool import ToolState
    from pickcli.motion.plan import Plan
    from pickcli.planning.arm_choice import ArmSuitability
    from pickcli.planning.pick_problem import Certify
    from pickcli.planning.planning_context import PlanningContext
    from pickcli.scene.scene import Scene

F = TypeVar("F", bound=Callable[..., Any])

CONFIGURATION = "NAME|q"
CONFIGURATION_HELP = (
    "a configuration of the cell (apc inspect lists them), or joint positions with commas, rad and m."
)
_NOTES = f"{__name__}.notes"  # key of the notes already printed in a click context


def artifact_options(function: F) -> F:
    """Give a command the options --roadmap and --trajectories.

    By default, they are those in the cell's folder in the user's cache, if built.

    Args:
        function: The command.

    Returns:
        The command with the options.
    """
    for name, what in (("trajectories", "trajectory database"), ("roadmap", "roadmap")):
        function = click.option(
            f"--{name}", type=PATH, metavar="FILE",
            help=f"The {what} to use instead of the cell's own in the cache.",
        )(function)  # fmt: skip
    return function


def start_option(function: F) -> F:
    """Give a command the option --from NAME|q, by default home.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--from", "start", metavar=CONFIGURATION, default="home", show_default=True,
        help=f"Start of the robot: {CONFIGURATION_HELP}",
    )(function)  # fmt: skip


def verify_option(function: F) -> F:
    """Give a command the option --no-verify.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--no-verify", is_flag=True, help="Write the plan unverified, without a certificate."
    )(function)


def tool_state_option(function: F) -> F:
    """Give a command the option --tool-state STATE.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    return click.option(
        "--tool-state", metavar="STATE", default=None, show_default="the first of the cell",
        help="State of the tool at the poses, e.g. straight.",
    )(function)  # fmt: skip


def load_context(
    cell: Cell,
    roadmap: Path | None,
    trajectories: Path | None,
    build_missing: bool = False,
    jobs: int | None = None,
) -> PlanningContext:
    """Load the planning context with the named artifacts, or those in the cache if they are built.

    Args:
        cell: The cell.
        roadmap: The named roadmap; None for the one in the cache.
        trajectories: The named trajectory database; None for the one in the cache.
        build_missing: Whether to build missing artifacts in the cache; else planning works without them, and
            a note says so.
        jobs: Number of parallel processes of the build; None for one per core.

    Returns:
        The context.

    Raises:
        InputError: A named file is missing.
        StaleError: A file was made for another cell or by another version of the format.
        DamagedError: The content of a file is not what was written.
    """
    from pickcli.planning.planning_context import PlanningContext
    from pickcli.precompute.artifact_cache import read_stored
    from pickcli.roadmap.store import read_database, read_roadmap

    if build_missing and (roadmap is None or trajectories is None):
        if roadmap is not None:  # named files are checked before anything is built
            read_roadmap(roadmap, cell)
        if trajectories is not None:
            read_database(trajectories, cell)
        _build_missing(cell, jobs)
    stored, database = read_stored(cell, roadmap, trajectories)
    if stored is None and database is None and cell.places:
        _print_once(
            "note: neither roadmap nor trajectory database is built for this cell, so every coarse motion "
            "is planned from scratch (apc run-trial builds both)"
        )
    return PlanningContext(cell, stored, database)


def _print_once(note: str) -> None:
    """Print a note only once per command, also if it applies to several arms."""
    printed = click.get_current_context().meta.setdefault(_NOTES, set())
    if note not in printed:
        printed.add(note)
        click.echo(note, err=True)


def _build_missing(cell: Cell, jobs: int | None) -> None:
    """Build the missing artifacts in the cell's cache, with progress."""
    from contextlib import ExitStack

    from pickcli.jobs.executors import available_cores, runner
    from pickcli.jobs.journal import journals
    from pickcli.precompute.artifact_cache import default_paths, ensure_artifacts

    try:
        with ExitStack() as bars:
            ensure_artifacts(
                cell,
                lambda what: bars.enter_context(build_report(f"building the {what}")),
                runner(jobs or available_cores()),
            )
    except (KeyboardInterrupt, InputError) as stop:
        paths = default_paths(cell)
        for journal in (*journals(paths.roadmap), *journals(paths.trajectories)):
            stop.add_note(f"finished tasks are kept in {journal}; run the same command again to continue")
        raise


def certified(plan: Plan, scene: Scene, advice: str, path: Path | None = None) -> Plan:
    """Verify a plan.

    Args:
        plan: The plan.
        scene: The scene in which it is to be executed.
        advice: Advice for a rejection.
        path: Its file; None for a new plan.

    Returns:
        The plan with the verifier's certificate.

    Raises:
        RejectedError: With every reason and the advice.
    """
    from pickcli.verification.verify import certify

    began = time.perf_counter()
    try:
        with stage("verification"):
            plan = certify(plan, scene)
    except RejectedError as error:
        what = plan.query if path is None else f"{path}: {plan.query}"
        raise RejectedError(what, error.reasons, advice) from None
    plan.statistics.update(verification_ms=1e3 * (time.perf_counter() - began))
    return plan


def timed_certifier(scene: Scene) -> Certify:
    """Return a certifier that notes in each plan how long its verification took.

    Args:
        scene: The scene in which they are to be executed.

    Returns:
        A function that returns a plan with its certificate, or the reasons for its rejection.
    """
    from pickcli.verification.verify import certifier

    judge = certifier(scene)

    def certify(plan: Plan) -> Plan | Failures:
        began = time.perf_counter()
        with stage("verification"):
            judged = judge(plan)
        plan.statistics.update(verification_ms=1e3 * (time.perf_counter() - began))
        return judged

    return certify


def trusted(
    plan: Plan, path: Path, believed: Scene, advice: str, scene_path: Path | None, option: str = "--scene"
) -> Plan:
    """Verify a plan from a file even if it has a certificate, which only guards against accidents.

    Args:
        plan: The plan.
        path: Its file.
        believed: The scene that it must be made for.
        advice: Advice for a rejection.
        scene_path: File of that scene; None for the empty cell.
        option: The option that states the scene of a plan.

    Returns:
        The plan with the verifier's certificate.

    Raises:
        RejectedError: The verifier rejects it.
        StaleError: It was made for another scene or cell.
    """
    from pickcli.errors import StaleError
    from pickcli.precompute.empty_cell_checkers import empty_scene
    from pickcli.scene.scene_file import scene_hash

    refuse_arm_mismatch(plan, path, believed.cell)
    here, cell, carried = scene_hash(believed), believed.cell, plan.certificate
    if plan.cell_fingerprint != cell.fingerprint:
        raise StaleError(
            f"{path}: made for the cell {plan.cell_fingerprint[:12]}, {cell.name} is "
            f"{cell.fingerprint[:12]}; plan it again"
        )
    if carried is not None and plan.scene_hash != here:
        this = scene_path or f"{cell.name} with nothing in it"
        fault = (
            f"{path}: made for the scene {plan.scene_hash[:12]}, {this} is {here[:12]}; plan it again, or "
        )
        if plan.scene_hash == scene_hash(empty_scene(cell)):
            raise StaleError(f"{fault}name only --cell, as when it was made")
        raise StaleError(f"{fault}name the scene it was made in with {option}")
    plan = certified(plan, believed, advice, path)
    if carried is None:
        click.echo(f"note: {path} has no certificate; it was verified now and accepted", err=True)
    return plan


def deliver(
    plan: Plan, scene: Scene, output: Path, verify_now: bool, as_json: bool, overwrite: bool,
    ranked: Sequence[ArmSuitability] = (),
) -> None:  # fmt: skip
    """Verify a plan if asked, write it and print its summary.

    Args:
        plan: The plan.
        scene: The scene in which it is to be executed.
        output: Output file.
        verify_now: Whether it is verified here; False if it was before, or is not to be.
        as_json: Whether JSON is printed.
        overwrite: Whether an existing file may be replaced.
        ranked: Ranking of the arms, the best first, if the arm was chosen.

    Raises:
        RejectedError: The verifier rejects the plan; nothing is written.
        InputError: The file cannot be written.
    """
    from pickcli.motion.plan_file import write_plan

    if verify_now:
        plan = certified(plan, scene, _advice(plan, scene.cell))
    write_plan(plan, output, overwrite)
    if as_json:
        why = [{**asdict(arm), "against": arm.against and str(arm.against)} for arm in ranked]
        emit_json({**plan_summary(plan, output), **({"arms_ranked": why} if why else {})})
    else:
        click.echo("\n".join([*map(str, ranked), plan_text(plan, output)]))


def _advice(plan: Plan, cell: Cell) -> str:
    """Return advice for a plan that the verifier rejects."""
    from pickcli.motion.plan import MAX_DURATION

    speed = cell.max_tool_speed
    if speed is not None and plan.trajectory.duration > MAX_DURATION:
        return f"the cell's max_tool_speed of {speed:g} m/s makes it too long; raise that"
    return "try another --seed, or look at the plan with --no-verify"


def named_state(cell: Cell, text: str | None) -> ToolState:
    """Find a state of the cell's tool by its name.

    Args:
        cell: The cell.
        text: The name; None for the default state.

    Returns:
        The state.

    Raises:
        UnknownNameError: The tool has no such state.
    """
    from pickcli.api.configurations import state_named

    return cell.robot.tool.default_state if text is None else state_named(cell, text)
