"""The motion of a trial: recorded as it was, thinned within its bounds, the same again, read strictly."""

from __future__ import annotations

import gzip
import json
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.tool import ToolState
from pickcli.cell.tools.lip_leak import FULL_VACUUM
from pickcli.errors import StaleError
from pickcli.files.packed_array import packed
from pickcli.motion.plan import Plan
from pickcli.scene.scene import Scene
from pickcli.simulation.motion_recorder import MotionRecorder
from pickcli.trial.motion_record import (
    JOINT_BOUND,
    MAX_TEXT,
    POSITION_BOUND,
    VACUUM_BOUND,
    motion_values,
    parse_motion,
    read_motion,
    refuse_other_motion,
    refuse_other_record,
    thinned,
    write_motion,
)
from pickcli.trial.trial_record import record_digest
from support.handmade_plans import CRAYOLA, pick
from support.recorded_pick import play

ROUNDING = 1e-4


@dataclass(frozen=True, eq=False)
class Played:
    recorder: MotionRecorder
    values: dict[str, Any]
    plan: Plan
    after: Scene


@pytest.fixture(scope="module")
def played() -> Played:
    recorder, after = play()
    plan, scene = pick()
    return Played(recorder, motion_values(recorder, [scene.cell]), plan, after)


@given(
    st.lists(st.lists(st.floats(-5.0, 5.0), min_size=2, max_size=2), min_size=2, max_size=60),
    st.floats(0.01, 3.0),
)
def test_lines_between_the_rows_that_are_kept_lead_past_all_others(
    rows: list[list[float]], bound: float
) -> None:
    table, times = np.array(rows), np.linspace(0.0, 1.0, len(rows))
    kept = thinned(times, table, np.array([bound, 2 * bound]))
    assert kept[0] == 0 and kept[-1] == len(rows) - 1 and (np.diff(kept) > 0).all()
    drawn = np.column_stack([np.interp(times, times[kept], column) for column in table[kept].T])
    assert (np.abs(drawn - table) <= np.array([bound, 2 * bound]) * (1 + 1e-9) + 1e-9).all()


def test_a_straight_line_keeps_its_ends_alone() -> None:
    times = np.linspace(0.0, 1.0, 50)
    assert thinned(times, np.outer(times, [1.0, -2.0]), np.full(2, 1e-6)).tolist() == [0, 49]


def test_what_was_recorded_is_read_again_within_its_bounds(played: Played, tmp_path: Path) -> None:
    path, recorder = tmp_path / "motion.json.gz", played.recorder
    write_motion(path, played.values)
    motion = read_motion(path)
    times, joints = np.array(recorder.times), np.array(recorder.joints)
    replayed = np.column_stack([np.interp(times, motion.times, column) for column in motion.joints.T])
    # The arm may move by its speed over the rounding of the times, too.
    assert np.abs(replayed - joints).max() <= JOINT_BOUND + ROUNDING + 5e-4 * 3.0
    assert len(motion.times) < len(times) / 2
    vacuum = np.interp(times, motion.vacuum_times, motion.vacuum)
    assert np.abs(vacuum - recorder.vacuum).max() <= VACUUM_BOUND + 0.1 * FULL_VACUUM
    assert motion.vacuum.max() > 0.5 * FULL_VACUUM
    item_times, poses = motion.items[CRAYOLA]
    end = played.after.find(CRAYOLA).T_world_item[:3, 3]
    assert np.abs(poses[-1, :3] - end).max() <= POSITION_BOUND + 2e-3
    assert item_times[-1] <= motion.times[-1] and set(motion.items) == {CRAYOLA}


def test_an_execution_is_the_plan_in_simulated_time(played: Played, tmp_path: Path) -> None:
    write_motion(tmp_path / "motion", played.values)
    (execution,) = read_motion(tmp_path / "motion").executions
    plan = played.plan
    assert execution.query == plan.query
    assert [s.kind for s in execution.segments] == [s.kind for s in plan.segments]
    for now, planned in zip(execution.segments, plan.segments, strict=True):
        # The arm rests on the item until the vacuum is there: never less than planned, little longer.
        late = now.t_start - execution.t_start - planned.t_start
        assert -0.11 <= late <= 1.6 and now.touching == planned.touching and now.held == planned.held
    assert execution.t_end - execution.t_start >= plan.trajectory.duration
    for shares in execution.shares:
        assert shares.shape == (len(execution.times), 8)
        assert 0.3 < np.abs(shares).max() <= 1.0 + 1e-2


def test_the_same_trial_gives_the_same_bytes(played: Played, tmp_path: Path) -> None:
    recorder, _ = play()
    for name, values in (("a", played.values), ("b", motion_values(recorder, [pick()[1].cell]))):
        write_motion(tmp_path / name, values)
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    assert (tmp_path / "a").stat().st_size < 60_000


def _execution(told: dict[str, Any], **change: Any) -> dict[str, Any]:
    return told | {"executions": [told["executions"][0] | change]}


@pytest.mark.parametrize(
    "spoil",
    [
        lambda told: told | {"version": 2},
        lambda told: {key: value for key, value in told.items() if key != "times"},
        lambda told: told | {"times": told["times"] | {"shape": [3]}},
        lambda told: told | {"times": told["times"] | {"type": "f8"}},
        lambda told: told | {"executions": [{"query": "move"}]},
        lambda told: told | {"times": packed(np.array([3.0, 2.0]), 1e-3)},
        lambda told: told | {"times": packed(np.array([0.0, 9e5]), 1.0)},
        lambda told: told | {"times": told["times"] | {"unit": 1e300}},
        lambda told: told | {"times": packed(np.zeros(0), 1e-3)},
        lambda told: told | {"joints": told["joints"][1:]},
        lambda told: told | {"joints": [told["joints"]]},
        lambda told: told | {"items": [told["items"][0] | {"times": packed(np.zeros(1), 1e-3)}]},
        lambda told: told | {"vacuum": told["vacuum"] | {"values": told["vacuum"]["times"] | {"shape": [1]}}},
        lambda told: _execution(told, t_end=1e4, t_start=2e4),
        lambda told: _execution(told, times=packed(np.zeros(1), 1e-3)),
        lambda told: _execution(told, shares=told["executions"][0]["shares"][:2]),
        lambda told: _execution(told, segments=told["executions"][0]["segments"][::-1]),
        lambda told: _execution(told, segments=[["dance", 0.0, 1.0, "down", None, []]]),
    ],
)
def test_what_is_no_motion_is_refused(
    played: Played, tmp_path: Path, spoil: Callable[[dict[str, Any]], dict[str, Any]],
    refused: Callable[[Callable[[], object]], str],
) -> None:  # fmt: skip
    path = tmp_path / "motion.json.gz"
    path.write_bytes(gzip.compress(json.dumps(spoil(dict(played.values))).encode()))
    assert "is no motion of a trial" in refused(lambda: read_motion(path))
    path.write_bytes(b"not gzip")
    assert "is no motion of a trial" in refused(lambda: read_motion(path))


def test_damaged_and_endless_files_are_refused(
    played: Played, tmp_path: Path, refused: Callable[[Callable[[], object]], str]
) -> None:
    path = tmp_path / "motion.json.gz"
    write_motion(path, played.values)
    sound = path.read_bytes()
    for at in range(10, len(sound), len(sound) // 50):
        path.write_bytes(sound[:at] + bytes([sound[at] ^ 0x55]) + sound[at + 1 :])
        assert "is no motion of a trial" in refused(lambda: read_motion(path))
        path.write_bytes(sound[:at])
        assert "is no motion of a trial" in refused(lambda: read_motion(path))
    path.write_bytes(gzip.compress(b"[" * 100_000))
    assert "is no motion of a trial" in refused(lambda: read_motion(path))
    path.write_bytes(gzip.compress(b" " * (MAX_TEXT + 1)))  # some kB
    assert f"its text has more than {MAX_TEXT} bytes" in refused(lambda: read_motion(path))


def test_a_motion_belongs_to_its_record(played: Played, tmp_path: Path) -> None:
    path = tmp_path / "motion.json.gz"
    write_motion(path, played.values)
    motion = read_motion(path)
    (execution,) = motion.executions
    attempt = {"plan": {"query": execution.query}, "execution": {}, "recovery": [{"execution": None}]}
    refuse_other_record(
        motion, {"attempts": [{"plan": None, "execution": None, "recovery": []}, attempt]}, "m"
    )
    others: tuple[list[dict[str, Any]], ...] = (
        [], [attempt, attempt], [{**attempt, "plan": {"query": "pick something else"}}],
        [{**attempt, "recovery": [{"execution": {}}]}], [{**attempt, "parking": {}}],
    )  # fmt: skip
    for attempts in others:
        with pytest.raises(StaleError, match="m: is the motion of another trial"):
            refuse_other_record(motion, {"attempts": attempts}, "m")


def test_a_motion_tells_its_record_from_those_of_the_same_queries(played: Played, tmp_path: Path) -> None:
    query = parse_motion(played.values).executions[0].query
    attempt = {"plan": {"query": query}, "execution": {}, "recovery": []}
    record = {"score": 12, "statistics": {"wall_s": 1.0}, "attempts": [attempt]}
    path = tmp_path / "motion.json.gz"
    write_motion(path, played.values | {"record": record_digest(record)})
    motion = read_motion(path)
    refuse_other_record(motion, record | {"statistics": {"wall_s": 2.0}}, "m")
    for change in ({"score": 13}, {"seed": 4}):
        with pytest.raises(StaleError, match="m: is the motion of another trial, or the record was changed"):
            refuse_other_record(motion, record | change, "m")


def test_a_motion_belongs_to_its_scene(played: Played, tmp_path: Path) -> None:
    path, scene = tmp_path / "motion.json.gz", pick()[1]
    write_motion(path, played.values)
    motion = read_motion(path)
    refuse_other_motion(motion, scene, [scene.cell], "motion")
    first, (execution,) = motion.executions[0].segments[0], motion.executions
    holding = replace(execution, segments=(replace(first, held="nothing"),))
    fewer = replace(execution, shares=tuple(rows[:, 1:] for rows in execution.shares))
    bent = replace(execution, segments=(replace(first, tool_state=ToolState("bent")),))
    for other in (
        replace(motion, joint_names=motion.joint_names[::-1]),
        replace(motion, items={"nothing": motion.items[CRAYOLA]}),
        *(replace(motion, executions=(each,)) for each in (holding, fewer, bent)),
    ):
        with pytest.raises(StaleError, match="motion of another scene or cell"):
            refuse_other_motion(other, scene, [scene.cell], "motion")
