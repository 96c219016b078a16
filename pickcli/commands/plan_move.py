"""``apc plan-move``: a move of the empty tool (KTH's move primitive)."""

from __future__ import annotations

import click

from pickcli.commands.command import Command
from pickcli.commands.logs import stage
from pickcli.commands.options.configuration_option import (
    CONFIGURATION,
    CONFIGURATION_HELP,
    named_state,
    parse_configuration,
)
from pickcli.commands.options.plan_options import PlanOptions, plan_options
from pickcli.commands.options.scene_options import scene_or_cell_options


@click.command("plan-move", cls=Command)
@scene_or_cell_options
@click.option("--to", "goal", metavar=CONFIGURATION, required=True, help=f"Goal: {CONFIGURATION_HELP}")
@click.option("--tool-state", metavar="STATE", default=None, show_default="that of the start",
              help="State of the tool at the goal, e.g. straight.")  # fmt: skip
@plan_options("the preferred one of those that have both configurations")
def command(goal: str, tool_state: str | None, options: PlanOptions) -> None:
    """Plan a move between two configurations.

    The primitive ``move`` of KTH (section IV), of the empty tool. With --tool-state the tool changes its
    state while the arm moves, if all of the motion is free in every state, else at rest where that is free.
    Without a scene the cell is empty. The plan is verified, and contains its certificate. Exit code 4 when
    the verifier rejects it, 5 when there is no plan; nothing is written then.

    \b
    Example:
      apc plan-move --scene scene.json --from home --to bin_C -o move.json
      apc plan-move --scene scene.json --from bin_C --to home --tool-state down -o back.json
      apc plan-move --cell my_robot --from home --to parked -o park.json
      apc plan-move --cell my_baxter --arm left --standing right=home --from home --to parked -o left.json
    """
    from pickcli.planning.move import MoveGoal, plan_move

    scene = options.scene(goal)
    q_goal, _ = parse_configuration(scene.cell, goal)
    end = MoveGoal(q_goal, None if tool_state is None else named_state(scene.cell, tool_state))
    begin = options.begin(scene)
    label = f"move from {options.start} to {goal}"
    with options.session(scene.cell) as session:
        with stage("planning"):
            plan = plan_move(session.context, scene, begin, end, options.seed, label, session.recorder)
        options.deliver(plan, scene)
