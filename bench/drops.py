"""How near what is dropped comes to cup and lance while these leave, and how far it falls.

    python -m bench.drops [--totes 6] [--seed 0] [--items 14] [--cell NAME] [--anywhere] [--json FILE]

A tote is filled with the items of a fresh scene in random order, each by the plan that it has as it is seen.
Only the release is played: from when the cup is vented the item falls and the tool moves as planned. What
lands on an edge turns over, and its other end comes up: reported is the least distance from the tool to the
item from ``APART`` on, and to what lay in the tote before. With --anywhere the release is moved over a random
place of the tote, as low as over any pile: edges are met far more often than where the planner lets go. If
several arms share the tote, they take turns: an item is dropped by the first that has a plan for it.
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
from numpy.random import Generator

from bench.warm import fresh_scene, planners
from pickcli.cell.cell import Cell
from pickcli.cell.place import Place
from pickcli.cell.shapes import Shape
from pickcli.cell.tool import ToolState
from pickcli.cell.tools.lip_leak import FULL_VACUUM
from pickcli.errors import NoPlanError
from pickcli.geometry import Array, inverse
from pickcli.motion.plan import Plan
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.drop_placements import ABOVE_PILE, LEAST_WALL_DISTANCE
from pickcli.planning.start_state import Start
from pickcli.scene.colours import STATIC_COLOURS, item_colour
from pickcli.scene.scene import TOTE, PlacedItem, Scene
from pickcli.seeds import derived_rng, derived_seed
from pickcli.simulation.engine import Engine
from pickcli.simulation.reality import Reality
from pickcli.simulation.suction import RELEASE_VACUUM
from pickcli.simulation.vacuum import VENT_TIME
from pickcli.simulation.world import TIME_STEP
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive
from pickcli.verification.contact_exemptions import releases
from pickcli.verification.fcl_solids import Solid
from pickcli.verification.forward_kinematics import T_lance_last
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
        arm: Name of the arm, "" if the cell has one.
        to_item: m, least distance of the tool to the item.
        to_others: m, the same to what lay there before.
        fall: m, from the item's lowest point at the release to its lowest at rest.
        duration: s of the whole plan.
    """

    item: str
    n_below: int
    tool_state: str
    arm: str
    to_item: float
    to_others: float
    fall: float
    duration: float


class _Tool:
    """Cup and lance as exact solids.

    Args:
        cell: Gives the robot.
        tool_state: Its state.
    """

    def __init__(self, cell: Cell, tool_state: ToolState) -> None:
        robot, tool = cell.robot, cell.robot.tool
        T_tip_cup = inverse(tool.T_last_tip)
        T_tip_lance = T_tip_cup @ inverse(T_lance_last(robot, tool_state))
        links = ((tool.last_link, T_tip_cup), (tool.lance_link, T_tip_lance))
        self._parts = [
            (T_tip_link @ body.T_parent_shape, Solid(body.shape))
            for link, T_tip_link in links
            for body in robot.link(link).bodies
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


def fill(
    warm: Sequence[PlanningContext], scene: Scene, seed: int, most: int, anywhere: bool = False
) -> Iterator[Drop]:
    """Drop items of a scene into its tote, one after the other.

    Args:
        warm: A planner for each arm.
        scene: Items in their bins, and an empty tote.
        seed: Of their order, and of how they are seen.
        most: Number of items.
        anywhere: Whether they are dropped over random places instead of where they are planned to be.

    Yields:
        Every release.
    """
    engine = Engine(TIME_STEP)
    for body in scene.cell.tote_bodies:
        engine.add_static(body, np.eye(4), STATIC_COLOURS[TOTE])
    left, fallen, rng = scene, tuple[PlacedItem, ...](), derived_rng("drops", seed)
    held = [placed for placed in scene.items if placed.item.suction]
    try:
        for k in rng.permutation(len(held)).tolist():
            if len(fallen) == most:
                return
            seen = perceive(replace(left, items=(*left.items, *fallen)), DEFAULT_NOISE, seed, k, Reality())
            turns = (*warm[len(fallen) % len(warm) :], *warm[: len(fallen) % len(warm)])
            planned = _planned(turns, seen, held[k], derived_seed("drops", seed, k))
            if planned is None:
                continue
            left = left.without(held[k].id)
            context, plan = planned
            release = _Release.of(context, plan, replace(seen, cell=context.cell), held[k])
            if anywhere:
                release = release.moved(held[k].item.shape, fallen, scene.cell.places[TOTE], rng)
            yield _dropped(engine, context.cell, release, held[k], fallen)
            fallen = _as_they_lie(engine, (*fallen, replace(held[k], location=TOTE)))
    finally:
        engine.close()


def _planned(
    turns: Sequence[PlanningContext], seen: Scene, target: PlacedItem, seed: int
) -> tuple[PlanningContext, Plan] | None:
    """The first planner that has a plan, and the plan; None if none has."""
    query = PickQuery(target.location, target.id)
    for warm in turns:
        home = warm.cell.configurations["home"]
        try:
            scene = replace(seen, cell=warm.cell)
            return warm, plan_pick(warm, scene, query, Start(home.q, home.tool_state), seed)
        except NoPlanError:
            continue
    return None


@dataclass(frozen=True, eq=False)
class _Release:
    """How an item leaves the cup, and the tool the item.

    Attributes:
        tool_state: State of the tool.
        tips: (N, 4, 4) poses of the tool frame in the world, one each time step from when the item is off.
        T_tip_item: (4, 4) the item in the cup, as it truly hangs there.
        pressed: m that its bellows are pressed in.
        duration: s of the whole plan.
    """

    tool_state: ToolState
    tips: Array
    T_tip_item: Array
    pressed: float
    duration: float

    @classmethod
    def of(cls, warm: PlanningContext, plan: Plan, seen: Scene, target: PlacedItem) -> _Release:
        """That of a plan. target: as it truly lies where it is taken"""
        (k,), T_tip_item, grasp = releases(plan), pose_in_tool(plan, seen), plan.grasp
        assert grasp is not None and T_tip_item is not None
        vented = plan.segments[k].t_end - warm.settings.release_time
        vented += VENT_TIME * np.log(FULL_VACUUM / RELEASE_VACUUM)
        times = vented + TIME_STEP * np.arange(round(WATCHED / TIME_STEP))
        tips = warm.arm.tips(plan.trajectory.sample(times), grasp.tool_state)
        pressed = float((inverse(grasp.T_item_tip) @ inverse(T_tip_item))[2, 3])
        off = inverse(seen.find(target.id).T_world_item) @ target.T_world_item
        return cls(grasp.tool_state, tips, T_tip_item @ off, pressed, plan.trajectory.duration)

    @property
    def T_world_item(self) -> Array:
        """(4, 4) where the item leaves the cup."""
        return np.asarray(self.tips[0] @ self.T_tip_item)

    def moved(self, shape: Shape, below: Sequence[PlacedItem], place: Place, rng: Generator) -> _Release:
        """The same over a random place of the tote, as low as over any pile."""
        T, T_place = self.T_world_item, place.T_carrier_place
        reach, middle = shape.reach(T[:3, :3]), T_place[:2, 3]
        room = np.maximum(place.room.size[:2] / 2 - reach[:2] - LEAST_WALL_DISTANCE, 0.0)
        centre, height = middle + rng.uniform(-room, room), float(T_place[2, 3])
        for placed in below:
            T_below = placed.T_world_item
            half = placed.item.shape.reach(T_below[:3, :3])
            if np.all(np.abs(T_below[:2, 3] - centre) < half[:2] + reach[:2]):
                height = max(height, float(T_below[2, 3] + half[2]))
        shift = np.array([*centre, height + ABOVE_PILE + reach[2]]) - T[:3, 3]
        tips = self.tips.copy()
        tips[:, :3, 3] += shift
        return replace(self, tips=tips)


def _dropped(
    engine: Engine, cell: Cell, release: _Release, target: PlacedItem, below: Sequence[PlacedItem]
) -> Drop:
    """Let an item go, and follow it to rest."""
    engine.add_item(target.id, target.item, release.T_world_item, item_colour(target.item))
    for placed in below:
        engine.wake(placed.id)
    tool, T_item_tip = _Tool(cell, release.tool_state), inverse(release.T_tip_item)
    to_item = to_others = FAR
    for n, tip in enumerate(release.tips):
        at = (engine.pose(target.id) @ T_item_tip)[:3, 3]
        if (spring := release.pressed - float((at - tip[:3, 3]) @ tip[:3, 2])) > 0.0:  # the bellows push
            engine.apply_force(target.id, cell.robot.tool.cup.stiffness * spring * tip[:3, 2], at)
        engine.step()
        if n % LOOK == 0:
            to_others = min(to_others, tool.distance(tip, _as_they_lie(engine, below)))
            if n * TIME_STEP >= APART:
                to_item = min(to_item, tool.distance(tip, _as_they_lie(engine, (target,))))
    for _ in range(round(SETTLED / TIME_STEP)):
        engine.step()
    fall = _lowest(target, release.T_world_item) - _lowest(target, engine.pose(target.id))
    state = str(release.tool_state)
    return Drop(target.id, len(below), state, cell.arm, to_item, to_others, fall, release.duration)


def _lowest(placed: PlacedItem, T_world_item: Array) -> float:
    """Height in the world of the lowest point of an item at a pose, m."""
    return float(T_world_item[2, 3] - placed.item.shape.reach(T_world_item[:3, :3])[2])


def _as_they_lie(engine: Engine, items: Sequence[PlacedItem]) -> tuple[PlacedItem, ...]:
    return tuple(replace(placed, T_world_item=engine.pose(placed.id)) for placed in items)


def measure(seeds: Sequence[int], most: int, cell: str, anywhere: bool = False) -> dict[str, Any]:
    """All releases of some totes, and how near they came."""
    warm = planners(cell)
    drops: list[Drop] = []
    for seed in seeds:
        drops += fill(warm, fresh_scene(warm[0].cell, seed)[1], seed, most, anywhere)
        print(f"tote {seed}: {len(drops)} releases", file=sys.stderr, flush=True)
    gaps = np.array([drop.to_item for drop in drops])
    falls = np.array([drop.fall for drop in drops])
    return {
        "releases": len(drops),
        "touching": int((gaps <= 0.0).sum()),
        "to_item_mm": {f"p{q}": 1e3 * float(np.percentile(gaps, q)) for q in (0, 1, 5, 50)},
        "fall_m": {"median": float(np.median(falls)), "max": float(falls.max())},
        "duration_s": float(np.mean([drop.duration for drop in drops])),
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
    parser.add_argument("--cell", default="apc2016_delft", help="a name under data/cells")
    parser.add_argument("--anywhere", action="store_true", help="over random places")
    parser.add_argument("--json", type=Path, metavar="FILE")
    given = parser.parse_args()
    figures = measure(range(given.seed, given.seed + given.totes), given.items, given.cell, given.anywhere)
    if given.json is not None:
        given.json.write_text(json.dumps(figures, indent=2) + "\n")
    print(json.dumps({key: value for key, value in figures.items() if key != "each"}, indent=2))


if __name__ == "__main__":
    main()
