"""The schedule against brute force: after the chosen pick, no order of the others begins more in time."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.stream_trials.pick_schedule import PlannedPick, next_pick

SECONDS = st.floats(0.1, 12.0)


def most_begun(t: float, lasts: float, deadlines: list[float]) -> int:
    """The most picks that any order begins in time."""
    most = 0
    for order in permutations(deadlines):
        at, n = t, 0
        for deadline in order:
            if at <= deadline:
                at, n = at + lasts, n + 1
        most = max(most, n)
    return most


@given(
    st.lists(st.tuples(SECONDS, st.floats(0.0, 5.0), SECONDS), min_size=1, max_size=4),
    st.lists(SECONDS, max_size=2),
)
def test_no_order_of_the_others_begins_more_in_time(
    planned: list[tuple[float, float, float]], unplanned: list[float]
) -> None:
    """If each of them keeps the arm busy for as long as these do on average."""
    picks = [PlannedPick(f"item {k}", busy + waits, busy) for k, (busy, waits, _) in enumerate(planned)]
    deadlines = {pick.item: deadline for pick, (*_, deadline) in zip(picks, planned, strict=True)}
    deadlines |= {f"other {k}": deadline for k, deadline in enumerate(unplanned)}
    lasts = float(np.mean([busy for busy, *_ in planned]))

    def begun(k: int) -> int:
        others = [deadline for item, deadline in deadlines.items() if item != picks[k].item]
        return most_begun(picks[k].duration, lasts, others)

    chosen = next_pick(picks, deadlines)
    assert begun(chosen) == max(map(begun, range(len(picks))))
    alike = [k for k in range(len(picks)) if begun(k) == begun(chosen)]
    assert picks[chosen].duration == min(picks[k].duration for k in alike)


@pytest.mark.parametrize("urgent", [0, 1])
def test_what_has_to_be_begun_first_is_taken_first_if_both_can_be(urgent: int) -> None:
    picks = [PlannedPick("a", 4.0, 4.0), PlannedPick("b", 4.5, 4.5)]
    deadlines = {"a": 9.0, "b": 9.0, picks[urgent].item: 1.0}
    assert next_pick(picks, deadlines) == urgent


def test_on_a_full_belt_the_shortest_pick_is_taken() -> None:
    picks = [PlannedPick("late", 5.0, 5.0), PlannedPick("near", 4.2, 4.2), PlannedPick("far", 6.0, 4.4)]
    assert next_pick(picks, {"late": 0.5, "near": 1.0, "far": 3.0}) == 1
    assert next_pick(picks, {}) == 1  # a belt that stands


def test_the_time_until_an_item_comes_is_not_that_of_every_pick() -> None:
    """The arm is at work for 4 s in each, and waits 6 s for the last: with 6 s for each, y would be lost."""
    picks = [PlannedPick("x", 3.5, 3.5), PlannedPick("y", 4.0, 4.0), PlannedPick("z", 10.0, 4.0)]
    assert next_pick(picks, {"x": 8.0, "y": 3.0, "z": 9.5}) == 1
