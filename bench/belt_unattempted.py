"""Whether an item of a stream that was never attempted could have been met, by a search over all meetings.

    python -m bench.belt_unattempted [--cell conveyor_sia20] [--items 100] [--seed 0] [--speed 0.5]
                                     [--gap 3.4,4.0] [--camera] [--every 0.02]

Plays one trial of a fresh stream, as ``apc run-trial`` does, and keeps every query that was answered by a
refusal: from where the arm stood, at the time at which it could have left, with what was known of the belt.
For each item that was not attempted and never had a plan, all of its queries are asked once more for a
contact at one place, for every place along the window, without the bounds by which a query ends early: a
plan contradicts the refusal. Items that had a plan, when another one was taken, and items that no query was
made for, as they passed while the arm was busy, are counted apart.
"""

from __future__ import annotations

import argparse
from collections import defaultdict
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from typing import Any
from unittest import mock

import numpy as np

from bench.belt_never import without_bounds
from pickcli.cell.cell_file import load_workcell
from pickcli.errors import NoPlanError
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept, why_never
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.random_scenes.make_stream import StreamRequest, make_stream
from pickcli.scene.item_stream import ItemStream
from pickcli.stream_trials import pick_queries
from pickcli.stream_trials.belt_camera import BeltCamera
from pickcli.stream_trials.stream_result import ItemOutcome
from pickcli.stream_trials.stream_trial import play_stream
from pickcli.stream_trials.stream_trial_request import StreamTrialRequest


@dataclass(frozen=True, eq=False)
class Refused:
    """A query that was refused.

    seen: the stream as it was perceived
    """

    context: PlanningContext
    seen: ItemStream
    query: InterceptQuery
    start: Start
    seed: int

    def could_be_met(self, every: float) -> float | None:
        """Return the first place along the window (m) at which there is a plan; None without one."""
        first, last = self.seen.belt.window
        for place in np.arange(first, last, every):
            try:
                at = replace(self.query, meet_at=float(place))
                plan_intercept(self.context, self.seen, at, self.start, self.seed)
            except NoPlanError:
                continue
            return float(place)
        return None


@contextmanager
def answers_noted(refused: dict[str, list[Refused]], planned_for: set[str]) -> Iterator[None]:
    """Note every query of a trial that is refused, by the item, and the items that there was a plan for."""

    def planned(context: PlanningContext, seen: ItemStream, query: InterceptQuery, start: Start, seed: int,
                certify: Any) -> Any:  # fmt: skip
        try:
            plan = plan_intercept(context, seen, query, start, seed, certify)
        except NoPlanError:
            refused[query.item].append(Refused(context, seen, query, start, seed))
            raise
        planned_for.add(query.item)
        return plan

    def never(context: PlanningContext, seen: ItemStream, query: InterceptQuery, start: Start) -> Any:
        if (why := why_never(context, seen, query, start)) is not None:
            refused[query.item].append(Refused(context, seen, query, start, 0))
        return why

    with ExitStack() as patches:
        for name, noted in (("plan_intercept", planned), ("why_never", never)):
            patches.enter_context(mock.patch.object(pick_queries, name, noted))
        yield


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cell", default="conveyor_sia20")
    parser.add_argument("--items", type=int, default=100)
    parser.add_argument("--seed", type=int, default=0, help="of the stream and of the trial")
    parser.add_argument("--speed", type=float, default=0.5)
    parser.add_argument("--gap", default="3.4,4.0", help="LO,HI in m")
    parser.add_argument("--camera", action="store_true", help="items are known by tracks of a camera")
    parser.add_argument("--every", type=float, default=0.02, help="m between places that are tried")
    options = parser.parse_args()
    workcell, (low, high) = load_workcell(options.cell), map(float, options.gap.split(","))
    contexts = [PlanningContext(cell) for cell in workcell.arms.values()]
    stream = make_stream(
        contexts[0].cell, StreamRequest(options.items, options.speed, (low, high)), options.seed
    )
    request = StreamTrialRequest(stream, camera=BeltCamera() if options.camera else None, seed=options.seed)
    refused, planned_for = defaultdict[str, list[Refused]](list), set[str]()
    with answers_noted(refused, planned_for):
        result = play_stream(request, contexts).result
    missed = [each for each in result.items if each.outcome is ItemOutcome.NOT_ATTEMPTED]
    delivered = sum(each.outcome is ItemOutcome.DELIVERED for each in result.items)
    print(f"{delivered} of {len(result.items)} delivered, {len(missed)} not attempted")
    had_plan = sum(each.item in planned_for for each in missed)
    asked = [each for each in missed if refused[each.item] and each.item not in planned_for]
    busy = len(missed) - had_plan - len(asked)
    print(f"of these {had_plan} had a plan, {busy} passed while the arm was busy, {len(asked)} were refused")
    feasible = 0
    for each in asked:
        with without_bounds():
            places = map(partial(Refused.could_be_met, every=options.every), refused[each.item])
            place = next((at for at in places if at is not None), None)
        feasible += place is not None
        told = "no meeting is feasible" if place is None else f"could be met at {place:.2f} m"
        print(f"  {each.item}: {told}; {len(refused[each.item])} queries; {each.reason}", flush=True)
    print(f"{feasible} of {len(asked)} could have been met")


if __name__ == "__main__":
    main()
