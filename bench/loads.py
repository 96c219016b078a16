"""The load on the cup as it is planned and as a fine simulation measures it, hold by hold.

    python -m bench.loads [--orders 2] [--seed 0] [--only side frontal] [--reality FILE] [--json FILE]

Every target of fresh orders (those of ``apc make-order`` with the seeds from --seed on) is planned from a
noisy look, verified and carried out once, in a world of its own with the rest of its bin. A hold is over its
plan where the simulated load reaches more than 1.1 of the planned one; where both are small, that is no harm,
so the difference as a share of what the cup bears is reported as well. With --only, grasps of other kinds are
planned and verified, but not carried out.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from bench.warm import context, fresh_scene
from pickcli.errors import NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Grasp, Plan
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.seeds import derived_seed
from pickcli.simulation.execute import execute
from pickcli.simulation.reality import Reality, read_reality
from pickcli.simulation.world import World
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive
from pickcli.verification.verify import verify

OVER = 1.1  # times the planned load
LIFTED = 5e-5  # m from where the cup sealed: the lift has begun, however long the vacuum was waited for


@dataclass(frozen=True)
class Worst:
    """When the simulated load was worst: where in the plan, and what it was, in N and Nm."""

    ratio: float
    segment: str
    t: float  # s since the segment began
    pull: float
    shear: float
    moment: float
    twist: float


@dataclass(frozen=True)
class Held:
    """One hold. planned and measured: shares of what the cup bears."""

    item: str
    bin: str
    seed: int
    grasp: str
    planned: float
    measured: float
    worst: Worst
    was_lost: bool

    @property
    def is_over(self) -> bool:
        """Whether the simulated load was over the planned one by more than a tenth of it."""
        return self.measured > OVER * self.planned


@dataclass(eq=False)
class Watch:
    """Notes the worst load of an execution; called after every time step."""

    plan: Plan
    worst: Worst | None = None
    t_start: float = field(default=float("nan"))
    sealed: Array | None = None  # (3,) m, tip where the cup sealed
    waited: float = field(default=float("nan"))  # s for the vacuum; known once the lift has begun

    def __call__(self, world: World) -> None:
        if np.isnan(self.t_start):
            self.t_start = world.t - world.time_step
        t, cup = world.t - self.t_start, world.suction
        if cup.held is not None:
            t = self._t_plan(t, world.tip[:3, 3])
        now = next((s for s in self.plan.segments if t <= s.t_end), self.plan.segments[-1])
        if cup.held is None or now.held is None:
            return
        if self.worst is None or cup.ratio > self.worst.ratio:
            load = cup.load
            figures = max(0.0, load.pull), load.shear, load.bending, load.twist
            self.worst = Worst(cup.ratio, str(now.kind), t - now.t_start, *figures)

    def _t_plan(self, t: float, tip: Array) -> float:
        """The plan's time: on the item, the execution may have waited for the vacuum."""
        lift = next(s for s in self.plan.segments if s.held is not None)
        self.sealed = tip if self.sealed is None else self.sealed
        if np.isnan(self.waited):
            if float(np.linalg.norm(tip - self.sealed)) < LIFTED:
                return min(t, lift.t_start)
            self.waited = max(0.0, t - lift.t_start)
        return t - self.waited


def picks(
    warm: PlanningContext, seeds: Sequence[int], reality: Reality, only: Sequence[str] = ()
) -> Iterator[Held | Reason]:
    """Every target of fresh orders, held once or with the reason why it was not."""
    for seed in seeds:
        order, scene = fresh_scene(warm.cell, seed)
        for target in order.work_order:
            yield pick(warm, scene, target.bin, target.item, seed, reality, only)


def pick(
    warm: PlanningContext,
    scene: Scene,
    bin_name: str,
    name: str,
    seed: int,
    reality: Reality,
    only: Sequence[str] = (),
) -> Held | Reason:
    """Plan, verify and carry out one pick; of other kinds of grasps than those of ``only``, not the last."""
    home = warm.cell.configurations["home"].q
    item = next(p for p in scene.in_location(bin_name) if p.item.name == name)
    truth = replace(scene, items=tuple(scene.in_location(bin_name)))
    seen = perceive(truth, DEFAULT_NOISE, seed, 0, reality)
    start = Start(home, warm.cell.robot.tool.default_state)
    try:
        plan = plan_pick(
            warm, seen, PickQuery(bin_name, item.id), start, derived_seed("loads", seed, bin_name)
        )
    except NoPlanError as error:
        return Reason("no plan", f"{name} in {bin_name}, order {seed}", str(error)[:200])
    verdict = verify(plan, seen)
    if verdict.certificate is None:
        return Reason("rejected", f"{name} in {bin_name}, order {seed}", str(verdict.reasons[0]))
    assert plan.grasp is not None
    if only and plan.grasp.kind not in only:
        return Reason("not carried out", f"{name} in {bin_name}, order {seed}", plan.grasp.kind)
    return _carried_out(plan, truth, item, seed, reality)


def _carried_out(plan: Plan, truth: Scene, item: PlacedItem, seed: int, reality: Reality) -> Held | Reason:
    assert plan.grasp is not None
    world = World(truth, plan.trajectory.positions[0], reality=reality, seed=seed)
    watch = Watch(plan)
    try:
        run = execute(plan, world, on_step=watch)
    finally:
        world.close()
    where = f"{item.item.name} in {item.location}, order {seed}"
    if watch.worst is None:
        return Reason("not held", where, run.stopped or "the cup found no seal")
    lost = any(not release.is_wanted for release in run.releases)
    measured, planned = watch.worst.ratio, plan.grasp.load_ratio
    return Held(
        item.id, item.location, seed, _described(plan.grasp), planned, measured, watch.worst, lost
    )  # fmt: skip


def _described(grasp: Grasp) -> str:
    return (
        f"{grasp.kind} {grasp.face}: pull {grasp.pull:.1f} shear {grasp.shear:.1f} "
        f"moment {grasp.moment:.2f} twist {grasp.twist:.3f}"
    )


def measure(
    seeds: Sequence[int] = range(2), reality: Reality | None = None, only: Sequence[str] = ()
) -> dict[str, Any]:
    """All holds, or those of some kinds of grasps, and what they have in common."""
    found = list(picks(context(), seeds, reality or read_reality(None), only))
    held = [h for h in found if isinstance(h, Held)]
    ratios = np.array([h.measured / h.planned for h in held])
    return {
        "picks": len(found),
        "holds": len(held),
        "over_share": float(np.mean([h.is_over for h in held])) if held else None,
        "measured_over_planned": [float(v) for v in np.percentile(ratios, [50, 95, 100])] if held else [],
        "measured_worst": max((h.measured for h in held), default=0.0),
        "lost": sum(h.was_lost for h in held),
        "each": [asdict(h) | {"is_over": h.is_over} for h in held],
        "none": [str(reason) for reason in found if isinstance(reason, Reason)],
    }


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--orders", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs="+", default=(), metavar="KIND", help="kinds of grasps")
    parser.add_argument("--reality", type=Path, metavar="FILE")
    parser.add_argument("--json", type=Path, metavar="FILE")
    given = parser.parse_args()
    seeds = range(given.seed, given.seed + given.orders)
    figures = measure(seeds, read_reality(given.reality), given.only)
    for held in sorted(figures["each"], key=lambda h: h["planned"] / h["measured"]):
        worst, mark = held["worst"], "over" if held["is_over"] else ""
        print(
            f"{held['item']:36} {held['planned']:5.2f} {held['measured']:5.2f} {mark:4} "
            f"{worst['segment']:9} {worst['t']:5.2f} s  pull {worst['pull']:.1f} shear {worst['shear']:.1f} "
            f"moment {worst['moment']:.2f} twist {worst['twist']:.3f} | {held['grasp']}"
        )
    print("\n".join(figures["none"]))
    print(json.dumps({k: v for k, v in figures.items() if k not in ("each", "none")}, indent=2))
    if given.json:
        given.json.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
