"""``apc compare-planners``: a benchmark of planners on the same pairs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from pickcli.commands.arm_options import ArmRequest, arm_option, open_cell, standing_option
from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.option_types import NumberType
from pickcli.commands.options import cell_option, json_option, seed_option
from pickcli.commands.progress_bar import progress
from pickcli.commands.table import table_lines
from pickcli.errors import InputError, UnknownNameError
from pickcli.path_planning.planner_names import PlannerName

if TYPE_CHECKING:
    from pickcli.planner_benchmark.benchmark_entries import BenchmarkEntry
    from pickcli.planner_benchmark.benchmark_summary import PlannerSummary

SEARCH = "search"
GEOMETRIC = (
    PlannerName.RRT_CONNECT,
    PlannerName.OMPL_RRT_CONNECT,
    PlannerName.RRT_STAR,
    PlannerName.AO_RRT_CONNECT,
)
DEFAULT = ",".join([*GEOMETRIC, SEARCH])
HEAD = ("planner", "solved", "planning ms", "p95", "whole ms", "p95", "as found", "length", "duration s",
        "x bound", "best x bound")  # fmt: skip
PAYLOADS = click.Choice(["empty", "cube", "centred cube"], case_sensitive=False)


@click.command("compare-planners", cls=Command)
@cell_option
@arm_option()
@standing_option
@click.option(
    "--pairs",
    metavar="A:B,...",
    help="Pairs of configurations.  [default: Delft's pairs whose line is blocked]",
)
@click.option("--payload", type=PAYLOADS, default="empty", show_default=True, help="Payload in the cup.")
@click.option("--planners", default=DEFAULT, show_default=True, metavar="NAME,...",
              help=f"Planners to compare; {SEARCH!r} is that of the database.")  # fmt: skip
@click.option("--tries", type=NumberType(1, 1000), default=3, show_default=True,
              help="Runs of each planner for each pair, each with its own seed.")  # fmt: skip
@click.option("--iterations", type=NumberType(1), default=3000, show_default=True,
              help=f"Maximum iterations of a planner for one path, except {SEARCH!r}.")  # fmt: skip
@seed_option
@json_option
def command(
    cell_name: str, arm: str | None, standing: tuple[str, ...],
    pairs: str | None, payload: str, planners: str, tries: int, iterations: int, seed: int,
    as_json: bool,
) -> None:  # fmt: skip
    """Compare planners on the same pairs: planning time, length, duration, share solved.

    RRT-Connect (Delft) in the kernel and by OMPL, RRT* (KTH), AORRTC and our own minimum-time search. If the
    straight line is free, all take it, so by default only pairs with a blocked line are tried.

    \b
    Example:
      apc compare-planners --pairs bin_A:tote,cam_D:drop_00_down --tries 5
    """
    from pickcli.planner_benchmark.planner_benchmark import blocked_pairs, compare
    from pickcli.roadmap.trajectory_database import PayloadClass

    cell, load = open_cell(cell_name, ArmRequest(arm, standing)), PayloadClass(payload)
    cell.require_places()
    chosen = blocked_pairs(cell, load) if pairs is None else _pairs(pairs)
    contestants = _contestants(planners, iterations)
    with stage("comparison"), progress("comparing planners") as report:
        done = compare(cell, chosen, contestants, payload=load, n_tries=tries, seed=seed, on_progress=report)
    if as_json:
        given = {"payload": payload, "tries": tries, "iterations": iterations, "seed": seed}
        emit_json({"cell_fingerprint": cell.fingerprint, **given, **done.values()})
        return
    own = f" ({SEARCH}: its own)" if SEARCH in planners.split(",") else ""
    most = f"at most {iterations} iterations{own}"
    click.echo(f"{len(chosen)} pairs, {tries} tries each, payload {payload}, {most}")
    click.echo(f"lengths and durations: the {len(done.common)} pairs that all solved, median try of each")
    click.echo("\n".join(table_lines(HEAD, [_row(standing) for standing in done.standings])))


def _pairs(text: str) -> list[tuple[str, str]]:
    """Parse pairs of names. Raises InputError."""
    pairs = [tuple(part.split(":")) for part in text.split(",")]
    wrong = next((":".join(pair) for pair in pairs if len(pair) != 2 or "" in pair), None)
    if wrong is not None:
        raise InputError(f"--pairs: {wrong!r} is not a pair; write A:B,C:D with names of configurations")
    return [(pair[0], pair[1]) for pair in pairs]


def _contestants(text: str, iterations: int) -> list[BenchmarkEntry]:
    """Return the planners named by --planners. Raises InputError for an unknown name."""
    from pickcli.planner_benchmark.benchmark_entries import GeometricEntry, MinimumTimeEntry
    from pickcli.trajopt.trajectory_settings import TrajectorySettings

    known = [*map(str, PlannerName), SEARCH]
    names = list(dict.fromkeys(text.split(",")))
    wrong = next((name for name in names if name not in known), None)
    if wrong is not None:
        raise UnknownNameError("planner", wrong, known, "--planners")
    return [
        MinimumTimeEntry(TrajectorySettings())
        if name == SEARCH
        else GeometricEntry(PlannerName(name), iterations)
        for name in names
    ]


def _row(standing: PlannerSummary) -> list[str]:
    seconds = (*standing.planning, *standing.whole)
    return [
        standing.planner, f"{standing.solved:.1%}", *(f"{1e3 * s:.1f}" for s in seconds),
        f"{standing.found:.2f}", f"{standing.length:.2f}",
        f"{standing.duration:.3f}", f"{standing.ratio:.3f}", f"{standing.best_ratio:.3f}",
    ]  # fmt: skip
