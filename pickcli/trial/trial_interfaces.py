"""Interfaces of a trial: planners, verifier, and the arena in which plans are carried out.

``simulated_cell`` implements them; tests use fakes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.errors import NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Certify, Plan, RecoveryLevel
from pickcli.motion.trajectory import Trajectory
from pickcli.planning.arm_choice import ArmSuitability
from pickcli.planning.move import MoveGoal
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.recovery.retrace import ItemRecovery, StoppedMotion
from pickcli.planning.start_state import Start
from pickcli.planning.topple import TopplingQuery
from pickcli.scene.scene import Scene
from pickcli.trial.disturbance import Disturbance
from pickcli.trial.final_state import Drop
from pickcli.trial.tote_shift import ToteTouches, unlocated_tote

if TYPE_CHECKING:
    from pickcli.simulation.contacts import Collision
    from pickcli.simulation.operator_stop import OperatorStop
    from pickcli.simulation.protective_stop import StopCause
    from pickcli.verification.verdict import Verdict


ARRIVAL = 0.1  # s from a plan's end to the end of its execution, without stops and falls
LONGEST_RELEASE = 0.5  # s after which a closed valve, or open fingers, have released any item


@dataclass(frozen=True)
class ExecutionResult:
    """Record of an execution in a trial. Times are simulated seconds.

    Attributes:
        duration: s.
        stopped: Why it ended before the plan did, "" if it did not.
        has_item: Last reading of vacuum or fingers at the end of the retreat, None if not read.
        collisions: Unplanned contacts that began or continued in this time, up to its end.
        limit_violations: Exceeded limits, in words.
        drops: Free falls of items.
        events: One mapping per fired event, with device, action and distance from its trigger.
        missed: Events that never fired.
        max_lag: m, largest distance between the actual and the commanded tool position.
        max_load: Largest load as a share of the grip's limits while an item was held.
        stop_cause: Kind of the stop; None if it did not stop or never started.
        path_time: Time on the plan's trajectory at which it came to rest after a stop, s; None without one.
        disturbed: Items that moved unintentionally since the last record.
        operator_stops: Stops by the operator, times since the start.
    """

    duration: float
    stopped: str = ""
    has_item: bool | None = None
    collisions: tuple[Collision, ...] = ()
    limit_violations: tuple[str, ...] = ()
    drops: tuple[Drop, ...] = ()
    events: tuple[dict[str, Any], ...] = ()
    missed: tuple[str, ...] = ()
    max_lag: float = 0.0
    max_load: float = 0.0
    stop_cause: StopCause | None = None
    path_time: float | None = None
    disturbed: tuple[Disturbance, ...] = ()
    operator_stops: tuple[OperatorStop, ...] = ()


class Arena(Protocol):
    """Environment in which plans are carried out, with access to the true state."""

    @property
    def q(self) -> Array:
        """Measured configuration (n,)."""

    @property
    def tool_state(self) -> ToolState:
        """Present state of the tool."""

    @property
    def held(self) -> str | None:
        """Id of the item that is truly held, only for the score."""

    @property
    def collisions(self) -> tuple[Collision, ...]:
        """All unplanned contacts so far, in motion or not; only for damage and score."""

    def now(self) -> Scene:
        """Return the true scene, for perception and the score.

        Returns:
            The scene, without the held item.
        """

    def disturbed(self) -> tuple[Disturbance, ...]:
        """Find items that moved unintentionally since the last record; only for the score.

        Returns:
            The disturbances.
        """

    def is_holding(self) -> bool:
        """Read the tool's measurement of its hold: the vacuum, or the width of its fingers.

        Returns:
            Whether it holds something, by that reading.
        """

    def wait(self, duration: float) -> None:
        """Let simulated time pass without motion.

        Args:
            duration: Simulated s.
        """

    def let_move(self, cell: Cell) -> None:
        """Switch to another arm.

        Args:
            cell: The cell as seen by that arm, with all others parked.

        Raises:
            InputError: The previous arm is not parked.
        """

    def execute(self, plan: Plan) -> ExecutionResult:
        """Carry out a certified plan to its end or to a stop.

        Args:
            plan: The plan with its certificate.

        Returns:
            The record of the execution.
        """

    def release(self, open_to: ToolState | None = None) -> ExecutionResult:
        """Close the valve or open the fingers at the present configuration, and wait for the release.

        Args:
            open_to: State to which fingers open; None for the widest.

        Returns:
            The record of the execution.
        """


class PlanPick(Protocol):
    """Planner of picks, such as ``planning.pick.plan_pick``."""

    def __call__(self, scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify) -> Plan:
        """Plan a pick.

        Args:
            scene: The perceived scene.
            query: The item, its place and destination.
            start: Start configuration and tool state.
            seed: Seed of the plan.
            certify: Returns a plan with its certificate, or reasons for rejection; then the next candidate is
                tried.

        Returns:
            The plan with its certificate.

        Raises:
            NoPlanError: No plan is certified; with the reasons.
        """
        ...


class PlanTopple(Protocol):
    """Planner of pushes that topple an item, such as ``planning.topple.plan_topple``."""

    def __call__(self, scene: Scene, query: TopplingQuery, start: Start, seed: int, certify: Certify) -> Plan:
        """Plan to topple an item.

        Args:
            scene: The perceived scene.
            query: The item and its place.
            start: Start configuration and tool state.
            seed: Seed of the plan.
            certify: Returns a plan with its certificate, or reasons for rejection; then the next candidate is
                tried.

        Returns:
            The plan with its certificate.

        Raises:
            NoPlanError: No plan is certified; with the reasons.
        """
        ...


class PlanRecovery(Protocol):
    """Planner of recovery motions with an empty tool, on one level of recovery."""

    def __call__(
        self, scene: Scene, start: Start, seed: int, level: RecoveryLevel, stopped: StoppedMotion | None
    ) -> Plan:
        """Plan a recovery motion.

        Args:
            scene: The perceived scene.
            start: Start configuration and tool state.
            seed: Seed of the plan.
            level: Level of recovery.
            stopped: The stopped motion along which to return; None if not needed.

        Returns:
            The plan, without a certificate.

        Raises:
            NoPlanError: There is no plan; with the reasons.
        """
        ...


class PlanItemRecovery(Protocol):
    """Planner that continues or reverses a stopped motion with its item."""

    def __call__(self, scene: Scene, stopped: StoppedMotion, bringing: ItemRecovery, seed: int) -> Plan:
        """Plan to bring the item of a stopped motion to its destination or back.

        Args:
            scene: The perceived scene.
            stopped: The stopped motion.
            bringing: Destination of the item.
            seed: Seed of the plan.

        Returns:
            The plan, without a certificate.

        Raises:
            NoPlanError: There is no plan; with the reasons.
        """
        ...


class PlanParking(Protocol):
    """Planner of the motion that parks the arm that acted last."""

    def __call__(self, scene: Scene, start: Start, seed: int) -> Plan:
        """Plan the parking motion.

        Args:
            scene: The perceived scene.
            start: Start configuration and tool state.
            seed: Seed of the plan.

        Returns:
            The plan, without a certificate.

        Raises:
            NoPlanError: There is no plan; with the reasons.
        """
        ...


class PlanMove(Protocol):
    """Planner of moves of the empty tool, such as ``planning.move.plan_move``."""

    def __call__(self, scene: Scene, start: Start, goal: MoveGoal, seed: int, label: str) -> Plan:
        """Plan a move.

        Args:
            scene: The perceived scene.
            start: Start configuration and tool state.
            goal: Configuration and tool state at its end.
            seed: Seed of the plan.
            label: Name of the plan.

        Returns:
            The plan, without a certificate.

        Raises:
            NoPlanError: There is no plan; with the reasons.
        """
        ...


class RankArms(Protocol):
    """Ranking of the arms for a pick, such as ``planning.arm_choice.rank_arms``."""

    def __call__(self, scenes: Sequence[Scene], query: PickQuery, seed: int) -> tuple[ArmSuitability, ...]:
        """Rank the arms.

        Args:
            scenes: The scene as seen by each arm.
            query: The item, its place and destination.
            seed: Seed of all random choices.

        Returns:
            The arms, in the order in which to try them.
        """
        ...


class LocateTote(Protocol):
    """Locates the tote by touching it, such as ``calibration.tote_location.locate_tote``."""

    def __call__(self, scene: Scene, seed: int) -> ToteTouches:
        """Locate the tote.

        Args:
            scene: The perceived scene, for all but where the tote is.
            seed: Seed of all random choices.

        Returns:
            Where it is believed to stand since, or why it was not located.
        """
        ...


def _never_parked(scene: Scene, start: Start, seed: int) -> Plan:
    raise NoPlanError("parking", [Reason("the cell has one arm")])


def _never_moved(scene: Scene, start: Start, goal: MoveGoal, seed: int, label: str) -> Plan:
    raise NoPlanError(label, [Reason("the trial has no planner for it")])


def _never_toppled(scene: Scene, query: TopplingQuery, start: Start, seed: int, certify: Certify) -> Plan:
    raise NoPlanError(f"topple {query.item}", [Reason("the trial has no planner for it")])


def _never_touched(scene: Scene, seed: int) -> ToteTouches:
    return ToteTouches(unlocated_tote(scene.cell), 0.0, 0, reason="the trial has nothing to touch it with")


def _nothing_to_rank(scenes: Sequence[Scene], query: PickQuery, seed: int) -> tuple[ArmSuitability, ...]:
    return ()


@dataclass(frozen=True, eq=False)
class TrialInterfaces:
    """All interfaces of a trial: planners, verifier and arena.

    Attributes:
        plan: Plans a pick.
        recover: Plans a recovery motion with an empty tool.
        bring: Plans to continue or reverse a stopped motion with its item.
        verify: Judges a plan in a scene; the trajectory is that of the stopped motion, if any.
        arena: Environment in which plans are carried out.
        cells: The cell as seen by each arm, by name; empty with a single arm.
        rank: Ranks the arms for a pick, if there are several.
        park: Plans the parking motion of an arm, if there are several.
        topple: Plans to topple an item that stands on edge in an open box.
        move: Plans a move of the empty tool.
        locate_tote: Locates the tote by touching it.
    """

    plan: PlanPick
    recover: PlanRecovery
    bring: PlanItemRecovery
    verify: Callable[[Plan, Scene, Trajectory | None], Verdict]
    arena: Arena
    cells: Mapping[str, Cell] = field(default_factory=dict)
    rank: RankArms = _nothing_to_rank
    park: PlanParking = _never_parked
    topple: PlanTopple = _never_toppled
    move: PlanMove = _never_moved
    locate_tote: LocateTote = _never_touched
