"""``apc plan-pick``: one pick, planned, verified and written as a plan file."""

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


@click.command("plan-pick")
@scene_option
@click.option("--bin", "bin_name", required=True, help="Bin to pick from, e.g. bin_C.")
@click.option("--item", required=True, help="Item name, or instance id of the scene (name#2).")
@click.option(
    "--from",
    "start",
    default="home",
    show_default=True,
    help="Named configuration, or q as numbers with commas.",
)
@click.option("--neighbours", type=click.Choice(["avoid", "ignore"]), default="avoid", show_default=True,
              help="avoid other items in the bin (Delft), or ignore them (KTH).")  # fmt: skip
@artifact_options
@seed_option
@json_option
@output_option(what="plan")
def command(
    scene_path: Path, bin_name: str, item: str, start: str, neighbours: str, roadmap: Path | None,
    trajectories: Path | None, seed: int, as_json: bool, output: Path, overwrite: bool,
) -> None:  # fmt: skip
    """Plan one pick: from leaving for the bin to the item released in the tote.

    \b
    Example:
      apc plan-pick --scene scene.json --bin bin_C --item dove_beauty_bar -o plan.json
    """
    from pickcli.cell.scene_file import read_scene
    from pickcli.motion.plan_file import write_plan
    from pickcli.planning.pick import Start, plan_pick
    from pickcli.planning.settings import Neighbours

    refuse_existing(output, overwrite)
    scene = read_scene(scene_path)
    planner = load_planner(scene.cell, roadmap, trajectories)
    q, pivot = parse_configuration(scene.cell, start)
    plan = plan_pick(planner, scene, bin_name, item, Start(q, pivot), seed, neighbours=Neighbours(neighbours))
    write_plan(plan, output)
    summary = report_plan(plan, output)
    if as_json:
        emit_json(summary)
    else:
        click.echo("\n".join(f"{key:>22}: {value}" for key, value in summary.items()))
