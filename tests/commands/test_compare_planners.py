"""``apc compare-planners``: the table, the JSON, and what it refuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pickcli.scene.stream_file import write_stream
from support.command_line import apc
from support.pr2_picks import stream

QUICK = ("compare-planners", "--tries", "1", "--planners", "RRTConnect,AORRTC", "--iterations", "400")


def test_a_row_per_planner_and_the_same_in_json() -> None:
    text = apc(*QUICK, "--pairs", "home:bin_A")
    assert text.code == 0
    first, _, head, *rows = text.out.splitlines()
    assert first == "1 pairs, 1 try each, payload empty, at most 400 iterations"
    assert head.startswith("planner") and [row.split()[0] for row in rows] == ["RRTConnect", "AORRTC"]
    told = json.loads(apc(*QUICK, "--pairs", "home:bin_A", "--json").out)
    assert [row["planner"] for row in told["planners"]] == ["RRTConnect", "AORRTC"]
    assert told["pairs"] == told["pairs_solved_by_all"] == 1 and len(told["attempts"]) == 2


def test_the_search_keeps_to_its_own_iterations_and_the_table_says_so() -> None:
    quick = ("compare-planners", "--tries", "1", "--iterations", "400", "--planners", "search,RRTConnect")
    first, *_ = apc(*quick, "--pairs", "home:bin_A").out.splitlines()
    assert first.endswith("at most 400 iterations (search: its own)")


def test_ara_star_states_a_bound_beside_ours_on_the_same_pairs() -> None:
    both = ("compare-planners", "--tries", "1", "--planners", "RRTConnect,ARA*-first", "--expansions", "60")
    told = apc(*both, "--pairs", "cam_D:cam_L", "--json")
    ours, theirs = json.loads(told.out)["planners"]
    assert ours["solved"] == theirs["solved"] == 1.0
    assert ours["cost_bound"] == [None, None] and 1.0 <= theirs["cost_bound"][0] <= 20.0
    first, _, head, *rows = apc(*both, "--pairs", "cam_D:cam_L").out.splitlines()
    assert first.endswith("60 expansions of ARA*") and head.split()[-3:] == ["cost", "bound", "worst"]
    assert [row.split()[-1] == "-" for row in rows] == [True, False]


def test_a_stream_is_compared_by_the_pregrasps_of_its_items(tmp_path: Path) -> None:
    path = tmp_path / "stream.json"
    write_stream(stream(n=2), path)
    quick = ("--arm", "left", "--tries", "1", "--planners", "RRTConnect,ARA*-first")
    told = json.loads(apc("compare-planners", "--stream", str(path), *quick, "--json").out)
    items = {riding.id for riding in stream(n=2).items}
    asked = {tuple(attempt["pair"]) for attempt in told["attempts"]}
    assert {item for _, item in asked} == items and {start for start, _ in asked} >= {"home", "bin_left"}
    assert told["pairs"] == told["pairs_solved_by_all"] == len(asked)


@pytest.mark.parametrize(
    ("argv", "code", "message"),
    [
        (("--pairs", "home:belt"), 2, "not both"),
        (("--payload", "cube"), 2, "--payload: to a pregrasp the tool goes empty"),
        (("--planners", "search"), 3, "'search' knows one goal only"),
        (("--arm", "third"), 3, "unknown arm 'third'"),
    ],
)
def test_what_makes_no_sense_with_a_stream_is_refused(
    argv: tuple[str, ...], code: int, message: str, tmp_path: Path
) -> None:
    path = tmp_path / "stream.json"
    write_stream(stream(n=2), path)
    answer = apc("compare-planners", "--stream", str(path), *argv)
    assert answer.code == code and message in answer.err and answer.out == ""


def test_a_stream_on_a_belt_that_stands_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "stream.json"
    write_stream(stream(0.0, n=2, one_by_one=True), path)
    answer = apc("compare-planners", "--stream", str(path), "--arm", "left")
    assert answer.code == 3 and "the belt of the stream stands" in answer.err and answer.out == ""


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
