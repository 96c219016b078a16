"""``apc run-trial``: a whole order, played by the rules."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.arm_options import arm_option
from pickcli.commands.build_options import jobs_option
from pickcli.commands.command import Command, emit_json
from pickcli.commands.experience_session import ExperienceSession, experience_session, learn_option
from pickcli.commands.logs import stage
from pickcli.commands.option_types import PATH
from pickcli.commands.options import (
    cell_option,
    items_option,
    json_option,
    of_file,
    order_argument,
    reality_option,
    refuse_reading,
    refuse_same,
    seed_option,
    stow_rule_option,
)
from pickcli.commands.planner import artifact_options, load_planner
from pickcli.commands.pod_shift import NONE, RANDOM, pod_pose, pod_shift_option
from pickcli.commands.progress_bar import progress
from pickcli.commands.table import stdout_console
from pickcli.errors import InputError, TrialAbortedError

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.cell.pod_tolerance import Displacement
    from pickcli.cell.workcell import Workcell
    from pickcli.geometry import Array
    from pickcli.scene.scene import PoseNoise
    from pickcli.simulation.reality import Reality
    from pickcli.trial.simulated_cell import ArmPlanner
    from pickcli.trial.trial_result import TrialResult

MAX_NOISE = (50.0, 45.0)  # mm, degrees: beyond that a pose says nothing


def parse_noise(ctx: click.Context | None, param: click.Parameter | None, value: str) -> PoseNoise:
    """Read the value of --pose-noise.

    Args:
        ctx: Context of click.
        param: The option.
        value: Millimetres and degrees with a comma, as written on the command line.

    Returns:
        Bounds of the error of item poses in m and rad.

    Raises:
        BadParameter: It is not two numbers, or they are out of range.
    """
    from pickcli.scene.scene import PoseNoise

    try:
        millimetres, degrees = (float(part) for part in value.split(","))
    except ValueError:
        what = f"{value!r}: expected two numbers, millimetres and degrees, e.g. 2,1"
        raise click.BadParameter(what, ctx, param) from None
    if not (0.0 <= millimetres <= MAX_NOISE[0] and 0.0 <= degrees <= MAX_NOISE[1]):
        what = f"{value!r}: expected 0..{MAX_NOISE[0]:g} mm and 0..{MAX_NOISE[1]:g} degrees"
        raise click.BadParameter(what, ctx, param)
    return PoseNoise(millimetres / 1000.0, math.radians(degrees))


def standing(
    asked: Displacement | str | None, reality: Reality, cell: Cell, seed: int
) -> tuple[Array, Reality]:
    """Tell where the pod stands, and whether that is at random.

    Args:
        asked: By --pod-shift, None where nothing was said.
        reality: Levels, whose own shift counts then.
        cell: Whose bounds hold.
        seed: Of a random shift.

    Returns:
        Pose (4, 4) of the pod in the world, and the levels with what holds of the shift.

    Raises:
        InputError: The shift is beyond the cell's bounds.
    """
    shift = asked or (RANDOM if reality.pod_shift else NONE)
    return pod_pose(shift, cell, seed), replace(reality, pod_shift=shift == RANDOM)


@click.command("run-trial", cls=Command)
@order_argument
@click.option(
    "-o", "--output", type=PATH, metavar="DIR",
    help="Folder to write.  [default: runs/ORDER-SEED]",
)  # fmt: skip
@click.option("--overwrite", is_flag=True,
              help="Replace scene.json, after.json, trial.json, motion.json.gz, output.json, before.png and "
                   "after.png in a folder that exists; its other files stay.")  # fmt: skip
@click.option("--pose-noise", metavar="MM,DEG", callback=parse_noise, default="2,1", show_default=True,
              help="Error of the poses given to planning: up to so many mm and degrees.")  # fmt: skip
@stow_rule_option
@pod_shift_option("random, unless --reality says otherwise")
@reality_option
@cell_option
@items_option
@arm_option("all of the cell's, one at a time")
@artifact_options
@jobs_option
@learn_option
@seed_option
@json_option
def command(
    order_path: Path, output: Path | None, overwrite: bool, pose_noise: PoseNoise, stow_rule: str,
    pod_shift: Displacement | str | None, reality_path: Path | None, cell_name: str, items_path: Path | None,
    arm: str | None, roadmap: Path | None, trajectories: Path | None, jobs: int | None, learn: bool,
    seed: int, as_json: bool,
) -> None:  # fmt: skip
    """Play a whole order by the rules and keep score.

    ORDER is the file of a pick or stow order, or the name of one under data/tasks. It is played in
    simulation, by the rules of its year. A file may also name moves from place to place
    (docs/formats/order.md). Exit code 6 when the arm could not be brought out of where it stopped, something
    collided or a limit was broken; an item that was missed is a result.

    \b
    Example:
      apc run-trial jsk_pick_sample --seed 3 -o runs/mine
    """
    from pickcli.cell.cell_file import load_workcell
    from pickcli.simulation.motion_recorder import MotionRecorder
    from pickcli.simulation.reality import read_reality
    from pickcli.trial.attempt_runner import TrialSettings
    from pickcli.trial.loop import require_playable, run_trial
    from pickcli.trial.motion_record import motion_values
    from pickcli.trial.order_file import order_file, read_order
    from pickcli.trial.stow_assignment import StowRule
    from pickcli.trial.trial_folder import write_folder
    from pickcli.trial.trial_record import trial_record

    workcell, reality = load_workcell(cell_name, items_path), read_reality(reality_path)
    cells = _cells_that_play(workcell, arm, roadmap, trajectories)
    cell = cells[0]
    for each in cells:
        each.require_places()
    order = require_playable(read_order(order_path, cell), str(order_path))
    T_world_pod, reality = standing(pod_shift, reality, cell, seed)
    folder = output or Path("runs") / f"{order_path.stem}-{seed}"
    inputs = (order_file(order_path, cell), reality_path, cell_name, items_path, roadmap, trajectories)
    _refuse_outputs(folder, overwrite, inputs)

    from pickcli.stowing.make_scene import make_scene, refuse_too_much
    from pickcli.trial.simulated_cell import SimulatedArena, interfaces_of

    refuse_too_much(order.contents, cell, order.year, str(order_path))
    planners = [load_planner(each, roadmap, trajectories, build_missing=True, jobs=jobs) for each in cells]
    with stage("stowing"), progress("placing the items") as report, of_file(order_path):
        scene = make_scene(order.contents, cell, seed, order.year, report, T_world_pod)
    recorder = MotionRecorder() if len(cells) == 1 else None  # of one robot, which several arms are not
    arena = SimulatedArena(scene, reality, seed, workcell.parked.get(cell.arm), recorder)
    click.get_current_context().call_on_close(arena.close)
    pictures = {"before": arena.picture()}
    began = time.perf_counter()
    with ExitStack() as stack:
        sessions = [
            stack.enter_context(experience_session(planner, roadmap, trajectories, learn))
            for planner in planners
        ]
        settings = TrialSettings(seed, pose_noise, reality, stow_rule=StowRule(stow_rule))
        interfaces = interfaces_of((_planner_of(workcell, session) for session in sessions), arena)

        def keep_edges() -> None:
            for session in sessions:
                session.keep_edges()

        with stage("trial"), progress("playing") as report:
            result = run_trial(order, interfaces, settings, report, after_attempt=keep_edges)
        record = trial_record(result, order_path.name, time.perf_counter() - began)
        pictures["after"] = arena.picture()
        if as_json:  # before it is written, for which there may be no room
            emit_json(record)
        else:
            _show(result)
        motion = None if recorder is None else motion_values(recorder, cell)
        paths = write_folder(folder, result, record, pictures, motion, overwrite)
        if not as_json:
            click.echo("\n".join(f"wrote {path}" for path in paths))
    if not result.is_clean:
        raise TrialAbortedError(_what_went_wrong(result))


def _cells_that_play(
    workcell: Workcell, arm: str | None, roadmap: Path | None, trajectories: Path | None
) -> list[Cell]:
    """The cell as each arm sees it that plays: the one that is named, else all, the preferred one first."""
    if arm is not None or not workcell.parked:
        return [workcell.cell(arm)]
    for option, path in (("--roadmap", roadmap), ("--trajectories", trajectories)):
        if path is not None:
            raise InputError(
                f"{option}: a file is of one arm, and cell {workcell.name} plays with "
                f"{' and '.join(workcell.arms)}; name one with --arm, or leave it to the cache"
            )
    return list(workcell.arms.values())


def _planner_of(workcell: Workcell, session: ExperienceSession) -> ArmPlanner:
    from pickcli.trial.simulated_cell import ArmPlanner

    arm = session.planner.cell.arm
    return ArmPlanner(
        session.planner, session.recorder, workcell.parked.get(arm), workcell.preferences.get(arm, 0)
    )


def _refuse_outputs(folder: Path, overwrite: bool, inputs: Sequence[Path | str | None]) -> None:
    """Refuse, before any work, a folder that must not be written, or in which an input lies."""
    from pickcli.trial.trial_folder import NAMES, refuse_existing_folder

    refuse_existing_folder(folder, overwrite)
    outputs = [folder / name for name in NAMES]
    refuse_same(*outputs)
    for path in outputs:
        refuse_reading(path, *inputs)


def _show(result: TrialResult) -> None:
    """The table and the score."""
    from pickcli.commands.trial_table import print_rows
    from pickcli.trial.trial_summary import rows, summary

    console = stdout_console()
    with console.capture() as captured:
        print_rows(console, rows(result))
        for line in summary(result):
            console.print(line, markup=False, highlight=False)
    click.echo("\n".join(line.rstrip() for line in captured.get().splitlines()))  # no blanks at the ends


def _what_went_wrong(result: TrialResult) -> str:
    """One sentence for the end, when the trial was not clean."""
    if result.aborted:
        return f"{result.aborted}; see trial.json"
    collisions, violations = result.n_collisions, result.n_limit_violations
    return f"{collisions} collisions and {violations} limit violations; trial.json says where"
