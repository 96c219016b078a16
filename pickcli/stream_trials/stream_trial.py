"""Plays a trial of a stream: items come along a conveyor, and are taken off it one after the other.

The belt runs on while the arm plans and moves. Before each decision the items on the belt are perceived, and
picks of the next ones are planned, side by side; which of them is carried out is a matter of their deadlines
(``pick_schedule``). The clock is simulated time, so that trials can be repeated exactly; the queries of a
decision are charged with a fixed time, before the motion, in which the one before may still be under way.
Every motion is executed in a world of its own, which begins with what is on the belt then; delivered items
are taken out of where they were brought to.

Several arms may be on their way at the same time: each moves in a world of its own, with the items that no
other arm is at, and what they do is proven apart before and judged after it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.geometry import Array, inverse
from pickcli.motion.plan import times_at_work
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.progress import Progress, ProgressObserver, nobody
from pickcli.scene.item_stream import ItemStream, RidingItem
from pickcli.seeds import derived_seed
from pickcli.simulation.execute import OnStep, execute
from pickcli.simulation.execution import Execution
from pickcli.simulation.motion_recorder import MotionRecorder
from pickcli.simulation.world import World
from pickcli.stream_trials.belt_perception import BeltPerception
from pickcli.stream_trials.bounded_perception import perceive_stream
from pickcli.stream_trials.meeting_watch import MeetingWatch
from pickcli.stream_trials.open_item import OpenItem
from pickcli.stream_trials.pick_queries import (
    QUERY_CHARGE,
    BeltLook,
    PickOption,
    PickQueries,
    StreamPlan,
    late_by,
)
from pickcli.stream_trials.reserved_motion import ReservedMotion
from pickcli.stream_trials.stream_arms import StreamArm, StreamArms
from pickcli.stream_trials.stream_result import ItemOutcome, StreamItemResult, StreamTrialResult
from pickcli.stream_trials.stream_trial_request import StreamTrialRequest

COMMITTED = 2.0 * QUERY_CHARGE  # s before a plan has to begin, in which it is not planned once more
LOOK_AGAIN = 0.1  # s until the next look if nothing can be done: PR2 saw the belt at 10 Hz
MOST_ATTEMPTS = 3  # at one item: on a belt that stands it does not leave
MOVED = 0.003  # m by which an item on the belt is off where it rode, from which on its track begins anew
RESET_TIME = 10.0  # s after a protective stop until the arm is at home again, by hand


@dataclass(frozen=True, eq=False)
class PlayedStream:
    """A played trial.

    Attributes:
        result: What became of every item.
        recorder: The motion.
        plans: Plans that were executed, in order.
    """

    result: StreamTrialResult
    recorder: MotionRecorder
    plans: tuple[StreamPlan, ...]


def play_stream(
    request: StreamTrialRequest, contexts: Sequence[PlanningContext], on_progress: ProgressObserver = nobody
) -> PlayedStream:
    """Play a trial of a stream, until its last item is taken or has left the window.

    Args:
        request: The stream and the conditions.
        contexts: Of each arm, the preferred one first: the cell as it sees it, its models and its precomputed
            files.
        on_progress: Called at every decision with the number of items that are decided.

    Returns:
        What became of every item, with the motion.
    """
    trial = _StreamTrial(request, contexts)
    while trial.open:
        on_progress(Progress(len(trial.decided), len(request.stream.items), f"at {trial.t:.1f} s"))
        trial.decide()
    return trial.played()


@dataclass(frozen=True, eq=False)
class _PlayedPick:
    """A pick as it was carried out.

    Attributes:
        world: Its world, at its end.
        run: Its execution.
        watch: What watched the tool at the item.
        poses: s on the trial's clock, and (n,) joints then, after each step.
        t_end: s on that clock.
    """

    world: World
    run: Execution
    watch: MeetingWatch
    poses: list[tuple[float, Array]]
    t_end: float

    @property
    def goes_on(self) -> bool:
        """Whether the arm goes on from where it came to rest: clear of what the belt brings, and empty."""
        return self.run.stop is None or (bool(self.run.is_clear) and self.world.held is None)


class _StreamTrial:
    """The state of a trial: time, arms, and items that are still open or decided."""

    def __init__(self, request: StreamTrialRequest, contexts: Sequence[PlanningContext]) -> None:
        self.request, self.stream, camera = request, request.stream, request.camera
        # What moves over the belt hides it from a camera; on a belt that stands nothing has to be in time.
        is_run_by_bounds = camera is None and self.stream.speed > 0.0
        self.arms = StreamArms(contexts, request.rule.moves_together and is_run_by_bounds)
        self.tracks = None if camera is None else BeltPerception(self.stream, camera, request.seed)
        self.recorder, self.plans = MotionRecorder(self.arms.positions), list[StreamPlan]()
        self.t, self.look = 0.0, 0
        self.at_work = list[tuple[RidingItem, float]]()  # items that arms are at, on the belt until (s)
        self.open = {riding.id: OpenItem(riding) for riding in self.stream.items}
        self.decided: dict[str, StreamItemResult] = {}
        self.n_collisions = self.n_limit_violations = self.n_stops = 0
        self.t_end = self.together = 0.0
        self.queries = PickQueries(request, self.arms)

    def decide(self) -> None:
        """Take one of the next items, or let time pass."""
        if not self.arms.free(self.t):
            self.t = self.arms.next_free
        self._close_those_past()
        look = self._looked()
        for riding in look.stream.items:
            if riding.id in self.open:
                self.open[riding.id].was_known = True
        takeable = self._takeable(look)
        options, refused, asking = self._asked(look, takeable)
        if options:
            left = [item for item in takeable if item not in refused]
            self._take_or_wait(self.queries.chosen(look, options, left))
        else:
            self.t += asking if refused else LOOK_AGAIN

    def _asked(
        self, look: BeltLook, takeable: Sequence[OpenItem]
    ) -> tuple[list[PickOption], list[OpenItem], float]:
        """Ask for picks of the next items, one after the other or side by side.

        Returns the picks, the items without one, and the s that refused queries took.
        """
        options, refused, asking = list[PickOption](), list[OpenItem](), 0.0
        in_turn = self.queries.are_made_in_turn(look.stream)
        for item in takeable:
            option, lasted = self.queries.option(look, item, self.t + (asking if in_turn else 0.0))
            asking = asking + lasted if in_turn else max(asking, lasted)
            if option is None:
                refused.append(item)
            else:
                options.append(option)
                if in_turn or len(options) == self.request.rule.most_planned:
                    break
        return options, refused, asking

    def _takeable(self, look: BeltLook) -> list[OpenItem]:
        """Return the items on the belt that may be asked for now, by when they leave the window."""
        found, seen = list[OpenItem](), look.stream
        on_belt = [riding for riding in seen.items if seen.is_on_belt(riding, self.t)]
        for riding in sorted(on_belt, key=lambda each: -seen.travel_at(each, self.t)):
            item = self.open.get(riding.id)
            if item is None or self.t < item.t_next:
                continue
            if too_late := self.queries.why_too_late(look, riding):
                item.reason = item.reason or too_late
            else:
                found.append(item)
        return found

    def _take_or_wait(self, option: PickOption) -> None:
        """Take an item, or plan once more while nothing has to begin yet and a camera sees more of it.

        The arm rests meanwhile, so that the plan which is carried out begins where the others did.
        """
        if self.tracks is not None and option.planned.rests_until > COMMITTED:
            self.t += QUERY_CHARGE
        else:
            self.t = option.t
            self._execute(option)

    def played(self) -> PlayedStream:
        """Return the trial, whose items are all decided."""
        self.recorder.finish()
        result = StreamTrialResult(
            self.stream.speed,
            tuple(self.decided[riding.id] for riding in self.request.stream.items),
            self.n_collisions,
            self.n_limit_violations,
            self.n_stops,
            self.t_end,
            tuple(self.queries.planning_ms),
            tuple(self.queries.refusing_ms),
            self.together,
        )
        return PlayedStream(result, self.recorder, tuple(self.plans))

    def _close_those_past(self) -> None:
        """Close the items that have left the window, or lie on a belt that stands and were tried."""
        last = self.stream.belt.window[1]
        for item_id, item in list(self.open.items()):
            is_past = self.stream.travel_at(item.riding, self.t) > last
            if self.stream.speed == 0.0 and not self.stream.is_on_belt(item.riding, self.t):
                item.reason, is_past = "it is not on the belt, which stands", True
            is_given_up = self.stream.speed == 0.0 and item.is_refused
            if is_past or is_given_up or item.attempts >= MOST_ATTEMPTS:
                outcome = ItemOutcome.LOST if item.attempts else ItemOutcome.NOT_ATTEMPTED
                self._close(item_id, outcome)

    def _close(self, item_id: str, outcome: ItemOutcome) -> None:
        self.decided[item_id] = self.open.pop(item_id).result(outcome)

    def _riding(self) -> ItemStream:
        """Return the true stream of the items that no arm is at; of one by one, the first of them."""
        items = tuple(item.riding for item in self.open.values() if item.t_released <= self.t)
        return replace(self.stream, items=items[:1] if self.stream.one_by_one else items)

    def _on_belt(self) -> ItemStream:
        """Return the true stream with the items that arms are at, as long as these are on the belt."""
        true = self._riding()
        free = {riding.id for riding in true.items}
        taken = tuple(r for r, until in self.at_work if self.t < until and r.id not in free)
        return replace(true, items=(*true.items, *taken))

    def _looked(self) -> BeltLook:
        """Perceive what is on the belt, by a camera or with bounded errors."""
        self.look += 1
        true = self._on_belt()
        if self.tracks is None:
            seen = perceive_stream(self.request, true, self.look, self.t, QUERY_CHARGE)
            return BeltLook(self.look, self.t, seen)
        known = self.tracks.known(true, self.t, QUERY_CHARGE)
        still = tuple(each for each in known.items if each.id in self.open)
        return BeltLook(self.look, self.t, replace(known, items=still))

    def _execute(self, option: PickOption) -> None:
        """Execute a plan in a world with what is truly on the belt, but for what other arms are at."""
        true, rode, t_start = self._riding(), option.item.riding, self.t
        self._begin(option)
        played = self._simulated(option, true)
        self._note_times(option, played, rode)
        if self.tracks is not None:
            self.tracks.take(true, t_start)
            self.tracks.hide(t_start, played.t_end + (0.0 if played.goes_on else RESET_TIME))
        # The arm goes on while what it has dropped still falls.
        self._update_truth(played.world, t_start + played.world.t, true, option.item)
        self._count(option.item, played.run)
        self._note_motion(option, played)
        self._note_outcome(option.item, played.world, true)
        played.world.close()
        self.t = t_start + QUERY_CHARGE

    def _simulated(self, option: PickOption, true: ItemStream) -> _PlayedPick:
        """Carry a plan out now."""
        arm, planned, t_start = option.arm, option.planned, self.t
        context, world, poses = arm.context, self._world(true, arm), list[tuple[float, Array]]()
        takes = context.method.rests(context.cell.devices, context.settings.release_time).taking
        watch = MeetingWatch(planned.plan, world, takes)

        def after_step(now: World) -> None:
            watch.after_step(now)
            poses.append((t_start + now.t, now.q.copy()))

        run = self._carried_out(planned, world, after_step)
        return _PlayedPick(world, run, watch, poses, t_start + run.t_end)

    def _note_times(self, option: PickOption, played: _PlayedPick, rode: RidingItem) -> None:
        """Note when an arm was at an item, and how it met it."""
        item, plan, t_start = option.item, option.planned.plan, self.t
        item.t_end = item.t_next = played.t_end
        released = t_start + times_at_work(plan.segments)[1] + late_by(option.planned.seen, plan)
        item.t_released = min(released, played.t_end)
        self.at_work.append((rode, item.t_released))
        self.t_end = max(self.t_end, played.t_end)
        item.met = played.watch.measured(t_start)

    def _note_motion(self, option: PickOption, played: _PlayedPick) -> None:
        """Note how an arm moved, whether it met another one, and from where it goes on."""
        item, arm, world, t_start = option.item, option.arm, played.world, self.t
        self.together += self.arms.overlap(t_start, played.t_end)
        arm.start, arm.free_at = Start(world.q.copy(), world.tool_state), played.t_end
        arm.note_measured(played.poses, late_by(option.planned.seen, option.planned.plan))
        if (met := self.arms.why_met(arm, t_start)) is not None:
            self.n_collisions += 1
            item.reason = "; ".join(filter(None, (item.reason, f"{met} as measured")))
        if not played.goes_on:
            self.arms.bring_home(arm, RESET_TIME)

    def _begin(self, option: PickOption) -> None:
        """Note what an arm is to do, and with which item."""
        item, arm, plan = option.item, option.arm, option.planned.plan
        item.attempts, item.reason, item.arm = item.attempts + 1, "", arm.context.cell.arm
        item.refusals.clear()
        item.clearance = None if plan.certificate is None else plan.certificate.min_clearance
        item.cost_bound = plan.statistics.get("transit_cost_bound")
        self.queries.note_taking(arm, option.planned)
        seen = option.planned.seen.scene_at(self.t)
        arm.reserved = ReservedMotion.planned(arm.context.model, plan, seen, self.t)

    def _note_outcome(self, item: OpenItem, world: World, true: ItemStream) -> None:
        """Note where an item is that was attempted, and close it unless it is still on the belt."""
        where = world.placed(item.riding.id).location
        if where in self.arms.destinations:
            self._close(item.riding.id, ItemOutcome.DELIVERED)
        elif where != next(iter(true.carrier.places)):
            item.reason = item.reason or f"it is {where}"
            self._close(item.riding.id, ItemOutcome.LOST)
        else:
            item.reason = item.reason or "it stayed on the belt"

    def _world(self, true: ItemStream, arm: StreamArm) -> World:
        """Return a world with what is truly on the belt now, and an arm where it is."""
        start, seed = arm.start, derived_seed("items", self.request.seed)
        scene = replace(true.scene_at(self.t), cell=arm.context.cell)
        world = World(scene, start.q, start.tool_state, reality=self.request.reality, seed=seed)
        world.reseed(derived_seed("world", self.request.seed, self.look))
        if true.speed > 0.0:
            world.run_belt(true.conveyor, true.speed)
        self.recorder.enter(world, self.t)
        return world

    def _carried_out(self, planned: StreamPlan, world: World, on_step: OnStep | None = None) -> Execution:
        """Execute a plan in a world that begins now, and record it."""
        self.plans.append(planned)
        noted = self.recorder.begin(planned.plan, world)
        run = execute(planned.plan, world, on_step=on_step, on_progress=lambda done: noted.note(world, done))
        noted.t_end = noted.t_start + run.t_end
        return run

    def _count(self, item: OpenItem, run: Execution) -> None:
        """Count what must not happen, and note what stopped the motion."""
        self.n_collisions += len(run.collisions)
        self.n_limit_violations += len(run.limit_violations)
        self.n_stops += run.stop is not None
        if run.stop is not None:
            item.reason = "; on the way off: ".join(map(str, (run.stop, *run.stops_on_way_off)))

    def _update_truth(self, world: World, t: float, true: ItemStream, item: OpenItem) -> None:
        """Note where the items truly are at a time (s); those that a motion knocked off the belt are lost."""
        T_belt_world, taken = inverse(true.carrier.T_world_carrier), item.riding.id
        for placed in world.scene.items:
            if (other := self.open.get(placed.id)) is None:
                continue
            T = T_belt_world @ world.engine.pose(placed.id)
            ridden = true.travel_at(other.riding, t), *other.riding.T_belt_item[1:3, 3]
            has_moved = float(np.linalg.norm(T[:3, 3] - ridden)) > MOVED
            if self.tracks is not None and (has_moved or placed.id == taken):
                self.tracks.forget(placed.id)
            other.riding = replace(other.riding, stamp=t, T_belt_item=T)
            is_off = abs(T[1, 3]) > true.belt.width / 2 or T[2, 3] < 0.0
            if is_off and placed.id != taken:
                other.reason = f"knocked off the belt in an attempt at {taken}"
                self._close(placed.id, ItemOutcome.LOST)
