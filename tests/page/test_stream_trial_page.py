"""The page of a trial of a stream: where items are before they come, and what it says of each."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from pickcli.page.page_document import PageDocument
from pickcli.page.stream_trial_page import stream_trial_page, waiting_scene
from pickcli.stream_trials.stream_record import stream_record
from pickcli.stream_trials.stream_trial import PlayedStream, play_stream
from pickcli.stream_trials.stream_trial_request import StreamTrialRequest
from pickcli.trial.motion_record import RecordedMotion, motion_values, parse_motion
from support.belt_picks import cell, context, stream

ITEMS = stream(n=3)


@pytest.fixture(scope="module")
def played() -> PlayedStream:
    return play_stream(StreamTrialRequest(ITEMS), [context()])


@pytest.fixture(scope="module")
def motion(played: PlayedStream) -> RecordedMotion:
    return parse_motion(motion_values(played.recorder, [cell()]))


@pytest.fixture(scope="module")
def page(played: PlayedStream, motion: RecordedMotion) -> PageDocument:
    record = stream_record(StreamTrialRequest(ITEMS), played.result, context(), "three.json", "0" * 64)
    return stream_trial_page(record, waiting_scene(ITEMS), [cell()], motion)


def test_items_ride_with_the_belt_until_they_are_taken(motion: RecordedMotion) -> None:
    along = ITEMS.carrier.T_world_carrier[:3, 0]
    for name, (times, poses) in motion.items.items():
        riding = ITEMS.find(name)
        is_early = times < times[0] + 1.0
        expected = [ITEMS.travel_at(riding, t) for t in times[is_early]]
        origin = ITEMS.carrier.T_world_carrier[:3, 3]
        assert (poses[is_early, :3] - origin) @ along == pytest.approx(expected, abs=0.005)
        assert (np.diff(times) > 0.0).all()


def test_attempts_follow_each_other(page: PageDocument, played: PlayedStream) -> None:
    moved = [each.item for each in played.result.items if each.attempts]
    assert [chapter.item for chapter in page.chapters] == moved and moved
    spans = sorted((chapter.t_start, chapter.t_end) for chapter in page.chapters)
    assert all(a[1] <= b[0] + 1e-3 for a, b in itertools.pairwise(spans))


def test_the_table_has_every_item_with_its_outcome(page: PageDocument, played: PlayedStream) -> None:
    (table,) = page.tables
    assert [row[:2] for row in table.rows] == [(each.item, str(each.outcome)) for each in played.result.items]


def test_what_waits_stands_beside_each_other_and_off_the_belt() -> None:
    scene = waiting_scene(stream(n=6))
    at = np.array([placed.T_world_item[:3, 3] for placed in scene.items])
    apart = np.linalg.norm(at[:, None] - at[None], axis=2) + np.eye(len(at))
    assert apart.min() > 0.3
    on_belt = np.linalg.inv(stream().carrier.T_world_carrier) @ np.vstack([at.T, np.ones(len(at))])
    assert (on_belt[0] < -0.5).all()
