"""Coarse queries as plan-pick meets them, in random scenes, for us and as JSON for the peers.

Of every scene some targets: from a named configuration to in front of the bin with the empty tool, and with
the item from there to over the tote. Grasp, lines in the bin and spots in the tote are planned as in a pick;
of several goals the one counts that would take least time if nothing were in the way. A pick's first motion
may turn the cup on the way; here it starts where the cup is turned already, for not every peer knows a shape
that changes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from bench.peers.robot_model import robot_json, shape_json
from pickcli.cell.cell import Cell
from pickcli.cell.shapes import Shape
from pickcli.cell.tool import ToolState
from pickcli.collision.attached_item import AttachedItem
from pickcli.collision.checker import SceneChecker
from pickcli.collision.motion_segment import Mode
from pickcli.errors import Failures, InputError
from pickcli.geometry import Array
from pickcli.path_planning.path_cost import estimated_duration
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.planning_context import COARSE_RESERVE, PlanningContext
from pickcli.planning.stages.grasp_selection import feasible_grasps
from pickcli.planning.stages.placement import plan_placements
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import Scene
from pickcli.seeds import derived_rng, derived_seed
from pickcli.trial.order import Order
from pickcli.trial.order_file import read_order

ORDERS = ("jsk_pick_sample", "delft_pick_2", "delft_pick_3", "delft_pick_4", "delft_pick_5")
TASKS = Path(__file__).parents[2] / "data" / "tasks"
N_PICKS = 2  # per scene, two queries each


@dataclass(frozen=True, eq=False)
class Query:
    """One coarse query: from q_start (n,) to q_goal (n,) in one tool state."""

    name: str
    scene: int
    tool_state: ToolState
    held: AttachedItem | None
    without: frozenset[str]  # ids of items that are not in the world
    q_start: Array
    q_goal: Array
    checker: SceneChecker


def scenes(cell: Cell, count: int) -> Iterator[Scene]:
    """Random scenes: the pick orders of 2016 in turn, each time with another seed."""
    orders = [read_order(TASKS / f"{name}.json", cell) for name in ORDERS]
    for i in range(count):
        yield _scene(cell, orders[i % len(orders)], derived_seed("peers", i))


def _scene(cell: Cell, order: Order, seed: int) -> Scene:
    while True:
        try:
            return make_scene(order.bin_contents, cell, seed, order.year)
        except InputError:  # now and then items do not fit at rest
            seed += 1


def queries(context: PlanningContext, scene: Scene, number: int) -> list[Query]:
    """The queries of the scene of that number."""
    rng = derived_rng("peers", number)
    targets = [scene.items[i] for i in rng.permutation(len(scene.items))]
    found = (_of_pick(context, scene, number, target.id, rng) for target in targets)
    return [query for pick in islice((pick for pick in found if pick), N_PICKS) for query in pick]


def _of_pick(
    context: PlanningContext, scene: Scene, number: int, target: str, rng: np.random.Generator
) -> list[Query]:
    """The way to the item and the way with it; none where no grasp leads out of the bin and into the tote."""
    placed = scene.find(target)
    cell_bin = context.cell.pod.bins[placed.location]
    asked = PickProblem(context, scene, cell_bin, placed, context.cell.places["tote"], seed=number)
    feasible, _ = feasible_grasps(asked, ())
    if not feasible:
        return []
    tool_state = feasible[0].grasp.tool_state
    kin = [f for f in feasible if f.grasp.tool_state == tool_state]
    start = _start(context, scene, tool_state, rng)
    there = _nearest(context, start, [f.start for f in kin])
    chosen = kin[there]
    landings = next(plan_placements(asked, chosen))
    if isinstance(landings, Failures):
        return []
    out = chosen.end
    over = _nearest(context, out, [landing.start for landing in landings])
    transit = context.checker_for(scene, Mode(tool_state, reserve=COARSE_RESERVE))
    gone = frozenset({target})
    carrying = Mode(tool_state, chosen.attached, asked.contacts.while_transferring(), COARSE_RESERVE)
    transfer = context.checker_for(scene, carrying)
    to, above, held = chosen.start, landings[over].start, chosen.attached
    made = [
        Query(f"{number} to {target}", number, tool_state, None, frozenset(), start, to, transit),
        Query(f"{number} with {target}", number, tool_state, held, gone, out, above, transfer),
    ]
    return [q for q in made if q.checker.is_valid(q.q_start) and q.checker.is_valid(q.q_goal)]


def _start(context: PlanningContext, scene: Scene, tool_state: ToolState, rng: np.random.Generator) -> Array:
    """One of the named configurations that a pick starts from, meant for that state of the cup, and free."""
    checker = context.checker_for(scene, Mode(tool_state, reserve=COARSE_RESERVE))
    named = [c.q for c in context.cell.configurations.values() if c.tool_state == tool_state]
    free = [q for q in named if checker.is_valid(q)]
    return free[int(rng.integers(len(free)))]


def _nearest(context: PlanningContext, q: Array, goals: list[Array]) -> int:
    """Index of the goal that would take least time if nothing were in the way."""
    return int(np.argmin([estimated_duration(context.space, np.stack([q, goal])) for goal in goals]))


def exchange(cell: Cell, in_scenes: list[Scene], asked: list[Query], time_limit: float) -> dict[str, Any]:
    """All queries for the peers, as JSON values. Lengths in m, angles in rad, times in s.

    margin: by which the solids of the world are to be grown
    """
    return {
        "joint_names": list(cell.robot.joint_names),
        "lower": cell.robot.limits.lower.tolist(),
        "upper": cell.robot.limits.upper.tolist(),
        "margin": cell.clearance + COARSE_RESERVE,
        "time_limit": time_limit,
        "scenes": [_world(scene) for scene in in_scenes],
        "queries": [
            {
                "scene": query.scene,
                "without": sorted(query.without),
                "robot": robot_json(cell, query.tool_state, query.held),
                "start": query.q_start.tolist(),
                "goal": query.q_goal.tolist(),
            }
            for query in asked
        ],
    }


def _world(scene: Scene) -> list[dict[str, Any]]:
    solids = [_solid(body.name, body.shape, T @ body.T_parent_shape) for body, T in scene.standing]
    return solids + [_solid(placed.id, placed.item.shape, placed.T_world_item) for placed in scene.items]


def _solid(name: str, shape: Shape, T: Array) -> dict[str, Any]:
    return {"name": name, **shape_json(shape, T)}
