"""Implements the interfaces of a trial in the simulated world."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from pickcli.calibration.tote_location import LocatingSettings, locate_tote
from pickcli.cell.cell import ArmState, Cell
from pickcli.cell.device import DeviceKind
from pickcli.cell.tool import ToolState
from pickcli.errors import InputError, NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Certify, Plan, RecoveryLevel
from pickcli.planning.arm_choice import ArmSuitability, rank_arms
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.recovery.recovery_plan import plan_recovery
from pickcli.planning.recovery.retrace import ItemRecovery, StoppedMotion, bring_item
from pickcli.planning.start_state import Start
from pickcli.planning.topple import TopplingQuery, plan_topple
from pickcli.roadmap.query_experience import ExperienceRecorder
from pickcli.scene.scene import Scene
from pickcli.simulation.arm_turn import let_move
from pickcli.simulation.camera import overview
from pickcli.simulation.execute import execute, falls_of
from pickcli.simulation.execution import Execution
from pickcli.simulation.grip import Release
from pickcli.simulation.motion_recorder import MotionRecorder
from pickcli.simulation.plan_record import FiredEvent
from pickcli.simulation.reality import DEFAULT, Reality
from pickcli.simulation.start_check import check_start
from pickcli.simulation.world import ROBOT, World
from pickcli.trial.disturbance import Disturbance, DisturbanceKind, disturbances
from pickcli.trial.final_state import Drop
from pickcli.trial.score import ScoringRules
from pickcli.trial.tote_shift import ToteTouches, felt_tote, unlocated_tote
from pickcli.trial.trial_interfaces import LONGEST_RELEASE, ExecutionResult, TrialInterfaces
from pickcli.verification.verify import verify

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from pickcli.planning.planning_context import PlanningContext
    from pickcli.simulation.contacts import Collision

LONGEST_FALL = 2.0  # s: a fall from the top row of the shelf to the floor of the hall, until rest
FALL_STEP = 0.02  # s
FALLING_SPEED = 0.2  # m/s


@dataclass(frozen=True, eq=False)
class TrialArm:
    """An arm that plays in a trial, with what its plans are made from.

    Attributes:
        context: Planning context: the cell as seen by the arm, with its stored motions.
        experience_recorder: Receives motions of coarse queries that were not stored; None to discard them.
        parked: Parked state of the arm; None for a single arm.
        preference: Among the arms suitable for a task, the one with the least value is chosen.
    """

    context: PlanningContext
    experience_recorder: ExperienceRecorder | None = None
    parked: ArmState | None = None
    preference: int = 0


class SimulatedArena:
    """A world in pybullet, with the robot at home, or several arms in their parking configurations.

    Args:
        scene: The true scene, as seen by the arm that moves first.
        reality: Levels of the world's deviations from its model.
        seed: Seed of these deviations.
        parked: Parked state of the arm that moves first; None to start at home.
        motion_recorder: Receives all motion; None to discard it.
    """

    def __init__(
        self,
        scene: Scene,
        reality: Reality = DEFAULT,
        seed: int = 0,
        parked: ArmState | None = None,
        motion_recorder: MotionRecorder | None = None,
    ) -> None:
        start = parked or scene.cell.home
        self._world = World(scene, start.q, start.tool_state, reality=reality, seed=seed)
        self._motion_recorder = motion_recorder or MotionRecorder()
        if motion_recorder is not None:
            motion_recorder.look(self._world)
            self._world.observer = motion_recorder.look
        self._scene_recorded = scene  # true scene at the last record

    @property
    def q(self) -> Array:
        """Measured configuration (n,)."""
        return self._world.q

    @property
    def tool_state(self) -> ToolState:
        """Present state of the tool."""
        return self._world.tool_state

    @property
    def held(self) -> str | None:
        """Id of the item that is truly held, or None."""
        return self._world.held

    @property
    def collisions(self) -> tuple[Collision, ...]:
        """All unplanned contacts so far, in motion or not, each once with its largest force."""
        return self._world.contacts.collisions

    def now(self) -> Scene:
        """Return the true scene.

        Returns:
            The scene, without the held item.
        """
        return self._world.now()

    def is_holding(self) -> bool:
        """Read the vacuum sensor, or whether fingers stopped on something.

        Returns:
            Whether the tool holds something, by that reading.
        """
        return self._world.grip.is_holding

    def close(self) -> None:
        """Free the simulation."""
        self._world.close()

    def wait(self, duration: float) -> None:
        """Let simulated time pass without motion.

        Args:
            duration: Simulated s.
        """
        self._world.wait(duration)

    def let_move(self, cell: Cell) -> None:
        """Switch to another arm.

        Args:
            cell: The cell as seen by that arm, with all others parked.

        Raises:
            InputError: The previous arm is not parked.
        """
        let_move(self._world, cell)

    def execute(self, plan: Plan) -> ExecutionResult:
        """Carry out a certified plan to its end or to a stop.

        Args:
            plan: The plan with its certificate.

        Returns:
            The record of the execution.
        """
        world = self._world
        noted = self._motion_recorder.begin(plan, world)
        try:
            check_start(plan, world)
        except InputError as error:  # nothing has moved, so recovery starts from the present configuration
            return ExecutionResult(0.0, stopped=str(error))
        run = execute(plan, world, on_progress=partial(noted.note, world))
        noted.t_end = world.t
        target = "" if plan.grasp is None else plan.grasp.item
        return self._settled(_recorded(run), run.t_start, run.releases, target)

    def release(self, open_to: ToolState | None = None) -> ExecutionResult:
        """Close the valve or open the fingers at the present configuration, and wait for the release.

        Args:
            open_to: State to which fingers open; None for the widest.

        Returns:
            The record of the execution.
        """
        world = self._world
        began, n_releases = world.t, len(world.grip.releases)
        noted = self._motion_recorder.begin(None, world)
        _let_go(world, LONGEST_RELEASE, open_to)
        noted.t_end = world.t
        return self._settled(ExecutionResult(LONGEST_RELEASE), began, world.grip.releases[n_releases:], "")

    def locate_tote(self, context: PlanningContext, scene: Scene, seed: int) -> ToteTouches:
        """Touch the tote, beginning where the arm is.

        Args:
            context: The cell with what motions are planned by.
            scene: The perceived scene, for all but where the tote is.
            seed: Seed of all random choices, and of the errors of the joints.

        Returns:
            Where it was found, or why it was not, with the time that it took.
        """
        settings, began, cell = LocatingSettings(), self._world.t, scene.cell
        try:
            located = locate_tote(context, scene, self._world, settings, seed)
        except (InputError, NoPlanError) as error:
            took = self._world.t - began
            return ToteTouches(unlocated_tote(cell), took, settings.n_touches, reason=str(error))
        return ToteTouches(felt_tote(located, cell), located.duration, settings.n_touches, located)

    def _settled(
        self, run: ExecutionResult, began: float, releases: Iterable[Release], target: str
    ) -> ExecutionResult:
        """Complete the record of an execution once nothing falls any more.

        Adds contacts, falls, and other items that moved since the last record; the target itself only if it
        fell.
        """
        world = self._world
        self._let_fall()
        drops = tuple(Drop(f.item, f.height, f.is_wanted) for f in falls_of(world, releases))
        now = self.now()
        found = disturbances(
            self._scene_recorded, now, {drop.item for drop in drops}, ScoringRules.drop_limit
        )
        self._scene_recorded = now
        return replace(
            run,
            duration=world.t - began,
            collisions=world.contacts.since(began),
            drops=drops,
            disturbed=tuple(d for d in found if d.item != target or d.kind is DisturbanceKind.FELL),
        )

    def disturbed(self) -> tuple[Disturbance, ...]:
        """Find items that moved unintentionally since the last record, while the robot stood still.

        Returns:
            The disturbances, sorted by id.
        """
        return disturbances(self._scene_recorded, self.now(), (), ScoringRules.drop_limit)

    def _let_fall(self) -> None:
        """Wait at most ``LONGEST_FALL`` until nothing falls any more, so that records include whole falls."""
        world, began = self._world, self._world.t
        items = [placed.id for placed in world.scene.items]
        while world.t - began < LONGEST_FALL and any(
            world.engine.speed(item)[0] > FALLING_SPEED for item in items if item != world.held
        ):
            world.wait(FALL_STEP)

    def picture(self) -> NDArray[np.uint8]:
        """Take a picture of the cell, with views of the bins and the tote.

        Returns:
            (height, width, 3) RGB.
        """
        return overview(self._world.engine, self.now())


def interfaces_of(arms: Iterable[TrialArm], arena: SimulatedArena) -> TrialInterfaces:
    """Combine the real interfaces: planner, independent verifier, and the simulated arena.

    Args:
        arms: All arms.
        arena: The simulated cell.

    Returns:
        The interfaces.
    """
    by_arm = {arm.context.cell.arm: arm for arm in arms}

    def plan(scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify) -> Plan:
        own = by_arm[scene.cell.arm]
        return plan_pick(own.context, scene, query, start, seed, own.experience_recorder, certify)

    def recover(
        scene: Scene, start: Start, seed: int, level: RecoveryLevel, stopped: StoppedMotion | None
    ) -> Plan:
        own = by_arm[scene.cell.arm]
        return plan_recovery(own.context, scene, start, seed, level, stopped, own.experience_recorder)

    def bring(scene: Scene, stopped: StoppedMotion, bringing: ItemRecovery, seed: int) -> Plan:
        return bring_item(stopped, bringing, scene, by_arm[scene.cell.arm].context.arm.limits, seed)

    def topple(scene: Scene, query: TopplingQuery, start: Start, seed: int, certify: Certify) -> Plan:
        own = by_arm[scene.cell.arm]
        return plan_topple(own.context, scene, query, start, seed, own.experience_recorder, certify)

    def touch_tote(scene: Scene, seed: int) -> ToteTouches:
        return arena.locate_tote(by_arm[scene.cell.arm].context, scene, seed)

    def move(scene: Scene, start: Start, goal: MoveGoal, seed: int, label: str) -> Plan:
        own = by_arm[scene.cell.arm]
        return plan_move(own.context, scene, start, goal, seed, label, own.experience_recorder)

    if len(by_arm) == 1:
        return TrialInterfaces(
            plan, recover, bring, verify, arena, topple=topple, move=move, locate_tote=touch_tote
        )

    def rank(scenes: Sequence[Scene], query: PickQuery, seed: int) -> tuple[ArmSuitability, ...]:
        return rank_arms(scenes, {arm: own.preference for arm, own in by_arm.items()}, query, seed)

    def park(scene: Scene, start: Start, seed: int) -> Plan:
        own = by_arm[scene.cell.arm]
        if own.parked is None:
            raise NoPlanError("parking", [Reason("nowhere to park", scene.cell.arm)])
        goal = MoveGoal(own.parked.q, own.parked.tool_state)
        return move(scene, start, goal, seed, f"park arm {scene.cell.arm}")

    cells = {arm: own.context.cell for arm, own in by_arm.items()}
    return TrialInterfaces(
        plan, recover, bring, verify, arena, cells, rank, park, topple, move, locate_tote=touch_tote
    )


def _let_go(world: World, duration: float, open_to: ToolState | None) -> None:
    """Switch pump and valve off, or open the fingers to a state; None for the widest.

    Bodies that tool and held item touch at this moment may stay in contact until the robot moves again, and
    so may items that lean on opening fingers.
    """
    bodies = (ROBOT,) if world.held is None else (ROBOT, world.held)
    touched = {touch.b for body in bodies for touch in world.engine.contact_points(body)}
    world.planned = world.planned.also(frozenset(touched | set(bodies)))
    tool = world.robot.tool
    for device in world.scene.cell.devices.values():
        if device.kind in (DeviceKind.PUMP, DeviceKind.VALVE):
            world.act(device.name, "off")
        elif device.kind is tool.mover and tool.grip.takes_widths:
            world.act(device.name, (open_to or max(tool.positions, key=tool.positions.__getitem__)).name)
            duration = max(duration, device.lead)
    world.wait(duration)


def _recorded(run: Execution) -> ExecutionResult:
    return ExecutionResult(
        duration=run.duration,
        stopped=_why(run),
        has_item=run.has_item,
        limit_violations=tuple(str(violation) for violation in run.limit_violations),
        events=tuple(_event(fired) for fired in run.events),
        missed=tuple(f"{event.device} {event.action}" for event in run.missed),
        max_lag=run.max_lag,
        max_load=run.max_load,
        stop_cause=run.stop_cause,
        path_time=run.path_time,
        operator_stops=run.operator_stops,
    )


def _why(run: Execution) -> str:
    where = f" in the {run.stopped_in}" if run.stopped and run.stopped_in is not None else ""
    return run.stopped + where


def _event(fired: FiredEvent) -> dict[str, object]:
    return {
        "device": fired.event.device,
        "action": fired.event.action,
        "t": round(fired.t, 6),
        "distance": round(fired.distance, 6),
        "reading": fired.reading,
    }
