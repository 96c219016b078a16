"""Failures as values: they add up, keep their order, and know what stood in the way."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from pickcli.errors import Failures, NoPlanError, Reason

reasons = st.builds(
    Reason, st.sampled_from(["collision", "too close"]), st.text("ab", max_size=2), st.just(""),
    st.sampled_from(["", "book", "bar", "cup"]),
)  # fmt: skip
several = st.lists(reasons, max_size=6).map(lambda found: Failures(tuple(found)))


@given(several, several, several)
def test_adding_is_associative_and_nothing_is_neutral(a: Failures, b: Failures, c: Failures) -> None:
    assert (a + b) + c == a + (b + c)
    assert a + Failures() == a == Failures() + a
    assert tuple(a + b) == (*a, *b)


@given(several, reasons)
def test_one_more_reason_comes_last(failures: Failures, reason: Reason) -> None:
    assert (failures + reason).reasons == (*failures.reasons, reason)


@given(several, st.text("xyz", min_size=1, max_size=3))
def test_telling_where_it_was_changes_nothing_else(failures: Failures, where: str) -> None:
    told = failures.within(where)
    assert told.in_the_way == failures.in_the_way
    for before, after in zip(failures, told, strict=True):
        assert after.where == (f"{where}, {before.where}" if before.where else where)
        assert (after.what, after.detail) == (before.what, before.detail)


@given(several)
def test_who_stood_in_the_way_most_often_is_named_first(failures: Failures) -> None:
    counts = [sum(reason.in_the_way == name for reason in failures) for name in failures.in_the_way]
    assert counts == sorted(counts, reverse=True)
    assert sum(counts) == sum(bool(reason.in_the_way) for reason in failures)
    assert NoPlanError("a pick", failures).in_the_way == failures.in_the_way
