"""Picks that are certified at once, by how the robot sees: what perception costs before anything moves.

python -m bench.seeing --orders 4 --seed 4200001
"""

from __future__ import annotations

import argparse
from dataclasses import replace

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.errors import NoPlanError
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import Scene
from pickcli.simulation.reality import DEFAULT
from pickcli.trial.make_order import make_order
from pickcli.trial.order import Order, OrderKind
from pickcli.trial.pose_noise import DEFAULT_NOISE
from pickcli.trial.trial_perception import PerceptionKind, ReachedViews, Touched
from pickcli.trial.trial_settings import TrialSettings
from pickcli.verification.verify import verify

TRIAL_SEED = 1
YEAR = 2016
BLIND_TO_HAND_EYE = "camera, exactly mounted"


def settings() -> dict[str, TrialSettings]:
    """How the robot sees, by name."""
    found = {str(kind): TrialSettings(TRIAL_SEED, perception=kind) for kind in PerceptionKind}
    exact = replace(DEFAULT, hand_eye=False)
    found[BLIND_TO_HAND_EYE] = TrialSettings(TRIAL_SEED, reality=exact, perception=PerceptionKind.CAMERA)
    return found


def certified(context: PlanningContext, scene: Scene, order: Order) -> tuple[int, int, int]:
    """Number of targets seen, certified picks of these, and with bounds of 2 mm and 1 degree for all."""
    home = context.cell.home
    start = Start(home.q, home.tool_state)
    alike = replace(scene, items=tuple(replace(placed, noise=DEFAULT_NOISE) for placed in scene.items))
    counts = [0, 0, 0]
    for target in order.targets:
        seen = [p for p in scene.in_location(target.bin) if p.item.name == target.item]
        counts[0] += bool(seen)
        for placed in seen[:1]:
            query = PickQuery(target.bin, placed.id)
            for k, each in enumerate((scene, alike), start=1):
                try:
                    plan = plan_pick(context, each, query, start, TRIAL_SEED)
                except NoPlanError:
                    continue
                counts[k] += verify(plan, each).certificate is not None
    return counts[0], counts[1], counts[2]


def look_into(cell: Cell, first_seed: int, n_orders: int) -> None:
    """Look once into the bins of fresh orders, and print the figures."""
    context = PlanningContext(cell)
    totals: dict[str, list[int]] = {}
    for seed in range(first_seed, first_seed + n_orders):
        order = make_order(OrderKind.PICK, YEAR, seed)
        true = make_scene(order.contents, cell, TRIAL_SEED, YEAR)
        for name, how in settings().items():
            perception = how.perceiving(true)
            scene = perception.look(true, 1, Touched())
            if viewpoints := perception.viewpoints():
                scene = perception.look_from(true, 1, ReachedViews(viewpoints))
            items = [item for look in perception.looks for item in look.items if item.is_believed]
            row = [
                len(order.targets), *certified(context, scene, order), len(items),
                sum(item.is_bound_kept for item in items),
            ]  # fmt: skip
            totals[name] = [a + b for a, b in zip(totals.get(name, [0] * len(row)), row, strict=True)]
    for name, (targets, seen, picks, alike, believed, kept) in totals.items():
        print(f"{name}: {seen} of {targets} targets seen, {picks} certified")
        print(f"  {alike} certified if all bounds were 2 mm and 1 degree")
        print(f"  bounds of {believed} poses, of which {kept} held")


def main() -> None:
    """Read the options, and look."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--orders", type=int, default=4)
    parser.add_argument("--seed", type=int, default=4200001, help="of the first order")
    arguments = parser.parse_args()
    look_into(load_cell("apc2016_delft"), arguments.seed, arguments.orders)


if __name__ == "__main__":
    main()
