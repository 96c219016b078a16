"""``apc plan-move``: a move of the empty tool (KTH's move primitive)."""

from __future__ import annotations

from pathlib import Path

import click

from pickcli.commands.arm_options import ArmRequest, arm_option, standing_option
from pickcli.commands.command import Command
from pickcli.commands.configuration_option import parse_configuration
from pickcli.commands.experience_session import experience_session, learn_option
from pickcli.commands.logs import stage
from pickcli.commands.options import json_option, output_option, refuse_output, seed_option
from pickcli.commands.planner import (
    CONFIGURATION,
    CONFIGURATION_HELP,
    artifact_options,
    deliver,
    load_planner,
    start_option,
    verify_option,
)
from pickcli.commands.scene_options import refuse_held, scene_or_cell_options, scene_or_empty


@click.command("plan-move", cls=Command)
@scene_or_cell_options
@start_option
@click.option("--to", "goal", metavar=CONFIGURATION, required=True, help=f"Goal: {CONFIGURATION_HELP}")
@arm_option("the preferred one of those that have both configurations")
@standing_option
@verify_option
@artifact_options
@learn_option
@seed_option
@json_option
@output_option("plan")
def command(
    scene_path: Path | None, cell_name: str | None, items_path: Path | None, start: str, goal: str,
    arm: str | None, standing: tuple[str, ...], no_verify: bool, roadmap: Path | None,
    trajectories: Path | None, learn: bool, seed: int, as_json: bool, output: Path, overwrite: bool,
) -> None:  # fmt: skip
    """Plan a move between two configurations.

    The primitive ``move`` of KTH (section IV): with the empty tool, in its state at the start. Without a
    scene the cell is empty. The plan is verified, and contains its certificate. Exit code 4 when the verifier
    rejects it, 5 when there is no plan; nothing is written then.

    \b
    Example:
      apc plan-move --scene scene.json --from home --to bin_C -o move.json
      apc plan-move --cell my_robot --from home --to parked -o move.json
      apc plan-move --cell my_baxter --arm left --standing right=home --from home --to parked -o move.json
    """
    from pickcli.api.arm_states import refuse_standing
    from pickcli.planning.move import plan_move
    from pickcli.planning.start_state import Start

    refuse_output(output, overwrite, scene_path, cell_name, items_path, roadmap, trajectories)
    scene = scene_or_empty(scene_path, cell_name, ArmRequest(arm, standing, (start, goal), items=items_path))
    refuse_held(scene, scene_path)
    q, tool_state = parse_configuration(scene.cell, start)
    q_goal, _ = parse_configuration(scene.cell, goal)
    with stage("reading of roadmap and trajectories"):
        planner = load_planner(scene.cell, roadmap, trajectories)
    begin = Start(q, tool_state or scene.cell.robot.tool.default_state)
    refuse_standing(scene, begin)
    with experience_session(planner, roadmap, trajectories, learn) as session:
        with stage("planning"):
            plan = plan_move(
                session.planner, scene, begin, q_goal, seed, f"move from {start} to {goal}", session.recorder
            )
        deliver(plan, scene, output, not no_verify, as_json, overwrite)
