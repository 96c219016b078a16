"""A recorder gives every experience once to who stores it, and all of it to who asks for all."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pickcli.roadmap.query_experience import ExperienceRecorder, QueryExperience
from pickcli.roadmap.trajectory_database import PayloadClass


@given(st.lists(st.booleans()))
def test_everything_is_taken_once_and_in_order(takes: list[bool]) -> None:
    recorder = ExperienceRecorder()
    taken: list[QueryExperience] = []
    recorded: list[QueryExperience] = []
    for k, is_take in enumerate(takes):
        if is_take:
            taken += recorder.take()
            continue
        recorded.append(QueryExperience(np.zeros(1), np.full(1, k), PayloadClass.EMPTY, ()))
        recorder.record(recorded[-1:])
    taken += recorder.take()
    assert taken == recorded == list(recorder.recorded)
