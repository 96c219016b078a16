"""Of several destinations the first with a plan is taken; an item that cannot leave its place has none."""

from __future__ import annotations

import pytest

from pickcli.errors import NoExtractionError, NoPlanError, Reason
from pickcli.planning.destination_choice import plan_into_first

FULL = NoPlanError(
    "stow glue into bin_A", [Reason("no free place", "bin_A", in_the_way="book")], "", ["book"]
)
STUCK = NoExtractionError("stow glue", [Reason("collision", "lift", in_the_way="box")], "", ["box"])


def planner(*answers: NoPlanError | str):  # type: ignore[no-untyped-def]
    """Planning that gives the answers one after the other, and notes the destinations."""
    left, tried = list(answers), []

    def plan_into(name: str) -> str:
        tried.append(name)
        answer = left.pop(0)
        if isinstance(answer, NoPlanError):
            raise answer
        return answer

    return plan_into, tried


def test_the_first_with_a_plan_is_taken() -> None:
    plan_into, tried = planner(FULL, "plan", "other")
    assert plan_into_first("stow glue", ["bin_A", "bin_B", "bin_C"], plan_into) == "plan"
    assert tried == ["bin_A", "bin_B"]


def test_what_cannot_leave_its_place_is_not_planned_into_another_destination() -> None:
    plan_into, tried = planner(STUCK, "plan")
    with pytest.raises(NoExtractionError) as caught:
        plan_into_first("stow glue", ["bin_A", "bin_B"], plan_into)
    assert caught.value is STUCK and tried == ["bin_A"]


def test_the_error_of_several_has_the_reasons_and_blockers_of_each() -> None:
    plan_into, tried = planner(FULL, FULL, STUCK)
    with pytest.raises(NoPlanError) as caught:
        plan_into_first("stow glue", ["bin_A", "bin_B", "bin_C", "bin_D"], plan_into)
    error = caught.value
    assert tried == ["bin_A", "bin_B", "bin_C"]
    assert not isinstance(error, NoExtractionError)
    assert error.blockers == ("book", "box") and error.in_the_way == ("book", "box")
    assert [line.split(":")[0].strip() for line in str(error).splitlines()[1:]] == tried


def test_alternatives_none_of_which_leads_out_of_the_place_keep_that_type() -> None:
    error = NoPlanError.of_alternatives("pick", [("left", STUCK), ("right", STUCK), ("third", None)])
    assert isinstance(error, NoExtractionError)
    assert not isinstance(NoPlanError.of_alternatives("pick", [("left", None)]), NoExtractionError)


def test_a_reason_that_stands_in_an_alternative_is_not_told_twice() -> None:
    error = NoPlanError("pick", [Reason("cannot be held", "glue")])
    told = [("arm left: glue: cannot be held", error), ("arm right", error)]
    both = NoPlanError.of_alternatives("pick", told)
    assert str(both).count("cannot be held") == 2
