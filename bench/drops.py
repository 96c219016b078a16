"""How near what is dropped comes to cup and lance while these leave.

    python -m bench.drops [--totes 6] [--seed 0] [--items 14] [--json FILE]

A tote is filled with the items of a fresh scene in random order, each by the plan that it has as it is seen.
Only the release is played: from when the cup is vented the item falls and the tool moves as planned. What
lands on an edge turns over, and its other end comes up: told is the least distance from the tool to the item
from ``APART`` on, and to what lay in the tote before. A trial meets a handful of such releases, and takes a
minute for each.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bench.warm import fresh_scene, planner
from pickcli.cell.cell import Cell
from pickcli.errors import NoPlanError
from pickcli.geometry import Array, inverse
from pickcli.motion.plan import Plan
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, PlacedItem, Scene
from pickcli.seeds import derived_rng, derived_seed
from pickcli.simulation.colours import STATIC_COLOURS, item_colour
from pickcli.simulation.engine import Engine
from pickcli.simulation.reality import Reality
from pickcli.simulation.suction import RELEASE_VACUUM
from pickcli.simulation.vacuum import FULL_VACUUM, VENT_TIME
from pickcli.simulation.world import TIME_STEP
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive
from pickcli.verification.contact_exemptions import releases
from pickcli.verification.fcl_solids import Solid
from pickcli.verification.forward_kinematics import T_lance_cup, cup_position
from pickcli.verification.held_pose import pose_in_tool

APART = 0.06  # s after the release: until then the item is only just off the cup
WATCHED = 0.4  # s
SETTLED = 1.0  # s, on top of that
LOOK = 5  # time steps between two looks at the distance
FAR = 0.1  # m: what stays farther away is of no interest


@dataclass(frozen=True)
class Drop:
    """One release.

    Attributes:
        item: Its id.
        n_below: Number of items in the tote before.
        tool_state: State of the tool.
        to_item: m, least distance of the tool to the item.
        to_others: m, the same to what lay there before.
    """

    item: str
    n_below: int
    tool_state: str
    to_item: float
    to_others: float


class _Tool:
    """Cup and lance as exact solids.

    Args:
        cell: Gives the robot.
        plan: Gives the state of the tool.
    """

    def __init__(self, cell: Cell, plan: Plan) -> None:
        assert plan.grasp is not None
        robot, tool = cell.robot, cell.robot.tool
        T_tip_cup = inverse(tool.T_cup_tip)
        T_tip_lance = T_tip_cup @ inverse(T_lance_cup(robot, cup_position(robot, plan.grasp.tool_state)))
        links = ((tool.cup_link, T_tip_cup), (tool.lance_link, T_tip_lance))
        self._parts = [
            (T_tip_link @ body.T_parent_shape, Solid(body.shape))
            for link, T_tip_link in links
            for body in robot.link(link).shapes
        ]

    def distance(self, T_world_tip: Array, items: Sequence[PlacedItem]) -> float:
        """Least distance to any of some items, m; at most ``FAR``."""
        least = FAR
        for T_tip_part, solid in self._parts:
            solid.place(T_world_tip @ T_tip_part)
            for placed in items:
                other = Solid(placed.item.shape)
                other.place(placed.T_world_item)
                least = min(least, solid.distance(other))
        return least


def fill(warm: PlanningContext, scene: Scene, seed: int, most: int) -> Iterator[Drop]:
    """Drop items of a scene into its tote, one after the other.

    Args:
        warm: The planner.
        scene: Items in their bins, and an empty tote.
        seed: Of their order, and of how they are seen.
        most: Number of items.

    Yields:
        Every release.
    """
    engine = Engine(TIME_STEP)
    for body in warm.cell.tote.bodies:
        engine.add_static(body, np.eye(4), STATIC_COLOURS[TOTE])
    left, fallen = scene, tuple[PlacedItem, ...]()
    held = [placed for placed in scene.items if placed.item.suction]
    try:
        for k in derived_rng("drops", seed).permutation(len(held)).tolist():
            if len(fallen) == most:
                return
            seen = perceive(replace(left, items=(*left.items, *fallen)), DEFAULT_NOISE, seed, k, Reality())
            try:
                plan = _planned(warm, seen, held[k], derived_seed("drops", seed, k))
            except NoPlanError:
                continue
            left = left.without(held[k].id)
            yield _dropped(engine, warm, plan, seen, held[k], fallen)
            fallen = _as_they_lie(engine, (*fallen, replace(held[k], location=TOTE)))
    finally:
        engine.close()


def _planned(warm: PlanningContext, seen: Scene, target: PlacedItem, seed: int) -> Plan:
    home = warm.cell.configurations["home"]
    query = PickQuery(target.location, target.id)
    return plan_pick(warm, seen, query, Start(home.q, home.tool_state), seed)


def _dropped(
    engine: Engine,
    warm: PlanningContext,
    plan: Plan,
    seen: Scene,
    target: PlacedItem,
    below: Sequence[PlacedItem],
) -> Drop:
    """Let an item go where the plan does, wherever it truly hangs in the cup, and follow it to rest."""
    (k,), T_tip_item, grasp = releases(plan), pose_in_tool(plan, seen), plan.grasp
    assert grasp is not None and T_tip_item is not None
    t_off = (
        plan.segments[k].t_end - warm.settings.release_time + VENT_TIME * np.log(FULL_VACUUM / RELEASE_VACUUM)
    )
    times = t_off + TIME_STEP * np.arange(round(WATCHED / TIME_STEP))
    tips = warm.arm.tips(plan.trajectory.sample(times), grasp.tool_state)
    off = inverse(seen.find(target.id).T_world_item) @ target.T_world_item
    engine.add_item(target.id, target.item, tips[0] @ T_tip_item @ off, item_colour(target.item))
    for placed in below:
        engine.wake(placed.id)
    pressed = float((inverse(grasp.T_item_tip) @ inverse(T_tip_item))[2, 3])
    T_item_tip, axis = inverse(T_tip_item @ off), tips[0, :3, 2]
    tool, to_item, to_others = _Tool(warm.cell, plan), FAR, FAR
    for n, tip in enumerate(tips):
        at = (engine.pose(target.id) @ T_item_tip)[:3, 3]
        if (spring := pressed - float((at - tip[:3, 3]) @ axis)) > 0.0:  # which the bellows push it off with
            engine.push(target.id, warm.cell.robot.tool.cup_stiffness * spring * axis, at)
        engine.step()
        if n % LOOK == 0:
            to_others = min(to_others, tool.distance(tip, _as_they_lie(engine, below)))
            if n * TIME_STEP >= APART:
                to_item = min(to_item, tool.distance(tip, _as_they_lie(engine, (target,))))
    for _ in range(round(SETTLED / TIME_STEP)):
        engine.step()
    return Drop(target.id, len(below), str(grasp.tool_state), to_item, to_others)


def _as_they_lie(engine: Engine, items: Sequence[PlacedItem]) -> tuple[PlacedItem, ...]:
    return tuple(replace(placed, T_world_item=engine.pose(placed.id)) for placed in items)


def measure(seeds: Sequence[int], most: int) -> dict[str, Any]:
    """All releases of some totes, and how near they came."""
    warm = planner()
    drops: list[Drop] = []
    for seed in seeds:
        drops += fill(warm, fresh_scene(warm.cell, seed)[1], seed, most)
        print(f"tote {seed}: {len(drops)} releases", file=sys.stderr, flush=True)
    gaps = np.array([drop.to_item for drop in drops])
    return {
        "releases": len(drops),
        "touching": int((gaps <= 0.0).sum()),
        "to_item_mm": {f"p{q}": 1e3 * float(np.percentile(gaps, q)) for q in (0, 1, 5, 50)},
        "to_others_least_mm": 1e3 * min(drop.to_others for drop in drops),
        "each": [asdict(drop) for drop in drops],
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--totes", type=int, default=6)
    parser.add_argument("--seed", type=int, default=0, help="of the first scene")
    parser.add_argument("--items", type=int, default=14, help="in a tote, at most")
    parser.add_argument("--json", type=Path, metavar="FILE")
    given = parser.parse_args()
    figures = measure(range(given.seed, given.seed + given.totes), given.items)
    if given.json is not None:
        given.json.write_text(json.dumps(figures, indent=2) + "\n")
    print(json.dumps({key: value for key, value in figures.items() if key != "each"}, indent=2))


if __name__ == "__main__":
    main()
