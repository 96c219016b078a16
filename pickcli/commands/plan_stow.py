"""``apc plan-stow``: one item out of the tote into a bin, planned, verified and written as a plan file."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.arm_options import ArmRequest, arm_option, standing_option
from pickcli.commands.command import Command
from pickcli.commands.experience_session import learn_option
from pickcli.commands.options import json_option, output_option, refuse_output, seed_option
from pickcli.commands.pick_request import PickRequest, plan_with_first_able
from pickcli.commands.planner import artifact_options, deliver, start_option, verify_option
from pickcli.commands.scene_options import open_scene, refuse_held, scene_options
from pickcli.commands.stated_stow import bins_for, item_in_tote, stated_bin

if TYPE_CHECKING:
    from pickcli.motion.plan import Plan
    from pickcli.planning.arm_choice import ArmSuitability
    from pickcli.scene.scene import Scene


@click.command("plan-stow", cls=Command)
@scene_options
@click.option("--item", metavar="ITEM", required=True,
              help="Item in the tote to stow: its name, or its id in the scene (name#2).")  # fmt: skip
@click.option("--into", metavar="PLACE",
              help="Destination: a bin.  [default: the one with most points of those that fit]")  # fmt: skip
@start_option
@arm_option("the preferred one of those that hold and reach the item")
@standing_option
@verify_option
@artifact_options
@learn_option
@seed_option
@json_option
@output_option("plan")
def command(
    scene_path: Path, cell_name: str | None, items_path: Path | None, item: str, into: str | None, start: str,
    arm: str | None, standing: tuple[str, ...], no_verify: bool, roadmap: Path | None,
    trajectories: Path | None, learn: bool, seed: int, as_json: bool, output: Path, overwrite: bool,
) -> None:  # fmt: skip
    """Plan to stow one item: out of the tote, and set down in a bin.

    Without --into the bins are tried in the order of apc explain-stow, as if the scene were the start of the
    task. The plan is verified, and contains its certificate; if it is rejected, the next candidate is tried.
    Exit code 5 when there is no plan, with every reason; nothing is written then.

    \b
    Example:
      apc plan-stow --scene scene.json --item dove_beauty_bar --into bin_H -o plan.json
    """
    from pickcli.planning.first_plan import first_plan
    from pickcli.planning.pick_problem import PickQuery
    from pickcli.scene.scene import TOTE

    refuse_output(output, overwrite, scene_path, cell_name, items_path, roadmap, trajectories)
    arms = ArmRequest(arm, standing, (start,), items=items_path)
    scene = open_scene(scene_path, cell_name, arms)
    scene.cell.require_pod_and_tote()
    refuse_held(scene, scene_path)
    placed = item_in_tote(scene, item, "--item", "apc plan-pick")
    bins = bins_for(scene, placed) if into is None else (stated_bin(scene, placed, into, "--into"),)
    query = PickQuery(TOTE, placed.id, bins[0])
    asked = PickRequest(query, start, seed, roadmap, trajectories, learn, not no_verify)

    def write(plan: Plan, scene: Scene, ranked: tuple[ArmSuitability, ...]) -> None:
        deliver(plan, scene, output, False, as_json, overwrite, ranked)

    def plan_into(name: str) -> None:
        plan_with_first_able(scene, arms, replace(asked, query=replace(asked.query, into=name)), write)

    first_plan(f"stow {placed.id}", [(name, partial(plan_into, name)) for name in bins])
