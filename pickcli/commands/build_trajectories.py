"""``apc build-trajectories``: Delft's database of coarse motions."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.options.build_options import BuildOptions, build_options
from pickcli.commands.options.option_types import NumberType
from pickcli.path_planning.planner_names import PlannerName
from pickcli.trajopt.trajectory_settings import TrajectorySettings

if TYPE_CHECKING:
    from pickcli.precompute.database_builder import TrajectoryReport


@click.command("build-trajectories", cls=Command)
@click.option("--tries", type=NumberType(1, 1000), default=TrajectorySettings.n_tries,
              show_default=True,
              help="Paths to plan for a pair if bending yields no fast motion.")  # fmt: skip
@build_options("trajectory database", TrajectorySettings, "path")
def command(tries: int, options: BuildOptions) -> None:
    """Offline: Delft's database of coarse motions.

    Timed motions between named configurations (section 1 of their paper). The fastest motion of a pair is
    bent until it is free; the planner is used only if that yields no fast one. Every motion is proven free
    and within its limits; pairs without one are reported. An interrupted build continues when the same
    command is given again.

    \b
    Example:
      apc build-trajectories --cell apc2016_delft -o trajectories.h5
    """
    from pickcli.precompute.artifact_files import make_trajectories
    from pickcli.roadmap.store import read_database

    cell, output = options.cell(), options.output
    settings = TrajectorySettings(PlannerName(options.planner), tries, options.iterations, seed=options.seed)
    with options.building("building the trajectories") as run_options:
        built = make_trajectories(cell, output, settings, run_options, options.overwrite)
    n_motions = len(read_database(output, cell))
    if options.as_json:
        emit_json(_summary(output, cell.fingerprint, n_motions, built))
    else:
        click.echo("\n".join(_lines(output, n_motions, built)))


def _summary(output: Path, fingerprint: str, n_motions: int, built: TrajectoryReport) -> dict[str, Any]:
    return {
        "path": str(output),
        "cell_fingerprint": fingerprint,
        "motions": n_motions,
        **built.summary(),
        "missing": _missing(built),
    }


def _lines(output: Path, n_motions: int, built: TrajectoryReport) -> list[str]:
    ratio = built.duration / built.lower_bound if built.lower_bound else 1.0
    total = f"{n_motions} motions, {built.duration:.1f} s in all"
    head = f"{output}: {total}, {ratio:.3f} times the bound of the slowest joints alone"
    return [head, *(f"no motion: {reason}" for reason in _missing(built))]


def _missing(built: TrajectoryReport) -> list[str]:
    return [f"{key.start} to {key.goal}, {key.payload}: {reason}" for key, reason in built.missing]
