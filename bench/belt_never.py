"""How soon it is told that an item on a running belt cannot be met any more, and whether that is true.

    python -m bench.belt_never [--cell conveyor_sia20] [--items 100] [--seed 0] [--speed 0.33]
                               [--gap 0.25,0.60] [--checked 20]

Items of dense streams, each in a stream of its own seed, anywhere in the last ``LATEST`` s of the window; the
arm is over the tote. In ``pr2_belt`` both arms are asked in turns, from where they are parked or from over
their bin. Of those without a plan it prints how long the answer took in processor time, with percentiles, and
how many answers came by bounds alone (``why_never``: ``reach_table``, ``follow_bounds``). Tables are filled
beforehand by as many other items. The first of those that bounds tell, or that are too late, are searched
once more without these bounds, at every place and for contacts from half a second after the start on: a plan
would contradict what was said.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from unittest import mock

import numpy as np

from pickcli.cell.cell_file import load_workcell
from pickcli.errors import NoPlanError
from pickcli.planning.belt_picks import arm_intercept, axis_intercept, axis_windows
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept, why_never
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.random_scenes.make_stream import StreamRequest, make_stream
from pickcli.scene.item_stream import ItemStream
from pickcli.seeds import derived_rng
from pickcli.stream_trials.stream_arms import destination_of

N_ITEMS = 8
STARTS = {"conveyor_sia20": ("drop_01",), "pr2_belt": ("home", "bin_{arm}")}  # named configurations
LATEST = 4.5  # s before an item leaves the window, from which on it is asked for
MOST_MET = 10  # meetings of one effort that are tried without bounds


@dataclass(frozen=True)
class Asked:
    """An item that was asked for, and the answer.

    left: s until it left the window
    ms: of processor time
    why: there is no plan; "" if there is one
    by_bounds: whether bounds alone told that
    """

    context: PlanningContext
    stream: ItemStream
    query: InterceptQuery
    start: Start
    left: float
    ms: float
    why: str
    by_bounds: bool


def ask(context: PlanningContext, speed: float, gap: tuple[float, float], seed: int) -> Asked:
    """Ask for an item of the stream of a seed."""
    stream = make_stream(context.cell, StreamRequest(N_ITEMS, speed, gap), seed)
    draw = derived_rng("never", seed)
    item, left = stream.items[int(draw.integers(2, N_ITEMS - 2))], float(draw.uniform(0.0, LATEST))
    on_belt = stream.belt.window[1] - left * speed - float(item.T_belt_item[0, 3])
    query = InterceptQuery(item.id, item.stamp + on_belt / speed, destination_of(context.cell))
    names = STARTS[context.cell.name]
    named = context.cell.configurations[names[int(draw.integers(len(names)))].format(arm=context.cell.arm)]
    start = Start(named.q, named.tool_state)
    by_bounds = why_never(context, stream, query, start) is not None
    began = time.process_time()
    why = answer(context, stream, query, start)
    return Asked(context, stream, query, start, left, 1e3 * (time.process_time() - began), why, by_bounds)


def answer(context: PlanningContext, stream: ItemStream, query: InterceptQuery, start: Start) -> str:
    """Return why there is no plan; "" if there is one."""
    try:
        plan_intercept(context, stream, query, start)
    except NoPlanError as error:
        return str(error)
    return ""


@contextmanager
def without_bounds() -> Iterator[None]:
    """Let queries search without any of the bounds by which they end early."""
    with (
        mock.patch.object(axis_intercept, "too_late_by", lambda *args: -np.inf),
        mock.patch.object(axis_intercept, "WIDELY_LATE", np.inf),
        mock.patch.object(axis_windows, "least_times", lambda *args: np.array([-np.inf])),
        mock.patch.object(arm_intercept, "why_unreached", lambda *args: None),
        mock.patch.object(arm_intercept, "WIDELY_LATE", np.inf),
        mock.patch.object(arm_intercept, "SOONEST", 0.5),
        mock.patch.object(arm_intercept, "MOST_MET", MOST_MET),
    ):
        yield


def is_true(asked: Asked) -> bool:
    """Whether the search without any bound finds no plan either."""
    with without_bounds():
        return answer(asked.context, asked.stream, asked.query, asked.start) != ""


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cell", default="conveyor_sia20", choices=STARTS)
    parser.add_argument("--items", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--speed", type=float, default=0.33)
    parser.add_argument("--gap", default="0.25,0.60", help="LO,HI in m")
    parser.add_argument("--checked", type=int, default=20, help="answers that are searched once more")
    options = parser.parse_args()
    workcell, (low, high) = load_workcell(options.cell), map(float, options.gap.split(","))
    contexts = [PlanningContext(cell) for cell in workcell.arms.values()]
    for k in range(options.items):
        ask(contexts[k % len(contexts)], options.speed, (low, high), options.seed + options.items + k)
    asked = [
        ask(contexts[k % len(contexts)], options.speed, (low, high), options.seed + k)
        for k in range(options.items)
    ]
    never = [each for each in asked if each.why]
    told = [each for each in never if each.by_bounds]
    print(f"{len(asked)} items, {len(never)} without a plan, {len(told)} of these told by bounds")
    for name, some in (("all", never), ("told by bounds", told)):
        ms = np.array([each.ms for each in some])
        shares = " / ".join(f"{np.percentile(ms, share):.1f}" for share in (50, 90, 99)) if some else "-"
        within = int((ms <= 10.0).sum())
        print(f"{name}: {shares} ms at the median, 90 and 99 of 100; {within} within 10 ms")
    bounded = [each for each in never if each.by_bounds or "too late" in each.why][: options.checked]
    wrong = [each for each in bounded if not is_true(each)]
    print(f"searched once more without bounds: {len(bounded)}, with a plan {len(wrong)}")
    for each in wrong:
        print(f"  {each.query}, {each.left:.2f} s left: {each.why}")


if __name__ == "__main__":
    main()
