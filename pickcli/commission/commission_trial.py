"""Plays a commission: a tree decides what truck and arm do next, as in the chain of APPLE.

Truck and arm move one at a time, and hand over at rest: the truck drives only with the arm at home.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from pickcli.commission.belts_arm import BeltsArm
from pickcli.commission.commission_arm import CommissionArm
from pickcli.commission.commission_result import (
    ActionError,
    CommissionedItem,
    CommissionedOutcome,
    CommissionResult,
    CommissionStep,
    FloorDeviation,
    WatchedPeople,
)
from pickcli.commission.commission_station import CommissionStation
from pickcli.commission.commission_truck import CommissionTruck, TruckDrive, deviation
from pickcli.commission.people_watch import BoothWatch, PeopleWatch
from pickcli.driving.driving_area import DrivingArea
from pickcli.driving.simulated_drives import DriveNoise
from pickcli.geometry import Array
from pickcli.pallet_trials.pallet_result import SetDownDeviation
from pickcli.planning.planning_context import PlanningContext
from pickcli.progress import Progress, ProgressObserver, nobody
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.simulation.motion_recorder import MotionRecorder
from pickcli.simulation.reality import DEFAULT, Reality
from pickcli.strategy.node_types import TrialKind, TruckGoal
from pickcli.strategy.strategy_file import load_strategy
from pickcli.strategy.strategy_tree import Argument, Strategy
from pickcli.strategy.tree_player import TreePlayer
from pickcli.trial.pose_noise import DEFAULT_NOISE
from pickcli.trial.scene_plan import ScenePlan

STRATEGY = "apple"
NOISE = PoseNoise(position=0.002, angle=DEFAULT_NOISE.angle / 2)  # of items as the arm sees them
LIFT_TIME = 3.0  # s to raise or lower the forks; ours
LOOK_CHARGE = 0.5  # s for each look at load and pallet
DRIVE_CHARGE = 2.0  # s for each drive that is planned, in which the truck stands
MOST_TIME = 900.0  # s after which nothing is begun any more
MOST_TICKS = 2000  # of the tree


@dataclass(frozen=True, eq=False)
class CommissionRequest:
    """Everything that a trial of a commission depends on, besides commission and cell.

    Attributes:
        strategy: Decides what is done next.
        noise: Bounds of the errors of perceived poses of items.
        reality: Levels of the deviations of the simulated world from its model.
        drive_noise: Errors of localisation and of drives.
        seed: Seed of all random choices.
        watched: How drives are watched for people; None if nobody else is in the booth, and nobody watches.
    """

    strategy: Strategy = field(default_factory=lambda: load_strategy(STRATEGY, TrialKind.COMMISSION))
    noise: PoseNoise = NOISE
    reality: Reality = DEFAULT
    drive_noise: DriveNoise = field(default_factory=DriveNoise)
    seed: int = 0
    watched: BoothWatch | None = None


@dataclass(frozen=True, eq=False)
class TimedDrive:
    """A drive on the clock of the trial.

    Attributes:
        t_start: s.
        drive: The drive.
    """

    t_start: float
    drive: TruckDrive


@dataclass(frozen=True, eq=False)
class PlayedCommission:
    """A played trial.

    Attributes:
        result: What came of it.
        drives: All drives, in order.
        recorder: The motion of arm and items in the frame of the truck, on the clock of its world.
        arm_from: s of the trial at which that clock begins.
        plans: Plans of the arm that were executed, in order.
        before: The true scene around the truck as it came to the load; None if it did not.
        on_forks: (3,) m, m, rad: where the pallet truly was in the frame of the truck; None if it was not
            entered.
    """

    result: CommissionResult
    drives: tuple[TimedDrive, ...]
    recorder: MotionRecorder
    arm_from: float
    plans: tuple[ScenePlan, ...]
    before: Scene | None
    on_forks: Array | None


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
            if (is_success := player.tick()) is not None:
                if not is_success and not trial.aborted:
                    trial.end_here()
                break
        else:
            trial.aborted = f"the tree did not end in {MOST_TICKS} ticks"
        return trial.finished()
    finally:
        trial.arm.close()


@dataclass
class _Tried:
    """What was done about an item, and where it was set down."""

    attempts: int = 0
    is_open: bool = True
    is_placed: bool = False
    set_down: SetDownDeviation | None = None


class _CommissionTrial:
    """The clock of a trial, its truck and arm, and what was tried. It carries out the actions of the tree."""

    def __init__(
        self, request: CommissionRequest, station: CommissionStation, context: PlanningContext,
        on_progress: ProgressObserver,
    ) -> None:  # fmt: skip
        self.station, self.on_progress = station, on_progress
        self._request = request
        oversee = None if request.watched is None else self._oversee
        self.truck = CommissionTruck(station, request.drive_noise, request.seed, oversee)
        of_cell = CommissionArm if station.hand is None else BeltsArm
        self.arm = of_cell(station, context, request.noise, request.reality, request.seed)
        self.tried = {each.carton.id: _Tried() for each in station.placements}
        self.chosen = self.aborted = ""
        self.at_load = False
        self.arm_from = 0.0  # s of the trial at which the world of the arm was put up, or now before
        self.delivered: FloorDeviation | None = None
        self.steps: list[CommissionStep] = []
        self.drives: list[TimedDrive] = []

    # The tree ----------------------------------------------------------------------------------------

    @property
    def now(self) -> float:
        """Time on the trial's clock, s."""
        return self.arm_from + self.arm.t

    @property
    def time_left(self) -> float:
        """Time until nothing is begun any more, s."""
        return MOST_TIME - self.now

    def run(self, name: str, arguments: Mapping[str, Argument]) -> tuple[bool, str]:
        """Carry out a condition or an action; return its success, and the item that it was for."""
        if name == "has_open_items":
            return any(each.is_open for each in self.tried.values()), ""
        if name == "is_item_open":
            return self.chosen in self.tried and self.tried[self.chosen].is_open, self.chosen
        decided = sum(not each.is_open for each in self.tried.values())
        self.on_progress(Progress(decided, len(self.tried), name))
        began, reason, is_success, n_met = self.now, "", True, len(self.arm.collisions)
        try:
            figures = self._action(name)(**arguments)
        except ActionError as failed:
            figures, reason, is_success = failed.figures, str(failed), False
        if met := self.arm.collisions[n_met:]:
            figures = {**figures, "contacts": [asdict(each) for each in met]}
        target = self.chosen if name in ("choose_item", "transfer_item", "skip_item") else ""
        label = " ".join([name, *map(str, arguments.values())])
        self.steps.append(CommissionStep(label, target, began, self.now, is_success, reason, figures))
        return is_success, target

    def _action(self, name: str) -> Callable[..., dict[str, Any]]:
        if self.time_left <= 0.0 and name not in ("home_arm", "end_here"):
            raise ActionError(f"{MOST_TIME:g} s are over")
        actions: dict[str, Callable[..., dict[str, Any]]] = {
            "enter_pallet": self.enter_pallet, "lift_pallet": self.lift_pallet, "drive": self.drive,
            "choose_item": self.choose_item, "look_at_load": self.look_at_load,
            "transfer_item": self.transfer_item, "skip_item": self.skip_item, "home_arm": self.home_arm,
            "set_down_pallet": self.set_down_pallet, "end_here": self.end_here,
        }  # fmt: skip
        return actions[name]

    def _pass(self, seconds: float) -> None:
        """Let time pass in which neither truck nor arm moves."""
        if self.arm.before is None:
            self.arm_from += seconds
        else:
            self.arm.wait(seconds)

    # Truck -------------------------------------------------------------------------------------------

    def enter_pallet(self) -> dict[str, Any]:
        """Drive into the pallet."""
        return self._driven(self.truck.enter)

    def lift_pallet(self) -> dict[str, Any]:
        """Raise the forks."""
        self.truck.raise_forks()
        self._pass(LIFT_TIME)
        return {}

    def drive(self, to: str) -> dict[str, Any]:
        """Drive to a place, with the arm at home."""
        if not self.arm.is_home:
            raise ActionError("the arm is not at home")
        goal = TruckGoal(to)
        if goal is TruckGoal.LOAD and self.arm.before is not None:
            raise ActionError("the load was left, and is not come back to")
        self.at_load = False
        if goal is TruckGoal.DELIVERY:
            return self._driven(lambda: self.truck.to_delivery(self.arm.pallet_on_forks))
        figures = self._driven(self.truck.to_load if goal is TruckGoal.LOAD else self.truck.leave)
        self.at_load = goal is TruckGoal.LOAD
        return figures

    def _driven(self, drive: Callable[[], TruckDrive | None]) -> dict[str, Any]:
        """Drive, also if that fails at its end, and let the time pass with what is on the pallet."""
        self._pass(DRIVE_CHARGE)
        n_before = len(self.truck.drives)
        try:
            done = drive()
            return {} if done is None else done.figures
        finally:
            for each in self.truck.drives[n_before:]:
                self.drives.append(TimedDrive(self.now, each))
                self.arm.ride(each.felt)
                self._pass(max(0.0, each.duration - (self.now - self.drives[-1].t_start)))

    def _oversee(self, drive: str, area: DrivingArea) -> PeopleWatch:
        """What watches a drive that begins now."""
        booth, seed = self._request.watched, self._request.seed
        assert booth is not None
        return PeopleWatch(booth, drive, area, self.now, seed, len(self.truck.drives))

    def set_down_pallet(self) -> dict[str, Any]:
        """Lower the forks."""
        self.delivered = self.truck.set_down()
        self._pass(LIFT_TIME)
        return {"off_m": self.delivered.distance, "turned_rad": self.delivered.turn}

    def end_here(self) -> dict[str, Any]:
        """End the commission where the truck stands."""
        failed = [each for each in self.steps if not each.is_success]
        self.aborted = f"{failed[-1].action}: {failed[-1].reason}" if failed else "the tree ended it"
        return {}

    # Arm ---------------------------------------------------------------------------------------------

    def choose_item(self) -> dict[str, Any]:
        """Choose the open item whose place is the first in the sequence in which places are filled."""
        still_open = [name for name, each in self.tried.items() if each.is_open]
        if not still_open:
            self.chosen = ""
            raise ActionError("no item is open")
        self.chosen = min(still_open, key=self.arm.place_in_sequence)
        return {}

    def skip_item(self) -> dict[str, Any]:
        """Give the chosen item up, unless it is decided."""
        if self.chosen not in self.tried:
            raise ActionError("no item is chosen")
        self.tried[self.chosen].is_open = False
        return {}

    def look_at_load(self) -> dict[str, Any]:
        """Look at what stands around; the first look puts the world of the arm up."""
        if not self.at_load or self.truck.on_forks is None:
            raise ActionError("the truck does not stand at the load with a pallet")
        self._pass(LOOK_CHARGE)
        if self.arm.before is None:
            self.arm.put_up(self.truck.true, self.truck.on_forks)
        self.arm.look()
        return {}

    def transfer_item(self) -> dict[str, Any]:
        """Put the chosen item on the pallet."""
        if not self.at_load:
            raise ActionError("the truck does not stand at the load")
        if self.chosen not in self.tried or not self.tried[self.chosen].is_open:
            raise ActionError("no open item is chosen")
        if any(each.attempts for each in self.tried.values()):
            self.arm.look()  # what was seen before has changed
        done = self.arm.transfer(self.chosen)
        self.chosen = name = done.item
        tried = self.tried[name]
        tried.attempts += 1
        tried.set_down = done.set_down
        for each, other in self.tried.items():  # others may have been taken along
            other.is_open &= self.arm.is_on_load(each)
        if done.set_down is not None and done.set_down.is_in_place:
            tried.is_placed = True
            return {**done.figures, **({"trouble": done.trouble} if done.trouble else {})}
        where = f"ended {done.set_down}"
        if done.set_down is None:
            where = "stands on the load again" if self.arm.has(name) else "was taken away by hand"
        raise ActionError("; ".join(filter(None, (done.trouble, f"{name} {where}"))), done.figures)

    def home_arm(self) -> dict[str, Any]:
        """Move the arm home."""
        self.arm.go_home()
        return {}

    # The end -----------------------------------------------------------------------------------------

    def finished(self) -> PlayedCommission:
        """Return what came of everything."""
        arm, truck = self.arm, self.truck
        handling = ("look_at_load", "transfer_item", "home_arm")
        result = CommissionResult(
            tuple(self.steps), tuple(self._item(each.id) for each in self.station.commission.items),
            self.delivered, deviation(truck.true, self.station.commission.end),
            len(arm.collisions) + truck.n_collisions, arm.n_limit_violations, arm.n_stops, self.aborted,
            self.now,
            sum(each.t_end - each.t_start for each in self.steps if each.action in handling),
            _people_met(truck.drives) if self._request.watched else None,
        )  # fmt: skip
        return PlayedCommission(
            result, tuple(self.drives), arm.recorder, self.arm_from, tuple(arm.plans), arm.before,
            truck.on_forks,
        )  # fmt: skip

    def _item(self, name: str) -> CommissionedItem:
        tried = self.tried[name]
        is_left = self.arm.before is None or self.arm.is_on_load(name)
        at_end = None if is_left else self.arm.set_down_of(name)
        outcome = CommissionedOutcome.LEFT if is_left else CommissionedOutcome.LOST
        if tried.is_placed and at_end is not None and at_end.is_in_place:
            outcome = CommissionedOutcome.PLACED
        place = self.arm.place_of(name)
        return CommissionedItem(name, outcome, place, tried.attempts, tried.set_down, at_end)


def _people_met(drives: list[TruckDrive]) -> WatchedPeople:
    """What all drives tell of people."""
    outcomes = [each.watched for each in drives if each.watched is not None]
    return WatchedPeople(
        len({person.name for each in outcomes for person in each.people}),
        sum(each.braked for each in outcomes),
        sum(each.n_requests for each in outcomes),
        sum(len(each.touched) for each in outcomes),
        sum(len(each.walked_in) for each in outcomes),
    )
