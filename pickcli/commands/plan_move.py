"""``apc plan-move``: KTH's move primitive."""

from __future__ import annotations

from pathlib import Path

import click

from pickcli.commands.options import (
    emit_json,
    json_option,
    output_option,
    refuse_existing,
    scene_option,
    seed_option,
)
from pickcli.commands.planner import artifact_options, load_planner, parse_configuration, report_plan


@click.command("plan-move")
@scene_option
@click.option("--from", "start", required=True, help="Named configuration, or q as numbers with commas.")
@click.option("--to", "goal", required=True, help="Named configuration, or q as numbers with commas.")
@artifact_options
@seed_option
@json_option
@output_option(what="plan")
def command(
    scene_path: Path, start: str, goal: str, roadmap: Path | None, trajectories: Path | None,
    seed: int, as_json: bool, output: Path, overwrite: bool,
) -> None:  # fmt: skip
    """Plan a move with the empty tool (KTH, section IV: the primitive ``move``).

    \b
    Example:
      apc plan-move --scene scene.json --from home --to bin_C -o move.json
    """
    from pickcli.cell.scene_file import read_scene
    from pickcli.motion.plan_file import write_plan
    from pickcli.planning.move import plan_move
    from pickcli.planning.pick import Start

    refuse_existing(output, overwrite)
    scene = read_scene(scene_path)
    planner = load_planner(scene.cell, roadmap, trajectories)
    q, pivot = parse_configuration(scene.cell, start)
    q_goal, _ = parse_configuration(scene.cell, goal)
    plan = plan_move(planner, scene, Start(q, pivot), q_goal, seed, label=f"move from {start} to {goal}")
    write_plan(plan, output)
    summary = report_plan(plan, output)
    if as_json:
        emit_json(summary)
    else:
        click.echo("\n".join(f"{key:>22}: {value}" for key, value in summary.items()))
