"""Failures as values: they add up, keep their order, and know what stood in the way."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import pickcli.errors
from pickcli.errors import ApcError, Failures, NoPlanError, Reason, RejectedError, UnknownNameError
from pickcli.name_suggestion import suggestion
from pickcli.simulation.start_check import StartError

ERRORS_PAGE = Path(__file__).parents[1] / "docs" / "reference" / "errors.md"

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


@given(several, several, several)
def test_reasons_may_be_found_later_and_come_where_they_were_added(
    a: Failures, b: Failures, c: Failures
) -> None:
    asked = []

    def later() -> Iterator[Reason]:
        asked.append(True)
        yield from b

    found = a + Failures((later,)) + c
    assert not asked
    assert found.reasons == tuple(a + b + c) == tuple(found)
    assert found.in_the_way == (a + b + c).in_the_way and asked == [True]


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


BINS = [f"bin_{letter}" for letter in "ABCDEFGHIJKL"]
ITEMS = ["oral_b_toothbrush_green", "oral_b_toothbrush_red", "crayola_24_ct", "kleenex_tissue_box"]


@pytest.mark.parametrize(
    ("name", "known", "told"),
    [
        ("bin_c", BINS, "did you mean 'bin_C'?"),
        ("A", BINS, "did you mean 'bin_A'?"),
        ("BinL", BINS, "did you mean 'bin_L'?"),
        ("toothbrush", ITEMS, "did you mean 'oral_b_toothbrush_green' or 'oral_b_toothbrush_red'?"),
        ("Kleenex Tissue-Box", ITEMS, "did you mean 'kleenex_tissue_box'?"),
        ("crayola_25_ct", ITEMS, "did you mean 'crayola_24_ct'?"),
        ("bin_Z", BINS, f"known: {', '.join(BINS)}"),
        ("bin", BINS, f"known: {', '.join(BINS)}"),
        ("", ["b", "a"], "known: a, b"),
        ("x", [], "known: none"),
        ("y", [f"n{i:02}" for i in range(40)], f"known: {', '.join(f'n{i:02}' for i in range(16))}, ..."),
    ],
)
def test_a_suggestion_is_what_was_meant_or_what_there_is(name: str, known: list[str], told: str) -> None:
    assert suggestion(name, known) == told


@given(st.text(max_size=500), st.lists(st.text(max_size=30), max_size=20, unique=True))
def test_a_suggestion_names_known_names_alone(name: str, known: list[str]) -> None:
    told = suggestion(name, known)
    assert told.startswith(("did you mean ", "known: "))
    if told.startswith("did you mean "):
        assert any(repr(other) in told for other in known)


def test_a_name_of_any_length_is_told_short() -> None:
    error = UnknownNameError("item", "x" * 100_000, BINS, "here")
    assert str(error).startswith("here: unknown item 'xxx") and len(str(error)) < 600


def test_a_rejection_has_one_fault_per_line() -> None:
    reasons = (Reason("velocity limit", "a", "2 times"), Reason("collision"))
    error = RejectedError("plan.json: pick", reasons, "plan it again")
    assert (
        str(error) == "plan.json: pick: rejected, plan it again:\n  a: velocity limit: 2 times\n  collision"
    )
    assert error.reasons == reasons
    assert str(RejectedError("p")) == "p: rejected, plan it again"


def all_errors(base: type[ApcError] = ApcError) -> list[type[ApcError]]:
    """Every subclass that users may see."""
    return [each for child in base.__subclasses__() for each in (child, *all_errors(child))]


def test_the_tree_and_the_page_name_every_error_with_its_exit_code() -> None:
    errors = {error.__name__: error.exit_code for error in all_errors()}
    assert StartError.__name__ in errors
    assert pickcli.errors.__doc__ is not None
    tree = dict(re.findall(r"─ (\w+) +(\d)  ", pickcli.errors.__doc__))
    assert {name: int(code) for name, code in tree.items()} == errors
    rows = re.findall(r"^\| (\d+) \|([^|]*)\|", ERRORS_PAGE.read_text(), re.MULTILINE)
    page = {name: int(code) for code, names in rows for name in re.findall(r"`(\w+)`", names)}
    assert page.pop("UsageError") == page.pop("BadParameter") == 2  # click's own
    kinds = {name: code for name, code in errors.items() if name != "ArtifactError"}  # a base only
    assert page == kinds
