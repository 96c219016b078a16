"""Many streams: one folder, one summary, one page; resumed, compared, and never mixed with other trials."""

from __future__ import annotations

import hashlib
import json
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import pytest

from pickcli.cell.data_path import data_path
from pickcli.commands.operations.played_stream import bound_lines, paper_lines
from pickcli.commands.output.trials_output import cause_lines, rate_line
from pickcli.errors import InputError
from pickcli.jobs.job_run import Build, RunOptions
from pickcli.monte_carlo.interrupted_run import SUMMARY, is_interrupted
from pickcli.monte_carlo.trial_comparison import TrialComparison
from pickcli.monte_carlo.trials_folder import (
    PAGE,
    TrialsReport,
    play_trials,
    write_trials,
)
from pickcli.page.html_page import page_bytes
from pickcli.page.stream_trials_page import stream_trials_page
from pickcli.stream_trials.published_experiments import beside_paper
from pickcli.stream_trials.stream_comparison import STREAMS
from pickcli.stream_trials.stream_job import StreamJob
from pickcli.stream_trials.stream_record import RECORDS
from pickcli.stream_trials.stream_result import ItemOutcome, StreamItemResult, StreamTrialResult
from pickcli.stream_trials.stream_statistics import StreamStatistics
from pickcli.stream_trials.stream_trials import TRIALS, stream_summary
from support.command_line import apc, misused, refused
from support.commissions import SHIPPED
from support.scripted_commissions import write_scripted_commissions
from support.scripted_streams import ScriptedStreams, scripted_record, write_scripted_streams
from support.scripted_trials import write_scripted_trials

SEEDS = range(4)


def played(job: ScriptedStreams, folder: Path, replaced: bool = False) -> TrialsReport:
    folder.mkdir(exist_ok=True)
    build = Build(job, replace(RunOptions(), output=folder / SUMMARY))
    report = play_trials(build, cast(StreamJob, job), SEEDS, {"seeds": list(SEEDS)}, stream_summary)
    write_trials(folder, report, page_bytes(stream_trials_page(report.records)), replaced)
    build.finish()
    return report


def run(*argv: object) -> dict[str, Any]:
    answer = apc(*argv, "--json")
    assert answer.code == 0, answer.err
    told: dict[str, Any] = json.loads(answer.out)
    return told


def records(name: str, chance: float, seeds: range, sha256: str = "a") -> dict[str, dict[str, Any]]:
    return {f"{name}-{seed}": scripted_record(name, seed, chance, sha256) for seed in seeds}


@pytest.fixture(scope="module")
def stream(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("stream") / "two.json"
    words = ("--items", "2", "--gap", "2.0,2.2", "--seed", "3", "-o", path)
    assert apc("make-stream", *words).code == 0
    return path


def test_a_folder_has_every_trial_a_summary_and_a_page_that_show_makes_again(tmp_path: Path) -> None:
    report = played(ScriptedStreams(("a", "b")), tmp_path / "run")
    names = [f"{name}-{seed}" for name in "ab" for seed in SEEDS]
    assert sorted(path.name for path in (tmp_path / "run").iterdir()) == [*names, PAGE, SUMMARY]
    told = json.loads((tmp_path / "run" / SUMMARY).read_text())
    assert told == report.summary and [line["trial"] for line in told["trials"]] == names
    assert told["made_from"]["format"] == "apc-stream-trials"
    assert apc("show", tmp_path / "run", "-o", tmp_path / "page.html").code == 0
    assert (tmp_path / "page.html").read_bytes() == (tmp_path / "run" / PAGE).read_bytes()
    misused(
        apc("show", tmp_path / "run", "--cell", "nope", "-o", tmp_path / "x.html"), "--cell", "leave it out"
    )


def test_an_interrupted_run_goes_on_to_the_same_bytes(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        played(ScriptedStreams(("a",), ends_at=("a", "2")), tmp_path / "run")
    assert is_interrupted(tmp_path / "run")
    played(ScriptedStreams(("a",)), tmp_path / "run", replaced=True)
    played(ScriptedStreams(("a",)), tmp_path / "whole")
    for name in (SUMMARY, PAGE):
        assert (tmp_path / "run" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


def test_only_statistics_depend_on_the_clock_of_the_wall(tmp_path: Path) -> None:
    slow, fast = (
        played(ScriptedStreams(("a",), planning_ms=ms), tmp_path / f"{ms:g}").summary for ms in (90.0, 10.0)
    )
    assert slow["statistics"]["planning_ms"]["median"] == 9 * fast["statistics"]["planning_ms"]["median"]
    assert {**slow, "statistics": 0} == {**fast, "statistics": 0}
    assert (tmp_path / "90" / PAGE).read_bytes() == (tmp_path / "10" / PAGE).read_bytes()


def test_statistics_count_what_came_was_attempted_and_was_delivered() -> None:
    found = StreamStatistics({**records("a", 0.0, range(3)), **records("b", 1.0, range(2))})
    values = found.values()
    assert (values["delivered"]["successes"], values["delivered"]["tries"]) == (9, 20)
    low, high = values["delivered"]["interval"]
    assert 0.25 < low < 9 / 20 < high < 0.66  # Wilson
    of_attempted = values["delivered_of_attempted"]
    assert (of_attempted["successes"], of_attempted["tries"]) == (9, 15)
    assert values["by_item"]["cup"] == {**values["by_item"]["cup"], "successes": 6, "tries": 10}
    assert values["delivered_per_minute"] == pytest.approx(9 / 2.5)
    assert values["offset_m"]["worst"] == 0.003 and values["slip_m_s"]["worst"] == pytest.approx(3e-4)
    assert values["totals"] == {
        "presented": 20, "attempted": 15, "delivered": 9, "collisions": 0, "limit_violations": 0, "stops": 0,
    }  # fmt: skip
    assert found.computing()["planning_ms"]["p99"] == 150.0
    assert found.computing()["refusing_ms"]["median"] == 2.0


def test_only_the_trials_that_the_summary_lists_are_read(tmp_path: Path) -> None:
    """A run over another one leaves trials in its folder that are not its own."""
    run, fewer = tmp_path / "run", tmp_path / "fewer"
    played(ScriptedStreams(("a", "b")), run)
    played(ScriptedStreams(("a",)), run, replaced=True)
    played(ScriptedStreams(("a",)), fewer)
    assert (run / "b-0" / "trial.json").exists()
    names = [f"a-{seed}" for seed in SEEDS]
    assert [*TRIALS.read(run)] == names and TRIALS.is_of(run)
    assert apc("show", run, "-o", tmp_path / "page.html").code == 0
    assert (tmp_path / "page.html").read_bytes() == (fewer / PAGE).read_bytes()
    compared = apc("compare-trials", run, fewer)
    assert compared.code == 0 and "only in" not in compared.out


def test_a_trial_that_is_not_the_one_of_the_summary_or_of_its_stream_is_refused(tmp_path: Path) -> None:
    run, page = tmp_path / "run", tmp_path / "page.html"
    played(ScriptedStreams(("a",)), run)
    (run / "a-1" / "stream.json").write_text("{}")
    refused(apc("show", run, "-o", page), 4, "a-1/stream.json: is not the stream that the record was made")
    (run / "a-1" / "stream.json").unlink()
    record = run / "a-1" / "trial.json"
    record.write_text((run / "a-2" / "trial.json").read_text())
    refused(
        apc("show", run, "-o", page), 4, "a-1/trial.json: is of seed 2, and trials.json lists it with seed 1"
    )
    other = tmp_path / "other"
    played(ScriptedStreams(("a",)), other)
    refused(apc("compare-trials", other, run), 4, "is of seed 2, and trials.json lists it with seed 1")


def test_a_summary_that_cannot_be_followed_is_refused(tmp_path: Path) -> None:
    played(ScriptedStreams(("a",)), tmp_path / "run")
    summary = tmp_path / "run" / SUMMARY
    content = json.loads(summary.read_text())
    outside = [[{"trial": name}] for name in ("../a-0", "..", "", ".")]
    for trials in ([], "x", 5, {"trial": 3}, [1], [{"trial": 3}], None, *outside):
        summary.write_text(json.dumps({**content, "trials": trials}))
        with pytest.raises(InputError, match=r"trials\.json: lists no trials"):
            TRIALS.read(tmp_path / "run")
    summary.write_text(json.dumps(content))
    (tmp_path / "run" / "a-1" / "trial.json").unlink()
    with pytest.raises(InputError, match=r"lists the trial a-1, which has no trial\.json there"):
        TRIALS.read(tmp_path / "run")


@pytest.mark.parametrize("bound", ["1.0", -1.0, [1.0]])
def test_a_bound_on_the_cost_that_is_none_is_told_with_its_field(bound: object, tmp_path: Path) -> None:
    record = scripted_record("a", 0, 0.3)
    record["items"][1]["cost_bound"] = bound
    (tmp_path / "trial.json").write_text(json.dumps(record))
    with pytest.raises(InputError, match=r"(?s)no sound record of a trial.*items\[1\]\.cost_bound"):
        RECORDS.read(tmp_path / "trial.json")


def test_the_median_of_bounds_is_that_of_many_trials_and_of_one() -> None:
    items = [
        StreamItemResult(f"cup#{k}", ItemOutcome.DELIVERED, 1, "", cost_bound=bound)
        for k, bound in enumerate((1.2, None, 1.0))
    ]
    one = StreamTrialResult(0.33, tuple(items), 0, 0, 0, 9.0, (), ())
    many = StreamStatistics({"a-0": {**scripted_record("a", 0, 0.3), **one.record()}})
    assert one.cost_bound == many.cost_bound is not None
    (line,) = bound_lines(one.cost_bound)
    assert "at most 1.100 times the least on the lattice in the median, 1.200 at worst" in line
    assert bound_lines(replace(one, items=tuple(items[1:2])).cost_bound) == []


def test_folders_without_trials_are_told_for_what_they_are(tmp_path: Path) -> None:
    whole, interrupted, single, empty = (tmp_path / name for name in ("whole", "broken", "single", "empty"))
    played(ScriptedStreams(("a",)), whole)
    with pytest.raises(KeyboardInterrupt):
        played(ScriptedStreams(("a",), ends_at=("a", "2")), interrupted)
    write_scripted_streams(tmp_path, "single", range(1), 0.0)
    (tmp_path / "single-0").rename(single)
    empty.mkdir()
    for other, told in (
        (interrupted, "its run was interrupted, and has no trials.json yet"),
        (single, "is the folder of a single trial"),
        (empty, "no trials in it"),
    ):
        for words in ((whole, other), (other, whole)):
            answer = apc("compare-trials", *words)
            refused(answer, 3, f"{other}: {told}")
            assert "has trials of" not in answer.err


def test_without_an_attempt_the_share_of_the_attempted_is_none() -> None:
    left = {"item": "bottle", "outcome": "not attempted", "reason": "", "attempts": 0, "met": None}
    (record,) = records("a", 0.0, range(1)).values()
    record = {**record, "items": [left], "presented": 1, "attempted": 0, "delivered": 0}
    values = StreamStatistics({"a-0": record}).values()
    assert values["delivered_of_attempted"] == {"successes": 0, "tries": 0, "share": None, "interval": None}
    assert rate_line(values["delivered_of_attempted"], "items") == "none"
    assert rate_line(values["delivered"], "items").startswith("0 of 1 items, 0.0%")
    facts = {fact.label: fact.value for fact in stream_trials_page({"a-0": record}).facts}
    assert facts["of those attempted"] == "none"


def test_causes_are_whole_in_the_summary_and_shortened_on_the_terminal() -> None:
    why = "no plan for pick can from belt: " + "; ".join(f"reason {'x' * 60} of {k}" for k in range(9))
    item = {"item": "can", "outcome": "not attempted", "reason": why, "attempts": 0, "met": None}
    found = [
        {"items": n, "why": cause}
        for n, cause in StreamStatistics({"a": {"items": [item]}}).causes(ItemOutcome.NOT_ATTEMPTED)
    ]
    assert str(found[0]["why"]).count("x" * 60) == 9
    (line,) = cause_lines("not attempted", found, "items", "why")
    assert line.startswith("not attempted 1 times: no plan: ") and line.endswith("... (whole in trials.json)")
    assert len(line) < 200


def test_causes_name_neither_the_item_nor_another() -> None:
    """A word of which a name is a part stays."""
    told = "knocked off the belt in an attempt at can#4", "cup#2 cannot be held"
    items = [
        {"item": item, "outcome": "lost", "reason": reason, "attempts": 1}
        for item, reason in zip(("ball#1", "cup#2"), told, strict=True)
    ]
    items.append({"item": "can#4", "outcome": "delivered", "reason": "", "attempts": 1})
    found = StreamStatistics({"one": {"items": items}})
    assert sorted(why for _, why in found.causes(ItemOutcome.LOST)) == [
        "it cannot be held", "knocked off the belt in an attempt at another",
    ]  # fmt: skip


def test_causes_are_told_without_names_and_figures() -> None:
    found = StreamStatistics({**records("a", 0.0, range(3)), **records("b", 1.0, range(2))})
    assert found.causes(ItemOutcome.NOT_ATTEMPTED) == [(5, "no plan: it: too late: by … ms")]
    assert found.causes(ItemOutcome.LOST) == [(6, "it fell after … s")]


def test_streams_of_which_nothing_was_held_have_no_figures_of_meetings() -> None:
    record = scripted_record("a", 0, 0.0)
    items = [{**item, "met": None, "attempts": 0, "outcome": "not attempted"} for item in record["items"]]
    none = {**record, "items": items, "delivered": 0, "attempted": 0, "duration_s": 0.0}
    values = StreamStatistics({"a-0": none}).values()
    assert values["offset_m"] is None and values["delivered_per_minute"] == 0.0
    assert page_bytes(stream_trials_page({"a-0": none}))


def test_the_run_that_delivers_more_of_what_comes_is_better() -> None:
    good, bad = records("a", 0.0, range(12)), records("a", 0.9, range(12))
    found = TrialComparison.of(("old", "new"), bad, good, STREAMS)
    assert found.better == "new" and found.decisive.mean_b == 0.75
    assert found.sentence.startswith("new is better than old by ") and "items in 100" in found.sentence
    alike = TrialComparison.of(("old", "new"), good, good, STREAMS)
    assert alike.better == "" and "no difference beyond chance: new delivers +0.0 items" in alike.sentence
    other = records("a", 0.0, range(12), sha256="b")
    with pytest.raises(InputError, match=r"a\.json is another file in the one than in the other, so the tr"):
        TrialComparison.of(("old", "new"), good, other, STREAMS)
    with pytest.raises(InputError, match="no stream was played with the same seed in both"):
        TrialComparison.of(("old", "new"), good, records("a", 0.0, range(20, 22)), STREAMS)


def test_folders_are_compared_by_the_command(tmp_path: Path) -> None:
    good = write_scripted_streams(tmp_path / "good", "a", range(8), 0.0)
    bad = write_scripted_streams(tmp_path / "bad", "a", range(8), 0.9)
    told = run("compare-trials", bad, good)
    assert told["better"] == str(good) and told["pairs"] == 8
    assert {"delivered_share", "delivered_per_minute", "collisions"} < set(told["figures"])


def test_kinds_are_never_mixed(stream: Path, tmp_path: Path) -> None:
    ours = write_scripted_streams(tmp_path / "ours", "a", range(3), 0.0)
    orders = write_scripted_trials(tmp_path / "orders", "o", range(3), 0.0)
    chains = write_scripted_commissions(tmp_path / "chains", "c", range(3), 0.0)
    refused(apc("compare-trials", ours, orders), 3, f"{ours} has trials of streams and {orders} others")
    refused(apc("compare-trials", orders, ours), 3, f"{ours} has trials of streams and {orders} others")
    refused(apc("compare-trials", chains, ours), 3, f"{chains} has trials of commissions and {ours} others")
    assert TRIALS.is_of(ours) and not TRIALS.is_of(orders) and not TRIALS.is_of(chains)
    assert list(TRIALS.read(ours)) == ["a-0", "a-1", "a-2"]
    write_scripted_trials(tmp_path / "ours", "z", range(1), 0.0)
    for command in (("show", ours, "-o", tmp_path / "x.html"), ("compare-trials", ours, orders)):
        refused(apc(*command), 3, "has trials of streams (a-0) and others (z-0)", "a folder of its own")
    for words, told in (
        ((stream, "jsk_pick_sample"), f"{stream} is a stream and jsk_pick_sample is not"),
        ((stream, SHIPPED), f"{SHIPPED} is a commission and {stream} is not"),
    ):
        refused(apc("run-trials", *words, "-o", tmp_path / "x"), 3, told, "play one kind at a time")
    assert not (tmp_path / "x").exists()


def test_the_papers_experiments_are_set_beside_trials_of_their_streams() -> None:
    content = (data_path() / "tasks" / "pr2_belt_static.json").read_bytes()
    ours = records("pr2_belt_static", 0.0, range(2), sha256=hashlib.sha256(content).hexdigest())
    (beside,) = beside_paper({**ours, **records("pr2_belt_moving", 0.0, range(2))})
    assert beside.rows == (
        ("presented", "100", "8"), ("delivered of those", "91, 91%", "6, 75%"),
        ("attempted", "100", "6"), ("delivered of those", "91, 91%", "6, 100%"),
        ("s for each pick and place", "6.7", "10.0"), ("collisions", "not stated", "0"),
    )  # fmt: skip
    assert beside.title in paper_lines(ours)[0] and not paper_lines(records("a", 0.0, range(2)))
    assert stream_trials_page(ours).tables[-1].rows == beside.rows
    assert len(stream_trials_page(records("a", 0.0, range(2))).tables) == 4


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("--pod-shift", "none"), "--pod-shift applies to orders, not to streams"),
        (("--strategy", "apple"), "--strategy applies to orders, not to streams"),
        (("--sift", "none", "--drop-from", "rim"), "--sift and --drop-from apply to orders, not to streams"),
        (("--perception", "camera", "--pose-noise", "1,1"), "a camera has errors of its own"),
        (("--people", "2"), "--people applies to commissions"),
        (("--stream-rule", "pr2"), "'pr2'"),
    ],
)
def test_what_does_not_fit_is_refused_before_any_work(
    stream: Path, words: tuple[str, ...], told: str, tmp_path: Path
) -> None:
    for each in (stream, "pr2_belt_moving"):
        answer = apc("run-trials", each, *words, "-o", tmp_path / "out")
        misused(answer, told)
    assert not (tmp_path / "out").exists()


def test_files_that_cannot_be_played_are_refused_before_any_work(stream: Path, tmp_path: Path) -> None:
    out, copy = tmp_path / "out", tmp_path / "two.json"
    copy.write_bytes(stream.read_bytes())
    refused(apc("run-trials", stream, copy, "-o", out), 3, copy, "a second stream of the name two; rename it")
    data = json.loads(stream.read_text())
    copy.write_text(json.dumps({**data, "speed": -0.1}))
    refused(apc("run-trials", copy, "-o", out), 3, copy, "speed")
    copy.write_text(json.dumps({**data, "items": []}))
    for command in ("run-trial", "run-trials"):
        refused(apc(command, copy, "-o", out), 3, copy, "items: there are none")
    assert not out.exists()
    for words in (("jsk_pick_sample",), (SHIPPED,)):
        misused(apc("run-trials", *words, "--stream-rule", "earliest", "-o", out), "--stream-rule applies to")
    (out / "x").mkdir(parents=True)
    refused(apc("run-trials", stream, "-o", out), 3, "--overwrite")


@pytest.mark.slow
def test_trials_are_those_of_run_trial_from_one_process_and_from_two(stream: Path, tmp_path: Path) -> None:
    told = run("run-trials", stream, "--seeds", "5:7", "--jobs", 1, "-o", tmp_path / "one")
    again = run("run-trials", stream, "--seeds", "5:7", "--jobs", 2, "-o", tmp_path / "two")
    run("run-trial", stream, "--seed", 6, "-o", tmp_path / "alone")
    assert {**told, "path": 0, "statistics": 0} == {**again, "path": 0, "statistics": 0}
    made = told["made_from"]
    assert (told["totals"]["presented"], made["rule"], made["perception"]) == (4, "earliest", "noise")
    assert (tmp_path / "one" / PAGE).read_bytes() == (tmp_path / "two" / PAGE).read_bytes()
    for folder in (tmp_path / "one" / "two-6", tmp_path / "two" / "two-6"):
        assert {each.name for each in folder.iterdir()} == {
            each.name for each in (tmp_path / "alone").iterdir()
        }
        for name in ("stream.json", "motion.json.gz"):
            assert (folder / name).read_bytes() == (tmp_path / "alone" / name).read_bytes(), name
        alone, many = (json.loads((each / "trial.json").read_text()) for each in (tmp_path / "alone", folder))
        assert {**alone, "statistics": 0} == {**many, "statistics": 0}


@pytest.mark.slow
def test_a_named_task_and_conditions_reach_the_record(tmp_path: Path) -> None:
    """Of the first two items of the PR2's experiment, by its own rule and by a camera."""
    named = Path("data/tasks/pr2_belt_moving.json")
    data = json.loads(named.read_text())
    few = tmp_path / "pr2_few.json"
    few.write_text(json.dumps({**data, "items": data["items"][:2]}))
    words = ("--seeds", "1", "--jobs", 1, "--perception", "camera", "--stream-rule", "pr2-2013")
    told = run("run-trials", few, *words, "-o", tmp_path / "run")
    made = told["made_from"]
    assert (made["rule"], made["perception"], made["camera"]["rate"]) == ("pr2-2013", "camera", 10.0)
    assert list(made["cells"]) == ["pr2_belt"] and told["totals"]["presented"] == 2
    assert told["totals"]["collisions"] == told["totals"]["limit_violations"] == 0


@pytest.mark.parametrize(
    ("key", "value", "told"),
    [
        ("delivered", "x", "delivered: expected a valid integer"), ("collisions", None, "collisions: "),
        ("items", [1], "items[0]: expected an object"), ("items", "x", "items: expected"),
        ("speed_m_s", "x", "speed_m_s: expected"), ("delivered", 0, "delivered is 0, but items has"),
        ("presented", 0, "presented is 0, but items has"), ("items", [], "but items has 0"),
    ],
)  # fmt: skip
def test_an_edited_record_is_refused_with_its_field(
    key: str, value: object, told: str, tmp_path: Path
) -> None:
    (record,) = records("a", 0.0, range(1)).values()
    path = tmp_path / "trial.json"
    path.write_text(json.dumps(record))
    assert RECORDS.read(path)["presented"] == record["presented"]
    path.write_text(json.dumps({**record, key: value}))
    with pytest.raises(InputError) as error:
        RECORDS.read(path)
    assert told in str(error.value) and str(path) in str(error.value)


def test_a_run_over_another_one_that_is_ended_as_it_writes_is_no_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The summary of the former one is gone, and that of its trials not there yet."""
    played(ScriptedStreams(("a",)), tmp_path / "run")

    def ended(path: Path, *rest: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("pickcli.monte_carlo.trials_folder.write_bytes", ended)
    with pytest.raises(KeyboardInterrupt):
        played(ScriptedStreams(("a",), inputs="fedcba9876543210"), tmp_path / "run", replaced=True)
    with pytest.raises(InputError, match="its run was interrupted"):
        TRIALS.read(tmp_path / "run")
