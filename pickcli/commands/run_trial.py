"""``apc run-trial``: a simulated trial of a whole order."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.operations.played_commission import is_commission, play_commission_file
from pickcli.commands.operations.played_pallet import is_pallet, play_pallet_file
from pickcli.commands.operations.played_stream import is_stream, play_stream_file
from pickcli.commands.options.common_options import (
    json_option,
    of_file,
    order_argument,
    refuse_reading,
    refuse_same,
    seed_option,
)
from pickcli.commands.options.experience_session import experience_session, learn_option
from pickcli.commands.options.option_types import PATH, NumberType
from pickcli.commands.options.people_options import PeopleOptions, people_options, refuse_people
from pickcli.commands.options.stream_plan_options import (
    StreamPlanOptions,
    refuse_stream_plan,
    stream_plan_options,
)
from pickcli.commands.options.trial_options import TrialOptions, refuse_stow_rule, trial_arm, trial_options
from pickcli.commands.output.progress_bar import progress
from pickcli.commands.output.table import stdout_console
from pickcli.errors import TrialAbortedError

if TYPE_CHECKING:
    from pickcli.cell.workcell import Workcell
    from pickcli.page.live_page import LivePage
    from pickcli.scene.scene import Scene
    from pickcli.trial.played_trial import TrialSnapshot
    from pickcli.trial.trial_result import TrialResult


@click.command("run-trial", cls=Command)
@order_argument
@click.option(
    "-o", "--output", type=PATH, metavar="FOLDER",
    help="Folder to write.  [default: runs/ORDER-SEED]",
)  # fmt: skip
@click.option("--overwrite", is_flag=True,
              help="Replace scene.json, after.json, trial.json, motion.json.gz, output.json, before.png and "
                   "after.png in a folder that exists, and its look_NNN_PLACE.png, plan_NNN.json and "
                   "seen_NNN.json; its other files stay.")  # fmt: skip
@click.option("--live", is_flag=True, help="Serve the trial's page at 127.0.0.1 while it is played.")
@click.option(
    "--live-port", type=NumberType(1, 65535), help="Port of --live, which it implies.  [default: a free one]"
)
@click.option("--plans", "with_plans", is_flag=True,
              help="Write the plan of every attempt, too, and the scene that it was certified "
                   "for.")  # fmt: skip
@stream_plan_options
@people_options
@trial_options
@learn_option
@seed_option
@json_option
def command(
    order_path: Path, output: Path | None, overwrite: bool, live: bool, live_port: int | None,
    with_plans: bool, planned_by: StreamPlanOptions, people: PeopleOptions, options: TrialOptions,
    learn: bool, seed: int, as_json: bool,
) -> None:  # fmt: skip
    """Play a whole order in simulation, by the rules, and score it.

    ORDER is the file of a pick or stow order, or the name of one under data/tasks. The rules are those of its
    year. A file may also name moves from place to place (docs/formats/order.md), be a stream of items on a
    conveyor (docs/formats/stream.md), the order or stack of a pallet (docs/formats/pallet.md), whose cartons
    the arm of pallet_sia20 stacks, or a commission (docs/formats/commission.md), for which the truck of
    apple_booth takes a pallet, fills and delivers it. For a pallet --pose-noise is 1,0.2 by default, for a
    commission 2,0.5 and --strategy apple. Exit code 6 when the arm could not recover from a stop, something
    collided or a limit was broken; an item that was missed is a result.

    \b
    Example:
      apc run-trial jsk_pick_sample --seed 3 -o runs/mine
    """
    from pickcli.cell.cell_file import load_workcell
    from pickcli.simulation.reality import read_reality
    from pickcli.trial.order import require_playable
    from pickcli.trial.order_file import order_file, read_order, refuse_unknown_task
    from pickcli.trial.trial_folder import LOOKS, PLANS, write_folder

    if is_commission(order_path):
        refuse_stream_plan()
        folder = output or Path("runs") / f"{order_path.stem}-{seed}"
        play_commission_file(order_path, folder, overwrite, (options, people), with_plans, seed, as_json)
        return
    refuse_people()
    if is_stream(order_path):
        folder = output or Path("runs") / f"{order_path.stem}-{seed}"
        play_stream_file(order_path, folder, overwrite, options, planned_by, with_plans, seed, as_json)
        return
    refuse_stream_plan()
    if is_pallet(order_path):
        folder = output or Path("runs") / f"{order_path.stem}-{seed}"
        play_pallet_file(order_path, folder, overwrite, options, with_plans, seed, as_json)
        return
    workcell = load_workcell(options.cell_name, options.items_path)
    reality = read_reality(options.reality_path)
    cells = options.cells(workcell)
    cell = cells[0]
    refuse_unknown_task(order_path, cell)
    order = require_playable(read_order(order_path, cell), str(order_path))
    refuse_stow_rule([order])
    options.refuse_misplaced(reality, cell, [order], seed)
    is_live = live or live_port is not None
    folder = output or Path("runs") / f"{order_path.stem}-{seed}"
    _refuse_outputs(folder, overwrite, (order_file(order_path, cell), *options.inputs))

    from pickcli.random_scenes.make_scene import refuse_too_much
    from pickcli.trial.played_trial import TrialRequest, play_trial, stowed_scene

    refuse_too_much(order.contents, cell, order.year, str(order_path))
    request = TrialRequest(order, order_path.name, options.conditions(reality, cell, [order]), seed)
    contexts = options.planning_contexts(cells)
    with stage("placing of the items"), progress("placing the items") as report, of_file(order_path):
        scene = stowed_scene(request, cell, report)
    with ExitStack() as stack:
        sessions = [
            stack.enter_context(experience_session(context, options.roadmap, options.trajectories, learn))
            for context in contexts
        ]
        trial_arms = [trial_arm(workcell, session.context, session.recorder) for session in sessions]

        def keep_edges() -> None:
            for session in sessions:
                session.keep_edges()

        several = workcell if len(cells) > 1 else None
        watch = _watched(stack.enter_context(_live(live_port or 0)), scene, several) if is_live else None
        with stage("trial"), progress("playing") as report:
            played = play_trial(request, scene, trial_arms, report, keep_edges, watch)
        result = played.result
        try:  # neither a full disk nor a reader that has gone may lose the trial
            if as_json:
                emit_json({"path": str(folder), **played.record})
            else:
                _show(result)
        finally:
            paths = write_folder(
                folder, result, played.record, played.pictures, played.motion, overwrite, with_plans
            )
        if not as_json:
            looks = [path for path in paths if path.match(LOOKS)]
            plans = [path for path in paths if any(path.match(pattern) for pattern in PLANS)]
            told = [f"wrote {path}" for path in paths if path not in (*looks, *plans)]
            told += [f"wrote {folder / LOOKS}: {len(looks)} pictures"] if looks else []
            told += [f"wrote {folder / PLANS[0]}, {PLANS[1]}: {len(plans) // 2} of each"] if plans else []
            click.echo("\n".join(told))
    if not result.is_clean:
        raise TrialAbortedError(_what_went_wrong(result))


def _refuse_outputs(folder: Path, overwrite: bool, inputs: Sequence[Path | str | None]) -> None:
    """Refuse, before any work, a folder that must not be written, or that contains an input."""
    from pickcli.trial.trial_folder import NAMES, numbered_files, refuse_existing_folder

    refuse_existing_folder(folder, overwrite)
    outputs = [*(folder / name for name in NAMES), *numbered_files(folder)]
    refuse_same(*outputs)
    for path in outputs:
        refuse_reading(path, *inputs)


def _live(port: int) -> LivePage:
    """Start the server of the live page, and print its address."""
    from pickcli.page.live_page import LivePage

    live = LivePage(port)
    click.echo(f"watch the trial at {live.url}", err=True)
    return live


def _watched(live: LivePage, scene: Scene, several: Workcell | None) -> Callable[[TrialSnapshot], None]:
    """Return a function that offers a trial to the page; several: the cell, if several arms play."""
    from pickcli.page.html_page import page_bytes
    from pickcli.page.trial_page import trial_page

    def watch(snapshot: TrialSnapshot) -> None:
        live.update(lambda: page_bytes(trial_page(snapshot.record, scene, snapshot.motion(), several)))

    return watch


def _show(result: TrialResult) -> None:
    """Print the table and the score."""
    from pickcli.commands.output.trial_table import print_rows
    from pickcli.trial.trial_summary import rows, summary

    console = stdout_console()
    with console.capture() as captured:
        print_rows(console, rows(result))
        for line in summary(result):
            console.print(line, markup=False, highlight=False)
    click.echo("\n".join(line.rstrip() for line in captured.get().splitlines()))  # no trailing blanks


def _what_went_wrong(result: TrialResult) -> str:
    """Describe in one sentence why the trial was not clean."""
    if result.aborted:
        return f"{result.aborted}; see trial.json"
    collisions, violations = result.n_collisions, result.n_limit_violations
    return f"{collisions} collisions and {violations} limit violations; see trial.json"
