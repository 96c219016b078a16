"""Picks with two fingers as the physics judge them: held, delivered, slid, lost, contacts that no plan has.

    python -m bench.pinched [--picks 30] [--seed 0]

Fresh scenes of the cell ``panda_table``: items that fit between the fingers, laid at random on its mats and
seen with the noise of a trial. All are to go to the tray. Every certified plan is played in a world of its
own, in which nothing was moved before.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import count

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.errors import NoPlanError
from pickcli.motion.plan import Plan
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.simulation.execute import execute
from pickcli.simulation.reality import DEFAULT
from pickcli.simulation.world import World
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive
from pickcli.verification.verify import verify

CELL, MATS, TRAY = "panda_table", ("mat_front", "mat_right"), "tray"
# Those of 2016 that pass between the fingers with room to spare, however they lie.
NAMES = ("dove_beauty_bar", "expo_dry_erase_board_eraser", "soft_white_lightbulb", "up_glucose_bottle")
SLID = 1e-3  # m between the pads from which on an item counts as slid; rubber gives way by less


@dataclass(frozen=True)
class Pinched:
    """One pick, carried out.

    Attributes:
        item: Its id.
        face: What is pinched.
        ended_in: The place where the item is afterwards.
        slip: m that it moved between the pads.
        load: Most of what the pads bear that it took up.
        is_lost: Whether it left the pads by itself.
        contacts: Unplanned ones.
        violations: Limits broken.
        stopped: Why it ended before the plan did, "" if it did not.
    """

    item: str
    face: str
    ended_in: str
    slip: float
    load: float
    is_lost: bool
    contacts: int
    violations: int
    stopped: str

    def __str__(self) -> str:
        text = f"{self.item} by {self.face}: in {self.ended_in}, load {self.load:.2f}, "
        text += f"moved {1e3 * self.slip:.2f} mm, {self.contacts} contacts, {self.violations} limits"
        return f"{text}, {'lost' if self.is_lost else 'held'}{self.stopped and ', ' + self.stopped}"


def main() -> None:
    """Play the picks and print what came of them."""
    parser = argparse.ArgumentParser(description="picks with two fingers, judged by the physics")
    parser.add_argument("--picks", type=int, default=30)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    context = PlanningContext(load_cell(CELL))
    outcomes: Counter[str] = Counter()
    played: list[Pinched] = []
    for scene, target, seed in _targets(context.cell, asked.seed):
        if len(played) == asked.picks:
            break
        plan = _certified(context, scene, target, seed)
        if isinstance(plan, str):
            outcomes[plan] += 1
            continue
        played.append(_played(plan, scene, seed))
        print(played[-1], flush=True)
    print(_summary(played, outcomes))


def _targets(cell: Cell, seed: int) -> Iterator[tuple[Scene, PlacedItem, int]]:
    for number in count(seed):
        rng = np.random.default_rng(number)
        contents = {mat: tuple(rng.choice(NAMES, 4).tolist()) for mat in MATS}
        scene = make_scene(contents, cell, number)
        for target in scene.items:
            yield scene, target, number


def _certified(context: PlanningContext, scene: Scene, target: PlacedItem, seed: int) -> Plan | str:
    """The plan, or what kept it from being played."""
    home = context.cell.configurations["home"]
    seen = perceive(scene, DEFAULT_NOISE, seed, 1, DEFAULT)
    query = PickQuery(target.location, target.id, TRAY)
    try:
        plan = plan_pick(context, seen, query, Start(home.q, home.tool_state), seed)
    except NoPlanError:
        return "without a plan"
    return plan if verify(plan, seen).certificate is not None else "rejected"


def _played(plan: Plan, scene: Scene, seed: int) -> Pinched:
    assert plan.grasp is not None
    item = plan.grasp.item
    world = World(scene, plan.trajectory.positions[0], plan.segments[0].tool_state, seed=seed)
    slips = [0.0]

    def look(world: World) -> None:
        if world.held is not None and world.fingers is not None:
            slips.append(world.fingers.slip)

    try:
        run = execute(plan, world, on_step=look)
        world.wait(0.5)
        ended_in = "the hand" if world.held == item else world.placed(item).location
    finally:
        world.close()
    is_lost = any(not release.is_wanted for release in run.releases)
    return Pinched(
        item, plan.grasp.face, ended_in, max(slips), run.max_load, is_lost, len(run.collisions),
        len(run.limit_violations), run.stopped,
    )  # fmt: skip


def _summary(played: list[Pinched], outcomes: Counter[str]) -> str:
    figures = {
        "played": len(played),
        "delivered": sum(p.ended_in == TRAY for p in played),
        "lost": sum(p.is_lost for p in played),
        "slid": sum(p.slip > SLID for p in played),
        "stopped": sum(bool(p.stopped) for p in played),
        "contacts": sum(p.contacts for p in played),
        "limits broken": sum(p.violations for p in played),
        **outcomes,
    }
    return ", ".join(f"{value} {name}" for name, value in figures.items())


if __name__ == "__main__":
    main()
