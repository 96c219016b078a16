"""What jammed among others is not to push them aside again; among others it may."""

from __future__ import annotations

from dataclasses import replace

import pytest

from pickcli.motion.plan import Plan
from pickcli.motion.segment import SegmentKind
from pickcli.simulation.protective_stop import StopCause
from pickcli.trial.jam_memory import MOST_JAMS, JamMemory
from pickcli.trial.trial_interfaces import ExecutionResult
from support.handmade_plans import CRAYOLA, pick

OTHERS = ("dove_beauty_bar", "jane_eyre_dvd")


def stopped(plan: Plan, cause: StopCause | None, kind: SegmentKind = SegmentKind.LIFT) -> ExecutionResult:
    """In the middle of the first segment of a kind."""
    segment = next(segment for segment in plan.segments if segment.kind is kind)
    return ExecutionResult(3.0, "stopped", stop_cause=cause, path_time=(segment.t_start + segment.t_end) / 2)


def pushing(*others: str) -> Plan:
    plan = pick()[0]
    lifts = (
        replace(segment, pushing=others) if segment.kind is SegmentKind.LIFT else segment
        for segment in plan.segments
    )
    return replace(plan, segments=tuple(lifts))


@pytest.mark.parametrize("cause", [StopCause.SEAL_LOST, StopCause.CONTACT])
def test_an_item_pushes_the_same_others_no_third_time(cause: StopCause) -> None:
    memory, plan = JamMemory(), pushing(*OTHERS)
    for _ in range(MOST_JAMS):
        assert memory.may_push(CRAYOLA, OTHERS)
        memory.note(plan, stopped(plan, cause))
    assert not memory.may_push(CRAYOLA, frozenset(OTHERS))
    assert memory.may_push(CRAYOLA, OTHERS[:1])  # one of them is gone
    assert memory.may_push("dove_beauty_bar", OTHERS)


def test_only_what_jams_while_it_pushes_counts() -> None:
    memory = JamMemory()
    for plan, cause in (
        (pushing(*OTHERS), None),
        (pushing(*OTHERS), StopCause.OPERATOR),
        (pushing(*OTHERS), StopCause.NOT_SEALED),
        (pushing(), StopCause.SEAL_LOST),
    ):
        memory.note(plan, stopped(plan, cause))
    memory.note(pushing(*OTHERS), stopped(pushing(*OTHERS), StopCause.CONTACT, SegmentKind.TRANSIT))
    memory.note(pushing(*OTHERS), ExecutionResult(3.0, "stopped", stop_cause=StopCause.CONTACT))
    assert not memory.jams
