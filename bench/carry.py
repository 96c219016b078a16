"""What it gains to time a carry under the cup's limits, against slowing the whole of it down.

    python -m bench.carry [--orders 12] [--grasps 3] [--seed 0] [--year 2016] [--json FILE]

Every target of fresh orders (those of ``apc make-order`` with the seeds from --seed on) is planned, and again
with other grasps, as retries are. Where the motion without a load would break what the cup bears, the same
carry is timed the simpler way, too: all limits of the whole carry scaled down until the load fits. Coarse
motions are planned online, so that the figures do not depend on what is stored. Milliseconds are of the
processor, of this process alone.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from pickcli.cell.cell_file import load_cell
from pickcli.collision.motion_segment import MotionSegment
from pickcli.errors import Failures, NoPlanError
from pickcli.grasping.holding import Hold
from pickcli.motion.plan import Grasp
from pickcli.planning.assembly import proven_timing
from pickcli.planning.assembly.grip_load import carried_load
from pickcli.planning.assembly.proven_timing import CarriedRun, carried_run, proven_run
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import Scene
from pickcli.trial.make_order import make_order
from pickcli.trial.order import OrderKind, Target

FREE, SLOWED, TIMED = "without a load", "all of it slowed down", "under the cup's limits"
SLOWEST = 0.1  # of all limits, below which slowing down all of it gives up
SLOWER = 0.95  # from one try to the next


@dataclass(frozen=True)
class Carry:
    """One pick's way with the item, in s; slowed is None where even the slowest breaks what the cup bears."""

    item: str
    load_ratio: float  # of the motion without a load
    free: float
    slowed: float | None
    timed: float
    planning_ms: float


@dataclass(eq=False)
class Recorder:
    """Stands in for ``carried_run`` and keeps what the last carry was made of."""

    last: tuple[Scene, Sequence[MotionSegment], Grasp, Hold, CarriedRun] | None = None

    def __call__(
        self,
        context: PlanningContext,
        scene: Scene,
        segments: Sequence[MotionSegment],
        grasp: Grasp,
        hold: Hold,
        most: float,
    ) -> CarriedRun | Failures:
        carried = carried_run(context, scene, segments, grasp, hold, most)
        if isinstance(carried, CarriedRun):
            self.last = scene, segments, grasp, hold, carried
        return carried


def scaled_run(
    context: PlanningContext, scene: Scene, segments: Sequence[MotionSegment], hold: Hold, scale: float
) -> tuple[float, float] | None:
    """Seconds and load ratio of a carry with all limits scaled, or None where it is not proven."""
    run = proven_run(context, scene, [segment.scaled(scale) for segment in segments])
    if isinstance(run, Failures):
        return None
    load = carried_load(context.arm, segments[0].mode.tool_state, run.trajectory, hold)
    return run.trajectory.duration, load.ratio


def compared(context: PlanningContext, recorder: Recorder, item: str, planning_ms: float) -> Carry | None:
    """The last carry timed in all three ways."""
    assert recorder.last is not None
    scene, segments, _, hold, carried = recorder.last
    scale = 1.0
    most, timed = context.settings.load_ratio, carried.run.trajectory.duration
    free = scaled_run(context, scene, segments, hold, scale)
    if free is None:
        return None
    duration, ratio = free
    slowed: tuple[float, float] | None = free
    while slowed is not None and slowed[1] > most and scale >= SLOWEST:
        scale *= SLOWER
        slowed = scaled_run(context, scene, segments, hold, scale)
    held = slowed[0] if slowed is not None and slowed[1] <= most else None
    return Carry(item, ratio, duration, held, timed, planning_ms)


def carries(context: PlanningContext, year: int, seeds: Sequence[int], n_grasps: int) -> Iterator[Carry]:
    """Every target of fresh orders with every grasp that a plan was found for."""
    for seed in seeds:
        order = make_order(OrderKind.PICK, year, seed)
        scene = make_scene(order.bin_contents, context.cell, seed, year)
        for target in order.work_order:
            yield from _of_target(context, scene, target, seed, n_grasps)


def _of_target(
    context: PlanningContext, scene: Scene, target: Target, seed: int, n_grasps: int
) -> Iterator[Carry]:
    """One target with one grasp after the other."""
    home = Start(context.cell.configurations["home"].q, context.cell.robot.tool.default_state)
    tried: list[Grasp] = []
    for _ in range(n_grasps):
        recorder, began = Recorder(), time.process_time()
        with mock.patch.object(proven_timing, "carried_run", recorder):
            try:
                plan = plan_pick(
                    context, scene, PickQuery(target.bin, target.item, exclude=tuple(tried)), home, seed
                )
            except NoPlanError:
                return
        assert plan.grasp is not None
        tried.append(plan.grasp)
        carry = compared(context, recorder, target.item, 1e3 * (time.process_time() - began))
        if carry is not None:
            yield carry


def measure(year: int = 2016, seeds: Sequence[int] = range(12), n_grasps: int = 3) -> dict[str, Any]:
    """All carries, and what those gain whose load binds."""
    context = PlanningContext(load_cell("apc2016_delft"))
    found = list(carries(context, year, seeds, n_grasps))
    most = context.settings.load_ratio
    bound = [c for c in found if c.load_ratio > most]
    both = [c for c in bound if c.slowed is not None]
    return {
        "carries": len(found),
        "whose_load_binds": len(bound),
        "that_slowing_gives_up": len(bound) - len(both),
        "free_s": _mean(c.free for c in both),
        "slowed_s": _mean(c.slowed for c in both if c.slowed is not None),
        "timed_s": _mean(c.timed for c in both),
        "gain_s": _mean(c.slowed - c.timed for c in both if c.slowed is not None),
        "gain_of_all_s": sum(c.slowed - c.timed for c in both if c.slowed is not None) / max(len(found), 1),
        "planning_ms": _spread([c.planning_ms for c in found]),
        "planning_ms_where_it_binds": _spread([c.planning_ms for c in bound]),
        "bound": [asdict(c) for c in bound],
    }


def _mean(values: Iterable[float]) -> float | None:
    found = list(values)
    return float(np.mean(found)) if found else None


def _spread(values: Sequence[float]) -> list[float]:
    """Median, 95th percentile and largest."""
    return [float(v) for v in np.percentile(values, [50, 95, 100])] if values else []


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--orders", type=int, default=12)
    parser.add_argument("--grasps", type=int, default=3)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--year", type=int, default=2016)
    parser.add_argument("--json", type=Path, metavar="FILE")
    given = parser.parse_args()
    figures = measure(given.year, range(given.seed, given.seed + given.orders), given.grasps)
    print(f"{'item':36} {'load':>5} {FREE:>15} {SLOWED:>22} {TIMED:>23}")
    for c in figures["bound"]:
        slowed = "gives up" if c["slowed"] is None else f"{c['slowed']:.2f}"
        print(f"{c['item']:36} {c['load_ratio']:5.2f} {c['free']:15.2f} {slowed:>22} {c['timed']:23.2f}")
    print(json.dumps({k: v for k, v in figures.items() if k != "bound"}, indent=2))
    if given.json:
        given.json.write_text(json.dumps(figures, indent=2) + "\n")


if __name__ == "__main__":
    main()
