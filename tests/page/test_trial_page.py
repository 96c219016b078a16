"""The page of a trial: what was recorded is replayed, attempts have their reasons, rules their points."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pickcli.errors import InputError
from pickcli.files.packed_array import unpacked
from pickcli.page.html_page import page_bytes
from pickcli.page.page_document import PageDocument
from pickcli.page.page_scene import Tone
from pickcli.page.trial_page import trial_page
from pickcli.page.trials_page import trials_page
from pickcli.trial.loop import run_trial
from pickcli.trial.motion_record import RecordedMotion, motion_values, read_motion, write_motion
from pickcli.trial.record_schema import refuse_bad_record
from pickcli.trial.trial_record import trial_record
from support.browser import browser
from support.handmade_plans import CRAYOLA, cell, pick
from support.order_builders import pick_order
from support.recorded_pick import play
from support.scripted_trial import ScriptedTrial, scene_of

ORDER = pick_order({"bin_B": (CRAYOLA, "dove_beauty_bar")}, ("bin_B", CRAYOLA), ("bin_B", "dove_beauty_bar"))


def record(**script: Any) -> dict[str, Any]:
    """Of a trial in which the first target is delivered, and the second by the script."""
    played = run_trial(ORDER, ScriptedTrial(scene_of(ORDER, cell()), **script).interfaces())
    return trial_record(played, "order.json", wall_s=0.5)


@pytest.fixture(scope="module")
def motion(tmp_path_factory: pytest.TempPathFactory) -> RecordedMotion:
    path = tmp_path_factory.mktemp("motion") / "motion.json.gz"
    write_motion(path, motion_values(play()[0], [cell()]))
    return read_motion(path)


@pytest.fixture(scope="module")
def shown(motion: RecordedMotion) -> PageDocument:
    return trial_page(record(no_plan=frozenset({"dove_beauty_bar"})), pick()[1], motion)


def test_it_replays_what_was_recorded(shown: PageDocument, motion: RecordedMotion) -> None:
    assert shown.motion is not None and shown.robot is not None
    assert shown.robot.moved == motion.joint_names
    np.testing.assert_allclose(unpacked(shown.motion.positions), motion.joints, atol=1e-4)
    assert [track.item for track in shown.motion.tracks] == [CRAYOLA]
    segments = next(lane for lane in shown.lanes if lane.name == "segments")
    assert [span.label for span in segments.spans] == [str(s.kind) for s in pick()[0].segments]
    assert [signal.name for signal in shown.signals] == ["vacuum", "velocity", "acceleration", "jerk"]
    assert shown.clearance is not None
    distances = unpacked(shown.clearance.values)
    assert -0.005 < distances.min() < 0.05 and any(CRAYOLA in name for name in shown.clearance.names)


def test_motions_to_looks_are_of_no_attempt(shown: PageDocument, motion: RecordedMotion) -> None:
    (own,) = motion.executions
    look = replace(own, query="look from cam_B", t_start=own.t_start - 2.0, t_end=own.t_start - 1.0)
    page = trial_page(
        record(no_plan=frozenset({"dove_beauty_bar"})),
        pick()[1],
        replace(motion, executions=(look, own, look)),
    )
    assert [(c.t_start, c.t_end) for c in page.chapters] == [(c.t_start, c.t_end) for c in shown.chapters]
    assert {lane.name: lane.spans for lane in page.lanes if lane.name != "segments"} == {
        lane.name: lane.spans for lane in shown.lanes if lane.name != "segments"
    }


def test_attempts_are_chapters_with_their_reasons(shown: PageDocument, motion: RecordedMotion) -> None:
    by_item = {chapter.item: chapter for chapter in shown.chapters}
    assert set(by_item) == {CRAYOLA, "dove_beauty_bar"}
    done, missed = by_item[CRAYOLA], by_item["dove_beauty_bar"]
    (execution,) = motion.executions
    assert (done.tone, done.marks) == (Tone.GOOD, ())
    assert (done.t_start, done.t_end) == pytest.approx((execution.t_start, execution.t_end), abs=1e-3)
    assert missed.tone is Tone.BAD and missed.outcome == "no plan" and missed.place == "bin_B"
    assert [(mark.title, mark.t) for mark in missed.marks] == [("does not hold", None)]


def test_the_score_is_told_by_rule_and_line(shown: PageDocument) -> None:
    told = record(no_plan=frozenset({"dove_beauty_bar"}))
    (table,) = shown.tables
    assert [int(row[0]) for row in table.rows] == [line["points"] for line in told["score_lines"]]
    assert sum(int(row[0]) for row in table.rows) == told["score"]
    assert f"{told['score']} of {told['max_score']}" in shown.title


def seen(item: str, bound: float | None, off: float | None, refusal: str = "") -> dict[str, Any]:
    angle = {"bound_deg": None if bound is None else 2.0, "truly_off_deg": None if off is None else 1.0}
    at = {"place": "bin_B", "item": item, "confidence": 0.9, "refusal": refusal}
    return {**at, "bound_mm": bound, "truly_off_mm": off, **angle}


def test_looks_are_told_with_what_was_left_out_and_what_was_off_beyond_its_bounds(
    motion: RecordedMotion,
) -> None:
    sure, unsure, wrong = seen("tape", 5.0, 1.0), seen("book", None, 2.0), seen("cards", 5.0, 9.0)
    none, gone = seen("bulb", None, None, "no pose explains it"), seen("glue", 5.0, None)
    looks = [
        {"number": k + 1, "cameras": {"bin_B": ["hand", "cam_B"]}, "items": items}
        for k, items in enumerate(([sure], [sure, unsure, none], [sure, wrong, gone]))
    ]
    told = {**record(), "looks": looks}
    refuse_bad_record(told, "trial.json")
    table = next(table for table in trial_page(told, pick()[1], motion).tables if table.title == "Looks")
    assert [row[:2] for row in table.rows] == [
        ("1: bin_B, hand at cam_B", "1 of 1"),
        ("2: bin_B, hand at cam_B", "1 of 3"),
        ("3: bin_B, hand at cam_B", "3 of 3"),
    ]
    assert [row[2] for row in table.rows][:2] == ["", "book: no bounds; bulb: no pose explains it"]
    assert table.rows[2][2] == "cards: is truly off by 9.0 mm, 1.0 degrees; glue: is gone"
    assert table.tones == (Tone.PLAIN, Tone.FAIR, Tone.BAD)
    faults: tuple[dict[str, Any], ...] = ({"bound_mm": "5"}, {"refusal": None}, {"truly_off_deg": []})
    for broken in faults:
        items = [{**sure, **broken}]
        with pytest.raises(InputError, match=next(iter(broken))):
            refuse_bad_record({**told, "looks": [{**looks[0], "items": items}]}, "trial.json")


def test_it_is_the_same_again_and_small(shown: PageDocument, motion: RecordedMotion) -> None:
    again = trial_page(record(no_plan=frozenset({"dove_beauty_bar"})), pick()[1], motion)
    assert page_bytes(shown) == page_bytes(again)
    assert len(page_bytes(shown)) < 1_000_000


def test_several_trials_are_compared() -> None:
    document = trials_page({"a": record(), "b": record(no_plan=frozenset({"dove_beauty_bar"}))})
    scores, by_place_table, by_item_table, causes = document.tables
    assert [row[0] for row in scores.rows] == ["a", "b"]
    assert [row[4:6] for row in scores.rows] == [("2", "2"), ("1", "2")]
    assert by_place_table.rows == (("bin B", "3", "4", "75% (95 %: 30% to 95%)"),)
    assert [row[0] for row in by_item_table.rows] == ["dove beauty bar", "crayola 24 ct"], "the worst first"
    assert [(row[0], row[1].partition(":")[0]) for row in causes.rows] == [("1", "no plan")]
    shares, by_place, by_item = document.charts
    assert sum(bar.counts[0] for bar in shares.bars) == 2 and shares.bars[-1].counts == (1,)
    assert [(bar.name, bar.counts) for bar in by_place.bars] == [("bin B", (3, 0, 1))]
    assert {bar.name: bar.counts for bar in by_item.bars}["dove beauty bar"] == (1, 0, 1)
    assert ("delivered", "3 of 4 targets, 75% (95 %: 30% to 95%)") in {
        (fact.label, fact.value) for fact in document.facts
    }


@pytest.mark.slow
def test_pages_of_trials_open_in_a_browser(
    chromium: str, shown: PageDocument, motion: RecordedMotion, tmp_path: Path
) -> None:
    page, several = tmp_path / "trial.html", tmp_path / "trials.html"
    page.write_bytes(page_bytes(shown))
    several.write_bytes(page_bytes(trials_page({"a": record()})))
    with browser(chromium) as found:
        found.open(page)
        found.press("]")
        assert found.run("apcPage.chapter") >= 0
        found.run(
            "[...document.querySelectorAll('#panel .row')].find(r => r.textContent.includes('dove')).click()"
        )
        assert found.run("apcPage.chapters[apcPage.chapter].item") == "dove_beauty_bar"
        assert "does not hold" in found.run("document.querySelector('#panel .inner').textContent")
        at = f"apcPage.stage.items.get('{CRAYOLA}').position.z"
        before = found.run(f"(apcPage.replay.seek(0), {at})")
        found.press("End")
        assert abs(found.run(at) - before) > 0.1
        still = tmp_path / "still.html"
        still.write_bytes(
            page_bytes(trial_page(record(), pick()[1], replace(motion, executions=(), items={})))
        )
        found.open(still)
        for key in (" ", "ArrowRight", "ArrowUp", "l"):
            found.press(key)
        found.open(several)
        assert "1 trials" in found.run("document.body.textContent")
        assert found.errors == []


def test_pictures_of_looks_are_small_enough_together_and_the_same_bytes_again(motion: RecordedMotion) -> None:
    rng = np.random.default_rng(2)
    noise = {(k, "bin_A"): rng.integers(0, 255, (600, 640, 3), dtype=np.uint8) for k in range(3)}
    flat = {(k, "bin_A"): np.full((600, 640, 3), k, dtype=np.uint8) for k in range(60)}
    shown = trial_page(record(), pick()[1], motion, pictures=flat)
    assert [picture.title for picture in shown.pictures] == [f"{k}: bin_A" for k in range(60)]
    for pictures in (noise, flat, {**flat, **{(k, "bin_B"): noise[0, "bin_A"] for k in range(200)}}):
        shown = trial_page(record(), pick()[1], motion, pictures=pictures)
        n_bytes = sum(len(picture.data) - len("data:image/jpeg;base64,") for picture in shown.pictures)
        assert 0 < n_bytes < 4 / 3 * 600_000 + 4 * len(shown.pictures)
        assert len(page_bytes(shown)) < 2_000_000
        again = trial_page(record(), pick()[1], motion, pictures=pictures)
        assert page_bytes(again) == page_bytes(shown)
