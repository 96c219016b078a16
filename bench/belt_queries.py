"""How long queries for items on a running belt take: all joints of an arm follow it, or an axis along it.

    python -m bench.belt_queries [--cell pr2_belt] [--items 80] [--seed 0] [--speed 0.33] [--gap 1.8,2.4]
                                 [--late] [--verify] [--stream-rule pr2-2013] [--expansions 300]

Every item of one stream, with the errors of poses and of the speed that a trial has, is asked for within
``SOON`` s from when it is wholly on the belt, as a free arm does; with ``--late``, anywhere after that until
``LEFT`` s before it leaves the window, as an arm does that was busy. The arms take turns; each starts from
where it is parked, or from over its bin, in ``conveyor_sia20`` from home or from over the tote. Processor
times in one warm process, planning only; ``WARMING`` other items go before. It prints the median and
percentiles of the queries with a plan and of those without, of which some were told by bounds alone
(``why_never``), and, with ``--verify``, how many plans the verifier accepts. By ``--stream-rule pr2-2013``
items are met at one place, and with ``--expansions`` ARA* plans the transits, of which the bound on the cost
is printed, too.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.cell_file import load_workcell
from pickcli.errors import NoPlanError
from pickcli.motion.plan import Plan, times_at_work
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept, why_never
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.random_scenes.make_stream import StreamRequest, make_stream
from pickcli.scene.item_stream import ItemStream
from pickcli.seeds import derived_rng
from pickcli.stream_trials.stream_arms import destination_of
from pickcli.stream_trials.stream_rules import StreamRule
from pickcli.stream_trials.stream_trial_request import SPEED_ERROR
from pickcli.trial.pose_noise import DEFAULT_NOISE
from pickcli.verification.verify import certifier

STARTS = {"conveyor_sia20": ("home", "drop_01"), "pr2_belt": ("home", "bin_{arm}")}  # named configurations
WARMING = 8  # queries before those that count
SOON = 1.0  # s after an item is on the belt, within which it is asked for
LEFT = 1.5  # s before it leaves the window, from which on it is not asked for


@dataclass(frozen=True)
class Asked:
    """An item that was asked for, and the answer.

    stream: as it was perceived
    query: for the item
    ms: of processor time
    plan: None if there is none
    why: there is no plan; "" if there is one
    by_bounds: whether bounds alone told that
    """

    stream: ItemStream
    query: InterceptQuery
    ms: float
    plan: Plan | None
    why: str
    by_bounds: bool


def ask(context: PlanningContext, stream: ItemStream, k: int, is_late: bool, rule: StreamRule) -> Asked:
    """Ask an arm for the k-th item of a stream."""
    cell, draw, item = context.cell, derived_rng("belt query", stream.seed, k), stream.items[k]
    leaves = item.stamp + (stream.belt.window[1] - float(item.T_belt_item[0, 3])) / stream.speed
    soon = item.stamp + SOON
    now = draw.uniform(soon, leaves - LEFT) if is_late else draw.uniform(item.stamp, soon)
    place = rule.meeting_place(context, stream.carrier)
    query = InterceptQuery(item.id, float(now), destination_of(cell), place)
    named = cell.configurations[STARTS[cell.name][int(draw.integers(2))].format(arm=cell.arm)]
    start, seen = Start(named.q, named.tool_state), replace(stream, cell=cell)
    never = why_never(context, seen, query, start) is not None
    began, plan, why = time.process_time(), None, ""
    try:
        plan = plan_intercept(context, seen, query, start, stream.seed)
    except NoPlanError as error:
        why = str(error)
    return Asked(seen, query, 1e3 * (time.process_time() - began), plan, why, never)


def report(name: str, asked: Sequence[Asked]) -> None:
    """Print how long some queries took."""
    ms = np.array([each.ms for each in asked])
    shares = " / ".join(f"{np.percentile(ms, share):.1f}" for share in (50, 90, 99)) if len(ms) else "-"
    most = f", {ms.max():.1f} at most" if len(ms) else ""
    print(f"{len(asked)} {name}: {shares} ms at the median, 90 and 99 of 100{most}")


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cell", default="pr2_belt", choices=STARTS)
    parser.add_argument("--items", type=int, default=80)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--speed", type=float, default=0.33)
    parser.add_argument("--gap", default="1.8,2.4", help="LO,HI in m")
    parser.add_argument("--late", action="store_true", help="ask for the items when they are farther along")
    parser.add_argument("--verify", action="store_true", help="judge the plans, too")
    parser.add_argument(
        "--stream-rule", type=StreamRule, default=StreamRule.EARLIEST, help="how they are met"
    )
    parser.add_argument("--expansions", type=int, help="of ARA*, which plans the transits then")
    parser.add_argument("--list", action="store_true", help="print every query")
    options = parser.parse_args()
    workcell, (low, high) = load_workcell(options.cell), map(float, options.gap.split(","))
    by = options.expansions
    contexts = [PlanningContext(cell).with_lattice_transits(by) for cell in workcell.arms.values()]
    request = StreamRequest(options.items + WARMING, options.speed, (low, high))
    stream = make_stream(contexts[0].cell, request, options.seed)
    stream = replace(stream, noise=DEFAULT_NOISE, speed_error=2.0 * SPEED_ERROR)
    n, rule = len(stream.items), options.stream_rule
    each_of = [ask(contexts[k % len(contexts)], stream, k, options.late, rule) for k in range(n)]
    asked = each_of[WARMING:]
    planned = [each for each in asked if each.plan is not None]
    report("with a plan", planned)
    report("without a plan", [each for each in asked if each.plan is None and not each.by_bounds])
    report("told by bounds", [each for each in asked if each.by_bounds])
    lasting = [times_at_work(each.plan.segments)[1] for each in asked if each.plan is not None]
    if lasting:
        print(f"the item is off the belt after {np.mean(lasting):.2f} s in the mean")
    bounds = [each.plan.statistics["transit_cost_bound"] for each in planned if each.plan] if by else []
    if bounds:
        n_best = sum(bound == 1.0 for bound in bounds)
        print(f"cost bound: {np.median(bounds):.3f} in the median, {max(bounds):.3f} at most; {n_best} least")
    if options.list:
        for each in asked:
            end = "" if each.plan is None else f"off at {times_at_work(each.plan.segments)[1]:.2f} s"
            print(f"  {each.query.now:.2f} s: {each.ms:.1f} ms, {each.query.item}, {end or each.why[:300]}")
    if options.verify:
        told = Counter(
            isinstance(certifier(each.stream.scene_at(each.query.now))(each.plan), Plan)
            for each in planned
            if each.plan is not None
        )
        print(f"verified: {told[True]} accepted, {told[False]} rejected")


if __name__ == "__main__":
    main()
