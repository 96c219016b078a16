"""Results of a trial: attempts, targets, final state and score."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING

from pickcli.errors import Reason
from pickcli.motion.plan import Grasp, Plan
from pickcli.perception.textures.sift_views import SiftRule
from pickcli.scene.scene import TOTE, PoseNoise, Scene
from pickcli.simulation.reality import Reality
from pickcli.strategy.tree_player import Tick
from pickcli.trial.disturbance import Disturbance
from pickcli.trial.final_state import FinalState
from pickcli.trial.order import ANY_BIN, Order, Target
from pickcli.trial.score import Score
from pickcli.trial.tote_shift import ToteTouches
from pickcli.trial.trial_interfaces import ExecutionResult
from pickcli.trial.trial_perception import LookRecord, PerceptionKind

if TYPE_CHECKING:
    from pickcli.planning.arm_choice import ArmSuitability
    from pickcli.simulation.contacts import Collision


class Stage(StrEnum):
    """What an attempt may fail in."""

    SEEING = "seeing"
    PLANNING = "planning"
    MOVING = "moving"
    TIME = "time"
    STRATEGY = "strategy"  # made no attempt


class Outcome(StrEnum):
    """Outcome of an attempt, as the robot perceives it."""

    IN_TOTE = "in tote"
    DELIVERED = "delivered"  # in a stow into a bin, with moves to the destination
    MOVED = "moved aside"  # a blocking item, into another bin or the tote
    TOPPLED = "toppled"  # an item that stood on edge, so that a face that seals is on top
    NOT_TOPPLED = "not toppled"  # it was pushed, and stands as before
    NOT_RECOGNISED = "not recognised"  # by the cameras, where it should be
    NO_PLAN = "no plan"
    REJECTED = "rejected"  # the verifier rejected all plans; nothing was executed
    NOT_PICKED = "not picked"  # no item was measured in the tool after the retreat
    WRONG_ITEM = "wrong item"  # by its weight, and brought back
    LOST = "lost"  # the item was held but did not arrive
    MISSING = "missing"  # no such item is left in its bin
    NOT_TRIED = "not tried"  # the strategy made no attempt
    NO_TIME = "no time"

    @property
    def is_delivered(self) -> bool:
        """Whether a target reached its destination."""
        return self in (Outcome.IN_TOTE, Outcome.DELIVERED)

    @property
    def stage(self) -> Stage:
        """What failed, if the outcome is a failure."""
        if self in (Outcome.NOT_RECOGNISED, Outcome.MISSING, Outcome.WRONG_ITEM):
            return Stage.SEEING
        if self in (Outcome.NO_PLAN, Outcome.REJECTED):
            return Stage.PLANNING
        others = {Outcome.NO_TIME: Stage.TIME, Outcome.NOT_TRIED: Stage.STRATEGY}
        return others.get(self, Stage.MOVING)


@dataclass(frozen=True, eq=False)
class RecoveryStep:
    """One step of recovery after a stop.

    Attributes:
        what: A level of recovery, "bring on", "bring back", "let go" or "wait".
        reason: Why it failed or stopped; "" if it succeeded.
        execution: Its execution, or None.
    """

    what: str
    reason: str = ""
    execution: ExecutionResult | None = None


@dataclass(frozen=True, eq=False)
class RejectedPlan:
    """A plan that the verifier rejected, so that the next candidate was tried.

    Attributes:
        grasp: Grasp of the plan.
        reasons: All faults found by the verifier.
    """

    grasp: Grasp | None
    reasons: tuple[Reason, ...]


@dataclass(frozen=True, eq=False)
class Attempt:
    """One attempt at a target, or at moving a blocking item aside.

    Attributes:
        target: The target of the attempt.
        item: Id of the item to be moved, "" without one.
        number: 1 for the first attempt at this target.
        t_start: s on the clock of the trial.
        outcome: Outcome as the robot perceives it.
        reason: Why it failed, "" if it succeeded.
        into: Destination; a bin for items moved aside.
        out_of: Place of the item before.
        is_aside: Whether it moves a blocking item aside, or topples an item.
        topples: Whether it topples an item.
        arms: The ranked arms in the order in which they were tried; empty with a single arm.
        plan: The plan that was or should have been executed.
        seen: The scene that the plan was made and certified for, None without a plan.
        parking: Execution of the motion that parked the previous arm, or None.
        execution: Execution of the plan, or None.
        recovery: Steps of recovery afterwards.
        seen_in: Place where the item was perceived afterwards, "" if it was not.
        truly_in: True place of the item afterwards.
        in_the_way: Ids blamed by the failed plan, the most blamed first.
        has_way_out: Whether the item might be brought to another destination; False if no grasp leads it out
            of its place.
        reasons: All reasons why there is no plan.
        rejected: Plans that the verifier rejected.
        statistics: Wall-clock figures.
    """

    target: Target
    item: str
    number: int
    t_start: float
    outcome: Outcome
    reason: str = ""
    into: str = TOTE
    out_of: str = ""
    is_aside: bool = False
    topples: bool = False
    arms: tuple[ArmSuitability, ...] = ()
    plan: Plan | None = None
    seen: Scene | None = None
    parking: ExecutionResult | None = None
    execution: ExecutionResult | None = None
    recovery: tuple[RecoveryStep, ...] = ()
    seen_in: str = ""
    truly_in: str = ""
    in_the_way: tuple[str, ...] = ()
    has_way_out: bool = True
    reasons: tuple[Reason, ...] = ()
    rejected: tuple[RejectedPlan, ...] = ()
    statistics: dict[str, float] = field(default_factory=dict)

    @property
    def executions(self) -> tuple[ExecutionResult, ...]:
        """All executions of this attempt."""
        steps = (self.parking, self.execution, *(step.execution for step in self.recovery))
        return tuple(execution for execution in steps if execution is not None)


@dataclass(frozen=True, eq=False)
class TargetResult:
    """Result for one line of the order.

    Attributes:
        target: The line.
        outcome: Outcome as the robot perceives it.
        reason: Why it failed, "" if it succeeded.
        points: Points by the true final state.
        attempts: All attempts for it, in order of time.
    """

    target: Target
    outcome: Outcome
    reason: str
    points: int
    attempts: tuple[Attempt, ...]

    @property
    def into(self) -> str:
        """Name of the destination; for a stow the bin that was tried last."""
        tried = next((a.into for a in reversed(self.attempts) if not a.is_aside and a.into), "")
        return tried if self.target.into == ANY_BIN and tried else self.target.into


@dataclass(frozen=True)
class ArmSummary:
    """Summary of one of several arms in a trial.

    Attributes:
        executed: Number of executed attempts at targets.
        delivered: Number of those that truly brought the target to its destination.
    """

    executed: int
    delivered: int


@dataclass(frozen=True, eq=False)
class TrialResult:
    """Result of a whole trial.

    Attributes:
        order: The order that was played.
        seed: Seed of the trial.
        noise: Bounds of the errors of perceived item poses.
        reality: Levels of the deviations of the simulated world from its model.
        targets: Results in the order of the work order.
        attempts: Attempts in order of time.
        before: The true scene before the trial.
        after: The true scene after it.
        final: The final state for the rules.
        score: The score of the final state.
        collisions: All unplanned contacts, in motion or not, each once, in the order of their start.
        simulated: s of simulated time.
        clock: s on the clock of the trial: simulated time plus the charge for planning calls.
        aborted: Why the arm could not be brought to a safe place before the end of time, "" if it was.
        cut_short: What the end of time interrupted although it was possible, "" if nothing.
        disturbed_last: Items that moved unintentionally after the last execution.
        strategy: Name of the strategy.
        strategy_hash: Hash of its tree.
        ticks: All ticks of the strategy's conditions and actions.
        strategy_stuck: Why the strategy was ended before its tree failed, "" if it was not.
        perception: Source of the perceived scene.
        sift: For which items cameras looked for prints, and how.
        looks: All looks by cameras.
        tote: What touching the tote at the start told; None if it was not touched.
    """

    order: Order
    seed: int
    noise: PoseNoise
    reality: Reality
    targets: tuple[TargetResult, ...]
    attempts: tuple[Attempt, ...]
    before: Scene
    after: Scene
    final: FinalState
    score: Score
    collisions: tuple[Collision, ...]
    simulated: float
    clock: float
    aborted: str
    cut_short: str = ""
    disturbed_last: tuple[Disturbance, ...] = ()
    strategy: str = ""
    strategy_hash: str = ""
    ticks: tuple[Tick, ...] = ()
    strategy_stuck: str = ""
    perception: PerceptionKind = PerceptionKind.NOISE
    sift: SiftRule = SiftRule.NONE
    looks: tuple[LookRecord, ...] = ()
    tote: ToteTouches | None = None

    @property
    def executions(self) -> tuple[ExecutionResult, ...]:
        """All executions: those of attempts, then those that brought cameras to where they look from."""
        looking = (e for look in self.looks for e in look.motions)
        return (*(e for attempt in self.attempts for e in attempt.executions), *looking)

    @property
    def arms(self) -> dict[str, ArmSummary]:
        """Summary of each arm, by name; empty with a single arm."""
        names = sorted({arm.arm for attempt in self.attempts for arm in attempt.arms})
        moved = [a for a in self.attempts if a.execution is not None and not a.is_aside]
        own = {name: [a for a in moved if a.plan is not None and a.plan.arm == name] for name in names}
        return {
            name: ArmSummary(len(mine), sum(self.order.is_met(a.target, a.truly_in) for a in mine))
            for name, mine in own.items()
        }

    @property
    def n_collisions(self) -> int:
        """Number of unplanned contacts."""
        return len(self.collisions)

    @property
    def n_limit_violations(self) -> int:
        """Number of limit violations in all executions."""
        return sum(len(e.limit_violations) for e in self.executions)

    @property
    def drops(self) -> tuple[str, ...]:
        """Ids of items that the tool lost."""
        return tuple(d.item for e in self.executions for d in e.drops if not d.is_release)

    @property
    def disturbed(self) -> tuple[Disturbance, ...]:
        """Items that moved unintentionally, in order of time."""
        return (*(d for e in self.executions for d in e.disturbed), *self.disturbed_last)

    @property
    def items_in_tote(self) -> int:
        """Number of targets that are truly at their destinations."""
        return sum(target.points > 0 for target in self.targets)

    @property
    def n_misjudged(self) -> int:
        """Number of targets with a wrongly perceived outcome."""
        return sum(t.outcome.is_delivered != (t.points > 0) for t in self.targets)

    @property
    def is_clean(self) -> bool:
        """Whether the trial was completed without unplanned contacts and limit violations."""
        return not self.aborted and self.n_collisions == 0 and self.n_limit_violations == 0
