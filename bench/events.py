"""How far along the tool's path events fire from where they were resolved, whatever the robot does.

    python -m bench.events

The same picks are carried out by a robot that keeps up, lags ten times as far behind, pauses on the way and
runs at half its speed. Per robot: the largest distance in mm, and how many events were missed.
"""

from __future__ import annotations

import json
from typing import Any

from bench.paces import LAGGING, paused, slowed
from bench.warm import context, fresh_scene
from pickcli.errors import NoPlanError
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.simulation.execute import execute
from pickcli.simulation.servo import Servo
from pickcli.simulation.stream import Pace, full_speed
from pickcli.simulation.world import World

ROBOTS: dict[str, tuple[Servo, Pace]] = {
    "as planned": (Servo(), full_speed),
    "lagging": (LAGGING, full_speed),
    "paused": (Servo(), paused(1.0, 0.7)),
    "slowed": (Servo(), slowed(0.5)),
}
N_PICKS = 3


def measure(warm: PlanningContext | None = None) -> dict[str, Any]:
    """Largest distance and missed events by robot, over the first picks of a fresh order."""
    warm = warm or context()
    order, scene = fresh_scene(warm.cell, seed=0)
    home = warm.cell.configurations["home"]
    figures: dict[str, dict[str, float]] = {name: {"distance_mm": 0.0, "missed": 0} for name in ROBOTS}
    n_done = 0
    for target in order.work_order:
        try:
            plan = plan_pick(warm, scene, PickQuery(target.bin, target.item), Start(home.q, home.tool_state))
        except NoPlanError:
            continue
        for name, (servo, pace) in ROBOTS.items():
            run = execute(plan, World(scene, home.q, home.tool_state, servo=servo), pace=pace)
            worst = max((1e3 * fired.distance for fired in run.events), default=0.0)
            figures[name]["distance_mm"] = max(figures[name]["distance_mm"], worst)
            # After a stop (a lagging robot may lose the item) nothing more is due.
            figures[name]["missed"] += 0 if run.stopped else len(run.missed)
        n_done += 1
        if n_done == N_PICKS:
            break
    return figures


if __name__ == "__main__":
    print(json.dumps(measure(), indent=2))
