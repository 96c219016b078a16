"""What to pick next: by points per second, with one retry, within the time of a trial."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from pickcli.cell.model import Cell
from pickcli.motion.plan import Grasp
from pickcli.trial.order import Order, Target
from pickcli.trial.score import target_points

MAX_ATTEMPTS = 2  # one retry
MAX_CLEARED = 3  # items that are moved aside for one target, each of which gives it another attempt
PICK_SECONDS = 12.0  # of an item of which no plan is known yet: the figure to reach, leaving to released
TIME_LIMIT = {2015: 20 * 60.0, 2016: 15 * 60.0}  # s
PLANNING_CHARGE = 1.5  # s per planning call: at most 0.5 s of planning and 1 s of verification
# Delft retried failed picks for ever, at the end: a second try is worth less than an untried target.
RETRY_CHANCE = 0.5


@dataclass(frozen=True, eq=False)
class Job:
    """One target and what is known of it. A job is replaced, never changed.

    index: place in the work order, which breaks ties
    points: what the item gives in the tote
    seconds: estimated duration of the next attempt
    can_hold: whether the tool can hold it at all; what it cannot hold comes last
    failed_grasps: what has been tried in vain, so that the next attempt takes another
    cleared: how many items were moved aside for it
    """

    index: int
    target: Target
    points: int
    seconds: float
    can_hold: bool = True
    attempts: int = 0
    failed_grasps: tuple[Grasp, ...] = ()
    cleared: int = 0

    @property
    def rate(self) -> float:
        """Expected points per second of the next attempt."""
        chance = RETRY_CHANCE**self.attempts if self.can_hold else 0.0
        return chance * self.points / self.seconds

    @property
    def is_retriable(self) -> bool:
        """Whether another attempt is allowed and makes sense."""
        return self.can_hold and self.attempts < MAX_ATTEMPTS + self.cleared

    @property
    def is_clearable(self) -> bool:
        """Whether something may be moved aside for it."""
        return self.can_hold and self.cleared < MAX_CLEARED

    def failed(self, grasp: Grasp | None = None, seconds: float | None = None) -> Job:
        """The job after an attempt that failed with a grasp (None: none was found) and that duration."""
        failed = self.failed_grasps if grasp is None else (*self.failed_grasps, grasp)
        estimate = self.seconds if seconds is None else seconds
        return replace(self, attempts=self.attempts + 1, failed_grasps=failed, seconds=estimate)

    def cleared_once(self) -> Job:
        """The job after one more item was moved aside for it."""
        return replace(self, cleared=self.cleared + 1)


def may_move_others(year: int) -> bool:
    """Whether the rules let items that are no targets go elsewhere: 2015 took 12 points for each."""
    return year != 2015


def jobs_of(order: Order, cell: Cell, bonus: Mapping[str, int]) -> tuple[Job, ...]:
    """One job per line of a pick order."""
    jobs = []
    for index, target in enumerate(order.work_order):
        item = cell.item(target.item, order.year)
        points = target_points(order, target.bin, target.item, bonus)
        # Only the second half of a pick carries the item; slow items stretch that half.
        seconds = PICK_SECONDS / 2 * (1.0 + 1.0 / item.speed_scale)
        jobs.append(Job(index, target, points, seconds, can_hold=item.suction))
    return tuple(jobs)


def next_job(jobs: Sequence[Job]) -> Job:
    """The open job with the most points per second; the earlier line of the order where equal."""
    return max(jobs, key=lambda job: (job.rate, -job.index))


@dataclass(frozen=True)
class TrialClock:
    """The clock of a trial: simulated time and a fixed charge per planning call, never wall time."""

    limit: float  # s
    simulated: float = 0.0  # s
    n_plans: int = 0
    charge: float = PLANNING_CHARGE

    @property
    def now(self) -> float:
        """s since the start of the trial."""
        return self.simulated + self.n_plans * self.charge

    @property
    def left(self) -> float:
        """s until the limit; never negative."""
        return max(0.0, self.limit - self.now)

    def planned(self) -> TrialClock:
        """The clock after one more planning call."""
        return replace(self, n_plans=self.n_plans + 1)

    def moved(self, seconds: float) -> TrialClock:
        """The clock after some simulated seconds."""
        return replace(self, simulated=self.simulated + seconds)

    def has_time_for(self, seconds: float) -> bool:
        """Whether something that long still ends within the limit."""
        return self.now + seconds <= self.limit
