"""Plays a trial of a pallet: the arm stacks cartons that come one by one, in the sequence of a planned stack.

Each carton is planned, verified and executed as one pick from the infeed to its planned place, among the
cartons where they truly ended up. All happens in one simulated world, with one clock: while a query is
planned, for a fixed time, the arm rests, and the stack with it.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np

from pickcli.errors import NoPlanError
from pickcli.geometry import inverse
from pickcli.motion.plan import Plan
from pickcli.pallet_trials.pallet_result import (
    CartonOutcome,
    CartonResult,
    PalletTrialResult,
    SetDownDeviation,
)
from pickcli.pallet_trials.pallet_station import INFEED, PALLET, PalletStation
from pickcli.palletizing.pallet_stack import Placement
from pickcli.palletizing.pallet_stack_file import StackedPallet
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery, StatedPlace
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.progress import Progress, ProgressObserver, nobody
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.seeds import derived_rng
from pickcli.simulation.execute import execute
from pickcli.simulation.execution import Execution
from pickcli.simulation.motion_recorder import MotionRecorder
from pickcli.simulation.reality import DEFAULT, Reality
from pickcli.simulation.world import World
from pickcli.trial.certifier import Certifier
from pickcli.trial.pose_noise import perceive
from pickcli.trial.scene_plan import ScenePlan
from pickcli.trial.standing_items import standing
from pickcli.verification.verify import verify

QUERY_CHARGE = 0.3  # s for each query, in which the arm rests: what planning and verification take
AFTERWARDS = 2.0  # s after the last carton, in which all of them are awake
ARRIVES_OFF, ARRIVES_TURNED = 0.003, float(np.deg2rad(1.0))  # m and rad, at most: the infeed's stop has play
SETTLING = 0.2  # s after which a carton that was set down is at rest
RESET_TIME = 10.0  # s after a protective stop until the arm is at home again, by hand
MOST_ATTEMPTS = 2  # at a carton that stays on the infeed
NOISE = PoseNoise(position=0.001, angle=float(np.deg2rad(0.2)))  # the infeed has a stop; depth sees the stack


@dataclass(frozen=True, eq=False)
class PalletTrialRequest:
    """Everything that a trial of a pallet depends on.

    Attributes:
        stack: The planned stack.
        noise: Bounds of the errors of perceived poses.
        reality: Levels of the deviations of the simulated world from its model.
        seed: Seed of all random choices.
    """

    stack: StackedPallet
    noise: PoseNoise = NOISE
    reality: Reality = DEFAULT
    seed: int = 0


@dataclass(eq=False)
class PlayedPallet:
    """A played trial.

    Attributes:
        result: What became of every carton.
        recorder: The motion.
        plans: Plans that were executed, in order.
        after: The true scene at the end.
    """

    result: PalletTrialResult
    recorder: MotionRecorder
    plans: tuple[ScenePlan, ...]
    after: Scene


def play_pallet(
    request: PalletTrialRequest,
    station: PalletStation,
    context: PlanningContext,
    on_progress: ProgressObserver = nobody,
) -> PlayedPallet:
    """Play a trial of a pallet, until its last carton is put up or left.

    Args:
        request: The stack and the conditions.
        station: The cell, and the cartons as its items.
        context: The cell, its models and its precomputed files.
        on_progress: Called before every carton with the number of cartons that are decided.

    Returns:
        What became of every carton, with the motion.
    """
    trial = _PalletTrial(request, station, context)
    try:
        for k, placement in enumerate(request.stack.placements):
            on_progress(Progress(k, len(request.stack.placements), placement.carton.id))
            trial.stack(placement)
        return trial.finished()
    finally:
        trial.world.close()


@dataclass
class _Decided:
    """What is known of a carton that was tried: how often, why not, and where it was set down.

    t_start: s at which its query began. t_end: s at which its last motion ended
    """

    attempts: int = 0
    reason: str = ""
    t_start: float = 0.0
    t_end: float | None = None
    at: SetDownDeviation | None = None
    planning_ms: list[float] = field(default_factory=list)
    verifying_ms: list[float] = field(default_factory=list)

    def note(self, reason: str) -> None:
        """Add what went wrong, if anything did."""
        self.reason = "; then ".join(filter(None, (self.reason, reason)))


class _PalletTrial:
    """The state of a trial: the world, the arm, and the cartons that are decided."""

    def __init__(self, request: PalletTrialRequest, station: PalletStation, context: PlanningContext) -> None:
        self.request, self.station, self.context = request, station, context
        home = station.cell.home
        self.arm = self.home = Start(home.q, home.tool_state)
        self.world = World(
            station.empty(request.seed), home.q, home.tool_state, reality=request.reality, seed=request.seed
        )
        self.recorder = MotionRecorder()
        self.world.observer = self.recorder.look
        self.decided: dict[str, _Decided] = {}
        self.put: dict[str, Placement] = {}
        self.plans: list[ScenePlan] = []
        self.n_collisions = self.n_limit_violations = self.n_stops = self.look = 0

    def stack(self, placement: Placement) -> None:
        """Let a carton come, and put it up; what stays on the infeed is taken away by hand."""
        name = placement.carton.id
        carton = self.decided[name] = _Decided(t_start=self.world.t)
        if missing := [other for other in placement.rests_on if other not in self.put]:
            carton.reason = f"rests on {' and '.join(missing)}, which is not in its place"
            return
        self.world.bring_in(self.station.presented(placement.carton, self._arrival(name)))
        while carton.attempts < MOST_ATTEMPTS and self._is_on_infeed(name):
            plan = self._planned(placement, carton)
            if plan is None:
                break
            self._execute(plan, carton)
        if not self._is_there(name):
            return
        self.world.wait(SETTLING)
        at = self._off(placement)
        carton.at = at if carton.attempts else None
        if at.is_in_place:
            self.put[name] = placement
        else:
            carton.reason = carton.reason or f"it ended {at}"
            self.world.take_out(name)

    def _arrival(self, name: str) -> StatedPlace:
        """By how much a carton truly comes beside the middle of the infeed, and turned."""
        x, y, turn = derived_rng("arrival", self.request.seed, name).uniform(-1.0, 1.0, 3)
        return StatedPlace(ARRIVES_OFF * x, ARRIVES_OFF * y, 0.0, ARRIVES_TURNED * turn)

    def _is_there(self, name: str) -> bool:
        return any(placed.id == name for placed in self.world.scene.items)

    def _is_on_infeed(self, name: str) -> bool:
        return self._is_there(name) and self.world.placed(name).location == INFEED

    def _planned(self, placement: Placement, carton: _Decided) -> Plan | None:
        """Plan to put up a carton among what is perceived; remember why not."""
        self.look += 1
        request, world = self.request, self.world
        looked = perceive(world.now(), request.noise, request.seed, self.look, request.reality)
        heights = {name: float(other.centre[2]) for name, other in self.put.items()}
        heights[placement.carton.id] = placement.carton.size[2] / 2
        seen = standing(looked, heights)
        query = PickQuery(INFEED, placement.carton.id, PALLET, at=self.station.stated(placement))
        certifier = Certifier(verify)
        world.wait(QUERY_CHARGE)
        began = time.perf_counter()
        try:
            plan = plan_pick(
                self.context, seen, query, self.arm, request.seed, certify=certifier.within(seen)
            )
        except NoPlanError as error:
            carton.note(str(error))
            return None
        finally:
            carton.planning_ms.append(1e3 * (time.perf_counter() - began - certifier.seconds))
            carton.verifying_ms.append(1e3 * certifier.seconds)
        self.plans.append(ScenePlan(plan, seen))
        return plan

    def _execute(self, plan: Plan, carton: _Decided) -> None:
        """Execute a plan; after a stop the arm is brought home by hand, without what it holds."""
        world = self.world
        noted = self.recorder.begin(plan, world)
        run = execute(plan, world, on_progress=lambda progress: noted.note(world, progress))
        noted.t_end = carton.t_end = world.t
        carton.attempts += 1
        carton.note(run.trouble)
        self._count(run)
        if run.stop is None and world.held is None:
            self.arm = Start(world.q.copy(), world.tool_state)
            return
        if world.held is not None:
            world.take_out(world.held)
        world.let_move(self.station.cell, self.home.q, self.home.tool_state)
        world.wait(RESET_TIME)
        self.arm = self.home

    def _count(self, run: Execution) -> None:
        self.n_collisions += len(run.collisions)
        self.n_limit_violations += len(run.limit_violations)
        self.n_stops += run.stop is not None

    def _off(self, placement: Placement) -> SetDownDeviation:
        """Return how far a carton truly is from its planned place."""
        T_pallet_world = inverse(self.world.scene.T_world_place(self.station.pallet))
        return SetDownDeviation.of(placement, T_pallet_world @ self.world.engine.pose(placement.carton.id))

    def finished(self) -> PlayedPallet:
        """Wake all cartons, let them stand, and return what became of them."""
        t_end = max((each.t_end or 0.0 for each in self.decided.values()), default=0.0)
        for name in self.put:
            self.world.engine.wake(name)
        self.world.wait(AFTERWARDS)
        ends = {name: self._off(placement) for name, placement in self.put.items()}
        cartons = tuple(
            _result(name, each, ends.get(name), name in self.put) for name, each in self.decided.items()
        )
        result = PalletTrialResult(
            cartons,
            dict(self.request.stack.left),
            self.n_collisions,
            self.n_limit_violations,
            self.n_stops,
            t_end,
        )
        return PlayedPallet(result, self.recorder, tuple(self.plans), self.world.now())


def _result(name: str, decided: _Decided, end: SetDownDeviation | None, is_put: bool) -> CartonResult:
    lost = CartonOutcome.LOST if decided.attempts else CartonOutcome.LEFT
    return CartonResult(
        name, CartonOutcome.PLACED if is_put else lost, decided.attempts, decided.reason, decided.t_start,
        decided.t_end, decided.at, end, tuple(decided.planning_ms), tuple(decided.verifying_ms),
    )  # fmt: skip
