"""What a trial leaves behind: attempts, targets, final state, score."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING

from pickcli.errors import Reason
from pickcli.motion.plan import Grasp, Plan
from pickcli.scene.scene import TOTE, PoseNoise, Scene
from pickcli.simulation.reality import Reality
from pickcli.trial.disturbance import Disturbance
from pickcli.trial.order import ANY_BIN, Order, Target
from pickcli.trial.score import FinalState, Score
from pickcli.trial.trial_interfaces import ExecutionResult

if TYPE_CHECKING:
    from pickcli.planning.arm_choice import ArmSuitability
    from pickcli.simulation.contacts import Collision


class Outcome(StrEnum):
    """How an attempt ended."""

    IN_TOTE = "in tote"
    DELIVERED = "delivered"  # of a stow into a bin, of moves to where each item is wanted
    MOVED = "moved aside"  # into another bin, or the tote, so that a target can be picked
    NO_PLAN = "no plan"
    REJECTED = "rejected"  # by the verifier, every plan that was found: nothing was executed
    NOT_PICKED = "not picked"  # nothing was measured to be held after the retreat
    LOST = "lost"  # it was held, but did not arrive
    MISSING = "missing"  # no such item is left in its bin
    NO_TIME = "no time"

    @property
    def is_delivered(self) -> bool:
        """Whether a target is where it is wanted."""
        return self in (Outcome.IN_TOTE, Outcome.DELIVERED)


@dataclass(frozen=True, eq=False)
class RecoveryStep:
    """One thing that was tried after a stop.

    Attributes:
        what: A level of recovery, "bring on", "bring back", "let go" or "wait".
        reason: Why it came to nothing, or stopped; "" if it did not.
        execution: What was carried out, None if nothing was.
    """

    what: str
    reason: str = ""
    execution: ExecutionResult | None = None


@dataclass(frozen=True, eq=False)
class RejectedPlan:
    """A plan that the verifier refused, so that the next candidate took its place.

    Attributes:
        grasp: How the item was to be held.
        reasons: Every fault that the verifier found.
    """

    grasp: Grasp | None
    reasons: tuple[Reason, ...]


@dataclass(frozen=True, eq=False)
class Attempt:
    """One try at one target, or at moving aside what is in its way.

    Attributes:
        target: The target that it was for.
        item: Id of what is to be moved, "" if there was none.
        number: 1 for the first try at this target.
        t_start: s on the clock of the trial.
        outcome: What the robot believes.
        reason: Why it did not go as planned, "" if it did.
        into: Place where to, a bin for what is moved aside.
        out_of: Place where from.
        is_aside: Whether it was to make room for the target.
        arms: Why its arm was chosen: the arms in the order in which they were tried; none in a cell with one.
        plan: What was executed, or was to be.
        parking: How the arm that had acted before was brought to where it is parked, None if it was not.
        execution: What happened then, None if nothing was executed.
        recovery: What was tried to bring item and arm out afterwards.
        seen_in: Where the item was seen afterwards, "" if it was not.
        truly_in: Where it really was.
        in_the_way: Ids that the failed plan blames, the most blamed first.
        reasons: Every reason why there is no plan.
        rejected: Plans that the verifier refused on the way to this one, or to none.
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
    arms: tuple[ArmSuitability, ...] = ()
    plan: Plan | None = None
    parking: ExecutionResult | None = None
    execution: ExecutionResult | None = None
    recovery: tuple[RecoveryStep, ...] = ()
    seen_in: str = ""
    truly_in: str = ""
    in_the_way: tuple[str, ...] = ()
    reasons: tuple[Reason, ...] = ()
    rejected: tuple[RejectedPlan, ...] = ()
    statistics: dict[str, float] = field(default_factory=dict)

    @property
    def executions(self) -> tuple[ExecutionResult, ...]:
        """All that was executed in this attempt."""
        steps = (self.parking, self.execution, *(step.execution for step in self.recovery))
        return tuple(execution for execution in steps if execution is not None)


@dataclass(frozen=True, eq=False)
class TargetResult:
    """One line of the order, played.

    Attributes:
        target: The line.
        outcome: What the robot believes.
        reason: Why it did not go well, "" if it did.
        points: What it truly gave.
        attempts: Everything tried for it, in the order of time.
    """

    target: Target
    outcome: Outcome
    reason: str
    points: int
    attempts: tuple[Attempt, ...]

    @property
    def into(self) -> str:
        """Name of the place where it was brought, or wanted: of a stow the bin that was tried last."""
        tried = next((a.into for a in reversed(self.attempts) if not a.is_aside and a.into), "")
        return tried if self.target.into == ANY_BIN and tried else self.target.into


@dataclass(frozen=True)
class ArmSummary:
    """What one of several arms did in a trial.

    Attributes:
        executed: Attempts at targets that it moved for.
        delivered: Those of them that truly brought the target where it is wanted.
    """

    executed: int
    delivered: int


@dataclass(frozen=True, eq=False)
class TrialResult:
    """A whole trial.

    Attributes:
        order: The order that was played.
        seed: Seed of the trial.
        noise: Bounds of the error of the item poses that were perceived.
        reality: Levels at which the simulated world differed from its model.
        targets: In the order of the work order.
        attempts: In the order of time.
        before: The true scene before the trial.
        after: The true scene after it.
        final: What the rules look at.
        score: What they give.
        collisions: Every contact that no plan allowed, in motion or not, once, in the order of their start.
        simulated: s of simulated time.
        clock: s on the clock of the trial: simulated time and the charge of the planning calls.
        aborted: Why the arm stood where it could not be brought out of when the time ended, "" if it did not.
        cut_short: What the end of the time left undone although there was a way, "" if nothing.
        disturbed_last: What moved without being meant to after the last execution, during the last look.
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

    @property
    def executions(self) -> tuple[ExecutionResult, ...]:
        """Everything that was executed, in the order of time."""
        return tuple(e for attempt in self.attempts for e in attempt.executions)

    @property
    def arms(self) -> dict[str, ArmSummary]:
        """What each arm did, by name; empty where there is one arm."""
        names = sorted({arm.arm for attempt in self.attempts for arm in attempt.arms})
        moved = [a for a in self.attempts if a.execution is not None and not a.is_aside]
        own = {name: [a for a in moved if a.plan is not None and a.plan.arm == name] for name in names}
        return {
            name: ArmSummary(len(mine), sum(self.order.is_met(a.target, a.truly_in) for a in mine))
            for name, mine in own.items()
        }

    @property
    def n_collisions(self) -> int:
        """Contacts that no plan allowed."""
        return len(self.collisions)

    @property
    def n_limit_violations(self) -> int:
        """Executed motions beyond a limit."""
        return sum(len(e.limit_violations) for e in self.executions)

    @property
    def drops(self) -> tuple[str, ...]:
        """Ids of items that the tool lost."""
        return tuple(d.item for e in self.executions for d in e.drops if not d.is_release)

    @property
    def disturbed(self) -> tuple[Disturbance, ...]:
        """What moved without being meant to, in the order of time."""
        return (*(d for e in self.executions for d in e.disturbed), *self.disturbed_last)

    @property
    def items_in_tote(self) -> int:
        """Targets that truly lie in the tote, or where else the order wants them."""
        return sum(target.points > 0 for target in self.targets)

    @property
    def n_misjudged(self) -> int:
        """Targets of which the robot believes something else than is true."""
        return sum(t.outcome.is_delivered != (t.points > 0) for t in self.targets)

    @property
    def is_clean(self) -> bool:
        """Whether it ran through, touched nothing and kept every limit."""
        return not self.aborted and self.n_collisions == 0 and self.n_limit_violations == 0
