"""Plays a trial of a stream: items come along a conveyor, and are taken off it one after the other.

The belt runs on while the arm plans and moves. Before each decision the items on the belt are perceived, and
picks of the next ones are planned, side by side; which of them is carried out is a matter of their deadlines
(``pick_schedule``). The clock is simulated time, so that trials can be repeated exactly; the queries of a
decision are charged with a fixed time, before the motion, in which the one before may still be under way.
Every motion is executed in a world of its own, which begins with what is on the belt then; delivered items
are taken out of where they were brought to. Of several arms one moves at a time.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from pickcli.errors import NoPlanError
from pickcli.geometry import inverse, pose
from pickcli.motion.plan import Plan, times_at_work
from pickcli.planning.belt_picks.belt_query import InterceptQuery
from pickcli.planning.belt_picks.intercept import plan_intercept, why_never
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.progress import Progress, ProgressObserver, nobody
from pickcli.scene.item_stream import ItemStream, RidingItem
from pickcli.scene.scene import PoseNoise
from pickcli.seeds import derived_rng, derived_seed
from pickcli.simulation.execute import OnStep, execute
from pickcli.simulation.execution import Execution
from pickcli.simulation.motion_recorder import MotionRecorder
from pickcli.simulation.reality import DEFAULT, Reality
from pickcli.simulation.world import World
from pickcli.stream_trials.belt_camera import BeltCamera
from pickcli.stream_trials.belt_perception import BeltPerception
from pickcli.stream_trials.meeting_watch import MeetingWatch
from pickcli.stream_trials.pick_schedule import PlannedPick, next_pick
from pickcli.stream_trials.stream_arms import StreamArms, destination_of
from pickcli.stream_trials.stream_result import (
    ItemOutcome,
    MeetingRecord,
    StreamItemResult,
    StreamTrialResult,
)
from pickcli.stream_trials.stream_rules import StreamRule
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive
from pickcli.verification.verify import certifier

QUERY_CHARGE = 0.3  # s of the belt's time for a query, which takes 0.25 s with verification
COMMITTED = 2.0 * QUERY_CHARGE  # s before a plan has to begin, in which it is not planned once more
LOOK_AGAIN = 0.1  # s until the next look if nothing can be done: PR2 saw the belt at 10 Hz
TRY_AGAIN = 0.5  # s after which an item without a plan is tried again
LEAST_SHARE = 0.9  # of the least time that a pick took: a shorter one is not expected
MOST_ATTEMPTS = 3  # at one item: on a belt that stands it does not leave
MOVED = 0.003  # m by which an item on the belt is off where it rode, from which on its track begins anew
PARKED = 0.15  # s that parking may take longer than planned, after which the other arm begins
RESET_TIME = 10.0  # s after a protective stop until the arm is at home again, by hand
SPEED_ERROR = 0.0008  # m/s, standard deviation of the PR2's estimate of its belt's speed, here as a bound


@dataclass(frozen=True, eq=False)
class StreamTrialRequest:
    """Everything that a trial of a stream depends on.

    Attributes:
        stream: The true stream.
        noise: Bounds of the errors of perceived poses.
        speed_error: m/s, bound of the error of the perceived speed.
        camera: Camera by whose tracks the items are known, instead of by poses with these errors; None for
            those.
        reality: Levels of the deviations of the simulated world from its model.
        rule: Where items are met, and by which arm.
        seed: Seed of all random choices.
    """

    stream: ItemStream
    noise: PoseNoise = DEFAULT_NOISE
    speed_error: float = SPEED_ERROR
    camera: BeltCamera | None = None
    reality: Reality = DEFAULT
    rule: StreamRule = StreamRule.EARLIEST
    seed: int = 0


@dataclass(frozen=True, eq=False)
class StreamPlan:
    """A plan that was executed.

    Attributes:
        plan: The certified plan.
        seen: The stream as it was perceived, in which the plan was certified from its time on; None for the
            way of an arm to where it is parked.
    """

    plan: Plan
    seen: ItemStream | None


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


@dataclass
class _Item:
    """What is known of an item of the stream, truly: where it rides, and what was tried."""

    riding: RidingItem
    attempts: int = 0
    reason: str = ""
    t_next: float = 0.0
    t_end: float | None = None
    met: MeetingRecord | None = None
    arm: str = ""
    clearance: float | None = None
    cost_bound: float | None = None
    was_known: bool = False
    refusals: dict[str, str] = field(default_factory=dict)  # why an arm had no plan when it was first asked
    is_planned: bool = False  # whether there was a plan when it was last asked for

    def refuse(self, arm: str, why: str) -> None:
        """Note why an arm has no plan. Asked again later it is only later, so that its first reason stays."""
        self.refusals.setdefault(arm, why)
        if len(self.refusals) > 1:
            self.reason = "; ".join(f"arm {name}: {each}" for name, each in self.refusals.items())
        else:
            self.reason = self.refusals[arm]

    def had_plan(self) -> None:
        """Forget why there was no plan before: if it passes now, that is for others."""
        self.is_planned, self.reason = True, ""
        self.refusals.clear()

    def was_refused(self, t: float) -> None:
        """Ask again later, but at once for what had a plan just before, at a time t (s)."""
        self.t_next = t if self.is_planned else t + TRY_AGAIN
        self.is_planned = False


@dataclass(frozen=True, eq=False)
class _Option:
    """A pick that can be carried out next.

    item: what is taken
    context: that of the arm that takes it
    parking: motion of the arm that acts before; None if it is parked, or takes the item
    t_begins: s of the stream at which the first of these motions starts
    t: s of the stream at which the plan starts
    planned: the plan
    """

    item: _Item
    context: PlanningContext
    parking: Plan | None
    t_begins: float
    t: float
    planned: StreamPlan


class _StreamTrial:
    """The state of a trial: time, arms, and items that are still open or decided."""

    def __init__(self, request: StreamTrialRequest, contexts: Sequence[PlanningContext]) -> None:
        self.request, self.arms = request, StreamArms(contexts)
        self.stream, camera = request.stream, request.camera
        self.tracks = None if camera is None else BeltPerception(self.stream, camera, request.seed)
        self.recorder, self.plans = MotionRecorder(self.arms.positions), list[StreamPlan]()
        self.t, self.look = 0.0, 0
        self.open = {riding.id: _Item(riding) for riding in self.stream.items}
        self.decided: dict[str, StreamItemResult] = {}
        self.n_collisions = self.n_limit_violations = self.n_stops = 0
        self.t_end = 0.0
        self.took: PlanningContext | None = None  # that of the arm which took the last item
        self.parking: tuple[int, Plan | NoPlanError | None] | None = None  # the last, with its look
        self.least_taking = np.inf  # s from when the arm moves until an item is off the belt
        self.planning_ms: list[float] = []
        self.refusing_ms: list[float] = []

    def decide(self) -> None:
        """Take one of the next items, or let time pass."""
        self._close_those_past()
        believed = self._perceived()
        for riding in believed.items:
            self.open[riding.id].was_known = True
        takeable, is_alone = self._takeable(believed), self._plans_for_one(believed)
        options, refused, asking = list[_Option](), list[_Item](), 0.0
        for item in takeable:
            option, lasted = self._option(believed, item, self.t + (asking if is_alone else 0.0))
            asking = asking + lasted if is_alone else max(asking, lasted)
            if option is None:
                refused.append(item)
            else:
                options.append(option)
                if is_alone or len(options) == self.request.rule.most_planned:
                    break
        if options:
            left = [item for item in takeable if item not in refused]
            chosen = next_pick(self._picks(options), self._deadlines(believed, left))
            self._take_or_wait(options[chosen])
        else:
            self.t += asking if refused else LOOK_AGAIN

    def _plans_for_one(self, believed: ItemStream) -> bool:
        """Whether the first item with a plan is taken: queries are made one after the other then."""
        return self.request.rule.most_planned == 1 or believed.speed == 0.0

    def _takeable(self, believed: ItemStream) -> list[_Item]:
        """Return the items on the belt that may be asked for now, by when they leave the window."""
        found = list[_Item]()
        on_belt = [riding for riding in believed.items if believed.is_on_belt(riding, self.t)]
        for riding in sorted(on_belt, key=lambda each: -believed.travel_at(each, self.t)):
            item = self.open[riding.id]
            if self.t < item.t_next:
                continue
            if too_late := self._why_too_late(believed, riding):
                item.reason = item.reason or too_late
            else:
                found.append(item)
        return found

    def _take_or_wait(self, option: _Option) -> None:
        """Take an item, or plan once more while nothing has to begin yet and a camera sees more of it.

        The arm rests meanwhile, so that the plan which is carried out begins where the others did.
        """
        is_waiting = self.tracks is not None and option.parking is None
        if is_waiting and _rests_until(option.planned.plan) > COMMITTED:
            self.t += QUERY_CHARGE
        else:
            self._take(option)

    def _picks(self, options: Sequence[_Option]) -> list[PlannedPick]:
        """Return the picks among which one is chosen."""
        picks = list[PlannedPick]()
        for each in options:
            lasts = each.t - self.t + each.planned.plan.trajectory.duration
            picks.append(PlannedPick(each.item.riding.id, lasts, lasts - _rests_until(each.planned.plan)))
        return picks

    def _deadlines(self, believed: ItemStream, items: Sequence[_Item]) -> dict[str, float]:
        """Return the s from now in which the picks of items have to begin, by those that were carried out."""
        if believed.speed == 0.0:
            return {}
        takes = self.least_taking if self.least_taking < np.inf else 0.0
        return {each.riding.id: self._seconds_left(believed, each.riding.id) - takes for each in items}

    def _seconds_left(self, believed: ItemStream, item_id: str) -> float:
        """Time (s) until an item leaves the window of a running belt."""
        travel = believed.travel_at(believed.find(item_id), self.t)
        return (believed.belt.window[1] - travel) / believed.speed

    def _option(self, believed: ItemStream, item: _Item, t: float) -> tuple[_Option | None, float]:
        """Plan to take an item with the first arm in turn that can, asked one after the other from t (s) on.

        Returns the pick, None if no arm can take the item, and the s that refused queries took.
        """
        arms, lasted = self.arms, 0.0
        for context in self.request.rule.in_turn(arms.all, arms.context, self.took):
            is_acting = context is arms.context
            parking = None if is_acting else self._parking(believed)
            if isinstance(parking, NoPlanError):
                item.refuse(context.cell.arm, str(parking))
                break
            parked = 0.0 if parking is None else parking.trajectory.duration + PARKED
            start = arms.start if is_acting else arms.home(context)
            planned = self._planned(believed, item.riding.id, context, start, t + lasted + parked)
            if planned is not None:
                item.had_plan()
                return _Option(item, context, parking, t + lasted, t + lasted + parked, planned), lasted
            lasted += QUERY_CHARGE
        item.was_refused(self.t)
        return None, lasted

    def _take(self, option: _Option) -> None:
        """Take an item, once the arm that acted is parked if another one does."""
        self.t = option.t_begins
        if option.parking is not None and not self._park(option.item, option.parking, option.t):
            return
        if option.context is not self.arms.context:
            self.arms.let_act(option.context)
        self._execute(option.item, option.planned)

    def _parking(self, believed: ItemStream) -> Plan | NoPlanError | None:
        """Plan to park the arm that acts, once for each look; None if it is parked."""
        if self.parking is None or self.parking[0] != self.look:
            seed = derived_seed("parking", self.request.seed, self.look)
            try:
                self.parking = self.look, self.arms.parking(believed, self.t, seed)
            except NoPlanError as error:
                self.parking = self.look, error
        return self.parking[1]

    def _park(self, item: _Item, parking: Plan, until: float) -> bool:
        """Park the arm that acts, and wait until a time (s); False if its motion was stopped."""
        true, t_start = self._riding(), self.t
        world = self._world(true)
        run = self._carried_out(StreamPlan(parking, None), world)
        self._pass(true, t_start, t_start + run.t_end)
        self._update_truth(world, t_start + world.t, true, item)
        self._count(item, run)
        world.close()
        self.arms.start = Start(world.q.copy(), world.tool_state)
        if run.stop is not None:
            self._by_hand()
            return False
        self.t = max(self.t, until)
        return True

    def _why_too_late(self, believed: ItemStream, riding: RidingItem) -> str:
        """Say that an item leaves its window sooner than any pick so far took, or than any arm can by bounds.

        Both are told at once, at no charge; "" if it may be taken.
        """
        if believed.speed == 0.0:
            return ""
        left = self._seconds_left(believed, riding.id)
        if left < LEAST_SHARE * self.least_taking < np.inf:
            takes = f"no pick took less than {self.least_taking:.1f} s"
            return f"too late: it leaves the window in {left:.1f} s, {takes}"
        arms, reasons = self.arms, list[str]()
        acting = (arms.context, arms.start)
        for context, start in (acting, *((other, arms.home(other)) for other in arms.others)):
            query = self._query(riding.id, self.t, context)
            never = why_never(context, replace(believed, cell=context.cell), query, start)
            if never is None:
                return ""
            reasons.append(str(never))
        return reasons[0]

    def played(self) -> PlayedStream:
        """Return the trial, whose items are all decided."""
        result = StreamTrialResult(
            self.stream.speed,
            tuple(self.decided[riding.id] for riding in self.request.stream.items),
            self.n_collisions,
            self.n_limit_violations,
            self.n_stops,
            self.t_end,
            tuple(self.planning_ms),
            tuple(self.refusing_ms),
        )
        return PlayedStream(result, self.recorder, tuple(self.plans))

    def _close_those_past(self) -> None:
        """Close the items that have left the window, or lie on a belt that stands and were tried."""
        last = self.stream.belt.window[1]
        for item_id, item in list(self.open.items()):
            is_past = self.stream.travel_at(item.riding, self.t) > last
            if self.stream.speed == 0.0 and not self.stream.is_on_belt(item.riding, self.t):
                item.reason, is_past = "it is not on the belt, which stands", True
            is_given_up = self.stream.speed == 0.0 and item.t_next > 0.0
            if is_past or is_given_up or item.attempts >= MOST_ATTEMPTS:
                outcome = ItemOutcome.LOST if item.attempts else ItemOutcome.NOT_ATTEMPTED
                self._close(item_id, outcome)

    def _close(self, item_id: str, outcome: ItemOutcome) -> None:
        item = self.open.pop(item_id)
        missed = "the arm was busy with others" if item.was_known else "it was never seen well enough"
        reason = item.reason or ("" if outcome is ItemOutcome.DELIVERED else missed)
        self.decided[item_id] = StreamItemResult(
            item_id, outcome, item.attempts, reason, item.t_end, item.met, item.arm, item.clearance,
            item.cost_bound,
        )  # fmt: skip

    def _riding(self) -> ItemStream:
        """Return the true stream of the items that are still open; of one by one, the first of them."""
        items = tuple(item.riding for item in self.open.values())
        return replace(self.stream, items=items[:1] if self.stream.one_by_one else items)

    def _perceived(self) -> ItemStream:
        """Perceive what was on the belt when the query had to begin, with errors of poses and speed.

        From then on the encoder tells how far it has gone. The speed is an upper bound, so that plans wait
        for the belt, and not the belt for plans; its stated error holds the true one.
        """
        self.look += 1
        request, true = self.request, self._riding()
        if self.tracks is not None:
            known = self.tracks.known(true, self.t, QUERY_CHARGE)
            return replace(known, items=tuple(each for each in known.items if each.id in self.open))
        t_seen = self.t - QUERY_CHARGE
        seen = perceive(true.scene_at(t_seen), request.noise, request.seed, self.look, request.reality)
        off = derived_rng("belt speed", request.seed, self.look).uniform(-1.0, 1.0) * request.speed_error
        most = min(true.speed + off + request.speed_error, true.belt.max_speed)
        T_now_world = pose((true.speed * QUERY_CHARGE, 0.0, 0.0)) @ inverse(true.carrier.T_world_carrier)
        items = tuple(
            RidingItem(placed.id, placed.item, self.t, T_now_world @ placed.T_world_item)
            for placed in seen.items
        )
        if true.speed == 0.0:
            return replace(true, items=items, noise=request.noise)
        error = 2.0 * request.speed_error
        return replace(true, items=items, speed=most, speed_error=error, noise=request.noise)

    def _query(self, item_id: str, t: float, context: PlanningContext) -> InterceptQuery:
        """Return the query for an item by an arm from a time (s) on."""
        place = self.request.rule.meeting_place(context, self.stream.carrier)
        return InterceptQuery(item_id, t, destination_of(context.cell), place)

    def _planned(
        self, believed: ItemStream, item_id: str, context: PlanningContext, start: Start, t: float
    ) -> StreamPlan | None:
        """Plan to take an item with an arm from a time (s) on; remember why not."""
        seen = replace(believed, cell=context.cell)
        query = self._query(item_id, t, context)
        scene, seed = seen.scene_at(t), self.request.seed
        began = time.perf_counter()
        filtered = self.request.rule.filtered(context, seen, query, seed)
        try:
            plan = plan_intercept(filtered.context, seen, query, start, seed, certifier(scene))
        except NoPlanError as error:
            self.refusing_ms.append(1e3 * (time.perf_counter() - began))
            self.open[item_id].refuse(context.cell.arm, str(filtered.explained(error)))
            return None
        self.planning_ms.append(1e3 * (time.perf_counter() - began))
        return StreamPlan(plan, seen)

    def _execute(self, item: _Item, planned: StreamPlan) -> None:
        """Execute a plan in a world with what is truly on the belt."""
        true, t_start, context, plan = self._riding(), self.t, self.arms.context, planned.plan
        item.attempts, item.reason, item.arm = item.attempts + 1, "", context.cell.arm
        item.refusals.clear()
        item.clearance = None if plan.certificate is None else plan.certificate.min_clearance
        item.cost_bound = plan.statistics.get("transit_cost_bound")
        self.took = context
        if plan.tracking is not None:
            takes = times_at_work(plan.segments)[1] - _moves_from(plan)
            self.least_taking = min(self.least_taking, takes)
        world = self._world(true)
        release_time = context.settings.release_time
        watch = MeetingWatch(plan, world, context.method.rests(context.cell.devices, release_time).taking)
        run = self._carried_out(planned, world, watch.after_step)
        # Clear of what the belt brings, the empty arm goes on from where it came to rest.
        goes_on = run.stop is None or (bool(run.is_clear) and world.held is None)
        # The arm goes on while what it has dropped still falls.
        self._pass(true, t_start, t_start + run.t_end, 0.0 if goes_on else RESET_TIME)
        self._update_truth(world, t_start + world.t, true, item)
        item.t_end, self.t_end = self.t, self.t
        item.met = watch.measured(t_start)
        self._count(item, run)
        self.arms.start = Start(world.q.copy(), world.tool_state)
        if not goes_on:
            self._by_hand()
        where = world.placed(plan.grasp.item).location if plan.grasp is not None else ""
        if where in self.arms.destinations:
            self._close(item.riding.id, ItemOutcome.DELIVERED)
        elif where != next(iter(true.carrier.places)):
            item.reason = item.reason or f"it is {where}"
            self._close(item.riding.id, ItemOutcome.LOST)
        else:
            item.reason = item.reason or "it stayed on the belt"
        world.close()

    def _world(self, true: ItemStream) -> World:
        """Return a world with what is truly on the belt now, and the arm that acts where it is."""
        arms, seed = self.arms, derived_seed("items", self.request.seed)
        scene = replace(true.scene_at(self.t), cell=arms.context.cell)
        world = World(scene, arms.start.q, arms.start.tool_state, reality=self.request.reality, seed=seed)
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

    def _pass(self, true: ItemStream, t_start: float, t_end: float, hidden: float = 0.0) -> None:
        """Let the time pass in which an arm moved, and hid the belt for so many s longer."""
        self.t = t_end
        if self.tracks is not None:
            self.tracks.take(true, t_start)
            self.tracks.hide(t_start, t_end + hidden)

    def _by_hand(self) -> None:
        """Let the arm that acts be brought home by hand."""
        self.t, self.arms.start = self.t + RESET_TIME, self.arms.home(self.arms.context)

    def _count(self, item: _Item, run: Execution) -> None:
        """Count what must not happen, and note what stopped the motion."""
        self.n_collisions += len(run.collisions)
        self.n_limit_violations += len(run.limit_violations)
        self.n_stops += run.stop is not None
        if run.stop is not None:
            item.reason = "; on the way off: ".join(map(str, (run.stop, *run.stops_on_way_off)))

    def _update_truth(self, world: World, t: float, true: ItemStream, item: _Item) -> None:
        """Note where the items truly are at a time (s); those that a motion knocked off the belt are lost."""
        T_belt_world, taken = inverse(true.carrier.T_world_carrier), item.riding.id
        for placed in world.scene.items:
            other = self.open[placed.id]
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


def _moves_from(plan: Plan) -> float:
    """Time (s) of a plan at which the arm begins to move."""
    moves = np.flatnonzero(np.abs(plan.trajectory.velocities).max(axis=1) > 0.0)
    return float(plan.trajectory.times[max(0, int(moves[0]) - 1)])


def _rests_until(plan: Plan) -> float:
    """Time (s) of a plan at which the arm begins to move, or a device is switched."""
    switched = (event.t_trigger for event in plan.events if event.t_trigger is not None)
    return min(_moves_from(plan), *switched)
