"""Plays a commission: a tree decides what truck and arm do next, as in the chain of APPLE.

Truck and arm move one at a time, and hand over at rest. Drives are planned on the lattice from where the truck
believes to be, and followed with noise; the pallet is found in simulated depth pictures on the way into it. In
front of the load a simulated world is put up around the truck where it truly stands: there the arm sees load,
pallet and items with errors, and every motion is planned, verified and executed as in other trials. As the
truck drives on, the same world is accelerated as its frame is, with the items on the pallet.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from pickcli.driving.drive_plan import DrivePlan, plan_drive
from pickcli.driving.drive_tracking import PERIOD
from pickcli.driving.driving_area import DrivingArea, StatedPallet
from pickcli.driving.free_space_proof import clearances
from pickcli.driving.pallet_entry import plan_entry, plan_entry_anew, plan_exit, pallet_gap
from pickcli.driving.simulated_drives import (
    END_POSITION,
    END_YAW,
    DriveNoise,
    FollowedDrives,
    NoisyTruck,
    followed,
)
from pickcli.driving.simulated_entries import enter_pallet
from pickcli.driving.steering_path import posed, seen_from, wrapped
from pickcli.driving.tricycle import Tricycle
from pickcli.errors import InputError, NoPlanError
from pickcli.geometry import Array, inverse
from pickcli.motion.plan import Plan
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.progress import Progress, ProgressObserver, nobody
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.seeds import derived_rng, derived_seed
from pickcli.simulation.execute import execute
from pickcli.simulation.motion_recorder import MotionRecorder
from pickcli.simulation.reality import DEFAULT, Reality
from pickcli.simulation.world import World
from pickcli.strategy.node_types import TrialKind, TruckGoal
from pickcli.strategy.strategy_file import load_strategy
from pickcli.strategy.strategy_tree import Argument, Strategy
from pickcli.strategy.tree_player import TreePlayer
from pickcli.trial.certifier import Certifier
from pickcli.trial.commission import LOAD, PALLET
from pickcli.trial.commission_result import (
    CommissionedItem,
    CommissionResult,
    CommissionStep,
    ItemOutcome,
    PlanarDeviation,
)
from pickcli.trial.commission_station import CommissionStation, with_thing_at
from pickcli.trial.pallet_result import SetDownDeviation
from pickcli.trial.pose_noise import perceive
from pickcli.trial.standing_items import standing
from pickcli.verification.verify import verify

STRATEGY = "apple"
NOISE = PoseNoise(position=0.002, angle=float(np.deg2rad(0.5)))  # of items as the arm sees them
LIFT_TIME = 3.0  # s to raise or lower the forks; ours
LOOK_CHARGE = 0.5  # s for each look at load and pallet
QUERY_CHARGE = 0.3  # s for each query, in which the arm rests
DRIVE_CHARGE = 2.0  # s for each drive that is planned, in which the truck stands
SETTLING = 0.2  # s after which an item that was set down is at rest
RESET_TIME = 10.0  # s after a protective stop until the arm is at home again, by hand
MOST_TIME = 900.0  # s after which nothing is begun any more
MOST_TICKS = 2000  # of the tree
AT_HOME = 0.01  # rad, within which the arm counts as at home
STRAIGHT = {TruckGoal.LOAD: 0.2, TruckGoal.DELIVERY: -0.3}  # m of the last part of drives
NEAR = 0.02, float(np.deg2rad(0.7))  # m and rad of its goal, where a truck believes to have arrived


@dataclass(frozen=True, eq=False)
class CommissionRequest:
    """Everything that a trial of a commission depends on, besides commission and cell.

    Attributes:
        strategy: Decides what is done next.
        noise: Bounds of the errors of perceived poses of items.
        reality: Levels of the deviations of the simulated world from its model.
        drive_noise: Errors of localisation and of drives.
        seed: Seed of all random choices.
    """

    strategy: Strategy = field(default_factory=lambda: load_strategy(STRATEGY, TrialKind.COMMISSION))
    noise: PoseNoise = NOISE
    reality: Reality = DEFAULT
    drive_noise: DriveNoise = field(default_factory=DriveNoise)
    seed: int = 0


@dataclass(frozen=True, eq=False)
class SeenPlan:
    """A plan that was executed.

    Attributes:
        plan: The certified plan.
        seen: The scene that it was certified for.
    """

    plan: Plan
    seen: Scene


@dataclass(frozen=True, eq=False)
class DrivenPath:
    """One drive as it was driven.

    Attributes:
        name: What it was for.
        t_start: s of the trial.
        poses: (T, 3) m, m, rad: true poses of the truck, ``PERIOD`` apart.
        is_loaded: Whether the pallet was on the forks.
    """

    name: str
    t_start: float
    poses: Array
    is_loaded: bool


@dataclass(eq=False)
class PlayedCommission:
    """A played trial.

    Attributes:
        result: What came of it.
        drives: All drives, in order.
        recorder: The motion in front of the load and afterwards, in the frame of the truck.
        arm_from: s of the trial at which that motion begins.
        plans: Plans of the arm that were executed, in order.
        before: The true scene around the truck as it came to the load; None if it did not.
    """

    result: CommissionResult
    drives: tuple[DrivenPath, ...]
    recorder: MotionRecorder
    arm_from: float
    plans: tuple[SeenPlan, ...]
    before: Scene | None


def play_commission(
    request: CommissionRequest,
    station: CommissionStation,
    context: PlanningContext,
    on_progress: ProgressObserver = nobody,
) -> PlayedCommission:
    """Play a commission until its tree succeeds or fails.

    Args:
        request: The conditions.
        station: The commission in its cell.
        context: The station's cell, its models and its precomputed files.
        on_progress: Called before every action with the number of items that are decided.

    Returns:
        What came of it, with all motion.
    """
    trial = _CommissionTrial(request, station, context, on_progress)
    player = TreePlayer(request.strategy.root, trial)
    try:
        for _ in range(MOST_TICKS):
            if player.tick() is not None:
                break
        else:
            trial.abort(f"the tree did not end in {MOST_TICKS} ticks")
        return trial.finished()
    finally:
        trial.close()


class _Unable(Exception):
    """Why an action fails."""


@dataclass
class _Tried:
    """What was done about an item, and where it was set down."""

    attempts: int = 0
    is_open: bool = True
    is_placed: bool = False
    set_down: SetDownDeviation | None = None


class _CommissionTrial:
    """The state of a trial: truck, pallet, arm and items. It carries out the actions of the tree."""

    def __init__(
        self, request: CommissionRequest, station: CommissionStation, context: PlanningContext,
        on_progress: ProgressObserver,
    ) -> None:  # fmt: skip
        self.request, self.station, self.context = request, station, context
        self.on_progress = on_progress
        commission, seed = station.commission, request.seed
        area = commission.area
        self.truck = NoisyTruck(
            area.truck, area.start, request.drive_noise, 1, derived_rng("commission drives", seed)
        )
        self.pallet = _really_off(commission.pallet, seed)
        self.pallet_on_forks: Array | None = None  # (3,) m, m, rad in the frame of the truck
        self.pallet_stands: Array | None = None  # (3,) m, m, rad: where it was set down
        self.is_raised = False
        self.delivered: PlanarDeviation | None = None
        home = station.cell.home
        self.arm = self.home = Start(home.q, home.tool_state)
        self.world: World | None = None
        self.before: Scene | None = None
        self.arm_from = 0.0
        self.recorder = MotionRecorder()
        self.seen: Scene | None = None
        self.tried = {each.id: _Tried() for each in commission.items}
        self.places = {each.carton.id: each for each in station.placements}
        self.chosen = ""
        self.t = self.handling = 0.0
        self.steps: list[CommissionStep] = []
        self.drives: list[DrivenPath] = []
        self.plans: list[SeenPlan] = []
        self.figures: dict[str, Any] = {}
        self.note = ""
        self.aborted = ""
        self.n_collisions = self.n_limit_violations = self.n_stops = self.n_looks = 0

    # The tree ----------------------------------------------------------------------------------------

    @property
    def now(self) -> float:
        """Time on the trial's clock, s."""
        return self.t

    @property
    def time_left(self) -> float:
        """Time until nothing is begun any more, s."""
        return MOST_TIME - self.t

    def run(self, name: str, arguments: Mapping[str, Argument]) -> tuple[bool, str]:
        """Carry out a condition or an action; return its success, and the item that it was for."""
        if name == "has_open_items":
            return any(each.is_open for each in self.tried.values()), ""
        decided = sum(not each.is_open for each in self.tried.values())
        self.on_progress(Progress(decided, len(self.tried), name))
        began, self.figures, self.note = self.t, {}, ""
        is_success = True
        try:
            if self.time_left <= 0.0 and name != "end_here":
                raise _Unable(f"{MOST_TIME:g} s are over")
            self._actions()[name](**arguments)
        except _Unable as reason:
            is_success, self.note = False, str(reason)
        target = self.chosen if name in ("choose_item", "transfer_item", "skip_item") else ""
        label = " ".join([name, *map(str, arguments.values())])
        self.steps.append(
            CommissionStep(label, target, began, self.t, is_success, self.note, self.figures)
        )
        return is_success, target

    def _actions(self) -> Mapping[str, Callable[..., None]]:
        return {
            "enter_pallet": self.enter_pallet, "lift_pallet": self.lift_pallet, "drive": self.drive,
            "choose_item": self.choose_item, "look_at_load": self.look_at_load,
            "transfer_item": self.transfer_item, "skip_item": self.skip_item, "home_arm": self.home_arm,
            "set_down_pallet": self.set_down_pallet, "end_here": self.end_here,
        }  # fmt: skip

    def abort(self, why: str) -> None:
        """Note why the commission ends early."""
        self.aborted = self.aborted or why

    # Truck and pallet --------------------------------------------------------------------------------

    @property
    def believed(self) -> Array:
        """(3,) m, m, rad: where the truck believes to be."""
        believed: Array = self.truck.believed[0].copy()
        return believed

    def enter_pallet(self) -> None:
        """Drive into the pallet where it is seen on the way."""
        if self.pallet_on_forks is not None:
            raise _Unable("the forks are in the pallet already")
        area, expected = self.station.entering(self.believed), self.station.commission.pallet
        is_first = not any(each.name == "enter_pallet" for each in self.drives)
        plan = self._planned(lambda: (plan_entry if is_first else plan_entry_anew)(area, expected))
        seed = derived_seed("commission looks", self.request.seed, len(self.drives))
        entry = enter_pallet(area, plan, self.pallet, self.truck, seed)
        self._driven("enter_pallet", entry.poses, entry.duration, area)
        self.figures |= {"pictures_with_pallet": entry.n_seen, "renewals": entry.n_renewed, "stops": entry.n_stops}
        if entry.has_given_up:
            raise _Unable("the pallet was not seen, or there is no path into where it was seen")
        (real,) = self.pallet.real
        self._count_meeting(area, real)
        self.figures |= _off_figures(entry.off)
        self.pallet_on_forks = seen_from(self.truck.true[0], real.pose)

    def _count_meeting(self, area: DrivingArea, pallet: StatedPallet) -> None:
        """Count whether the truck met a pallet in its last drive, into it or out of it."""
        gap = pallet_gap(area, pallet, self.drives[-1].poses)
        self.n_collisions += gap <= 0.0
        self.figures["pallet_gap_m"] = gap

    def lift_pallet(self) -> None:
        """Raise the forks."""
        if self.pallet_on_forks is None:
            raise _Unable("no pallet is on the forks")
        self.t += LIFT_TIME
        self.is_raised = True

    def drive(self, to: str) -> None:
        """Drive to a place, with the arm at home."""
        goal = TruckGoal(to)
        if not self._is_home():
            raise _Unable("the arm is not at home")
        if goal is TruckGoal.END:
            self._drive_out()
            return
        if not self.is_raised:
            raise _Unable("no pallet is raised")
        if goal is TruckGoal.LOAD and self.world is not None:
            raise _Unable("the load was left, and is not come back to")
        at = self.station.at_load if goal is TruckGoal.LOAD else self._delivering_at()
        area = self.station.loaded(self.believed, at, STRAIGHT[goal])
        if not _is_near(self.believed, at):
            self._follow(f"drive {to}", self._planned(lambda: plan_drive(area)), is_loaded=True)
        self._refuse_far(at)

    def _delivering_at(self) -> Array:
        """Where the truck is to stand so that the pallet, as it was seen last, is where it is delivered."""
        on_forks = self.station.pallet_in_truck
        if self.seen is not None:
            T = self.seen.pose_of(self.station.cell.carriers[PALLET]).T_world_carrier
            on_forks = np.array([T[0, 3], T[1, 3], np.arctan2(T[1, 0], T[0, 0])])
        return with_thing_at(self.station.commission.delivery, on_forks)

    def _drive_out(self) -> None:
        """Drive out of the pallet that was set down."""
        if self.pallet_stands is None:
            raise _Unable("the pallet is not set down")
        area, end = self.station.leaving(self.believed), self.station.commission.end
        pallet = replace(
            self.station.commission.pallet, pose=posed(self.believed, self.station.pallet_in_truck)
        )
        if not any(each.name == "drive end" for each in self.drives):
            self._follow("drive end", self._planned(lambda: plan_exit(area, pallet)), is_loaded=False)
            assert self.pallet_stands is not None
            self._count_meeting(area, replace(pallet, pose=self.pallet_stands))
        elif not _is_near(self.believed, end):
            self._follow("drive end", self._planned(lambda: plan_drive(area)), is_loaded=False)
        self._refuse_far(end)

    def _planned(self, plan: Callable[[], DrivePlan]) -> DrivePlan:
        """Plan a drive while the truck stands."""
        self.t += DRIVE_CHARGE
        self.truck.localise()
        try:
            return plan()
        except (InputError, NoPlanError) as error:
            raise _Unable(str(error)) from None

    def _follow(self, name: str, plan: DrivePlan, is_loaded: bool) -> None:
        """Drive a plan, with all that stands on the pallet."""
        drive = followed(plan, self.truck)
        duration = float(drive.durations[0])
        n = int(round(duration / PERIOD)) + 1
        self._driven(name, drive.poses[:n, 0], duration, plan.area, is_loaded)
        self.figures["planned_duration"] = plan.profile.duration
        if self.world is not None and is_loaded:
            self._ride(self.world, drive, plan.area.truck)

    def _driven(
        self, name: str, poses: Array, duration: float, area: DrivingArea, is_loaded: bool = False
    ) -> None:
        """Count a drive, and whether the truck met anything but a pallet on the way."""
        least = float(clearances(area if is_loaded else _without_pallet(area), poses).min())
        self.n_collisions += least <= 0.0
        self.drives.append(DrivenPath(name, self.t, poses, is_loaded))
        self.t += duration
        self.figures |= {"drive_s": duration, "clearance_m": least}

    def _ride(self, world: World, drive: FollowedDrives, truck: Tricycle) -> None:
        """Accelerate the world as the pallet is in a drive."""
        for name in self.places:
            if world_has(world, name):
                world.engine.wake(name)
        for acceleration in _felt(drive, truck, float(self.station.pallet_in_truck[0])):
            world.engine.accelerate((float(acceleration[0]), float(acceleration[1])))
            world.wait(PERIOD)
        world.engine.accelerate((0.0, 0.0))
        world.wait(SETTLING)

    def _refuse_far(self, goal: Array) -> None:
        self.figures |= _off_figures(_off(self.truck.true[0], goal))
        if not _is_near(self.believed, goal):
            off = _off(self.believed, goal)
            raise _Unable(f"the truck stands {np.hypot(*off[:2]):.3f} m beside its goal")

    def set_down_pallet(self) -> None:
        """Lower the forks; what is said of the pallet is where it truly stands then."""
        if not self.is_raised or self.pallet_on_forks is None:
            raise _Unable("no pallet is raised")
        self.t += LIFT_TIME
        self.is_raised = False
        self.pallet_stands = posed(self.truck.true[0], self.pallet_on_forks)
        off = _off(self.pallet_stands, self.station.commission.delivery)
        self.delivered = PlanarDeviation(float(np.hypot(*off[:2])), abs(float(off[2])))
        self.figures |= _off_figures(off)

    def end_here(self) -> None:
        """End the commission where the truck stands."""
        failed = next((each for each in reversed(self.steps) if not each.is_success), None)
        self.abort("" if failed is None else f"{failed.action}: {failed.reason}")

    # Arm and items -----------------------------------------------------------------------------------

    def _is_home(self) -> bool:
        return bool(np.abs(self.arm.q - self.home.q).max() <= AT_HOME)

    def choose_item(self) -> None:
        """Choose the first open item in the sequence in which they are put up."""
        self.chosen = next((name for name in self.places if self.tried[name].is_open), "")
        if not self.chosen:
            raise _Unable("no item is open")

    def skip_item(self) -> None:
        """Give the chosen item up."""
        if not self.chosen:
            raise _Unable("no item is chosen")
        self.tried[self.chosen].is_open = False

    def look_at_load(self) -> None:
        """Look at what stands around; the first look puts the simulated world up."""
        if self.pallet_on_forks is None or not self.is_raised:
            raise _Unable("no pallet is raised")
        if self.world is None:
            scene = self.station.scene(self.truck.true[0], self.pallet_on_forks)
            if why := self.station.off_bounds(scene):
                self.t += LOOK_CHARGE
                raise _Unable(why)
            self._put_up(scene)
        assert self.world is not None
        self._pass(LOOK_CHARGE)
        self.seen = self._look(self.world)

    def _put_up(self, scene: Scene) -> None:
        self.before, self.arm_from = scene, self.t
        self.world = World(
            scene, self.home.q, self.home.tool_state, reality=self.request.reality, seed=self.request.seed
        )
        self.world.observer = self.recorder.look

    def _pass(self, seconds: float) -> None:
        """Let time pass while the arm rests."""
        if self.world is not None:
            self.world.wait(seconds)
        self.t += seconds
        self.handling += seconds

    def _look(self, world: World) -> Scene:
        """Perceive the world; items stand level, at the heights that follow from their shapes."""
        self.n_looks += 1
        request = self.request
        looked = perceive(world.now(), request.noise, request.seed, self.n_looks, request.reality)
        heights = {each.id: float(each.item.shape.extents[2]) / 2 for each in looked.items}
        return standing(self.station.seen(looked, request.seed, self.n_looks), heights)

    def transfer_item(self) -> None:
        """Take the chosen item from the load to its place on the pallet."""
        world = self._at_load()
        name, tried = self.chosen, self.tried.get(self.chosen)
        if tried is None or not tried.is_open:
            raise _Unable("no open item is chosen")
        if not world_has(world, name) or world.placed(name).location != LOAD:
            tried.is_open = False
            raise _Unable(f"{name} is not on the load any more")
        if tried.attempts or any(each.set_down is not None for each in self.tried.values()):
            self.seen = self._look(world)  # what was seen before has changed
        query = PickQuery(LOAD, name, PALLET, at=self.station.stated(self.places[name]))
        certifier = Certifier(verify)
        seen = self.seen
        assert seen is not None
        self._pass(QUERY_CHARGE)
        seed = derived_seed("commission pick", self.request.seed, name, tried.attempts)
        try:
            plan = plan_pick(self.context, seen, query, self.arm, seed, certify=certifier.within(seen))
        except NoPlanError as error:
            raise _Unable(str(error)) from None
        tried.attempts += 1
        trouble = self._execute(plan, seen, world)
        self._pass(SETTLING)
        self._judge(name, tried, world, trouble)

    def _judge(self, name: str, tried: _Tried, world: World, trouble: str) -> None:
        """Say whether an item stands in its place after a motion."""
        if not world_has(world, name):
            tried.is_open = False
            raise _Unable(trouble or f"{name} was taken away by hand")
        tried.set_down = self._item_off(world, name)
        self.figures |= {"aside_m": tried.set_down.aside, "turn_rad": tried.set_down.turn}
        self.note = trouble
        if tried.set_down.is_in_place:
            tried.is_open, tried.is_placed = False, True
            return
        raise _Unable("; ".join(filter(None, (trouble, f"{name} ended {tried.set_down}"))))

    def _item_off(self, world: World, name: str) -> SetDownDeviation:
        """How far an item truly is from its place: a round one may be turned about its axis."""
        at = self.station.stated(self.places[name]).T_place_item
        T = inverse(world.scene.T_world_place(world.cell.places[PALLET])) @ world.engine.pose(name)
        off = T[:3, 3] - at[:3, 3]
        cosine = float(T[:3, 2] @ at[:3, 2])
        if len(world.scene.find(name).item.shape.size) == 3:
            cosine = (float(np.trace(at[:3, :3].T @ T[:3, :3])) - 1.0) / 2.0
        return SetDownDeviation(
            float(np.hypot(off[0], off[1])), float(off[2]), float(np.arccos(np.clip(cosine, -1.0, 1.0)))
        )

    def _at_load(self) -> World:
        """The world, while the truck stands at the load."""
        if self.world is None or self.seen is None or self.drives[-1].name != f"drive {TruckGoal.LOAD}":
            raise _Unable("the truck does not stand at a load that was looked at")
        return self.world

    def _execute(self, plan: Plan, seen: Scene, world: World) -> str:
        """Execute a plan; after a stop the arm is brought home by hand, without what it holds."""
        self.plans.append(SeenPlan(plan, seen))
        noted, before = self.recorder.begin(plan, world), world.t
        run = execute(plan, world, on_progress=lambda progress: noted.note(world, progress))
        noted.t_end = world.t
        self.n_collisions += len(run.collisions)
        self.n_limit_violations += len(run.limit_violations)
        self.n_stops += run.stop is not None
        self.figures["segments"] = [
            {"kind": str(each.kind), "s": each.t_end - each.t_start} for each in plan.segments
        ]
        if run.stop is None and world.held is None:
            self.arm = Start(world.q.copy(), world.tool_state)
        else:
            if world.held is not None:
                world.take_out(world.held)
            world.let_move(self.station.cell, self.home.q, self.home.tool_state)
            world.wait(RESET_TIME)
            self.arm = self.home
        self.t += world.t - before
        self.handling += world.t - before
        return run.trouble or ""

    def home_arm(self) -> None:
        """Move the arm home."""
        if self._is_home():
            return
        assert self.world is not None
        world = self.world
        seen = self._look(world)
        self._pass(QUERY_CHARGE)
        goal = MoveGoal(self.home.q, self.home.tool_state)
        seed = derived_seed("commission home", self.request.seed, len(self.plans))
        try:
            plan = plan_move(self.context, seen, self.arm, goal, seed, "home")
        except NoPlanError as error:
            raise _Unable(str(error)) from None
        verdict = verify(plan, seen, None)
        if verdict.certificate is None:
            raise _Unable("; ".join(map(str, verdict.reasons)))
        self.note = self._execute(replace(plan, certificate=verdict.certificate), seen, world)
        self.seen = seen
        if not self._is_home():
            raise _Unable(self.note or "the arm is not at home")

    # The end -----------------------------------------------------------------------------------------

    def finished(self) -> PlayedCommission:
        """Return what came of everything."""
        off = _off(self.truck.true[0], self.station.commission.end)
        result = CommissionResult(
            tuple(self.steps), tuple(self._item(each.id) for each in self.station.commission.items),
            self.delivered, PlanarDeviation(float(np.hypot(*off[:2])), abs(float(off[2]))),
            self.n_collisions, self.n_limit_violations, self.n_stops, self.aborted, self.t, self.handling,
        )  # fmt: skip
        return PlayedCommission(
            result, tuple(self.drives), self.recorder, self.arm_from, tuple(self.plans), self.before
        )

    def _item(self, name: str) -> CommissionedItem:
        tried, at_end = self.tried[name], None
        if tried.is_placed and self.world is not None:
            at_end = self._item_off(self.world, name)
        outcome = ItemOutcome.LOST if tried.attempts else ItemOutcome.LEFT
        if at_end is not None and at_end.is_in_place:
            outcome = ItemOutcome.PLACED
        return CommissionedItem(name, outcome, tried.attempts, tried.set_down, at_end)

    def close(self) -> None:
        """Free the simulated world."""
        if self.world is not None:
            self.world.close()


def world_has(world: World, name: str) -> bool:
    """Tell whether an item is in a world.

    Args:
        world: The world.
        name: Id of the item.

    Returns:
        True if it was not taken out.
    """
    return any(placed.id == name for placed in world.scene.items)


def _really_off(stated: StatedPallet, seed: int) -> StatedPallet:
    """The pallet as the commission states it, or anywhere within the tolerance if it says nothing."""
    if stated.off.any():
        return stated
    off = derived_rng("pallet", seed).uniform(-1.0, 1.0, 3) * stated.tolerance
    return replace(stated, off=off)


def _without_pallet(area: DrivingArea) -> DrivingArea:
    """The area with all that the truck must not meet: the last box may be the pallet that it leaves."""
    return replace(area, boxes=tuple(box for box in area.boxes if box.name != "the pallet"))


def _felt(drive: FollowedDrives, truck: Tricycle, x: float) -> Array:
    """(T, 2) m/s^2: accelerations of a point (x, 0) of the truck in its frame, as commanded."""
    moved = np.diff(drive.poses[:, 0, :2], axis=0, prepend=drive.poses[:1, 0, :2])
    heading = drive.poses[:, 0, 2]
    forwards = np.sign(moved[:, 0] * np.cos(heading) + moved[:, 1] * np.sin(heading))
    signed = forwards * drive.speeds[:, 0]
    along, yaw_rate = signed * np.cos(drive.steering[:, 0]), signed * np.sin(drive.steering[:, 0]) / truck.wheel_base
    gain, turn = np.gradient(along, PERIOD), np.gradient(yaw_rate, PERIOD)
    return np.column_stack([gain - yaw_rate**2 * x, along * yaw_rate + turn * x])


def _off(pose: Array, wanted: Array) -> Array:
    """(3,) m, m, rad of a pose in the frame of the wanted one."""
    off = seen_from(wanted, pose)
    return np.array([off[0], off[1], wrapped(off[2:])[0]])


def _is_near(pose: Array, wanted: Array) -> bool:
    off = _off(pose, wanted)
    return bool(np.hypot(*off[:2]) <= NEAR[0] and abs(off[2]) <= NEAR[1])


def _off_figures(off: Array) -> dict[str, float]:
    return {"off_m": float(np.hypot(*off[:2])), "turned_rad": abs(float(off[2]))}
