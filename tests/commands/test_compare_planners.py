"""``apc compare-planners``: the table, the JSON, and what it refuses."""

from __future__ import annotations

import json

import pytest

from support.command_line import apc

QUICK = ("compare-planners", "--tries", "1", "--planners", "RRTConnect,AORRTC", "--iterations", "400")


def test_a_row_per_planner_and_the_same_in_json() -> None:
    text = apc(*QUICK, "--pairs", "home:bin_A")
    assert text.code == 0
    first, _, head, *rows = text.out.splitlines()
    assert first == "1 pairs, 1 tries each, payload empty, at most 400 iterations"
    assert head.startswith("planner") and [row.split()[0] for row in rows] == ["RRTConnect", "AORRTC"]
    told = json.loads(apc(*QUICK, "--pairs", "home:bin_A", "--json").out)
    assert [row["planner"] for row in told["planners"]] == ["RRTConnect", "AORRTC"]
    assert told["pairs"] == told["pairs_solved_by_all"] == 1 and len(told["attempts"]) == 2


def test_the_search_keeps_to_its_own_iterations_and_the_table_says_so() -> None:
    quick = ("compare-planners", "--tries", "1", "--iterations", "400", "--planners", "search,RRTConnect")
    first, *_ = apc(*quick, "--pairs", "home:bin_A").out.splitlines()
    assert first.endswith("at most 400 iterations (search: its own)")


@pytest.mark.parametrize(
    ("argv", "message"),
    [
        (("--pairs", "home"), "--pairs: 'home' is not a pair; write A:B"),
        (("--pairs", "home:home"), "home:home is no motion"),
        (("--pairs", "home:bin_Z"), "unknown configuration 'bin_Z'"),
        (("--pairs", "home:tote_10h"), "tote_10h is not free"),
        (("--planners", "RRTConect"), "unknown planner 'RRTConect'; did you mean 'RRTConnect'?"),
    ],
)
def test_what_cannot_be_compared_is_refused(argv: tuple[str, ...], message: str) -> None:
    pairs = () if "--pairs" in argv else ("--pairs", "home:bin_A")
    answer = apc("compare-planners", *pairs, *argv)
    assert answer.code == 3 and message in answer.err and answer.out == ""
