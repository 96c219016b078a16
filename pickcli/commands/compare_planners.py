"""``apc compare-planners``: a benchmark of planners on the same pairs."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.arm_options import (
    ArmRequest,
    arm_option,
    open_alike,
    open_cell,
    standing_option,
)
from pickcli.commands.options.common_options import CELL_HELP, DEFAULT_CELL, json_option, seed_option
from pickcli.commands.options.option_types import PATH, NumberType
from pickcli.commands.output.progress_bar import progress
from pickcli.commands.output.table import table_lines
from pickcli.errors import InputError, UnknownNameError
from pickcli.path_planning.planner_names import PlannerName

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.planner_benchmark.benchmark_entries import BenchmarkEntry, BenchmarkQuery
    from pickcli.planner_benchmark.benchmark_summary import NamePair, PlannerSummary
    from pickcli.planner_benchmark.stream_queries import StreamQueries
    from pickcli.roadmap.trajectory_database import PayloadClass

SEARCH, ARA_STAR, ARA_STAR_FIRST = "search", "ARA*", "ARA*-first"
GEOMETRIC = (
    PlannerName.RRT_CONNECT,
    PlannerName.OMPL_RRT_CONNECT,
    PlannerName.RRT_STAR,
    PlannerName.AO_RRT_CONNECT,
)
DEFAULT = ",".join([*GEOMETRIC, SEARCH])
ON_STREAM = ",".join([*GEOMETRIC, ARA_STAR_FIRST, ARA_STAR])
HEAD = ("planner", "solved", "planning ms", "p95", "whole ms", "p95", "as found", "length", "duration s",
        "x bound", "best x bound", "cost bound", "worst")  # fmt: skip
PAYLOADS = click.Choice(["empty", "cube", "centred cube"], case_sensitive=False)


@click.command("compare-planners", cls=Command)
@click.option("--cell", "cell_name", metavar="NAME|FOLDER",
              help=f"{CELL_HELP}  [default: {DEFAULT_CELL}; with --stream that of the stream]")  # fmt: skip
@arm_option()
@standing_option
@click.option(
    "--pairs",
    metavar="A:B,...",
    help="Pairs of configurations.  [default: Delft's pairs whose line is blocked]",
)
@click.option("--stream", "stream_path", type=PATH, metavar="FILE",
              help="Instead of pairs: to the pregrasps of a stream's items.")  # fmt: skip
@click.option("--payload", type=PAYLOADS, default="empty", show_default=True, help="Payload in the cup.")
@click.option("--planners", metavar="NAME,...",
              help=f"Planners to compare; {SEARCH!r} is that of the database.  "
                   f"[default: {DEFAULT}; with --stream {ON_STREAM}]")  # fmt: skip
@click.option("--tries", type=NumberType(1, 1000), default=3, show_default=True,
              help="Runs of each planner for each pair, each with its own seed.")  # fmt: skip
@click.option("--iterations", type=NumberType(1), default=3000, show_default=True,
              help=f"Maximum iterations of a planner for one path, except {SEARCH!r} and ARA*.")  # fmt: skip
@click.option("--expansions", type=NumberType(1), default=300, show_default=True,
              help="Maximum expansions of ARA* for one path.")  # fmt: skip
@seed_option
@json_option
def command(
    cell_name: str | None, arm: str | None, standing: tuple[str, ...], pairs: str | None,
    stream_path: Path | None, payload: str, planners: str | None, tries: int, iterations: int,
    expansions: int, seed: int, as_json: bool,
) -> None:  # fmt: skip
    """Compare planners on the same queries: time, length, duration, share solved.

    RRT-Connect (Delft) in the kernel and by OMPL, RRT* (KTH), AORRTC, our own minimum-time search, and ARA*
    (the PR2 at its conveyor, 2013) with its proven bound on the cost. If the straight line is free, all but
    ARA* take it, so by default only pairs with a blocked line are tried.

    \b
    Example:
      apc compare-planners --pairs bin_A:tote,cam_D:drop_00_down --tries 5
      apc compare-planners --stream stream.json --arm left --tries 1
    """
    from pickcli.planner_benchmark.planner_benchmark import compare_queries
    from pickcli.roadmap.trajectory_database import PayloadClass

    arms, load = ArmRequest(arm, standing), PayloadClass(payload)
    names = planners or (DEFAULT if stream_path is None else ON_STREAM)
    contestants = _contestants(names, iterations, expansions)
    if stream_path is None:
        cell, asked = _of_pairs(pairs, cell_name or DEFAULT_CELL, arms, load)
        without: dict[str, str] = {}
    else:
        _refuse_beside_stream(pairs, load, names)
        cell, found = _of_stream(stream_path, cell_name, arms, seed)
        asked, without = found.queries, found.without
    label = "stream" if stream_path else str(load)
    with stage("comparison"), progress("comparing planners") as report:
        done = compare_queries(asked, contestants, label=label, n_tries=tries, seed=seed, on_progress=report)
    if as_json:
        given = {"payload": payload, "tries": tries, "iterations": iterations, "expansions": expansions,
                 "seed": seed, "without_pregrasp": without}  # fmt: skip
        emit_json({"cell_fingerprint": cell.fingerprint, **given, **done.values()})
        return
    own = f" ({SEARCH}: its own)" if SEARCH in names.split(",") else ""
    most = f"at most {iterations} iterations{own}"
    if {ARA_STAR, ARA_STAR_FIRST} & {*names.split(",")}:
        most += f", {expansions} expansions of ARA*"
    click.echo(
        f"{len(asked)} pairs, {tries} {'try' if tries == 1 else 'tries'} each, payload {payload}, {most}"
    )
    for item, why in without.items():
        click.echo(f"{item} has no pregrasp in the middle of the window: {why}")
    click.echo(f"lengths and durations: the {len(done.common)} pairs that all solved, median try of each")
    click.echo("\n".join(table_lines(HEAD, [_row(standing) for standing in done.standings])))


def _refuse_beside_stream(pairs: str | None, payload: PayloadClass, planners: str) -> None:
    """Refuse what has no meaning with --stream. Raises UsageError, and InputError for a planner."""
    if pairs is not None:
        raise click.UsageError("name pairs with --pairs or a stream with --stream, not both")
    if str(payload) != "empty":
        raise click.UsageError("--payload: to a pregrasp the tool goes empty; leave --payload out")
    if SEARCH in planners.split(","):
        raise InputError(f"--planners: {SEARCH!r} knows one goal only, pregrasps are several; leave it out")


def _of_pairs(
    pairs: str | None, cell_name: str, arms: ArmRequest, payload: PayloadClass
) -> tuple[Cell, dict[NamePair, BenchmarkQuery]]:
    """Load a cell and return it with the queries of pairs. Raises InputError."""
    from pickcli.planner_benchmark.planner_benchmark import blocked_pairs, pair_queries

    cell = open_cell(cell_name, arms)
    cell.require_places()
    chosen = blocked_pairs(cell, payload) if pairs is None else _pairs(pairs)
    return cell, pair_queries(cell, chosen, payload)


def _of_stream(path: Path, cell_name: str | None, arms: ArmRequest, seed: int) -> tuple[Cell, StreamQueries]:
    """Read a stream and return the cell and the queries. Raises InputError and StaleError."""
    from pickcli.planner_benchmark.stream_queries import stream_queries
    from pickcli.planning.planning_context import PlanningContext
    from pickcli.scene.stream_file import read_stream

    with stage("reading of the stream"):
        cell = None if cell_name is None else open_alike(cell_name, arms)
        stream = read_stream(path, cell, partial(open_alike, request=arms))
    with stage("pregrasps"):
        return stream.cell, stream_queries(PlanningContext(stream.cell), stream, seed)


def _pairs(text: str) -> list[tuple[str, str]]:
    """Parse pairs of names. Raises InputError."""
    pairs = [tuple(part.split(":")) for part in text.split(",")]
    wrong = next((":".join(pair) for pair in pairs if len(pair) != 2 or "" in pair), None)
    if wrong is not None:
        raise InputError(f"--pairs: {wrong!r} is not a pair; write A:B,C:D with names of configurations")
    return [(pair[0], pair[1]) for pair in pairs]


def _contestants(text: str, iterations: int, expansions: int) -> list[BenchmarkEntry]:
    """Return the planners named by --planners. Raises InputError for an unknown name."""
    from pickcli.planner_benchmark.benchmark_entries import GeometricEntry, MinimumTimeEntry
    from pickcli.planner_benchmark.lattice_entry import LatticeEntry
    from pickcli.trajopt.trajectory_settings import TrajectorySettings

    known = [*map(str, PlannerName), ARA_STAR, ARA_STAR_FIRST, SEARCH]
    names = list(dict.fromkeys(text.split(",")))
    wrong = next((name for name in names if name not in known), None)
    if wrong is not None:
        raise UnknownNameError("planner", wrong, known, "--planners")

    def entry(name: str) -> BenchmarkEntry:
        if name == SEARCH:
            return MinimumTimeEntry(TrajectorySettings())
        if name in (ARA_STAR, ARA_STAR_FIRST):
            return LatticeEntry(expansions, name == ARA_STAR_FIRST)
        return GeometricEntry(PlannerName(name), iterations)

    return [entry(name) for name in names]


def _row(standing: PlannerSummary) -> list[str]:
    seconds = (*standing.planning, *standing.whole)
    return [
        standing.planner, f"{standing.solved:.1%}", *(f"{1e3 * s:.1f}" for s in seconds),
        f"{standing.found:.2f}", f"{standing.length:.2f}",
        f"{standing.duration:.3f}", f"{standing.ratio:.3f}", f"{standing.best_ratio:.3f}",
        *("-" if math.isnan(bound) else f"{bound:.3f}" for bound in standing.cost_bound),
    ]  # fmt: skip
