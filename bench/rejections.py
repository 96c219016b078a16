"""Plans that the planner hands over and its own verifier refuses, by reason, on fresh scenes.

    python -m bench.rejections [--scenes 6] [--seed 0] [--json FILE]

Every item of every bin of scenes from fresh orders is planned once as it lies and once as it is seen in a
trial, the pod's pose with its error, and every plan is verified. Also reported: how near the plans came to
what they are not to touch, how many of the items that a cup can hold had a plan, and how long it took to find
one, to find that there is none, and to verify.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from bench.warm import context
from pickcli.errors import InputError, NoPlanError
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import Scene
from pickcli.seeds import derived_seed
from pickcli.simulation.reality import Reality
from pickcli.trial.make_order import make_order
from pickcli.trial.order import OrderKind
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive
from pickcli.verification.verify import verify


@dataclass
class Tally:
    """What came of the queries. Times are those of the processor, ms."""

    asked: Counter[int] = field(default_factory=Counter)  # picks, by the number of items in the bin
    planned: Counter[int] = field(default_factory=Counter)  # of those, the ones with a plan
    refused: Counter[str] = field(default_factory=Counter)  # kinds of reasons of plans that were rejected
    examples: list[str] = field(default_factory=list)
    by_region: int = 0  # plans with a grasp that a region query found
    in_the_way: int = 0  # no plan, and an item is named
    clearances: list[float] = field(default_factory=list)  # m, of accepted plans
    planning: list[float] = field(default_factory=list)
    failing: list[float] = field(default_factory=list)  # of planning where there is no plan
    verifying: list[float] = field(default_factory=list)

    @property
    def plans(self) -> int:
        """Plans handed to the verifier."""
        return len(self.planning)

    @property
    def rejected(self) -> int:
        """Plans that it refused."""
        return len(self.examples)

    def figures(self) -> dict[str, Any]:
        """As figures."""
        return {
            "asked": self.asked.total(),
            "planned_by_items_in_bin": {
                n: f"{self.planned[n]} of {asked}" for n, asked in sorted(self.asked.items())
            },
            "plans": self.plans,
            "by_region": self.by_region,
            "rejected": self.rejected,
            "rejected_percent": 100.0 * self.rejected / max(1, self.plans),
            "reasons": dict(self.refused.most_common()),
            "examples": self.examples,
            "no_plan_but_an_item_named": self.in_the_way,
            "clearance_least_mm": 1e3 * min(self.clearances, default=0.0),
            "planning_ms": _quantiles(self.planning),
            "failing_ms": _quantiles(self.failing),
            "verification_ms": _quantiles(self.verifying),
        }


def fresh_scenes(warm: PlanningContext, seeds: Sequence[int]) -> Iterator[tuple[int, Scene]]:
    """A scene at rest for the fresh order of every seed; those whose items find no rest are left out."""
    for seed in seeds:
        order = make_order(OrderKind.PICK, 2016, seed)
        try:
            yield seed, make_scene(order.bin_contents, warm.cell, seed)
        except InputError as error:
            print(f"seed {seed}: {error}")


def tally(warm: PlanningContext, scene: Scene, seed: int, into: Tally) -> None:
    """Plan and verify a pick of every item of a scene that a cup can hold."""
    home = warm.cell.configurations["home"]
    start = Start(home.q, home.tool_state)
    for placed in scene.items:
        if not placed.item.suction:
            continue
        n_items = len(scene.in_location(placed.location))
        into.asked[n_items] += 1
        began = process_time()
        try:
            plan = plan_pick(
                warm, scene, PickQuery(placed.location, placed.id), start, derived_seed(seed, placed.id)
            )
        except NoPlanError as error:
            into.failing.append(1e3 * (process_time() - began))
            into.in_the_way += bool(error.in_the_way)
            continue
        planned = process_time()
        into.planned[n_items] += 1
        into.by_region += plan.grasp is not None and bool(plan.grasp.envelope)
        verdict = verify(plan, scene)
        into.planning.append(1e3 * (planned - began))
        into.verifying.append(1e3 * (process_time() - planned))
        if verdict.certificate is None:
            into.refused.update({reason.what for reason in verdict.reasons})
            into.examples.append(f"{seed} {plan.query}: {'; '.join(map(str, verdict.reasons[:2]))}")
        else:
            into.clearances.append(verdict.certificate.min_clearance)


def measure(seeds: Sequence[int]) -> dict[str, Any]:
    """Figures for exact and for noisy poses."""
    warm = context()
    exact, noisy = Tally(), Tally()
    for seed, scene in fresh_scenes(warm, seeds):
        if seed == seeds[0]:  # not counted: models are made, and libraries imported, by who needs them first
            tally(warm, scene, seed, Tally())
        tally(warm, scene, seed, exact)
        tally(warm, perceive(scene, DEFAULT_NOISE, seed, 1, Reality()), seed, noisy)
        print(f"scene {seed}: {exact.rejected} of {exact.plans}, noisy {noisy.rejected} of {noisy.plans}")
    return {"exact": exact.figures(), "noisy": noisy.figures()}


def _quantiles(values: Sequence[float]) -> dict[str, float]:
    if not values:
        return {}
    shares = (("median", 0.5), ("p95", 0.95), ("p99", 0.99), ("worst", 1.0))
    return {name: float(np.quantile(values, q)) for name, q in shares}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--scenes", type=int, default=6)
    parser.add_argument("--seed", type=int, default=0, help="of the first order")
    parser.add_argument("--json", type=Path, metavar="FILE")
    given = parser.parse_args()
    figures = measure(range(given.seed, given.seed + given.scenes))
    print(json.dumps(figures, indent=2))
    if given.json is not None:
        given.json.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
