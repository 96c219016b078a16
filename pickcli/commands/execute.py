"""``apc execute``: execution of a plan in simulation, or by another driver."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias, cast

import click

from pickcli.commands.command import Command, emit_json, in_order_given
from pickcli.commands.logs import stage
from pickcli.commands.operations.plan_execution import driven, film_of, run_plans, simulated
from pickcli.commands.operations.plan_verification import certified, trusted
from pickcli.commands.operations.query_execution import QueryRequest, answer_queries
from pickcli.commands.options.arm_options import ArmRequest, arm_option, standing_option
from pickcli.commands.options.artifact_options import artifact_options, load_context
from pickcli.commands.options.common_options import (
    json_option,
    overwrite_option,
    reality_option,
    refuse_output,
    seed_option,
)
from pickcli.commands.options.configuration_option import CONFIGURATION, CONFIGURATION_HELP, start_state_of
from pickcli.commands.options.motion_queries import configurations_in, query_options
from pickcli.commands.options.operator_stop_option import operator_stop_option
from pickcli.commands.options.option_types import PATH, RenamedOption
from pickcli.commands.options.scene_options import (
    open_scene,
    refuse_held,
    scene_or_cell_options,
    scene_or_empty,
)
from pickcli.commands.options.stream_options import StreamOptions, stream_options
from pickcli.simulation.installed_drivers import SIMULATED, driver_factory, driver_names

if TYPE_CHECKING:
    from pickcli.cell.robot import Limits
    from pickcli.cell.tool import ToolState
    from pickcli.motion.plan import Plan
    from pickcli.planning.planning_context import PlanningContext
    from pickcli.planning.start_state import Start
    from pickcli.scene.scene import Scene
    from pickcli.simulation.operator_stop import OperatorStop
    from pickcli.simulation.world import World


TO_THE_START = "add --bridge, which does that"
TO_THE_BELT = "or plan the pick from there, with apc plan-pick --from"

NamedScene: TypeAlias = "tuple[Scene, Path | None]"  # a scene and its file; None for the empty cell


@click.command("execute", cls=Command)
@click.argument("plan_path", metavar="[PLAN]", type=PATH, required=False)
@query_options
@scene_or_cell_options
@stream_options
@click.option("--planned-in", type=PATH, metavar="FILE",
              help="Scene that the plan was made for, if --scene is the true one.")  # fmt: skip
@click.option("--from", "start", cls=RenamedOption, old=("--start",), metavar=CONFIGURATION,
              help=f"Start of the robot: {CONFIGURATION_HELP}  [default: start of the plan or of the first "
                   "move, else home]")  # fmt: skip
@arm_option("the preferred one, of those that have the named configurations; for queries")
@standing_option
@click.option("--bridge", is_flag=True, help="First move to the plan's first point; planned and verified.")
@click.option("--no-verify", cls=RenamedOption, old=("--unverified",), is_flag=True,
              help="Execute the plan unverified, in any scene, as an experiment.")  # fmt: skip
@click.option("--driver", "driver_name", metavar="DRIVER", default=SIMULATED, show_default=True,
              help=f"Driver that executes the plan: {', '.join(driver_names())}.")  # fmt: skip
@operator_stop_option
@reality_option
@click.option("--video", type=PATH, metavar="FILE.gif", help="Also write an animated GIF of the execution.")
@overwrite_option
@artifact_options
@seed_option
@json_option
def command(
    plan_path: Path | None, picks: tuple[str, ...], stows: tuple[str, ...], moves: tuple[str, ...],
    scene_path: Path | None, cell_name: str | None, items_path: Path | None, planned_in: Path | None,
    start: str | None, arm: str | None, standing: tuple[str, ...], bridge: bool, no_verify: bool,
    driver_name: str, operator_stops: tuple[OperatorStop, ...], reality_path: Path | None,
    video: Path | None, overwrite: bool, roadmap: Path | None, trajectories: Path | None, seed: int,
    as_json: bool, request: StreamOptions,
) -> None:  # fmt: skip
    """Execute a plan in pybullet or with another driver, or plan and execute queries.

    The plan is verified first, even if it has a certificate. It does not start if the robot stands more than
    0.01 rad or m from the plan's first point; --bridge plans, verifies and executes a move to it first.

    Instead of PLAN, --pick, --stow and --move are queries, executed in the given order: each is planned from
    the stored files, from the arm's current configuration in the current scene, verified, and executed in one
    simulated world. If the arm is not at the FROM of a move, it moves there first.

    Exit code 6 after a collision, a broken limit, a missed event, or a stop by a following error or an
    unexpected contact. An item that was not picked or was lost is a result: exit code 0.

    \b
    Example:
      apc execute plan.json --scene scene.json --video pick.gif
      apc execute plan.json --scene scene.json --from tote --bridge
      apc execute plan.json --scene scene.json --driver recorder
      apc execute plan.json --scene scene.json --operator-stop 2.5:4
      apc execute --scene scene.json --pick bin_C:dove_beauty_bar --move home:bin_C
      apc execute belt.json --stream stream.json --now 5 --video belt.gif
      apc execute belt.json --stream stream.json --now 5 --operator-stop 3:5
      apc execute --scene filled.json --stow dove_beauty_bar:bin_H
    """
    from pickcli.commands.output.execution_report import execution_summary, execution_text, trouble
    from pickcli.errors import TrialAbortedError
    from pickcli.motion.plan_file import read_plan
    from pickcli.planning.start_state import Start
    from pickcli.simulation.driver import DriverRequest
    from pickcli.simulation.guarded_driver import GuardedDriver, connected
    from pickcli.simulation.operator_stop import signal_of
    from pickcli.simulation.reality import read_reality

    request.refuse_scene(scene_path)
    if bridge and request.stream_path is not None:
        raise click.UsageError("--bridge: not with --stream: the belt would carry the items on meanwhile")
    if driver_name != SIMULATED and (reality_path is not None or video is not None):
        raise click.UsageError(f"--reality and --video need the simulated world, not driver {driver_name}")
    if video is not None:
        read = plan_path, scene_path, planned_in, reality_path, cell_name, items_path, roadmap, trajectories
        refuse_output(video, overwrite, *read)
    connect, reality = driver_factory(driver_name), read_reality(reality_path)
    given = in_order_given(picks=picks, stows=stows, moves=moves)
    if plan_path is None or given:
        _refuse_mixed(plan_path, given, {
            "--planned-in": planned_in is not None, "--stream": request.stream_path is not None,
            "--bridge": bridge, "--no-verify": no_verify,
            "--driver": driver_name != SIMULATED, "--operator-stop": bool(operator_stops),
        })  # fmt: skip
        named = (*configurations_in(given), *(() if start is None else (start,))) or ("home",)
        arms = ArmRequest(arm, standing, named, items=items_path)
        scene = scene_or_empty(scene_path, cell_name, arms)
        refuse_held(scene, scene_path)
        queries = QueryRequest(given, start, reality, video, overwrite, seed, as_json)
        answer_queries(queries, scene, lambda: load_context(scene.cell, roadmap, trajectories))
        return
    if arm is not None:
        raise click.UsageError(f"--arm {arm}: a plan names its arm; the option is for queries")
    plan = read_plan(plan_path)
    arms = ArmRequest.of_plan(plan, standing, items_path)
    if request.stream_path is not None and planned_in is not None:
        raise click.UsageError("--planned-in is for scenes; leave it out with --stream")
    scene = request.surroundings(plan, scene_path, cell_name, arms)
    scene_path = request.stream_path or scene_path
    believed = scene if planned_in is None else open_scene(planned_in, cell_name, arms)
    refuse_held(scene, scene_path)
    refuse_held(believed, planned_in or scene_path)
    if planned_in is not None:
        _compare(plan, plan_path, (scene, scene_path), (believed, planned_in))
    plan = _judged(plan, plan_path, (scene, scene_path), (believed, planned_in), no_verify)
    q, tool_state = start_state_of(plan, scene, start)
    plans = [plan]
    belts = {} if plan.tracking is None else {plan.tracking.conveyor: plan.tracking.speed}
    driver = connected(driver_name, connect, DriverRequest(scene, q, tool_state, reality, seed, belts))
    with closing(driver if driver_name == SIMULATED else GuardedDriver(driver_name, driver)) as driver:
        if bridge and _is_away(plan, Start(driver.q, tool_state), scene.cell.robot.limits):
            context = load_context(scene.cell, roadmap, trajectories)
            plans.insert(0, _bridge(context, believed, plan, Start(driver.q, tool_state), seed))
        film = film_of(video, scene.cell, plans)
        world = cast("World", driver) if driver_name == SIMULATED else None
        with stage("simulation" if world else "execution"):
            operator = signal_of(operator_stops, driver.t) if operator_stops else None
            carry_out = driven(driver, operator) if world is None else simulated(world, film, operator)
            is_of_scene = request.stream_path is None
            runs = run_plans(plans, carry_out, TO_THE_START if is_of_scene else TO_THE_BELT)
        if as_json:
            emit_json({"driver": driver_name, **execution_summary(plans, runs, world)})
        else:
            click.echo(execution_text(plans, runs, world))
        if operator is not None and not any(run.operator_stops for run in runs):
            click.echo("note: the motion ended before --operator-stop", err=True)
        if film is not None and video is not None:  # after the result, which matters more
            film.write(video, overwrite)
            click.echo(f"  wrote {video}", err=as_json)
    if why := trouble(runs):
        raise TrialAbortedError(why)


def _refuse_mixed(plan_path: Path | None, given: list[tuple[str, str]], of_plan: dict[str, bool]) -> None:
    """Raise UsageError unless there are only queries. of_plan: options that apply only to a plan file."""
    if not given:
        raise click.UsageError(
            "nothing to execute: name a PLAN, or queries with --pick PLACE:ITEM, --stow ITEM and "
            "--move FROM:TO"
        )
    if plan_path is not None:
        raise click.UsageError(
            f"{plan_path} is a plan, and --{given[0][0][:-1]} a query; give one or the other"
        )
    if mixed := [option for option, is_given in of_plan.items() if is_given]:
        raise click.UsageError(
            f"{' and '.join(mixed)}: only for a plan file; queries are planned, verified and executed in the "
            "simulated world"
        )


def _compare(plan: Plan, path: Path, true: NamedScene, planned: NamedScene) -> None:
    """Compare the true scene with that of the plan; a note tells if the target lies in another place.

    Raises StaleError if the plan was made in the true one, InputError if its target is not there.
    """
    from pickcli.errors import InputError, StaleError
    from pickcli.scene.scene_file import scene_hash

    (scene, scene_path), (believed, planned_in) = true, planned
    name = scene_path or f"{scene.cell.name} with nothing in it"
    if plan.scene_hash == scene_hash(scene) != scene_hash(believed):
        fault = f"{path}: made in {name}, which --scene states as the true one, not in {planned_in}"
        raise StaleError(f"{fault}; swap --scene and --planned-in, or leave out --planned-in")
    if plan.grasp is None:
        return
    item = plan.grasp.item
    now, then = ({i.id: i.location for i in each.items} for each in (scene, believed))
    if item in then and item not in now:
        fault = f"{name}: does not contain {item}, which {path} picks"
        raise InputError(f"{fault}; name the current scene with --scene")
    if item in then and now[item] != then[item]:
        note = f"{item} is in {now[item]} in {name}, but {path} expects it in {then[item]}"
        click.echo(f"note: {note}", err=True)


def _judged(plan: Plan, path: Path, true: NamedScene, planned: NamedScene, is_experiment: bool) -> Plan:
    """Return the plan with a new certificate; an experiment is not verified, which a note states."""
    (scene, scene_path), (believed, planned_in) = true, planned
    if not is_experiment:
        advice = "plan it again, or watch it fail with --no-verify"
        is_stream = plan.tracking is not None
        option = "--stream" if is_stream else "--scene" if scene_path is None else "--planned-in"
        return trusted(plan, path, believed, advice, planned_in or scene_path, option)
    _refuse_unknown_states(plan, path, scene)
    click.echo(f"note: {path} was not verified: this run is an experiment", err=True)
    return plan


def _refuse_unknown_states(plan: Plan, path: Path, scene: Scene) -> None:
    """Raise InputError if a segment has a tool state that the tool of the scene's cell does not have."""
    from pickcli.errors import InputError

    tool = scene.cell.robot.tool
    for k, segment in enumerate(plan.segments):
        if segment.tool_state not in tool.states_and_moving:
            raise InputError(
                f"{path}: segments.{k}.tool_state: the tool has no state {str(segment.tool_state)!r}, only "
                f"{', '.join(map(str, tool.states_and_moving))}; plan it again"
            )


def _is_away(plan: Plan, start: Start, limits: Limits) -> bool:
    from pickcli.kinematics.continuous_joints import unwound_towards
    from pickcli.simulation.start_check import START_TOLERANCE

    first = unwound_towards(limits, plan.trajectory.positions[0], start.q)
    is_in_state = _first_state(plan) in (None, start.tool_state)
    return not is_in_state or bool(abs(start.q - first).max() > START_TOLERANCE)


def _first_state(plan: Plan) -> ToolState | None:
    """Return the state of the tool at the plan's first point; None if it may be any."""
    from pickcli.cell.tool import MOVING

    state = plan.segments[0].tool_state
    return None if state == MOVING else state


def _bridge(context: PlanningContext, believed: Scene, plan: Plan, start: Start, seed: int) -> Plan:
    """Plan a certified move from the state of the robot to that at the plan's first point."""
    from pickcli.planning.move import MoveGoal, plan_move

    goal = MoveGoal(plan.trajectory.positions[0], _first_state(plan))
    bridge = plan_move(context, believed, start, goal, seed, label="bridge to the first point")
    return certified(bridge, believed, "try another --seed")
