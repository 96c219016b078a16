"""Remembers which items were lost or stopped as they pushed others aside: what jams once, jams again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass, field

from pickcli.motion.plan import Plan
from pickcli.simulation.protective_stop import StopCause
from pickcli.trial.trial_interfaces import ExecutionResult

MOST_JAMS = 2  # of one item among the same others: the second time its pose is known otherwise
_JAMMED = (StopCause.SEAL_LOST, StopCause.GRASP_LOST, StopCause.CONTACT, StopCause.FOLLOWING_ERROR)


@dataclass
class JamMemory:
    """How often each item jammed among which others.

    Attributes:
        jams: Number of jams by id of the item and the ids of what it was to push aside.
    """

    jams: Counter[tuple[str, frozenset[str]]] = field(default_factory=Counter)

    def note(self, plan: Plan, execution: ExecutionResult) -> None:
        """Learn from a motion.

        Args:
            plan: Its plan.
            execution: What came of it.
        """
        pushed = frozenset(_pushed_at(plan, execution.path_time))
        if plan.grasp is not None and pushed and execution.stop_cause in _JAMMED:
            self.jams[plan.grasp.item, pushed] += 1

    def may_push(self, item: str, others: Collection[str]) -> bool:
        """Whether an item may be lifted once more among others that it pushes aside.

        Args:
            item: Its id.
            others: Ids of what it would push.

        Returns:
            False if it jammed among just these too often.
        """
        return self.jams[item, frozenset(others)] < MOST_JAMS


def _pushed_at(plan: Plan, t: float | None) -> tuple[str, ...]:
    """Return what a plan may push at a time of its trajectory, s; nothing if that is not known."""
    return () if t is None else next((s.pushing for s in plan.segments if t <= s.t_end), ())
