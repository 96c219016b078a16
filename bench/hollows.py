"""Picks of an item that stands with its hollow open, with the hollow and as if its file stated none.

    python -m bench.hollows [--item platinum_pets_dog_bowl] [--place bin_E] [--into tote] [--face FACE]
        [--scenes 20] [--executed 5] [--seed 0] [--cell apc2016_kth_picking] [--exact] [--json FILE]
    python -m bench.hollows --orders 20 [--seed 0] [--cell apc2016_delft]

Scenes of fresh seeds with the item alone in a place, at rest as a trial would have it, are drawn until as
many as asked have it in the pose in question: its face FACE up, else the face of its first hollow. Each is
planned as it is seen in a trial, with pose errors (without, if --exact), and every plan is verified. The
first plans that take it by a hollow are carried out in simulation, in the true scene, and of an item that has
none the first of all. Reported are plans before and after, the commonest reason for each that is missing, and
contacts that no plan allows.

With --orders the scenes are those of fresh pick orders instead, each target that has a hollow left alone in
its bin as it lies there, whichever face is up: what it is when its bin is cleared.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any

from bench.warm import planners
from pickcli.cell.item import Item
from pickcli.errors import InputError, NoPlanError, RejectedError
from pickcli.motion.plan import Plan
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import TOTE, Scene
from pickcli.seeds import derived_seed
from pickcli.simulation.execute import execute
from pickcli.simulation.reality import DEFAULT, Reality
from pickcli.simulation.world import World
from pickcli.trial.make_order import make_order
from pickcli.trial.order import OrderKind
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive
from pickcli.verification.verify import certify

UP = 0.99  # cosine between a face's normal and the vertical
MOST_SEEDS = 5_000  # that are tried


@dataclass
class Tally:
    """What came of the picks.

    Attributes:
        planned: Number of scenes with a verified plan.
        faces: Number of plans by the face that the cup is put on.
        why_not: The commonest kind of reason of each scene without one.
        rejected: Plans that the verifier refused.
    """

    planned: int = 0
    faces: Counter[str] = field(default_factory=Counter)
    why_not: Counter[str] = field(default_factory=Counter)
    rejected: list[str] = field(default_factory=list)

    def figures(self) -> dict[str, Any]:
        """As figures."""
        return {
            "planned": self.planned,
            "faces": dict(self.faces),
            "why_not": dict(self.why_not.most_common()),
            "rejected": self.rejected,
        }


def scenes_of(cell_context: PlanningContext, item: Item, place: str, up: str, seed: int) -> Iterator[Scene]:
    """Scenes with the item alone in a place, its face ``up`` up, of the seeds from one on."""
    if place not in cell_context.cell.places:
        raise InputError(f"--place: the cell has no {place}; it has {', '.join(cell_context.cell.places)}")
    for k in range(seed, seed + MOST_SEEDS):
        try:
            scene = make_scene({place: [item.name]}, cell_context.cell, k, item.year)
        except InputError:
            continue
        axis, side = "xyz".index(up[1]), 1.0 if up[0] == "+" else -1.0
        if side * float(scene.items[0].T_world_item[2, axis]) >= UP:
            yield scene


def without_hollows(scene: Scene) -> Scene:
    """The scene as if the files of its items stated no hollows."""
    items = [
        replace(
            placed, item=replace(
                placed.item, hollows=(),
                seals={face: placed.item.seals[face] for face in placed.item.shape.face_names},
            ),
        )
        for placed in scene.items
    ]  # fmt: skip
    return replace(scene, items=tuple(items))


def planned(
    warm: Sequence[PlanningContext], scene: Scene, into: str, seed: int, tally: Tally
) -> tuple[PlanningContext, Plan] | None:
    """The first verified plan of any arm for the item of a scene."""
    placed, whys = scene.items[0], Counter[str]()
    for context in warm:
        home = context.cell.configurations["home"]
        query = PickQuery(placed.location, placed.id, into)
        own = replace(scene, cell=context.cell)
        try:
            plan = certify(plan_pick(context, own, query, Start(home.q, home.tool_state), seed), own)
        except RejectedError as error:
            tally.rejected.append(str(error))
            continue
        except NoPlanError as error:
            whys.update(reason.what for reason in error.failures)
            continue
        assert plan.grasp is not None
        tally.planned += 1
        tally.faces[plan.grasp.face] += 1
        return context, plan
    tally.why_not[whys.most_common(1)[0][0] if whys else "rejected"] += 1
    return None


def carried_out(context: PlanningContext, plan: Plan, scene: Scene, into: str, seed: int) -> str:
    """What a plan comes to in simulation: "delivered", or what happened, and contacts it does not allow."""
    home = context.cell.configurations["home"]
    world = World(replace(scene, cell=context.cell), home.q, home.tool_state, reality=DEFAULT, seed=seed)
    run = execute(plan, world)
    is_there = world.held is None and world.placed(scene.items[0].id).location == into
    world.close()
    told = [] if is_there and not run.trouble else [run.trouble or "not delivered"]
    told += [f"{c.a} and {c.b}, {1e3 * c.depth:.1f} mm, {c.force:.0f} N" for c in run.collisions]
    return "; ".join(told) or "delivered"


@dataclass(frozen=True)
class Asked:
    """What is measured.

    Attributes:
        item: Name of the item, of 2016.
        place: Where it is.
        into: Where it is brought to.
        face: Face that is up, None for that of its first hollow.
        scenes: Number of scenes.
        executed: Number of plans that are carried out, at most.
        seed: The first seed of scenes.
        exact: Whether poses are seen without errors.
    """

    item: str
    place: str
    into: str
    face: str | None
    scenes: int
    executed: int
    seed: int
    exact: bool


def measure(warm: Sequence[PlanningContext], asked: Asked) -> dict[str, Any]:
    """Figures with and without the hollows."""
    item = warm[0].cell.item(asked.item, 2016)
    after, before, outcomes = Tally(), Tally(), Counter[str]()
    up = asked.face or item.hollows[0].face
    scenes = scenes_of(warm[0], item, asked.place, up, asked.seed)
    for k, scene in enumerate(islice(scenes, asked.scenes)):
        seen = scene if asked.exact else perceive(scene, DEFAULT_NOISE, asked.seed + k, 1, Reality())
        seed = derived_seed(asked.seed, k)
        planned(warm, without_hollows(seen), asked.into, seed, before)
        found = planned(warm, seen, asked.into, seed, after)
        if found is not None and outcomes.total() < asked.executed:
            context, plan = found
            if plan.grasp is not None and (not item.hollows or item.hollow_at(plan.grasp.face)):
                outcomes[carried_out(context, plan, scene, asked.into, seed)] += 1
        print(f"scene {k + 1}: {before.planned} before, {after.planned} after", file=sys.stderr)
    return {
        "scenes": asked.scenes,
        "up": up,
        "without hollows": before.figures(),
        "with hollows": after.figures(),
        "carried out": dict(outcomes),
    }


def measure_targets(warm: Sequence[PlanningContext], n_orders: int, asked: Asked) -> dict[str, Any]:
    """Figures of the targets with hollows of fresh pick orders, each alone in its bin."""
    tallies: dict[str, tuple[Tally, Tally]] = {}
    for k in range(asked.seed, asked.seed + n_orders):
        order = make_order(OrderKind.PICK, 2016, k)
        wanted = {(t.bin, t.item) for t in order.work_order if warm[0].cell.item(t.item, 2016).hollows}
        if not wanted:
            continue
        try:
            scene = make_scene(order.bin_contents, warm[0].cell, k, order.year)
        except InputError as error:
            print(f"seed {k}: {error}", file=sys.stderr)
            continue
        for bin_name, name in sorted(wanted):
            (target, *_) = [p for p in scene.in_location(bin_name) if p.item.name == name]
            alone = replace(scene, items=(target,))
            seen = alone if asked.exact else perceive(alone, DEFAULT_NOISE, k, 1, Reality())
            before, after = tallies.setdefault(name, (Tally(), Tally()))
            planned(warm, without_hollows(seen), asked.into, k, before)
            planned(warm, seen, asked.into, k, after)
            print(f"seed {k}, {name}: {before.planned} before, {after.planned} after", file=sys.stderr)
    return {
        name: {"without hollows": before.figures(), "with hollows": after.figures()}
        for name, (before, after) in sorted(tallies.items())
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--item", default="platinum_pets_dog_bowl")
    parser.add_argument("--place", default="bin_E")
    parser.add_argument("--into", default=TOTE)
    parser.add_argument("--face")
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--executed", type=int, default=5)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--cell", default="apc2016_kth_picking")
    parser.add_argument("--orders", type=int, default=0)
    parser.add_argument("--exact", action="store_true")
    parser.add_argument("--json", type=Path)
    given = vars(parser.parse_args())
    cell, path, n_orders = given.pop("cell"), given.pop("json"), given.pop("orders")
    warm, asked = planners(cell), Asked(**given)
    figures = measure_targets(warm, n_orders, asked) if n_orders else measure(warm, asked)
    text = json.dumps(figures, indent=2)
    print(text)
    if path is not None:
        path.write_text(text + "\n")


if __name__ == "__main__":
    main()
