"""``apc build-trajectories``: Delft's database of coarse motions."""

from __future__ import annotations

from pathlib import Path

import click

from pickcli.commands.building import building, jobs_option, scheduler_option
from pickcli.commands.options import (
    cell_option,
    json_option,
    output_option,
    refuse_output,
    seed_option,
)
from pickcli.commands.report import emit_json
from pickcli.roadmap.planners import PlannerName

PLANNERS = click.Choice([planner.value for planner in PlannerName])


@click.command("build-trajectories")
@cell_option
@click.option(
    "--planner", type=PLANNERS, default="RRTConnect", show_default=True, help="Planner of the paths."
)
@click.option("--tries", type=click.IntRange(1, 1000), default=8, show_default=True,
              help="Paths per pair that compete; the fastest is kept.")  # fmt: skip
@click.option("--iterations", type=click.IntRange(1), default=5000, show_default=True,
              help="Most iterations of the planner for one try.")  # fmt: skip
@jobs_option
@scheduler_option
@seed_option
@json_option
@output_option("trajectory database")
def command(
    cell_name: str, planner: str, tries: int, iterations: int, jobs: int | None,
    scheduler: str | None, seed: int, as_json: bool, output: Path, overwrite: bool,
) -> None:  # fmt: skip
    """Offline: Delft's database of coarse motions.

    Timed motions between named configurations (section 1 of their paper). Every motion is proven free,
    corners included, and within its limits; pairs without one are reported. An interrupted
    build goes on when the same command is given again.

    \b
    Example:
      apc build-trajectories --cell apc2016_delft -o trajectories.h5
    """
    from pickcli.cell.load import load_cell
    from pickcli.precompute.coarse_motion import TrajectorySettings
    from pickcli.precompute.make import make_trajectories
    from pickcli.roadmap.store import read_database

    refuse_output(output, overwrite)
    cell = load_cell(cell_name)
    settings = TrajectorySettings(PlannerName(planner), tries, max_iterations=iterations, seed=seed)
    with building("building the trajectories", output, jobs, as_json, scheduler) as means:
        built = make_trajectories(cell, output, settings, means)
    n_motions = len(read_database(output, cell))
    summary = {
        "trajectories": str(output),
        "cell_fingerprint": cell.fingerprint,
        "motions": n_motions,
        **built.summary(),
        "missing": [f"{key.start} to {key.goal}, {key.payload}: {reason}" for key, reason in built.missing],
    }
    if as_json:
        emit_json(summary)
        return
    ratio = built.duration / built.lower_bound if built.lower_bound else 1.0
    click.echo(
        f"{output}: {n_motions} motions, {built.duration:.1f} s in all, {ratio:.3f} times the bound of "
        "the slowest joints alone"
    )
    for key, reason in built.missing:
        click.echo(f"no motion: {key.start} to {key.goal}, {key.payload}: {reason}")
