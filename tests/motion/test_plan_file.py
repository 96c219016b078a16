"""Plan files: exact round trips, and a clear refusal for everything else."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.robot import PivotState
from pickcli.errors import DamagedError, InputError
from pickcli.geometry import pose
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.plan import Certificate, Grasp, Plan
from pickcli.motion.plan_file import motion_hash, plan_to_dict, read_plan, write_plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory


def make_plan(rng: np.random.Generator, n_points: int = 5) -> Plan:
    """A plan that has every optional part, full of awkward floats."""
    moving = np.ones((n_points, 1))
    moving[[0, -1]] = 0.0
    times = np.concatenate([[0.0], np.cumsum(rng.uniform(1e-3, 1.0, n_points - 1))])
    trajectory = Trajectory(
        joint_names=("rail", "s"),
        times=times,
        positions=rng.normal(size=(n_points, 2)) / 3,
        velocities=rng.normal(size=(n_points, 2)) * moving,
        accelerations=rng.normal(size=(n_points, 2)) * 1e-7,
    )
    middle = float(times[2])
    return Plan(
        query="pick crayola_24_ct from bin_B",
        cell_fingerprint="c" * 64,
        scene_hash="5" * 64,
        seed=7,
        segments=(
            Segment(SegmentKind.CONTACT, 0.0, middle, PivotState.STRAIGHT, None, ("crayola_24_ct",)),
            Segment(SegmentKind.LIFT, middle, trajectory.duration, PivotState.STRAIGHT, "crayola_24_ct"),
        ),
        trajectory=trajectory,
        events=(
            Event("valve", "on", Anchor(AnchorKind.SEGMENT_END, 0), 0.05, middle, middle - 0.05),
            Event("valve", "off", Anchor(AnchorKind.ARC_LENGTH, 1, 1 / 3), 0.05),
        ),
        grasp=Grasp(
            "crayola_24_ct", "frontal", "-x", PivotState.STRAIGHT,
            pose(rng.normal(size=3), rpy=rng.normal(size=3)), 0.1, 0.2, 0.3, 1 / 7, 0.01, 0.4,
        ),
        speed_scale=0.5,
        statistics={"planning_ms": 12.5},
    )  # fmt: skip


def certified(plan: Plan) -> Plan:
    figures = (100, 2e-3, 4e-3, 0.9, 0.8, 0.7, ("limits",))
    return replace(
        plan, certificate=Certificate(motion_hash(plan), plan.scene_hash, plan.cell_fingerprint, *figures)
    )


@pytest.fixture
def plan() -> Plan:
    return certified(make_plan(np.random.default_rng(1)))


def edit(path: Path, change: Any) -> None:
    data = json.loads(path.read_text())
    change(data)
    path.write_text(json.dumps(data))


@given(seed=st.integers(0, 2**32 - 1))
def test_a_round_trip_is_exact(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    plan = certified(make_plan(np.random.default_rng(seed)))
    path = tmp_path_factory.mktemp("plans") / "plan.json"
    write_plan(plan, path)
    again = read_plan(path)
    for name in ("times", "positions", "velocities", "accelerations"):
        a, b = getattr(plan.trajectory, name), getattr(again.trajectory, name)
        assert a.tobytes() == b.tobytes()
    assert plan_to_dict(again) == plan_to_dict(plan)
    assert motion_hash(again) == motion_hash(plan)
    assert (again.segments, again.events, again.certificate) == (plan.segments, plan.events, plan.certificate)


def test_the_same_plan_gives_the_same_bytes(plan: Plan, tmp_path: Path) -> None:
    write_plan(plan, tmp_path / "a.json")
    write_plan(read_plan(tmp_path / "a.json"), tmp_path / "b.json")
    assert (tmp_path / "a.json").read_bytes() == (tmp_path / "b.json").read_bytes()


def test_the_hash_covers_what_moves_and_nothing_else(plan: Plan) -> None:
    same = replace(plan, statistics={}, certificate=None, seed=8)
    assert motion_hash(same) == motion_hash(plan)
    nudged = plan.trajectory.positions.copy()
    nudged[2, 1] = np.nextafter(nudged[2, 1], 9.0)
    assert plan.grasp is not None
    others = (
        replace(plan, trajectory=replace(plan.trajectory, positions=nudged)),
        replace(plan, segments=(plan.segments[0], replace(plan.segments[1], held=None))),
        replace(plan, events=plan.events[:1]),
        replace(plan, grasp=replace(plan.grasp, face="+z")),
    )
    assert len({motion_hash(plan), *map(motion_hash, others)}) == 5


@pytest.mark.parametrize(
    "change",
    [
        lambda d: d["trajectory"]["points"][2]["positions"].__setitem__(0, 0.25),
        lambda d: d["segments"][1].__setitem__("held", None),
        lambda d: d["events"][0].__setitem__("lead", 0.1),
        lambda d: d.__setitem__("scene_hash", "6" * 64),
        lambda d: d.__setitem__("cell_fingerprint", "d" * 64),
        lambda d: d["certificate"].__setitem__("motion_hash", "0" * 64),
        lambda d: d["certificate"].__setitem__("min_clearance", 0.5),
        lambda d: d["certificate"].__setitem__("max_jerk_ratio", 0.1),
        lambda d: d["certificate"].__setitem__("n_states", 10**6),
        lambda d: d["certificate"]["checks"].append("proven safe"),
        lambda d: d["certificate"].__setitem__("seal", "0" * 64),
        lambda d: d.__setitem__("query", "pick something_else from bin_B"),
        lambda d: d.__setitem__("seed", 8),
        lambda d: d.__setitem__("speed_scale", 0.25),
        lambda d: [o.__setitem__("scene_hash", "6" * 64) for o in (d, d["certificate"])],
    ],
)
def test_an_edit_after_the_certificate_is_damage(plan: Plan, tmp_path: Path, change: Any) -> None:
    path = tmp_path / "plan.json"
    write_plan(plan, path)
    edit(path, change)
    with pytest.raises(DamagedError, match="edited after it was certified"):
        read_plan(path)


def point(i: int, key: str, value: Any) -> Any:
    return lambda d: d["trajectory"]["points"][i].__setitem__(key, value)


@pytest.mark.parametrize(
    ("change", "field"),
    [
        (lambda d: d.__setitem__("format", "apc scene"), "format"),
        (lambda d: d.__setitem__("version", 1), "version"),
        (lambda d: d.__setitem__("version", True), "version"),
        (lambda d: d.__setitem__("version", 2.0), "version"),
        (lambda d: d.__setitem__("seed", 10**4000), "4001 digits"),
        (lambda d: d.__setitem__("seed", -1e300), "seed"),
        (point(1, "velocities", [0.0, 1e300]), "less than or equal to 1000000"),
        (point(4, "time_from_start", 301.0), "less than or equal to 300"),
        (lambda d: d.pop("events"), "events"),
        (lambda d: d.__setitem__("note", "hello"), "note"),
        (lambda d: d.__setitem__("speed_scale", 0.0), "speed_scale"),
        (lambda d: d.__setitem__("speed_scale", "1.0"), "speed_scale"),
        (point(1, "positions", [0.0]), "trajectory.points.1.positions"),
        (point(1, "positions", [0.0, 1e999]), "finite"),
        (point(2, "time_from_start", 0.0), "trajectory.points.2.time_from_start"),
        (point(0, "time_from_start", 1e-9), "trajectory.points.0.time_from_start"),
        (point(0, "velocities", [0.0, 1e-3]), "trajectory.points.0.velocities"),
        (point(4, "velocities", [0.1, 0.0]), "trajectory.points.4.velocities"),
        (lambda d: d["trajectory"].__setitem__("joint_names", ["s", "s"]), "trajectory.joint_names"),
        (lambda d: d["trajectory"].__setitem__("points", d["trajectory"]["points"][:1]), "trajectory.points"),
        (lambda d: d["segments"][0].__setitem__("kind", "wander"), "segments.0.kind"),
        (lambda d: d["segments"][1].__setitem__("pivot", "sideways"), "segments.1.pivot"),
        (lambda d: d["segments"][1].__setitem__("t_start", 0.0), "segments.1.t_start"),
        (lambda d: d["segments"].pop(), "segments.0.t_end"),
        (lambda d: d["events"][0]["anchor"].__setitem__("segment", 2), "events.0.anchor.segment"),
        (lambda d: d["grasp"]["T_item_tip"][0].__setitem__(0, 3.0), "grasp.T_item_tip"),
    ],
)
def test_a_broken_field_is_named(plan: Plan, tmp_path: Path, change: Any, field: str) -> None:
    path = tmp_path / "plan.json"
    write_plan(replace(plan, certificate=None), path)
    edit(path, change)
    with pytest.raises(InputError, match=field) as caught:
        read_plan(path)
    assert str(path) in str(caught.value)


def test_several_problems_are_reported_at_once(plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    write_plan(replace(plan, certificate=None), path)
    edit(path, lambda d: (d.__setitem__("seed", -1), d["segments"][0].__setitem__("kind", "wander")))
    with pytest.raises(InputError, match=r"(?s)seed.*segments\.0\.kind"):
        read_plan(path)


def test_every_cut_of_the_file_is_damage(plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    write_plan(plan, path)
    whole = path.read_bytes().rstrip()
    for n in range(0, len(whole), 97):
        path.write_bytes(whole[:n])
        with pytest.raises(DamagedError, match="cut off or damaged"):
            read_plan(path)


@pytest.mark.parametrize("text", ['{"seed": NaN}', '{"seed": 1, "seed": 2}', "[" * 200_000, "[]", "3"])
def test_json_traps_are_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "plan.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"plan\.json"):
        read_plan(path)


def test_what_is_no_text_or_no_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    with pytest.raises(InputError, match="no such file"):
        read_plan(path)
    path.write_bytes(b"\x89HDF\xff\xfe")
    with pytest.raises(InputError, match="not UTF-8"):
        read_plan(path)


def test_a_plan_that_is_not_finite_is_not_written(plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    write_plan(plan, path)
    before = path.read_bytes()
    with pytest.raises(InputError, match="not finite"):
        write_plan(replace(plan, statistics={"planning_ms": float("nan")}), path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["plan.json"]


def test_an_integer_of_any_length_is_refused(plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    write_plan(replace(plan, certificate=None), path)
    path.write_text(path.read_text().replace('"seed": 7', '"seed": ' + "9" * 5000))
    with pytest.raises(InputError, match=r"999999999999\.\.\. has 5000 digits"):
        read_plan(path)


def test_a_million_keys_of_which_one_stands_twice_are_refused_soon(tmp_path: Path) -> None:
    """Counting each key among all of them would take minutes."""
    path = tmp_path / "plan.json"
    keys = ", ".join(f'"{i}": 0' for i in range(100_000))
    path.write_text("{" + keys + ', "99999": 0}')
    began = process_time()
    with pytest.raises(InputError, match="99999: the key stands twice"):
        read_plan(path)
    assert process_time() - began < 5.0


def test_times_that_are_equal_are_refused(plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    write_plan(replace(plan, certificate=None), path)
    time = json.loads(path.read_text())["trajectory"]["points"][1]["time_from_start"]
    edit(path, point(2, "time_from_start", time))
    with pytest.raises(InputError, match=r"trajectory\.points\.2\.time_from_start: expected over"):
        read_plan(path)


def test_a_segment_without_length_is_refused(plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    write_plan(replace(plan, certificate=None), path)
    edit(path, lambda d: d["segments"].insert(0, d["segments"][0] | {"t_end": 0.0}))
    with pytest.raises(InputError, match=r"segments\.0\.t_end: expected over 0"):
        read_plan(path)


@pytest.mark.parametrize("n", [20, 21, 45])
def test_twenty_problems_are_told_and_the_others_counted(plan: Plan, tmp_path: Path, n: int) -> None:
    path = tmp_path / "plan.json"
    write_plan(replace(plan, certificate=None), path)
    edit(path, lambda d: d.update({f"more{i}": 0 for i in range(n)}))
    with pytest.raises(InputError) as caught:
        read_plan(path)
    lines = str(caught.value).splitlines()
    assert len(lines) == 1 + min(n, 20) + (n > 20)
    assert n == 20 or lines[-1] == f"  and {n - 20} more"
