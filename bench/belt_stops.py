"""What happens if the arm or the belt is stopped at any phase of a pick from a running conveyor.

    python -m bench.belt_stops [--runs 200] [--seed 0] [--speed 0.33] [--json FILE]

As many stops of the arm (by the operator, for a second), of the belt (at the conveyor's greatest
acceleration, for a second and a half), belts that run away (to the greatest speed of the conveyor), and
belts that slow down (to ``SLOWED`` of their speed, at ``SLOWING``), each in a pick from a dense stream of
its own seed, at a time drawn evenly from the motion until the item is off the belt, and just after. Items
are perceived with the errors of a trial, and the world deviates from its model by the default levels. After
a motion that ended early, the belt carries the others on under the arm for two more seconds.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import count, islice
from pathlib import Path

import numpy as np

from pickcli.cell.cell_file import load_cell
from pickcli.errors import NoPlanError
from pickcli.geometry import inverse
from pickcli.motion.plan import Plan, times_at_work
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.random_scenes.make_stream import StreamRequest, make_stream
from pickcli.scene.item_stream import ItemStream, RidingItem
from pickcli.scene.scene import PlacedItem
from pickcli.seeds import derived_rng
from pickcli.simulation.execute import execute
from pickcli.simulation.operator_stop import OperatorStop, signal_of
from pickcli.simulation.world import World
from pickcli.stream_trials.stream_trial_request import SPEED_ERROR
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive
from pickcli.verification.verify import certifier

ARM, BELT, RUNS_AWAY, SLOWS = "arm", "belt", "belt runs away", "belt slows"
SLOWED, SLOWING = 0.8, 0.2  # of its speed, and m/s^2
CELL, GAP, N_ITEMS = "conveyor_sia20", (0.25, 0.60), 8
BEFORE_WINDOW = 0.4  # m of travel of the item before the window when its pick is planned
ARM_STOPPED, BELT_STOPPED = 1.0, 1.5  # s
AFTER_IT = 0.5  # s after the item is off the belt, until which stops are drawn
AFTERWARDS = 2.0  # s of the world after a motion that ended early
STAYED = 0.005  # m of an item off where it rode, within which it has not been moved


@dataclass(frozen=True)
class Pick:
    """A pick, planned in what is seen of a stream.

    true: what is on the belt, as it rides truly, from the start of the plan on
    """

    seed: int
    true: ItemStream
    plan: Plan


@dataclass(frozen=True)
class Stopped:
    """One pick in which something was stopped.

    stops: what was stopped, at ``t`` s of the plan, in ``phase`` of it
    cause: of a stop that ended the motion, "" if it went on
    off: what was amiss on the way off the belt
    clear: whether the arm rested clear of what the belt brings after that
    ends: where the target came to
    torn: whether the target was lost from the cup
    knocked: other items that were moved on the belt
    """

    stops: str
    seed: int
    t: float
    phase: str
    cause: str
    off: tuple[str, ...]
    clear: bool | None
    ends: str
    torn: bool
    knocked: int
    collisions: tuple[str, ...]
    limits: tuple[str, ...]


def picks(context: PlanningContext, speed: float, first_seed: int) -> Iterator[Pick]:
    """Yield picks from streams of one seed after the other, all that can be planned."""
    for seed in count(first_seed):
        stream = make_stream(context.cell, StreamRequest(N_ITEMS, speed, GAP), seed)
        target = stream.items[3]
        now = target.stamp + (stream.belt.window[0] - BEFORE_WINDOW - float(target.T_belt_item[0, 3])) / speed
        now = max(now, target.stamp)
        seen = _seen(stream, now, seed)
        home = context.cell.home
        try:
            plan = plan_intercept(
                context, seen, InterceptQuery(target.id, now), Start(home.q, home.tool_state), seed,
                certifier(seen.scene_at(now)),
            )  # fmt: skip
        except NoPlanError:
            continue
        yield Pick(seed, stream, plan)


def _seen(stream: ItemStream, now: float, seed: int) -> ItemStream:
    """Return the stream as a trial perceives it at a time (s)."""
    seen = perceive(stream.scene_at(now), DEFAULT_NOISE, seed, 0)
    T = inverse(stream.carrier.T_world_carrier)
    items = tuple(RidingItem(each.id, each.item, now, T @ each.T_world_item) for each in seen.items)
    off = derived_rng("belt speed", seed).uniform(-1.0, 1.0) * SPEED_ERROR
    most = min(stream.speed + off + SPEED_ERROR, stream.belt.max_speed)
    return replace(stream, items=items, speed=most, speed_error=2.0 * SPEED_ERROR, noise=DEFAULT_NOISE)


def stop(context: PlanningContext, pick: Pick, what: str) -> Stopped:
    """Carry a pick out, and stop something at a time of its motion."""
    plan, true = pick.plan, pick.true
    assert plan.tracking is not None and plan.grasp is not None
    now, home, draw = plan.tracking.t_stream, context.cell.home, derived_rng("stop", pick.seed, what)
    moves = np.flatnonzero(np.abs(plan.trajectory.velocities).max(axis=1) > 0.0)
    begins = float(plan.trajectory.times[max(0, int(moves[0]) - 1)])
    t = float(draw.uniform(begins, times_at_work(plan.segments)[1] + AFTER_IT))
    scene = true.scene_at(now)
    world = World(scene, home.q, home.tool_state, seed=pick.seed)
    world.run_belt(true.conveyor, true.speed)
    belt = world.belts[true.conveyor]
    changes = {
        ARM: (),
        BELT: ((t, 0.0), (t + BELT_STOPPED, true.speed)),
        RUNS_AWAY: ((t, true.belt.max_speed),),
        SLOWS: ((t, SLOWED * true.speed),),
    }[what]
    most = SLOWING if what == SLOWS else true.belt.max_acceleration

    def change(at: World) -> None:
        for t_change, speed in changes:
            if abs(at.t - t_change) < at.time_step / 2:
                belt.change_speed(speed, most)

    stops = (OperatorStop(t, t + ARM_STOPPED),) if what == ARM else ()
    run = execute(plan, world, operator=signal_of(stops), on_step=change)
    if run.stop is not None:
        world.wait(AFTERWARDS, change)
    target = plan.grasp.item
    where = "cup" if world.held == target else world.placed(target).location
    knocked = sum(_is_moved(world, true, each, now) for each in scene.items if each.id != target)
    collisions, releases = world.contacts.since(0.0), world.grip.releases
    world.close()
    return Stopped(
        what, pick.seed, t, _phase(plan, t), "" if run.stop is None else str(run.stop),
        tuple(map(str, run.stops_on_way_off)), run.is_clear, where,
        any(not each.is_wanted for each in releases), knocked,
        tuple(f"{c.a} and {c.b}, {1e3 * c.depth:.1f} mm" for c in collisions),
        tuple(map(str, run.limit_violations)),
    )  # fmt: skip


def _is_moved(world: World, true: ItemStream, placed: PlacedItem, now: float) -> bool:
    """Whether an item, still on the belt, is not where it would have ridden from a time (s) on."""
    travel = world.belts[true.conveyor].travel
    if true.travel_at(true.find(placed.id), now) + travel > true.belt.length:
        return False
    way = world.engine.pose(placed.id)[:3, 3] - placed.T_world_item[:3, 3]
    return float(np.linalg.norm(way - travel * true.carrier.T_world_carrier[:3, 0])) > STAYED


def _phase(plan: Plan, t: float) -> str:
    t_works, t_left = times_at_work(plan.segments)
    if t_works <= t < t_left:
        return str(next(s.kind for s in plan.segments if s.t_start <= t < s.t_end))
    return "coming" if t < t_works else "leaving"


def measure(n: int, first_seed: int, speed: float, whats: Sequence[str], log: Path | None) -> list[Stopped]:
    """Stop n picks for each of what is stopped; each result is appended to a log as it comes."""
    context, found = PlanningContext(load_cell(CELL)), list[Stopped]()
    for pick in islice(picks(context, speed, first_seed), n):
        for what in whats:
            found.append(stop(context, pick, what))
            if log is not None:
                with log.open("a") as file:
                    file.write(json.dumps(asdict(found[-1])) + "\n")
    return found


def table(found: Sequence[Stopped]) -> str:
    """Count what happened, by what was stopped."""
    lines = []
    for what in dict.fromkeys(each.stops for each in found):
        some = [each for each in found if each.stops == what]
        ends = Counter(each.ends for each in some)
        causes = Counter(each.cause.split(":")[0] for each in some if each.cause)
        off = Counter(each.split(":")[0] for one in some for each in one.off)
        lines.append(
            f"{what}: {len(some)} stops; {sum(bool(s.collisions) for s in some)} with collisions, "
            f"{sum(bool(s.limits) for s in some)} with broken limits, {sum(s.torn for s in some)} torn off, "
            f"{sum(s.knocked > 0 for s in some)} moved others, "
            f"{sum(s.clear is False for s in some)} not clear; "
            f"ends {dict(ends)}; ended early {dict(causes)}; on the way off {dict(off)}"
        )
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--speed", type=float, default=0.33)
    parser.add_argument("--stops", default=",".join((ARM, BELT, RUNS_AWAY, SLOWS)), help="what is stopped")
    parser.add_argument("--json", type=Path, help="file to which each result is appended")
    options = parser.parse_args()
    found = measure(options.runs, options.seed, options.speed, options.stops.split(","), options.json)
    print(table(found))


if __name__ == "__main__":
    main()
