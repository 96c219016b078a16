"""Queries of a stream: to all pregrasps of an item at once, free of all that the belt brings."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from pickcli.errors import InputError
from pickcli.path_planning.planner_names import PlannerName
from pickcli.planner_benchmark.benchmark_entries import GeometricEntry
from pickcli.planner_benchmark.lattice_entry import LatticeEntry
from pickcli.planner_benchmark.planner_benchmark import compare_queries
from pickcli.planner_benchmark.stream_queries import StreamQueries, stream_queries
from support.pr2_picks import context, stream


@cache
def asked() -> StreamQueries:
    return stream_queries(context(), stream(n=2))


def test_goals_are_free_and_over_where_the_item_passes_the_middle_of_the_window() -> None:
    first, last = stream().belt.window
    middle = stream().carrier.T_world_carrier @ [(first + last) / 2, 0.0, 0.0, 1.0]
    for query in asked().queries.values():
        assert len(query.goals) > 1 and query.planning.are_valid(query.goals).all()
        tips = context().arm.tips(query.goals, query.planning.tool_state)[:, :3, 3]
        assert (np.linalg.norm(tips[:, :2] - middle[:2], axis=1) < 0.25).all()


def test_goals_are_in_the_turn_of_the_start() -> None:
    is_continuous = context().cell.robot.limits.is_continuous
    for query in asked().queries.values():
        assert np.abs(query.goals - query.start)[:, is_continuous].max() <= np.pi + 1e-9


def test_both_kinds_of_planner_answer_and_ara_star_keeps_its_bound() -> None:
    entries = (GeometricEntry(PlannerName.RRT_CONNECT), LatticeEntry(is_first_only=True), LatticeEntry(100))
    done = compare_queries(asked().queries, entries, label="stream", n_tries=1)
    answers = {(each.planner, each.pair): each.answer for each in done.attempts}
    for pair, query in asked().queries.items():
        ours, first, whole = (answers[entry.name, pair] for entry in entries)
        assert ours is not None and first is not None and whole is not None
        assert ours.cost_bound is None and first.cost_bound is not None and whole.cost_bound is not None
        assert 1.0 <= whole.cost_bound <= first.cost_bound <= 20.0
        assert min(ours.duration, first.duration, whole.duration) >= query.bound


def test_an_item_without_a_pregrasp_is_told_with_the_reason() -> None:
    high = stream(n=2)
    far = high.items[0].T_belt_item.copy()
    far[1, 3] += 3.0
    beside = replace(high, items=(replace(high.items[0], T_belt_item=far), high.items[1]))
    found = stream_queries(context(), beside)
    assert set(found.without) == {high.items[0].id} and found.without[high.items[0].id]
    assert {item for _, item in found.queries} == {high.items[1].id}
    with pytest.raises(InputError, match="no item of the stream has a pregrasp"):
        stream_queries(context(), replace(beside, items=beside.items[:1]))


def test_a_belt_that_stands_is_refused() -> None:
    with pytest.raises(InputError, match="the belt of the stream stands"):
        stream_queries(context(), replace(stream(), speed=0.0))
