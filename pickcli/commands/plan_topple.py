"""``apc plan-topple``: a push that turns an item over, planned, verified and written as a plan file."""

from __future__ import annotations

import click

from pickcli.commands.command import Command
from pickcli.commands.logs import stage
from pickcli.commands.operations.plan_verification import timed_certifier
from pickcli.commands.options.plan_options import PlanOptions, plan_options
from pickcli.commands.options.scene_options import scene_options


@click.command("plan-topple", cls=Command)
@scene_options
@click.option("--bin", "bin_name", metavar="PLACE", required=True,
              help="Bin, or open box such as a tote or crate, that contains the item.")  # fmt: skip
@click.option("--item", metavar="ITEM", required=True,
              help="Item to topple: its name, or its id in the scene (name#2).")  # fmt: skip
@plan_options("the preferred one of those that have the start")
def command(bin_name: str, item: str, options: PlanOptions) -> None:
    """Plan a push that topples an item in a box or bin, or pushes it off others.

    For items that no cup can take as they stand ("no face within reach"): the empty tool pushes the upper
    part of the item until it falls, so that a face that seals comes to lie on top. Look again before the next
    plan. The plan is verified, and contains its certificate. Exit code 5 when there is no plan, with every
    reason; nothing is written then.

    \b
    Example:
      apc plan-topple --scene scene.json --bin crate_left --item crayola_24_ct -o topple.json
    """
    from pickcli.planning.topple import TopplingQuery, plan_topple

    scene = options.scene()
    scene.cell.require_places()
    begin = options.begin(scene)
    query = TopplingQuery(bin_name, item)
    certify = None if options.no_verify else timed_certifier(scene)
    with options.session(scene.cell) as session:
        with stage("planning"):
            plan = plan_topple(session.context, scene, query, begin, options.seed, session.recorder, certify)
        options.deliver(plan, scene, is_judged=True)
