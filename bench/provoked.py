"""Provoked failures: picks carried out in a world that is not as they were planned for.

    python -m bench.provoked [--seed 0] [--json FILE]

Three picks of a fresh order (a top-down one, a frontal one, the heaviest) are planned once and carried out
once per lie. Every outcome must be among those that physics allows, and reported: what is not delivered was
noticed or named as lost. Exit code 1 otherwise.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

from rich.console import Console
from rich.table import Table

from bench.warm import context, fresh_scene
from pickcli.errors import NoPlanError
from pickcli.geometry import pose
from pickcli.motion.plan import Plan
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, Scene
from pickcli.simulation.execute import execute
from pickcli.simulation.execution import Execution
from pickcli.simulation.reality import DEFAULT
from pickcli.simulation.world import World

DELIVERED, NOTICED, LOST, SILENT = "delivered", "noticed", "lost", "silent"
TOLD = frozenset({DELIVERED, NOTICED, LOST})
NOT_PICKED = frozenset({NOTICED, LOST})
ASIDE = (-3.0, 2.0, 0.4)  # m, over the hall's floor
EXACT = replace(DEFAULT, mass_error=0.0)

Lie: TypeAlias = Callable[[Plan, Scene, str], tuple[Plan, Scene]]


@dataclass(frozen=True)
class Case:
    """One lie, what may come of it, and whether the commands themselves break a limit."""

    name: str
    lie: Lie
    allowed: frozenset[str]
    breaks_limits: bool = False


def truth(plan: Plan, scene: Scene, target: str) -> tuple[Plan, Scene]:
    """Nothing is changed."""
    return plan, scene


def later(device: str, action: str, by: float) -> Lie:
    """A device is commanded so many seconds late; early, if negative."""

    def lie(plan: Plan, scene: Scene, target: str) -> tuple[Plan, Scene]:
        events = tuple(
            replace(event, t_trigger=(event.t_trigger or 0.0) + by)
            if (event.device, event.action) == (device, action)
            else event
            for event in plan.events
        )
        return replace(plan, events=tuple(sorted(events, key=lambda event: event.t_trigger or 0.0))), scene

    return lie


def changed_item(**changes: Any) -> Lie:
    """The target is another than it was said to be."""

    def lie(plan: Plan, scene: Scene, target: str) -> tuple[Plan, Scene]:
        items = tuple(
            replace(placed, item=replace(placed.item, **changes)) if placed.id == target else placed
            for placed in scene.items
        )
        return plan, replace(scene, items=items)

    return lie


def heavier(factor: float) -> Lie:
    """The target has so many times its stated mass."""

    def lie(plan: Plan, scene: Scene, target: str) -> tuple[Plan, Scene]:
        return changed_item(mass=factor * scene.find(target).item.mass)(plan, scene, target)

    return lie


def porous(plan: Plan, scene: Scene, target: str) -> tuple[Plan, Scene]:
    """Air passes through every face of the target."""
    faces = scene.find(target).item.seals
    return changed_item(seals=dict.fromkeys(faces, 0.0), areas={})(plan, scene, target)


def gone(plan: Plan, scene: Scene, target: str) -> tuple[Plan, Scene]:
    """The target is not there: it lies in a corner of the hall."""
    items = tuple(
        replace(placed, T_world_item=pose(ASIDE)) if placed.id == target else placed for placed in scene.items
    )
    return plan, replace(scene, items=items)


def faster(factor: float) -> Lie:
    """The plan runs at so many times its pace."""

    def lie(plan: Plan, scene: Scene, target: str) -> tuple[Plan, Scene]:
        old = plan.trajectory
        trajectory = replace(
            old, times=old.times / factor, velocities=old.velocities * factor,
            accelerations=old.accelerations * factor**2,
        )  # fmt: skip
        segments = [replace(s, t_start=s.t_start / factor, t_end=s.t_end / factor) for s in plan.segments]
        events = [
            replace(e, t_anchor=(e.t_anchor or 0.0) / factor, t_trigger=(e.t_trigger or 0.0) / factor)
            for e in plan.events
        ]
        return replace(plan, trajectory=trajectory, segments=tuple(segments), events=tuple(events)), scene

    return lie


CASES = (
    Case("none", truth, frozenset({DELIVERED})),
    Case("valve opens 0.1 s late", later("valve", "on", 0.1), frozenset({DELIVERED})),
    Case("valve opens 0.3 s early: less vacuum", later("valve", "on", -0.3), TOLD),
    Case("valve opens 0.3 s late: the cup leaves", later("valve", "on", 0.3), TOLD),
    Case("valve opens 0.6 s late: the cup is off", later("valve", "on", 0.6), NOT_PICKED),
    Case("valve closes 0.3 s early", later("valve", "off", -0.3), frozenset({DELIVERED})),
    Case("pump starts 1.5 s late", later("pump", "on", 1.5), TOLD),
    Case("item 3 times as heavy", heavier(3.0), TOLD),
    Case("item 10 times as heavy", heavier(10.0), TOLD),
    Case("air passes through the item", porous, NOT_PICKED),
    Case("item is not there", gone, NOT_PICKED),
    Case("plan at twice its pace", faster(2.0), TOLD, breaks_limits=True),
)


def outcome(run: Execution, world: World, target: str) -> str:
    """What came of it: delivered, noticed (a stop, the sensor, missed events), named as lost, or none."""
    if world.held is None and world.placed(target).location == TOTE:
        return DELIVERED
    if any(not fall.is_wanted for fall in run.falls):
        return LOST
    return NOTICED if run.stop is not None or run.has_item is False or run.missed else SILENT


def picks(warm: PlanningContext, seed: int) -> Iterator[tuple[str, Plan, Scene, str]]:
    """(kind, plan, scene, target) of a top-down and a frontal pick and of the heaviest item."""
    order, scene = fresh_scene(warm.cell, seed)
    home = warm.cell.configurations["home"]
    found: dict[str, tuple[float, Plan, str]] = {}
    for target in order.work_order:
        try:
            plan = plan_pick(warm, scene, PickQuery(target.bin, target.item), Start(home.q, home.tool_state))
        except NoPlanError:
            continue
        assert plan.grasp is not None
        item = scene.find(plan.grasp.item).item
        for kind in (str(plan.grasp.kind), "heaviest"):
            if kind not in found or (kind == "heaviest" and item.mass > found[kind][0]):
                found[kind] = (item.mass, plan, plan.grasp.item)
    for kind, (_, plan, target_id) in sorted(found.items()):
        yield kind, plan, scene, target_id


def measure(seed: int) -> list[dict[str, Any]]:
    """One row per pick and lie."""
    warm = context()
    home = warm.cell.configurations["home"]
    found = []
    for kind, plan, scene, target in picks(warm, seed):
        for case in CASES:
            stated, real = case.lie(plan, scene, target)
            world = World(real, home.q, home.tool_state, reality=EXACT)
            run = execute(stated, world)
            what = outcome(run, world, target)
            found.append(
                {
                    "pick": kind,
                    "item": target,
                    "lie": case.name,
                    "outcome": what,
                    "as expected": what in case.allowed and bool(run.limit_violations) == case.breaks_limits,
                    "load": round(run.max_load, 3),
                    "lag_mm": round(1e3 * run.max_lag, 1),
                    "largest_force": round(max((c.force for c in run.collisions), default=0.0), 1),
                    "trouble": run.trouble,
                }
            )
            world.close()
    return found


def main() -> None:
    """Provoke, print, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--seed", type=int, default=0, help="of the fresh order")
    parser.add_argument("--json", type=Path, default=Path("runs/provoked.json"), metavar="FILE")
    given = parser.parse_args()
    found = measure(given.seed)
    table = Table("pick", "lie", "outcome", "load", "lag, mm", "force, N", "report")
    for row in found:
        mark = "" if row["as expected"] else " (not plausible)"
        table.add_row(row["pick"], row["lie"], row["outcome"] + mark, f"{row['load']:.2f}",
                      f"{row['lag_mm']:.1f}", f"{row['largest_force']:.0f}", row["trouble"])  # fmt: skip
    Console(width=140).print(table)
    given.json.parent.mkdir(parents=True, exist_ok=True)
    given.json.write_text(json.dumps(found, indent=2) + "\n")
    print(f"wrote {given.json}")
    if not all(row["as expected"] for row in found):
        raise SystemExit(1)


if __name__ == "__main__":
    main()
