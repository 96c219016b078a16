"""``apc execute`` answers queries: in the order given, each from where the one before left arm and items."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from support.command_line import ITEM, Made, apc, misused, refused

WAX = "crayola_24_ct"


def answered(made: Made, *argv: object) -> dict[str, Any]:
    answer = apc("execute", "--scene", made.scene, *argv, "--json")
    assert answer.code == 0, answer.err
    told: dict[str, Any] = json.loads(answer.out)
    return told


def test_queries_are_answered_in_the_order_given(made: Made) -> None:
    told = answered(
        made, "--pick", f"bin_C:{WAX}:bin_F", "--move", "home:bin_C", "--pick", f"bin_C:{ITEM}", "--seed", 2
    )
    assert [each["query"] for each in told["queries"]] == [
        f"pick {WAX} from bin_C to bin_F", "move from home to bin_C", f"pick {ITEM} from bin_C to tote",
    ]  # fmt: skip
    assert [each["item_is_in"] for each in told["queries"]] == ["bin_F", None, "tote"]
    assert [len(each["motions"]) for each in told["queries"]] == [1, 2, 1], "home is gone to first"
    assert [m["plan"] for m in told["queries"][1]["motions"]] == ["move to home", "move to bin_C"]
    assert (told["collisions"], told["limit_violations"], told["held"], told["not_started"]) == (
        0,
        0,
        None,
        [],
    )
    assert all(each["is_clean"] for each in told["queries"])
    runs = [motion for each in told["queries"] for motion in each["motions"]]
    assert told["simulated_s"] == pytest.approx(sum(run["simulated_s"] for run in runs))


def test_what_was_brought_somewhere_is_taken_from_there(made: Made) -> None:
    told = answered(made, "--pick", f"bin_C:{ITEM}:bin_F", "--pick", f"bin_F:{ITEM}")
    assert [each["item_is_in"] for each in told["queries"]] == ["bin_F", "tote"]


def test_what_was_brought_elsewhere_is_told_with_what_brings_it(made: Made) -> None:
    words = f"bin_C:{ITEM}:bin_F"
    answer = apc("execute", "--scene", made.scene, "--pick", words, "--pick", words)
    refused(answer, 3, f"--pick {words}: after --pick {words} {ITEM} is in bin_F; name that place")


def test_a_pick_that_is_planned_has_its_place_in_an_option(made: Made, tmp_path: Path) -> None:
    answer = apc(
        "plan-pick", "--scene", made.scene, "--pick", f"bin_C:{ITEM}:bin_F", "-o", tmp_path / "p.json"
    )
    misused(answer, f"write --bin bin_C --item {ITEM} --into bin_F")


def test_the_same_seed_gives_the_same_answers(made: Made) -> None:
    argv = ("--move", "home:bin_C", "--pick", f"bin_C:{ITEM}", "--seed", 5)
    first, second = answered(made, *argv), answered(made, *argv)
    for told in (first, second):
        for motion in (motion for each in told["queries"] for motion in each["motions"]):
            assert motion.pop("planning_ms") > 0.0
    assert first == second


def test_the_first_move_tells_where_the_arm_stands(made: Made) -> None:
    moved = answered(made, "--move", "bin_C:home")
    assert [m["plan"] for m in moved["queries"][0]["motions"]] == ["move to home"]
    away = answered(made, "--move", "bin_C:home", "--from", "bin_D")
    assert [m["plan"] for m in away["queries"][0]["motions"]] == ["move to bin_C", "move to home"]
    still = answered(made, "--move", "home:home")
    assert still["queries"][0]["motions"] == []
    answer = apc("execute", "--scene", made.scene, "--move", "home:home")
    assert (
        answer.code == 0
        and answer.out == "move from home to home: the arm is there already, nothing is executed\n"
    )


def test_what_was_picked_into_the_tote_is_stowed_from_there(made: Made) -> None:
    told = answered(made, "--pick", f"bin_C:{ITEM}", "--stow", f"{ITEM}:bin_H", "--pick", f"bin_H:{ITEM}")
    assert [each["query"] for each in told["queries"]][1] == f"stow {ITEM} into bin_H"
    assert [each["item_is_in"] for each in told["queries"]] == ["tote", "bin_H", "tote"]
    assert told["collisions"] == 0 and all(each["is_clean"] for each in told["queries"])


def test_a_stow_without_a_bin_goes_where_explain_stow_says(made: Made) -> None:
    told = answered(made, "--pick", f"bin_C:{ITEM}", "--stow", ITEM)
    query = told["queries"][1]
    assert query["query"] == f"stow {ITEM}" and query["item_is_in"].startswith("bin_")
    assert query["motions"][0]["plan"] == f"pick {ITEM} from tote into {query['item_is_in']}"


def test_it_is_told_in_lines(made: Made) -> None:
    answer = apc("execute", "--scene", made.scene, "--move", "home:bin_C", "--pick", f"bin_C:{ITEM}")
    lines = answer.out.splitlines()
    assert answer.code == 0 and lines[0].startswith("move to bin_C: done, ")
    assert lines[-1] == f"  {ITEM} is in the tote"


def test_a_query_without_a_plan_ends_the_sequence_and_what_was_done_is_told(
    made: Made, tmp_path: Path
) -> None:
    argv = (
        "--scene",
        made.scene,
        "--move",
        "home:bin_C",
        "--move",
        "bin_C:tote_10h",
        "--pick",
        f"bin_C:{ITEM}",
    )
    answer = apc("execute", *argv, "--json")
    told = json.loads(answer.out)
    assert answer.code == told["exit_code"] == 5 and "goal: collision" in told["error"]["message"]
    assert [len(each["motions"]) for each in told["queries"]] == [1, 0]
    assert told["not_started"] == [f"pick {ITEM} from bin_C to tote"]
    assert [(each["is_complete"], each["is_clean"]) for each in told["queries"]] == [
        (True, True),
        (False, False),
    ]
    text = apc("execute", *argv)
    assert text.code == 5 and text.out.startswith("move to bin_C: done") and "goal: collision" in text.err
    assert text.out.splitlines()[-1] == f"pick {ITEM} from bin_C to tote: not started"


def test_if_the_first_query_has_no_plan_the_others_are_told_as_not_started(made: Made) -> None:
    none = ("execute", "--scene", made.scene, "--move", "home:tote_10h")
    answer = apc(*none, "--pick", f"bin_C:{ITEM}")
    assert answer.code == 5 and "goal: collision" in answer.err
    assert answer.out.splitlines() == [
        "move from home to tote_10h: no plan, nothing is executed",
        f"pick {ITEM} from bin_C to tote: not started",
    ]
    assert apc(*none).out == ""


def test_a_stop_ends_the_sequence_and_is_no_error(made: Made, tmp_path: Path) -> None:
    """The item is not where the scene says: nothing seals, and the arm stays where it stopped."""
    from unittest import mock

    from pickcli.simulation.suction import Suction

    with mock.patch.object(Suction, "is_holding", False):
        answer = apc(
            "execute", "--scene", made.scene, "--pick", f"bin_C:{ITEM}", "--move", "home:bin_C", "--json"
        )
    told = json.loads(answer.out)
    assert answer.code == 0 and not told["queries"][0]["is_clean"]
    assert told["queries"][0]["motions"][0]["stop_cause"] in ("not sealed", "sensor")
    assert told["not_started"] == ["move from home to bin_C"]


@pytest.mark.parametrize(
    ("argv", "told"),
    [
        (("--pick", "bin_C"), "--pick: expected PLACE:ITEM or PLACE:ITEM:TO, got 'bin_C'; e.g. bin_C:"),
        (("--pick", ":x"), "--pick: expected PLACE:ITEM"),
        (("--pick", "a:b:c:d"), "--pick: expected PLACE:ITEM"),
        (("--stow", "a:b:c"), "--stow: expected ITEM or ITEM:BIN, got 'a:b:c'"),
        (("--stow", "a:"), "--stow: expected ITEM or ITEM:BIN"),
        (("--move", "home"), "--move: expected FROM:TO or FROM:TO:STATE, got 'home'"),
        (("--move", "home:"), "--move: expected FROM:TO"),
        (("--move", "home:bin_C:down:bin_D"), "--move: expected FROM:TO or FROM:TO:STATE"),
        ((), "nothing to execute: name a PLAN, or queries"),
    ],
)
def test_queries_of_another_form_are_wrong_usage(argv: tuple[str, ...], told: str, made: Made) -> None:
    misused(apc("execute", "--scene", made.scene, *argv), told)


@pytest.mark.parametrize(
    ("argv", "told"),
    [
        (("--pick", f"bin_c:{ITEM}"), f"--pick bin_c:{ITEM}: unknown place 'bin_c'; did you mean 'bin_C'?"),
        (("--pick", "bin_C:dove_beauty_bra"), f"did you mean '{ITEM}'"),
        (("--pick", f"bin_A:{ITEM}"), f"{ITEM} is not in bin_A but in bin_C"),
        (("--pick", f"bin_C:{ITEM}:bin_C"), "the item is in bin_C already; name another place"),
        (("--pick", f"bin_C:{ITEM}:bin_Z"), "unknown place 'bin_Z'"),
        (("--move", "home:bin_Z"), "unknown configuration 'bin_Z'"),
        (("--move", "home:1,2"), "got 2 of 8 numbers"),
        (("--move", "home:bin_C:dwon"), "unknown state of the tool 'dwon'; did you mean 'down'?"),
        (
            ("--pick", f"bin_C:{ITEM}", "--pick", f"bin_C:{ITEM}"),
            f"after --pick bin_C:{ITEM} {ITEM} is in tote",
        ),
        (
            ("--pick", f"bin_C:{ITEM}", "--stow", f"{ITEM}:bin_H", "--stow", ITEM),
            f"after --stow {ITEM}:bin_H {ITEM} is in bin_H, not in the tote; leave this query out",
        ),
    ],
)
def test_what_cannot_be_is_refused_before_anything_moves(
    argv: tuple[str, ...], told: str, made: Made
) -> None:
    refused(apc("execute", "--scene", made.scene, *argv), 3, told)


@pytest.mark.parametrize(
    "option", [("--bridge",), ("--no-verify",), ("--planned-in", "x.json"), ("--driver", "recorder")]
)
def test_options_of_a_plan_file_do_not_go_with_queries(option: tuple[str, ...], made: Made) -> None:
    argv = ("--scene", made.scene, "--move", "home:bin_C")
    misused(apc("execute", *argv, *option), f"{option[0]}: only for a plan file")


def test_a_plan_file_does_not_go_with_queries(made: Made) -> None:
    answer = apc("execute", made.plan, "--scene", made.scene, "--pick", f"bin_C:{ITEM}")
    misused(answer, "is a plan, and --pick a query; give one or the other")


def test_queries_are_filmed(made: Made, tmp_path: Path) -> None:
    film = tmp_path / "film.gif"
    answered(made, "--move", "home:bin_C", "--video", film)
    assert film.read_bytes().startswith(b"GIF8")


def test_a_move_may_end_with_the_tool_in_another_state(made: Made) -> None:
    told = answered(
        made, "--move", "home:home:down", "--move", "home:bin_C", "--move", "bin_C:bin_C:straight"
    )
    assert [[e["action"] for m in each["motions"] for e in m["events"]] for each in told["queries"]] == [
        ["down"], [], ["straight"],
    ]  # fmt: skip
    assert all(each["is_clean"] for each in told["queries"])


def test_of_two_arms_the_preferred_one_or_the_named_one_answers(tmp_path: Path) -> None:
    scene = tmp_path / "scene.json"
    item, cell = "fitness_gear_3lb_dumbbell", ("--cell", "apc2016_delft_pinch")
    assert apc("make-scene", *cell, "--in", f"bin_B={item}", "--seed", 9800041, "-o", scene).code == 0
    asked = ("execute", "--scene", scene, "--pick", f"bin_B:{item}")
    refused(apc(*asked), 5, "cannot be held by suction")  # the preferred arm's tool
    refused(apc(*asked, "--arm", "thumb"), 3, "unknown arm 'thumb'")
    pinched = apc(*asked, "--arm", "fingers")
    assert pinched.code == 0 and f"{item} is in the tote" in pinched.out, pinched.err
    plan = tmp_path / "plan.json"
    assert (
        apc("plan-move", *cell, "--arm", "fingers", "--from", "home", "--to", "bin_B", "-o", plan).code == 0
    )
    misused(apc("execute", plan, "--arm", "fingers"), "a plan names its arm")
