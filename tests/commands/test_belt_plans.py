"""``apc plan-pick --stream`` and ``apc verify --stream``."""

from __future__ import annotations

import hashlib
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.data_path import data_path
from pickcli.motion.plan_file import read_plan
from pickcli.trial.motion_record import read_motion
from support.command_line import apc, misused, refused


@pytest.fixture(scope="module")
def stream(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("stream") / "stream.json"
    assert apc("make-stream", "--items", "4", "--seed", "4", "-o", path).code == 0
    return path


def item(stream: Path, k: int) -> tuple[str, float]:
    """Id and stamp of the k-th item."""
    found = json.loads(stream.read_text())["items"][k]
    return found["id"], found["stamp"]


def test_a_pick_is_planned_and_verified_for_its_time_only(stream: Path, tmp_path: Path) -> None:
    name, stamp = item(stream, 1)
    plan, now = tmp_path / "plan.json", f"{stamp + 0.5:.2f}"
    planned = apc("plan-pick", "--stream", stream, "--item", name, "--now", now, "-o", plan)
    assert planned.code == 0 and "certified" in planned.out
    tracking = json.loads(plan.read_text())["tracking"]
    assert (tracking["conveyor"], tracking["speed"], tracking["speed_error"]) == ("belt", 0.33, 0.0)
    verified = apc("verify", plan, "--stream", stream, "--now", now)
    assert verified.code == 0 and "line tracking" in verified.out
    assert apc("verify", plan, "--stream", stream).code == 0  # the plan states its time
    refused(
        apc("verify", plan, "--stream", stream, "--now", "0.1"), 4, f"the plan starts at {float(now):g} s"
    )


def test_a_plan_for_a_running_belt_needs_its_stream_and_is_not_exported(stream: Path, tmp_path: Path) -> None:
    """By the clock alone, its set points would miss an item on a belt that is not quite as fast."""
    plan, out = tmp_path / "plan.json", tmp_path / "plan.csv"
    assert apc("plan-pick", "--stream", stream, "--item", item(stream, 0)[0], "-o", plan).code == 0
    for words in (("verify", plan), ("execute", plan), ("show", plan, "-o", tmp_path / "plan.html")):
        refused(apc(*words), 3, "the plan is for the running belt; name the stream with --stream")
        refused(apc(*words, "--cell", "conveyor_sia20"), 3, "name the stream with --stream")
    told = "its set points follow the encoder of belt"
    for where in (("--cell", "conveyor_sia20"), ("--stream", stream)):
        refused(apc("export", plan, "--format", "csv", *where, "-o", out), 3, told)
    refused(apc("check-driver", "recorder", plan, "--cell", "conveyor_sia20"), 3, told)
    assert not out.exists()


def test_a_plan_off_a_belt_that_stands_is_exported_with_its_stream(tmp_path: Path) -> None:
    stream, plan, out = tmp_path / "stream.json", tmp_path / "plan.json", tmp_path / "plan.csv"
    assert apc("make-stream", "--items", "1", "--speed", "0", "--seed", "4", "-o", stream).code == 0
    assert apc("plan-pick", "--stream", stream, "--item", item(stream, 0)[0], "-o", plan).code == 0
    words = ("export", plan, "--format", "csv", "-o", out)
    exported = apc(*words, "--stream", stream)
    assert exported.code == 0 and out.stat().st_size > 10_000
    misused(apc(*words, "--overwrite", "--stream", stream, "--scene", stream), "not both")
    values = json.loads(stream.read_text())
    values["items"][0]["position"][0] += 0.01
    stream.write_text(json.dumps(values))
    refused(apc(*words, "--overwrite", "--stream", stream), 4, f"{stream} is")


def test_a_plan_that_takes_nothing_from_a_running_belt_is_no_plan_of_its_stream(
    stream: Path, tmp_path: Path
) -> None:
    plan = tmp_path / "move.json"
    move = ("plan-move", "--cell", "conveyor_sia20", "--from", "home", "--to", "belt", "-o", plan)
    assert apc(*move).code == 0
    refused(apc("verify", plan, "--stream", stream), 4, "takes nothing from a belt that runs; name its own")


def test_a_plan_that_begins_elsewhere_is_not_bridged_while_the_belt_runs(
    stream: Path, tmp_path: Path
) -> None:
    plan = tmp_path / "plan.json"
    assert apc("plan-pick", "--stream", stream, "--item", item(stream, 0)[0], "-o", plan).code == 0
    away = apc("execute", plan, "--stream", stream, "--from", "tote")
    refused(away, 3, "or plan the pick from there, with apc plan-pick --from")
    assert "--bridge" not in away.err


def test_a_rule_that_has_items_met_at_one_place_is_named_where_that_is_out_of_reach(
    stream: Path, tmp_path: Path
) -> None:
    words = ("plan-pick", "--stream", stream, "--item", item(stream, 0)[0], "--stream-rule", "pr2-2013")
    refused(
        apc(*words, "-o", tmp_path / "p.json"), 5, "the rule lets items be met at 1.44 m from the infeed only"
    )


def test_by_default_the_first_item_is_picked_as_it_enters(stream: Path, tmp_path: Path) -> None:
    planned = apc("plan-pick", "--stream", stream, "--item", item(stream, 0)[0], "-o", tmp_path / "p.json")
    assert planned.code == 0 and "certified" in planned.out
    name, stamp = item(stream, 2)
    early = apc("plan-pick", "--stream", stream, "--item", name, "-o", tmp_path / "q.json")
    refused(early, 5, "plan for then")
    enters = early.err.split("past the infeed at ")[1].split(" s")[0]
    later = ("--item", name, "--now", enters, "-o", tmp_path / "q.json")
    assert float(enters) >= stamp - 0.02 and apc("plan-pick", "--stream", stream, *later).code == 0


def test_an_item_that_is_never_met_has_no_plan(stream: Path, tmp_path: Path) -> None:
    name, _ = item(stream, 0)
    words = ("plan-pick", "--stream", stream, "--item", name, "--now", "20", "-o", tmp_path / "p.json")
    refused(apc(*words), 5, "out of the window: it left the window")
    assert not (tmp_path / "p.json").exists()


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--item", "x", "--bin", "belt"), "--bin, --at and --neighbours are for scenes"),
        ((), "name the item by its id in the stream"),
        (
            ("--item", "x", "--scene", "scene.json"),
            "a scene with --scene or a stream with --stream, not both",
        ),
        (("--item", "x", "--now", "-1"), "--now"),
        (("--item", "x", "--now", "nan"), "--now"),
    ],
)
def test_options_that_contradict_each_other_are_wrong_usage(
    stream: Path, words: tuple[str, ...], told: str, tmp_path: Path
) -> None:
    misused(apc("plan-pick", "--stream", stream, *words, "-o", tmp_path / "p.json"), told)


def test_a_transit_by_ara_star_tells_its_bound_and_is_verified(stream: Path, tmp_path: Path) -> None:
    plan, name = tmp_path / "plan.json", item(stream, 0)[0]
    words = ("plan-pick", "--stream", stream, "--item", name, "--planner", "ara-star", "--expansions", "60")
    planned = apc(*words, "-o", plan)
    assert planned.code == 0 and "certified" in planned.out
    figures = json.loads(plan.read_text())["statistics"]
    assert "transit by ARA*: costs " in planned.out
    is_least = figures["transit_cost_bound"] == 1.0
    assert ("m, the least on the lattice, as " in planned.out) == is_least
    assert ("; then they ran out" in planned.out) == (not is_least)
    assert is_least or figures["transit_expansions"] == 60
    assert figures["transit_cost_bound"] >= 1.0 and 0 < figures["transit_expansions"] <= 60
    assert apc("verify", plan, "--stream", stream).code == 0
    again = apc(*words[:-3], "ARA*", *words[-2:], "-o", tmp_path / "again.json", "--json")
    assert json.loads(again.out)["statistics"]["transit_cost_bound"] == figures["transit_cost_bound"]
    motions = [json.loads((tmp_path / f).read_text()) for f in ("plan.json", "again.json")]
    assert {**motions[0], "statistics": 0} == {**motions[1], "statistics": 0}


def test_too_few_expansions_are_no_plan(stream: Path, tmp_path: Path) -> None:
    words = ("plan-pick", "--stream", stream, "--item", item(stream, 0)[0], "--planner", "ara-star")
    refused(
        apc(*words, "--expansions", "1", "-o", tmp_path / "p.json"),
        5,
        "ARA* found none on its lattice in the 1 expansions that it may take",
    )
    assert not (tmp_path / "p.json").exists()


def test_options_of_planners_and_rules_that_do_not_apply_are_wrong_usage(
    stream: Path, tmp_path: Path
) -> None:
    of_stream = ("plan-pick", "--stream", stream, "--item", item(stream, 0)[0], "-o", tmp_path / "p.json")
    misused(apc(*of_stream, "--expansions", "20"), "--expansions limits ARA*; add --planner ara-star")
    misused(apc(*of_stream, "--planner", "ara-star", "--expansions", "0"), "--expansions")
    misused(apc(*of_stream, "--planner", "astar"), "'astar'")
    misused(apc(*of_stream, "--stream-rule", "2013"), "'2013'")
    of_scene = ("plan-pick", "--scene", "s.json", "--bin", "bin_A", "--item", "x", "-o", tmp_path / "p.json")
    misused(apc(*of_scene, "--stream-rule", "pr2-2013"), "--stream-rule applies to streams")


def test_nothing_is_set_down_on_a_running_belt(stream: Path, tmp_path: Path) -> None:
    words = ("plan-pick", "--stream", stream, "--item", item(stream, 0)[0], "--into", "belt")
    refused(apc(*words, "-o", tmp_path / "p.json"), 3, "--into belt: it runs, and nothing is set down on it")
    dropped = (*words[:-2], "--drop-from", "inside", "-o", tmp_path / "p.json")
    refused(apc(*dropped), 3, "--drop-from: off a running belt items are dropped from over the rim")


def test_names_that_are_unknown_are_told(stream: Path, tmp_path: Path) -> None:
    words = ("plan-pick", "--stream", stream, "-o", tmp_path / "p.json", "--item")
    refused(apc(*words, "nothing"), 3, f"{stream}: unknown item 'nothing'")
    refused(apc(*words, item(stream, 0)[0], "--into", "bin_A"), 3, "bin_A")
    missing = ("plan-pick", "--stream", tmp_path / "none.json", "-o", tmp_path / "p.json", "--item", "x")
    refused(apc(*missing), 3, "no such file")


def test_a_time_needs_a_stream(tmp_path: Path) -> None:
    misused(
        apc("plan-pick", "--now", "1", "--item", "x", "-o", tmp_path / "p.json"),
        "--now is the time of a stream",
    )
    misused(apc("plan-pick", "--bin", "belt", "--item", "x", "-o", tmp_path / "p.json"), "--scene")


def test_a_plan_is_executed_while_the_belt_runs(stream: Path, tmp_path: Path) -> None:
    name, stamp = item(stream, 1)
    plan, now = tmp_path / "plan.json", f"{stamp + 0.5:.2f}"
    words = ("--stream", stream, "--now", now)
    assert apc("plan-pick", *words, "--item", name, "-o", plan).code == 0
    played = apc("execute", plan, *words, "--json")
    told = json.loads(played.out)
    assert played.code == 0 and (told["item_is_in"], told["collisions"]) == ("tote", 0)
    assert told["disturbed"] == []  # the others went on with the belt
    stopped = apc("execute", plan, *words, "--operator-stop", "1:2")
    assert stopped.code == 0 and "operator: the item on belt was not taken yet" in stopped.out
    assert "at rest clear of all that the belt may bring" in stopped.out and "is in belt" in stopped.out
    misused(apc("execute", plan, *words, "--planned-in", "scene.json"), "--planned-in is for scenes")
    misused(apc("execute", plan, *words, "--bridge"), "--bridge: not with --stream")
    faster = json.loads(stream.read_text()) | {"speed": 0.4}
    (tmp_path / "faster.json").write_text(json.dumps(faster))
    for command in ("execute", "verify"):
        other = apc(command, plan, "--stream", tmp_path / "faster.json", "--now", now)
        refused(other, 4, "belt runs at 0.4 m/s within 0, but the belt of the plan is belt at 0.33 m/s")
    nearer = json.loads(stream.read_text())
    nearer["items"][1]["position"][0] += 0.01
    (tmp_path / "nearer.json").write_text(json.dumps(nearer))
    other = apc("verify", plan, "--stream", tmp_path / "nearer.json", "--now", now)
    refused(other, 4, "name the stream that it was made for, or plan it again")


def test_a_stream_is_played(tmp_path: Path) -> None:
    path, out = tmp_path / "stream.json", tmp_path / "trial"
    assert apc("make-stream", "--items", "1", "--seed", "3", "-o", path).code == 0
    played = apc("run-trial", path, "-o", out)
    assert played.code == 0 and "1 of 1 items delivered" in played.out
    record = json.loads((out / "trial.json").read_text())
    assert (record["presented"], record["delivered"], record["collisions"]) == (1, 1, 0)
    made = record["made_from"]
    assert (made["format"], made["version"], made["seed"]) == ("apc-stream-trial", 3, 0)
    assert made["stream_sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
    assert sorted(each.name for each in out.iterdir()) == ["motion.json.gz", "stream.json", "trial.json"]
    refused(apc("run-trial", path, "-o", out), 3, "exists already")
    misused(apc("run-trial", path, "--pod-shift", "none", "-o", out), "--pod-shift applies to orders")
    misused(apc("run-trial", path, "--drop-from", "inside", "-o", out), "--drop-from applies to orders")
    by_camera = "run-trial", path, "--perception", "camera", "-o", out
    misused(apc(*by_camera, "--sift", "all-views"), "--sift applies to orders")
    misused(
        apc("run-trial", path, "--perception", "camera", "--pose-noise", "2,1", "-o", out),
        "--pose-noise: a camera has errors of its own",
    )


def test_a_trial_of_a_stream_keeps_its_plans_and_is_shown(tmp_path: Path) -> None:
    path, out, page = tmp_path / "stream.json", tmp_path / "trial", tmp_path / "page.html"
    assert apc("make-stream", "--items", "2", "--gap", "2.0,2.2", "--seed", "5", "-o", path).code == 0
    assert apc("run-trial", path, "--plans", "-o", out).code == 0
    record = json.loads((out / "trial.json").read_text())
    assert record["delivered"] == 2 and all(each["clearance"] >= 0.003 for each in record["items"])
    plans = sorted(out.glob("plan_*.json"))
    assert len(plans) == 2
    for plan in plans:
        seen = plan.with_name(plan.name.replace("plan", "seen"))
        assert apc("verify", plan, "--stream", seen).code == 0
    path.unlink()  # the trial has its own copy
    shown = apc("show", out, "-o", page, "--json")
    assert shown.code == 0 and json.loads(shown.out)["kind"] == "stream trial"
    motion = read_motion(out / "motion.json.gz")
    assert [execution.query for execution in motion.executions] == [read_plan(each).query for each in plans]
    assert (np.diff(motion.times) > 0.0).all()
    first = read_plan(plans[0])
    start = motion.executions[0].t_start
    k = int(np.searchsorted(motion.times, start + 1.0))
    planned = first.trajectory.sample(np.array([motion.times[k] - start]))[0]
    assert np.abs(motion.joints[k, : len(planned)] - planned).max() < 0.05  # rad or m: joints lag a little
    (out / "stream.json").write_text((out / "stream.json").read_text().replace('"seed": 5', '"seed": 6'))
    refused(apc("show", out, "-o", page, "--overwrite"), 4, "is not the stream that the record was made from")


def test_a_trial_in_a_cell_of_ones_own_is_shown_with_that_cell(tmp_path: Path) -> None:
    own, path, out = tmp_path / "own", tmp_path / "stream.json", tmp_path / "trial"
    shutil.copytree(data_path() / "cells" / "conveyor_sia20", own)
    text = (own / "cell.yaml").read_text()
    (own / "cell.yaml").write_text(text.replace("name: conveyor_sia20", "name: my_belt", 1))
    assert apc("make-stream", "--cell", own, "--items", "1", "--seed", "3", "-o", path).code == 0
    assert apc("run-trial", path, "--cell", own, "-o", out).code == 0
    refused(apc("show", out, "-o", tmp_path / "page.html"), 3, "unknown cell 'my_belt'")
    for named in (out, out / "trial.json"):
        assert apc("show", named, "--cell", own, "-o", tmp_path / "page.html", "--overwrite").code == 0


def test_a_trial_in_which_no_arm_moved_has_nothing_to_show(tmp_path: Path) -> None:
    path, out = tmp_path / "stream.json", tmp_path / "trial"
    assert apc("make-stream", "--items", "1", "--seed", "3", "-o", path).code == 0
    values = json.loads(path.read_text())
    values["items"][0]["name"] = "fitness_gear_3lb_dumbbell"  # no cup holds it
    path.write_text(json.dumps(values))
    if apc("run-trial", path, "-o", out).code == 0:
        assert not (out / "motion.json.gz").exists()
        refused(apc("show", out, "-o", tmp_path / "page.html"), 3, "no arm moved in this trial")
