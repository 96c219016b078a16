"""What a trial needs of the rest: someone who plans, someone who verifies, an arena where it happens.

The real ones are put together in ``simulated_cell``; tests play with a fake.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.errors import NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.motion.plan import Plan, RecoveryLevel
from pickcli.motion.trajectory import Trajectory
from pickcli.planning.arm_choice import ArmSuitability
from pickcli.planning.pick_problem import Certify, PickQuery
from pickcli.planning.recovery.retrace import ItemRecovery, StoppedMotion
from pickcli.planning.start_state import Start
from pickcli.scene.scene import Scene
from pickcli.trial.disturbance import Disturbance
from pickcli.trial.score import Drop

if TYPE_CHECKING:
    from pickcli.simulation.contacts import Collision
    from pickcli.simulation.protective_stop import StopCause
    from pickcli.verification.verdict import Verdict


ARRIVAL = 0.1  # s after a plan's end by which its execution ends, if nothing stops or falls
LET_GO_TIME = 0.5  # s after which a closed valve has let go of anything


@dataclass(frozen=True)
class ExecutionResult:
    """What happened while something was carried out. Times are simulated seconds.

    Attributes:
        duration: s.
        stopped: Why it ended before the plan did, "" if it did not.
        has_item: What vacuum or fingers told at the end of the retreat, None if that was not read.
        collisions: Contacts that no plan allowed and that began or went on in this time, as far as they had
            come.
        limit_violations: What went beyond a limit, in words.
        drops: Free falls of items.
        events: One mapping per fired event, with its device, action and distance from where it was due.
        missed: Events that never fired.
        max_lag: m, farthest that the tool was from where it was told to be.
        max_load: Worst share of what the grip bears while something was held.
        stop_cause: Why it stopped, as a kind; None if it did not stop or never started.
        path_time: Where it came to rest after a stop, as s of the plan's trajectory; None without one.
        disturbed: Items that moved since the record before, though nobody meant them to.
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


class Arena(Protocol):
    """The place where plans are carried out, and the truth about it."""

    @property
    def q(self) -> Array:
        """Measured configuration (n,)."""

    @property
    def tool_state(self) -> ToolState:
        """State of the tool."""

    @property
    def held(self) -> str | None:
        """Id of the item that is truly held, for the score alone."""

    @property
    def collisions(self) -> tuple[Collision, ...]:
        """Every contact so far that no plan allowed, in motion or not: for damage and score alone."""

    def now(self) -> Scene:
        """Tell where everything really is: for perception and the score.

        Returns:
            The true scene, without the item that is held.
        """

    def disturbed(self) -> tuple[Disturbance, ...]:
        """Tell what has moved since the last record, though nobody meant it to: for the score alone.

        Returns:
            The items.
        """

    def is_holding(self) -> bool:
        """Read what the tool measures of its hold: the vacuum, or the width of its fingers.

        Returns:
            Whether it holds something, as far as that tells.
        """

    def wait(self, duration: float) -> None:
        """Stand still for some time.

        Args:
            duration: Simulated s.
        """

    def let_move(self, cell: Cell) -> None:
        """Let another arm move from now on.

        Args:
            cell: The cell as that arm sees it, all others where they are parked.

        Raises:
            InputError: The arm that moved does not stand where it is parked.
        """

    def execute(self, plan: Plan) -> ExecutionResult:
        """Carry out a certified plan to its end or to a stop.

        Args:
            plan: The plan with its certificate.

        Returns:
            The record of the execution.
        """

    def release(self, open_to: ToolState | None = None) -> ExecutionResult:
        """Close the valve, or open the fingers, where the robot stands and wait until the item is let go.

        Args:
            open_to: State to which fingers open; None for as wide as they go.

        Returns:
            The record of the execution.
        """


class PlanPick(Protocol):
    """Plans a pick, as ``planning.plan_pick`` does."""

    def __call__(self, scene: Scene, query: PickQuery, start: Start, seed: int, certify: Certify) -> Plan:
        """Plan a pick.

        Args:
            scene: The scene as it is seen.
            query: What is to be moved, from where and where to.
            start: Configuration and tool state to start from.
            seed: Seed of the plan.
            certify: Gives a plan its certificate, or says why not: then another one is tried.

        Returns:
            The plan with its certificate.

        Raises:
            NoPlanError: There is none that is certified; with the reasons.
        """
        ...


class PlanRecovery(Protocol):
    """Plans a way out with the empty tool, on one level, from wherever it is."""

    def __call__(
        self, scene: Scene, start: Start, seed: int, level: RecoveryLevel, stopped: StoppedMotion | None
    ) -> Plan:
        """Plan a way out.

        Args:
            scene: The scene as it is seen.
            start: Configuration and tool state to start from.
            seed: Seed of the plan.
            level: How the way out is to be searched.
            stopped: The motion that stopped, None if the way out need not lead along it.

        Returns:
            The plan, without a certificate.

        Raises:
            NoPlanError: There is none; with the reasons.
        """
        ...


class PlanItemRecovery(Protocol):
    """Plans the rest of a stopped motion, or the way back of it, with its item."""

    def __call__(self, scene: Scene, stopped: StoppedMotion, bringing: ItemRecovery, seed: int) -> Plan:
        """Plan to bring the item of a stopped motion on or back.

        Args:
            scene: The scene as it is seen.
            stopped: The motion that stopped.
            bringing: Where to bring the item.
            seed: Seed of the plan.

        Returns:
            The plan, without a certificate.

        Raises:
            NoPlanError: There is none; with the reasons.
        """
        ...


class PlanParking(Protocol):
    """Plans the move of the arm that acted last to where it is parked."""

    def __call__(self, scene: Scene, start: Start, seed: int) -> Plan:
        """Plan the move.

        Args:
            scene: The scene as it is seen.
            start: Configuration and tool state to start from.
            seed: Seed of the plan.

        Returns:
            The plan, without a certificate.

        Raises:
            NoPlanError: There is none; with the reasons.
        """
        ...


class RankArms(Protocol):
    """Ranks the arms for a pick, as ``planning.arm_choice.rank_arms`` does."""

    def __call__(self, scenes: Sequence[Scene], query: PickQuery, seed: int) -> tuple[ArmSuitability, ...]:
        """Rank the arms.

        Args:
            scenes: The scene as each arm sees it.
            query: What is to be moved, from where and where to.
            seed: Seed of all random choices.

        Returns:
            The arms, in the order in which they are tried.
        """
        ...


def _never_parked(scene: Scene, start: Start, seed: int) -> Plan:
    raise NoPlanError("parking", [Reason("the cell has one arm")])


def _nothing_to_rank(scenes: Sequence[Scene], query: PickQuery, seed: int) -> tuple[ArmSuitability, ...]:
    return ()


@dataclass(frozen=True, eq=False)
class TrialInterfaces:
    """Everything that a trial calls: planners, verifier and arena.

    Attributes:
        plan: Plans a pick.
        recover: Plans a way out with the empty tool.
        bring: Plans the rest of a stopped motion, or the way back of it, with its item.
        verify: Judges a plan in a scene; the trajectory is that of the stopped motion, if there is one.
        arena: Where plans are carried out.
        cells: The cell as each arm sees it, by name; empty where there is one arm.
        rank: Ranks the arms for a pick, where there are several.
        park: Plans the move of an arm to where it is parked, where there are several.
    """

    plan: PlanPick
    recover: PlanRecovery
    bring: PlanItemRecovery
    verify: Callable[[Plan, Scene, Trajectory | None], Verdict]
    arena: Arena
    cells: Mapping[str, Cell] = field(default_factory=dict)
    rank: RankArms = _nothing_to_rank
    park: PlanParking = _never_parked
