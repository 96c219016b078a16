"""The simulated world as a trial sees it, and the interfaces of a trial in it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

from pickcli.cell.cell import ArmState, Cell
from pickcli.cell.device import DeviceKind
from pickcli.cell.tool import ToolState
from pickcli.errors import InputError, NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.planning.arm_choice import ArmSuitability, rank_arms
from pickcli.planning.move import plan_move
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import Certify, PickQuery
from pickcli.planning.recovery.recovery_plan import plan_recovery
from pickcli.planning.recovery.retrace import ItemRecovery, StoppedMotion, bring_item
from pickcli.planning.start_state import Start
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
from pickcli.trial.score import Drop, ScoringRules
from pickcli.trial.trial_interfaces import LET_GO_TIME, ExecutionResult, TrialInterfaces
from pickcli.verification.verify import verify

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    import numpy as np
    from numpy.typing import NDArray

    from pickcli.planning.planning_context import PlanningContext
    from pickcli.simulation.contacts import Collision

HOME = "home"
LONGEST_FALL = 2.0  # s: over the shelf, down from the top row to the floor of the hall, and to rest
FALL_STEP = 0.02  # s
FALLING = 0.2  # m/s


@dataclass(frozen=True, eq=False)
class ArmPlanner:
    """What plans for one arm.

    Attributes:
        context: The cell as the arm sees it, with its stored motions.
        recorder: Gets what coarse queries found that was not stored; None drops it.
        parked: Where the arm stands while another one moves; None where it is the only one.
        preference: Among arms that can do a thing, the one with the least does it.
    """

    context: PlanningContext
    recorder: ExperienceRecorder | None = None
    parked: ArmState | None = None
    preference: int = 0


class SimulatedArena:
    """A world in pybullet, with the robot at home, or of several arms each where it is parked.

    Args:
        scene: Where the items truly are, as the arm sees it that moves first.
        reality: Levels at which the world differs from its model.
        seed: Seed of these differences.
        parked: Where the arm that moves first is parked; None for home.
        recorder: Gets everything that moves; None drops it.
    """

    def __init__(
        self,
        scene: Scene,
        reality: Reality = DEFAULT,
        seed: int = 0,
        parked: ArmState | None = None,
        recorder: MotionRecorder | None = None,
    ) -> None:
        start = parked or scene.cell.configurations[HOME]
        self._world = World(scene, start.q, start.tool_state, reality=reality, seed=seed)
        self._recorder = recorder or MotionRecorder()
        if recorder is not None:
            recorder.look(self._world)
            self._world.observer = recorder.look
        self._recorded = scene  # the truth when something was recorded last

    @property
    def q(self) -> Array:
        """Measured configuration (n,)."""
        return self._world.q

    @property
    def tool_state(self) -> ToolState:
        """State of the tool."""
        return self._world.tool_state

    @property
    def held(self) -> str | None:
        """Id of the item that is truly held."""
        return self._world.held

    @property
    def collisions(self) -> tuple[Collision, ...]:
        """Every contact so far that no plan allowed, in motion or not, once and with its largest force."""
        return self._world.contacts.collisions

    def now(self) -> Scene:
        """Tell where everything really is.

        Returns:
            The true scene, without the item that is held.
        """
        return self._world.now()

    def is_holding(self) -> bool:
        """Read the vacuum, or whether fingers stand on something.

        Returns:
            Whether the tool holds something, as far as that tells.
        """
        return self._world.grip.is_holding

    def close(self) -> None:
        """Give back what the simulation holds."""
        self._world.close()

    def wait(self, duration: float) -> None:
        """Stand still for some time.

        Args:
            duration: Simulated s.
        """
        self._world.wait(duration)

    def let_move(self, cell: Cell) -> None:
        """Let another arm move from now on.

        Args:
            cell: The cell as that arm sees it, all others where they are parked.

        Raises:
            InputError: The arm that moved does not stand where it is parked.
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
        noted = self._recorder.begin(plan, world)
        try:
            check_start(plan, world)
        except InputError as error:  # nothing has moved: the way out starts from where the robot is
            return ExecutionResult(0.0, stopped=str(error))
        run = execute(plan, world, on_progress=partial(noted.note, world))
        noted.t_end = world.t
        target = "" if plan.grasp is None else plan.grasp.item
        return self._settled(_recorded(run), run.t_start, run.releases, target)

    def release(self, open_to: ToolState | None = None) -> ExecutionResult:
        """Close the valve, or open the fingers, where the robot stands and wait until the item is let go.

        Args:
            open_to: State to which fingers open; None for as wide as they go.

        Returns:
            The record of the execution.
        """
        world = self._world
        began, n_releases = world.t, len(world.grip.releases)
        noted = self._recorder.begin(None, world)
        _let_go(world, LET_GO_TIME, open_to)
        noted.t_end = world.t
        return self._settled(ExecutionResult(LET_GO_TIME), began, world.grip.releases[n_releases:], "")

    def _settled(
        self, run: ExecutionResult, began: float, releases: Iterable[Release], target: str
    ) -> ExecutionResult:
        """The record of what began at a time, once nothing falls any more.

        With contacts, falls, and what else has moved since the record before; of the target, only a fall.
        """
        world = self._world
        self._let_fall()
        drops = tuple(Drop(f.item, f.height, f.is_wanted) for f in falls_of(world, releases))
        now = self.now()
        found = disturbances(self._recorded, now, {drop.item for drop in drops}, ScoringRules.drop_limit)
        self._recorded = now
        return replace(
            run,
            duration=world.t - began,
            collisions=world.contacts.since(began),
            drops=drops,
            disturbed=tuple(d for d in found if d.item != target or d.kind is DisturbanceKind.FELL),
        )

    def disturbed(self) -> tuple[Disturbance, ...]:
        """Tell what has moved since the last record, though nobody meant it to: while the robot stood.

        Returns:
            The items, sorted by id.
        """
        return disturbances(self._recorded, self.now(), (), ScoringRules.drop_limit)

    def _let_fall(self) -> None:
        """Wait, for a while, until nothing falls any more: a fall is over before it is recorded."""
        world, began = self._world, self._world.t
        items = [placed.id for placed in world.scene.items]
        while world.t - began < LONGEST_FALL and any(
            world.engine.speed(item)[0] > FALLING for item in items if item != world.held
        ):
            world.wait(FALL_STEP)

    def picture(self) -> NDArray[np.uint8]:
        """Take a picture of the cell as it looks now, with a look into the bins and the tote.

        Returns:
            (height, width, 3) RGB.
        """
        return overview(self._world.engine, self.now())


def interfaces_of(planners: Iterable[ArmPlanner], arena: SimulatedArena) -> TrialInterfaces:
    """Bring together the real interfaces: our planners, the independent verifier, the simulated arena.

    Args:
        planners: Of every arm that plays.
        arena: The simulated cell.

    Returns:
        The interfaces.
    """
    by_arm = {planner.context.cell.arm: planner for planner in planners}

    def plan(scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify) -> Plan:
        own = by_arm[scene.cell.arm]
        return plan_pick(own.context, scene, query, start, seed, own.recorder, certify)

    def recover(
        scene: Scene, start: Start, seed: int, level: RecoveryLevel, stopped: StoppedMotion | None
    ) -> Plan:
        own = by_arm[scene.cell.arm]
        return plan_recovery(own.context, scene, start, seed, level, stopped, own.recorder)

    def bring(scene: Scene, stopped: StoppedMotion, bringing: ItemRecovery, seed: int) -> Plan:
        return bring_item(stopped, bringing, scene, by_arm[scene.cell.arm].context.arm.limits, seed)

    if len(by_arm) == 1:
        return TrialInterfaces(plan, recover, bring, verify, arena)

    def rank(scenes: Sequence[Scene], query: PickQuery, seed: int) -> tuple[ArmSuitability, ...]:
        return rank_arms(scenes, {arm: own.preference for arm, own in by_arm.items()}, query, seed)

    def park(scene: Scene, start: Start, seed: int) -> Plan:
        own = by_arm[scene.cell.arm]
        if own.parked is None:
            raise NoPlanError("parking", [Reason("nowhere to park", scene.cell.arm)])
        return plan_move(
            own.context, scene, start, own.parked.q, seed, f"park arm {scene.cell.arm}", own.recorder
        )

    cells = {arm: own.context.cell for arm, own in by_arm.items()}
    return TrialInterfaces(plan, recover, bring, verify, arena, cells, rank, park)


def _let_go(world: World, duration: float, open_to: ToolState | None) -> None:
    """Pump and valve off, or fingers open to a state, where the robot stands; to their widest one for None.

    What tool and held item touch by then they may go on touching, until the robot moves again, and so may the
    fingers what leans on them as they open.
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
