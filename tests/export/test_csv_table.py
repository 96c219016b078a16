"""The table: every number comes back, units stand in the head, events at their times."""

from __future__ import annotations

import csv
import io
from dataclasses import replace

import numpy as np
import pytest

from pickcli.export.csv_table import EXPORTER
from pickcli.export.exporter import ExportRequest
from support.exported_motions import at_rate, handmade_pick, ur_request


def rows_of(request: ExportRequest) -> list[dict[str, str]]:
    text = EXPORTER.encode(request).decode()
    assert "\r" not in text and text.endswith("\n")
    return list(csv.DictReader(io.StringIO(text)))


def test_units_stand_in_the_names_of_the_columns() -> None:
    head = list(rows_of(handmade_pick())[0])
    assert head[:4] == ["time_s", "rail_position_m", "rail_velocity_m_per_s", "rail_acceleration_m_per_s2"]
    assert head[4:7] == [
        "joint_s_position_rad", "joint_s_velocity_rad_per_s", "joint_s_acceleration_rad_per_s2",
    ]  # fmt: skip
    assert head[-3:] == ["segment", "held", "events"] and len(head) == 1 + 3 * 8 + 3


@pytest.mark.parametrize("rate", [None, 125.0])
def test_every_number_comes_back(rate: float | None) -> None:
    request = at_rate(handmade_pick(), rate)
    trajectory, rows = request.plan.trajectory, rows_of(request)
    times = np.array([float(row["time_s"]) for row in rows])
    assert times[0] == 0.0 and np.all(np.diff(times) > 0.0) and abs(times[-1] - trajectory.duration) <= 1e-9
    numbers = np.array([[float(row[name]) for name in list(row)[1:-3]] for row in rows]).reshape(
        len(rows), 8, 3
    )
    if rate is None:
        np.testing.assert_array_equal(numbers[:, :, 0], trajectory.positions)
        np.testing.assert_array_equal(numbers[:, :, 1], trajectory.velocities)
        np.testing.assert_array_equal(numbers[:, :, 2], trajectory.accelerations)
    np.testing.assert_allclose(numbers[:, :, 0], trajectory.sample(times), rtol=0.0, atol=1e-8)


@pytest.mark.parametrize("rate", [None, 7.0, 125.0])
def test_events_stand_in_the_row_from_which_they_are_due(rate: float | None) -> None:
    request = at_rate(handmade_pick(), rate)
    rows = rows_of(request)
    found = []
    for row, after in zip(rows, [*rows[1:], None], strict=True):
        for told in row["events"].split("; ") if row["events"] else ():
            what, _, at = told.partition("@")
            assert float(row["time_s"]) <= float(at) and (after is None or float(at) < float(after["time_s"]))
            found.append((what, float(at)))
    planned = sorted((e.t_trigger or 0.0, f"{e.device}={e.action}") for e in request.plan.events)
    assert [what for what, _ in found] == [what for _, what in planned]
    np.testing.assert_allclose([at for _, at in found], [at for at, _ in planned], rtol=0.0, atol=1e-9)


def test_an_event_after_the_end_stands_in_the_last_row() -> None:
    assert rows_of(ur_request())[-1]["events"] == "valve=off@2.050000000"


def test_segments_and_what_is_held_are_told() -> None:
    request = handmade_pick()
    rows = rows_of(at_rate(request, 100.0))[:-1]
    assert {bool(row["held"]) for row in rows} == {False, True}
    for row in rows:
        t = float(row["time_s"])
        segment = next(s for s in request.plan.segments if s.t_start - 1e-9 <= t < s.t_end)
        assert (row["segment"], row["held"]) == (segment.kind.value, segment.held or "")


def test_a_row_at_a_boundary_tells_the_segment_that_begins_there() -> None:
    """Ends of segments are not on a grid of nanoseconds: rounded down, a row still is the next one's."""
    request = handmade_pick()
    first, second, *others = request.plan.segments
    odd = first.t_end + 4e-10
    segments = (replace(first, t_end=odd), replace(second, t_start=odd), *others)
    rows = rows_of(replace(request, plan=replace(request.plan, segments=segments)))
    (at,) = (row for row in rows if row["time_s"] == f"{first.t_end:.9f}")
    assert (at["segment"], at["held"]) == (second.kind.value, second.held or "")


def test_names_with_commas_and_quotes_are_quoted() -> None:
    request = ur_request()
    names = ('a,"b', *request.plan.trajectory.joint_names[1:])
    odd = replace(request.plan, trajectory=replace(request.plan.trajectory, joint_names=names))
    assert 'a,"b_position_rad' in rows_of(replace(request, plan=odd))[0]


def test_the_same_plan_gives_the_same_bytes() -> None:
    assert EXPORTER.encode(handmade_pick()) == EXPORTER.encode(handmade_pick())
