"""JointTrajectory as JSON: what was written is read back and compared with the plan, at every point."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.errors import InputError
from pickcli.export.exporter import ExportRequest
from pickcli.export.joint_trajectory import EXPORTER, MAX_ERROR
from pickcli.export.samples import SECOND
from pickcli.motion.plan_file import motion_hash
from pickcli.motion.trajectory import Trajectory
from support.exported_motions import at_rate, handmade_pick, ur_request

RATES = (None, 50.0, 125.0, 333.3, 1000.0)


def read_back(request: ExportRequest) -> tuple[dict[str, Any], Trajectory]:
    """The file, and the motion that a controller makes of it."""
    told = json.loads(EXPORTER.encode(request))
    message = told["trajectory"]
    columns = [
        np.array([point[name] for point in message["points"]])
        for name in ("positions", "velocities", "accelerations")
    ]
    times = [
        p["time_from_start"]["sec"] + p["time_from_start"]["nanosec"] / SECOND for p in message["points"]
    ]
    return told, Trajectory(tuple(message["joint_names"]), np.array(times), *columns)


@pytest.mark.parametrize("rate", RATES)
def test_a_controller_makes_the_plan_of_it(rate: float | None) -> None:
    plan = handmade_pick().plan
    _, read = read_back(at_rate(handmade_pick(), rate))
    assert read.joint_names == plan.trajectory.joint_names
    assert np.all(np.diff(read.times) > 0.0) and read.times[0] == 0.0
    assert abs(read.times[-1] - plan.trajectory.duration) <= 1e-9
    assert not read.velocities[-1].any() and not read.velocities[0].any()
    every_ms = np.arange(0.0, plan.trajectory.duration, 1e-3)
    bound = 1e-9 if rate is None else MAX_ERROR
    np.testing.assert_allclose(read.sample(every_ms), plan.trajectory.sample(every_ms), atol=bound, rtol=0.0)
    if rate is None:
        np.testing.assert_array_equal(read.positions, plan.trajectory.positions)


@pytest.mark.parametrize("rate", RATES)
def test_limits_hold_at_the_samples(rate: float | None) -> None:
    request = at_rate(handmade_pick(), rate)
    _, read = read_back(request)
    limits = request.scene.cell.robot.limits
    assert np.all(read.positions >= limits.lower) and np.all(read.positions <= limits.upper)
    assert np.all(np.abs(read.velocities) <= limits.velocity * (1 + 1e-6))
    assert np.all(np.abs(read.accelerations) <= limits.acceleration * (1 + 1e-6))


def test_events_stand_beside_it_at_their_times() -> None:
    request = handmade_pick()
    told, _ = read_back(request)
    found = [
        (
            e["device"],
            e["action"],
            e["time_from_start"]["sec"] + e["time_from_start"]["nanosec"] / SECOND,
            e["lead"],
        )
        for e in told["events"]
    ]
    planned = sorted(
        ((e.device, e.action, e.t_trigger or 0.0, e.lead) for e in request.plan.events), key=lambda e: e[2]
    )
    assert len(found) == len(planned) > 3
    for one, other in zip(found, planned, strict=True):
        assert one[:2] == other[:2] and one[3] == other[3] and abs(one[2] - other[2]) <= 1e-9
    devices = request.scene.cell.devices
    assert [e["kind"] for e in told["events"]] == [devices[e[0]].kind.value for e in found]


def test_it_says_what_it_was_made_from() -> None:
    request = handmade_pick()
    told, _ = read_back(request)
    assert list(told) == ["format", "version", "plan", "trajectory", "events"]
    assert told["plan"]["motion_hash"] == motion_hash(request.plan)
    assert told["plan"]["cell_fingerprint"] == request.scene.cell.fingerprint
    assert list(told["trajectory"]) == ["header", "joint_names", "points"]
    assert told["trajectory"]["header"] == {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}


def test_the_same_plan_gives_the_same_bytes() -> None:
    request = handmade_pick()
    other = replace(request, plan=replace(request.plan, statistics={"planning_ms": 3.0}))
    assert EXPORTER.encode(request) == EXPORTER.encode(other)


def test_a_rate_that_leaves_the_verified_motion_is_refused() -> None:
    with pytest.raises(
        InputError, match=r"rate: with 1 Hz .* leave the verified motion by .* (rad|m) in \w+, 0.001"
    ):
        EXPORTER.encode(at_rate(handmade_pick(), 1.0))


@settings(max_examples=30)
@given(st.floats(1.0, 1000.0))
def test_any_rate_that_is_taken_keeps_to_the_motion(rate: float) -> None:
    request = ur_request(rate)
    try:
        _, read = read_back(request)
    except InputError as error:
        assert "leave the verified motion" in str(error)
        return
    times = np.arange(0.0, 2.0013, 1.7e-3)
    assert np.abs(read.sample(times) - request.plan.trajectory.sample(times)).max() <= 1.1 * MAX_ERROR
