"""``apc build-roadmap``: KTH's roadmap."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

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

if TYPE_CHECKING:
    from pickcli.precompute.second_routes import SecondRoutes

PLANNERS = click.Choice([planner.value for planner in PlannerName])


@click.command("build-roadmap")
@cell_option
@click.option("--planner", type=PLANNERS, default="RRTstar", show_default=True, help="Planner of the edges.")
@click.option("--neighbours", type=click.IntRange(1, 100), default=6, show_default=True,
              help="k: edges are tried from each configuration to its k nearest.")  # fmt: skip
@click.option("--iterations", type=click.IntRange(1), default=3000, show_default=True,
              help="Most iterations of the planner for one edge.")  # fmt: skip
@jobs_option
@scheduler_option
@seed_option
@json_option
@output_option("roadmap")
def command(
    cell_name: str, planner: str, neighbours: int, iterations: int, jobs: int | None,
    scheduler: str | None, seed: int, as_json: bool, output: Path, overwrite: bool,
) -> None:  # fmt: skip
    """Offline: KTH's roadmap of the named configurations.

    Section IV of their paper. Every edge is proven free. Edges are added until important pairs (home, bins
    and camera poses to the tote; bins side by side) have a second route that shares no edge with the first.
    What is not free, has no path or has no second route is reported, with the reason. An interrupted build
    goes on when the same command is given again.

    \b
    Example:
      apc build-roadmap --cell apc2016_delft -o roadmap.h5
    """
    from pickcli.cell.load import load_cell
    from pickcli.precompute.edge_recipe import RoadmapSettings
    from pickcli.precompute.make import make_roadmap
    from pickcli.roadmap.store import read_roadmap

    refuse_output(output, overwrite)
    cell = load_cell(cell_name)
    settings = RoadmapSettings(PlannerName(planner), neighbours, iterations, seed=seed)
    with building("building the roadmap", output, jobs, as_json, scheduler) as means:
        built = make_roadmap(cell, output, settings, means)
    roadmap = read_roadmap(output, cell)
    summary = {
        "roadmap": str(output),
        "cell_fingerprint": cell.fingerprint,
        "nodes": roadmap.n_nodes,
        "edges": roadmap.n_edges,
        **built.summary(),
        "refused": [f"{name}: {reason}" for (name,), reason in built.gaps.refused],
        "missing": [f"{a} to {b}: {reason}" for (a, b), reason in built.gaps.missing],
        "without_second_route": [f"{a} to {b}: {reason}" for (a, b), reason in built.gaps.alone],
    }
    if as_json:
        emit_json(summary)
        return
    click.echo(f"{output}: {roadmap.n_nodes} nodes, {roadmap.n_edges} edges, k = {neighbours}, {planner}")
    for (name,), reason in built.gaps.refused:
        click.echo(f"not free: {name}: {reason}")
    for (a, b), reason in built.gaps.missing:
        click.echo(f"no edge: {a} to {b}: {reason.detail} (another --seed or more --iterations may find one)")
    for a, b in built.bridges:
        click.echo(f"joined on top of the k nearest: {a} to {b}")
    if built.n_components > 1:
        click.echo(f"the roadmap is in {built.n_components} parts that could not be joined")
    click.echo("\n".join(_route_lines(built.routes)))


def _route_lines(routes: SecondRoutes) -> list[str]:
    """Second routes of the important pairs: figures, what was added for them, and who has none."""
    told = routes.summary()
    longer = told["second_over_first_length"]
    head = f"second routes: {told['n_with_second_route']} of {told['n_important']} important pairs have one"
    if longer is not None:
        head += f", {longer['median']:.2f} times as long as the first in the median, "
        head += f"at most {longer['worst']:.2f} times ({longer['worst_pair']})"
    head += f"; {told['n_for_any_displaced_pod']} have one wherever the pod stands"
    added = [f"added for a second route: {a} to {b}" for a, b in routes.added]
    return [head, *added, *(f"no second route: {a} to {b}: {reason}" for (a, b), reason in routes.alone)]
