"""``apc build-roadmap``: KTH's roadmap."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.options.build_options import BuildOptions, build_options
from pickcli.commands.options.option_types import NumberType, RenamedOption
from pickcli.path_planning.planner_names import PlannerName
from pickcli.precompute.roadmap_settings import RoadmapSettings

if TYPE_CHECKING:
    from pickcli.precompute.roadmap_builder import RoadmapReport
    from pickcli.precompute.route_redundancy import RouteRedundancy
    from pickcli.roadmap.graph import Roadmap


@click.command("build-roadmap", cls=Command)
@click.option("--nearest", cls=RenamedOption, old=("--neighbours",), type=NumberType(1, 100),
              default=RoadmapSettings.n_neighbours, show_default=True,
              help="k: edges are tried from each configuration to its k nearest.")  # fmt: skip
@build_options("roadmap", RoadmapSettings, "edge")
def command(nearest: int, options: BuildOptions) -> None:
    """Offline: KTH's roadmap of the named configurations.

    Section IV of their paper. Every edge is proven free. Edges are added until important pairs (home, bins
    and camera poses to the tote; bins side by side) have a second route that shares no edge with the first.
    Configurations that are not free, and pairs without a path or a second route, are reported with the
    reason. An interrupted build continues when the same command is given again.

    \b
    Example:
      apc build-roadmap --cell apc2016_delft -o roadmap.h5
    """
    from pickcli.precompute.artifact_files import make_roadmap
    from pickcli.roadmap.store import read_roadmap

    cell, output = options.cell(), options.output
    settings = RoadmapSettings(PlannerName(options.planner), nearest, options.iterations, seed=options.seed)
    with options.building("building the roadmap") as run_options:
        built = make_roadmap(cell, output, settings, run_options, options.overwrite)
    roadmap = read_roadmap(output, cell)
    if options.as_json:
        emit_json(_summary(output, cell.fingerprint, roadmap, built))
    else:
        click.echo("\n".join(_lines(output, roadmap, built)))


def _summary(output: Path, fingerprint: str, roadmap: Roadmap, built: RoadmapReport) -> dict[str, Any]:
    gaps = built.gaps
    return {
        "path": str(output),
        "cell_fingerprint": fingerprint,
        "nodes": roadmap.n_nodes,
        "edges": roadmap.n_edges,
        **built.summary(),
        "refused": [f"{name}: {reason}" for (name,), reason in gaps.refused],
        "missing": [f"{a} to {b}: {reason}" for (a, b), reason in gaps.missing],
        "without_second_route": [f"{a} to {b}: {reason}" for (a, b), reason in gaps.without_second_route],
    }


def _lines(output: Path, roadmap: Roadmap, built: RoadmapReport) -> list[str]:
    """Describe the roadmap, its gaps and its additional edges."""
    settings, gaps, more = built.settings, built.gaps, "another --seed or more --iterations may find one"
    counts = f"{roadmap.n_nodes} nodes, {roadmap.n_edges} edges"
    lines = [f"{output}: {counts}, k = {settings.n_neighbours}, {settings.planner}"]
    lines += [f"not free: {name}: {reason}" for (name,), reason in gaps.refused]
    lines += [f"no edge: {a} to {b}: {reason.detail} ({more})" for (a, b), reason in gaps.missing]
    lines += [f"joined on top of the k nearest: {a} to {b}" for a, b in built.bridges]
    if built.n_components > 1:
        lines.append(f"the roadmap is in {built.n_components} parts that could not be joined")
    return lines + _route_lines(built.routes)


def _route_lines(routes: RouteRedundancy) -> list[str]:
    """Describe the second routes of the critical pairs: numbers, added edges, and pairs without one."""
    summary = routes.summary()
    longer = summary["second_over_first_length"]
    n, n_second = summary["n_important"], summary["n_with_second_route"]
    head = f"second routes: {n_second} of {n} important pairs have one"
    if longer is not None:
        head += f", {longer['median']:.2f} times as long as the first in the median, "
        head += f"at most {longer['worst']:.2f} times ({longer['worst_pair']})"
    head += f"; {summary['n_for_any_displaced_pod']} have one wherever the pod stands"
    added = [f"added for a second route: {a} to {b}" for a, b in routes.added]
    missing = [f"no second route: {a} to {b}: {reason}" for (a, b), reason in routes.without_second_route]
    return [head, *added, *missing]
