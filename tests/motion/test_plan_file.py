"""Plan files: exact round trips, and a clear refusal for everything else."""

from __future__ import annotations

import json
import re
from dataclasses import fields, replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.errors import DamagedError, InputError, StaleError
from pickcli.geometry import pose
from pickcli.motion.event import Anchor, AnchorKind, Event
from pickcli.motion.plan import Certificate, Grasp, LineTracking, Plan, RecoveryLevel
from pickcli.motion.plan_file import motion_hash, plan_to_dict, read_plan, write_plan
from pickcli.motion.plan_schema import VERSION, parse_plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from support.tool_states import STRAIGHT


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
            Segment(SegmentKind.CONTACT, 0.0, middle, STRAIGHT, None, ("crayola_24_ct",)),
            Segment(SegmentKind.LIFT, middle, trajectory.duration, STRAIGHT, "crayola_24_ct"),
        ),
        trajectory=trajectory,
        events=(
            Event("valve", "on", Anchor(AnchorKind.SEGMENT_END, 0), 0.05, middle, middle - 0.05),
            Event("valve", "off", Anchor(AnchorKind.ARC_LENGTH, 1, 1 / 3), 0.05),
        ),
        grasp=Grasp(
            "crayola_24_ct", "frontal", "-x", STRAIGHT,
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


@given(st.floats(0.0, 0.5))
def test_what_is_said_to_be_kept_is_kept(clearance: float) -> None:
    certificate = Certificate("", "", "", 1, 0.0, clearance, 0.0, 0.0, 0.0, ())
    assert certificate.clearance_mm <= 1e3 * clearance + 1e-9
    assert certificate.clearance_mm > 1e3 * clearance - 0.1 - 1e-9


@pytest.mark.parametrize(("clearance", "told"), [(0.003, 3.0), (0.0029607, 2.9), (0.0092, 9.2)])
def test_a_clearance_is_rounded_down_to_a_tenth(clearance: float, told: float) -> None:
    assert Certificate("", "", "", 1, 0.0, clearance, 0.0, 0.0, 0.0, ()).clearance_mm == told


def test_every_field_of_a_plan_is_in_its_file(plan: Plan) -> None:
    pushing = replace(plan.segments[0], pushing=("book",))
    assert plan.grasp is not None
    plan = replace(
        plan,
        arm="left",
        grasp=replace(plan.grasp, envelope="+z"),
        segments=(pushing, *plan.segments[1:]),
        tracking=LineTracking("belt", 0.33),
        upright=0.5,
    )
    data = plan_to_dict(plan)
    assert plan.grasp is not None and plan.certificate is not None
    event, written = plan.events[0], data["events"][0]
    pairs: list[tuple[Any, dict[str, Any]]] = [
        (plan, data),
        (plan.segments[0], data["segments"][0]),
        (event, written),
        (event.anchor, written["anchor"]),
        (plan.grasp, data["grasp"]),
        (plan.certificate, data["certificate"]),
    ]
    for value, keys in pairs:
        names = {field.name for field in fields(value)}
        assert names <= set(keys) and len(keys) - len(names) <= 2  # format and version, or the seal


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
        (lambda d: d.__setitem__("format", "apc plans"), "format"),
        (lambda d: d.__setitem__("version", True), "version"),
        (lambda d: d.__setitem__("version", 2.0), "version"),
        (lambda d: d.__setitem__("seed", 10**4000), "whole number of 4001 digits"),
        (lambda d: d.__setitem__("seed", -1e300), "seed"),
        (point(1, "velocities", [0.0, 1e300]), "less than or equal to 1000000"),
        (point(4, "time_from_start", 301.0), "less than or equal to 300"),
        (lambda d: d.pop("events"), "events: expected"),
        (lambda d: d.pop("certificate"), "got nothing; set it to null, then run apc verify"),
        (lambda d: d.__setitem__("grasp", {}), "grasp: lacks item, kind, face"),
        (lambda d: d["segments"].__setitem__(0, {}), "segments[0]: lacks kind, t_start, t_end, tool_state"),
        (lambda d: d.__setitem__("note", "hello"), "note"),
        (lambda d: d.__setitem__("speed_scale", 0.0), "speed_scale"),
        (lambda d: d.__setitem__("speed_scale", "1.0"), "speed_scale"),
        (point(1, "positions", [0.0]), "trajectory.points[1].positions"),
        (point(1, "positions", [0.0, 1e999]), "finite"),
        (point(2, "time_from_start", 0.0), "trajectory.points[2].time_from_start"),
        (point(1, "time_from_start", 0.0), "trajectory.points[1].time_from_start: expected over 0"),
        (point(0, "time_from_start", 1e-9), "trajectory.points[0].time_from_start"),
        (point(0, "velocities", [0.0, 1e-3]), "trajectory.points[0].velocities"),
        (point(4, "velocities", [0.1, 0.0]), "trajectory.points[4].velocities"),
        (lambda d: d["trajectory"].__setitem__("joint_names", ["s", "s"]), "trajectory.joint_names"),
        (lambda d: d["trajectory"].__setitem__("points", d["trajectory"]["points"][:1]), "trajectory.points"),
        (lambda d: d["segments"][0].__setitem__("kind", "wander"), "segments[0].kind"),
        (lambda d: d["segments"][1].__setitem__("tool_state", ""), "segments[1].tool_state"),
        (lambda d: d["segments"][1].__setitem__("t_start", 0.0), "segments[1].t_start"),
        (lambda d: d["segments"].pop(), "segments[0].t_end"),
        (lambda d: d["events"][0]["anchor"].__setitem__("segment", 2), "events[0].anchor.segment"),
        (lambda d: d["grasp"]["T_item_tip"][0].__setitem__(0, 3.0), "grasp.T_item_tip"),
    ],
)
def test_a_broken_field_is_named_in_one_line(plan: Plan, tmp_path: Path, change: Any, field: str) -> None:
    path = tmp_path / "plan.json"
    write_plan(replace(plan, certificate=None), path)
    edit(path, change)
    with pytest.raises(InputError, match=re.escape(field)) as caught:
        read_plan(path)
    assert str(path) in str(caught.value)
    assert str(caught.value).count("\n") <= 2


@pytest.mark.parametrize("version", [VERSION - 1, VERSION + 1])
def test_a_plan_of_another_version_is_stale(plan: Plan, tmp_path: Path, version: int) -> None:
    path = tmp_path / "plan.json"
    write_plan(plan, path)
    edit(path, lambda d: d.__setitem__("version", version))
    with pytest.raises(StaleError, match=f"version: expected {VERSION}, got {version}, of another apc"):
        read_plan(path)


def test_several_problems_are_reported_at_once(plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    write_plan(replace(plan, certificate=None), path)
    edit(path, lambda d: (d.__setitem__("seed", -1), d["segments"][0].__setitem__("kind", "wander")))
    with pytest.raises(InputError, match=r"(?s)seed.*segments\[0\]\.kind"):
        read_plan(path)


def test_every_cut_of_the_file_is_told_with_its_place(plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    write_plan(plan, path)
    whole = path.read_bytes().rstrip()
    for n in range(0, len(whole), 97):
        path.write_bytes(whole[:n])
        with pytest.raises(InputError, match=r"plan\.json:\d+:\d+: not JSON: "):
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
    with pytest.raises(InputError, match=r"9{60}\.\.\. is a whole number of 5000 digits, at most 20"):
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
    with pytest.raises(InputError, match=r"trajectory\.points\[2\]\.time_from_start: expected over"):
        read_plan(path)


def test_a_segment_without_length_is_refused(plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    write_plan(replace(plan, certificate=None), path)
    edit(path, lambda d: d["segments"].insert(0, d["segments"][0] | {"t_end": 0.0}))
    with pytest.raises(InputError, match=r"segments\[0\]\.t_end: expected over 0"):
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


def _at(value: Any, *place: Any) -> Any:
    """A change that puts a value at a place of the file."""

    def change(data: Any) -> None:
        for key in place[:-1]:
            data = data[key]
        data[place[-1]] = value

    return change


def _joints(n: int) -> Any:
    def change(data: Any) -> None:
        data["trajectory"]["joint_names"] = [f"j{i}" for i in range(n)]
        for row in data["trajectory"]["points"]:
            row |= {name: [0.0] * n for name in ("positions", "velocities", "accelerations")}

    return change


@pytest.mark.parametrize(
    ("largest", "too_large"),
    [
        (_joints(32), _joints(33)),
        (_at("x" * 1000, "query"), _at("x" * 1001, "query")),
        (_at("x" * 128, "scene_hash"), _at("x" * 129, "scene_hash")),
        (_at("x", "events", 0, "device"), _at("", "events", 0, "device")),
        (_at("x" * 200, "events", 0, "device"), _at("x" * 201, "events", 0, "device")),
        (_at(2**63 - 1, "seed"), _at(2**63, "seed")),
        (_at(0, "seed"), _at(-1, "seed")),
        (_at(1.0, "speed_scale"), _at(1.0 + 2**-52, "speed_scale")),
        (_at(1e6, "grasp", "score"), _at(1e6 + 1, "grasp", "score")),
        (_at(0.0, "grasp", "score"), _at(-1e-9, "grasp", "score")),
        (_at(300.0, "events", 0, "lead"), _at(300.0 + 1e-9, "events", 0, "lead")),
        (_at(0.0, "events", 0, "lead"), _at(-1e-9, "events", 0, "lead")),
        (_at(["x"] * 1000, "segments", 0, "touching"), _at(["x"] * 1001, "segments", 0, "touching")),
        (_at(1, "events", 0, "anchor", "segment"), _at(2, "events", 0, "anchor", "segment")),
        (_at(0, "events", 0, "anchor", "segment"), _at(-1, "events", 0, "anchor", "segment")),
        (_at(1e-9, "segments", 0, "t_start"), _at(1.1e-9, "segments", 0, "t_start")),
    ],
)  # fmt: skip
def test_every_figure_goes_as_far_as_stated_and_no_farther(
    plan: Plan, tmp_path: Path, largest: Any, too_large: Any
) -> None:
    path = tmp_path / "plan.json"
    write_plan(replace(plan, certificate=None), path)
    edit(path, largest)
    assert read_plan(path)
    edit(path, too_large)
    with pytest.raises(InputError):
        read_plan(path)


def test_a_plan_of_over_a_hundred_thousand_points_is_refused(plan: Plan) -> None:
    point = {name: [0.0, 0.0] for name in ("positions", "velocities", "accelerations")}
    data = plan_to_dict(replace(plan, certificate=None))
    data["trajectory"]["points"] = ["POINT"]
    points = ",".join([json.dumps(point | {"time_from_start": 0.0})] * 100_001)
    with pytest.raises(InputError, match=r"trajectory\.points: .* at most 100000 entries, got 100001"):
        parse_plan(json.dumps(data).replace('"POINT"', points), "p")


def test_an_integer_has_at_most_twenty_digits(plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    write_plan(replace(plan, certificate=None), path)
    edit(path, _at(10**19, "seed"))
    with pytest.raises(InputError, match="seed: expected a value less than"):
        read_plan(path)
    edit(path, _at(10**20, "seed"))
    with pytest.raises(InputError, match="of 21 digits"):
        read_plan(path)


def test_a_file_has_at_most_24_megabytes(plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    write_plan(replace(plan, certificate=None), path)
    text = path.read_text()
    path.write_text(text + " " * (24 * 2**20 - len(text)))
    assert read_plan(path)
    path.write_text(text + " " * (24 * 2**20 - len(text) + 1))
    with pytest.raises(InputError, match="25165824 bytes"):
        read_plan(path)


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("[" * 200_000, "nested too deeply"),
        ('{"seed": -Infinity}', "1:10: -Infinity is not JSON; write a finite number"),
        ('{"a": 1, "b": 2, "a": 3}', ": a: the key stands twice"),
        ('{"version": 3}', 'format: expected "apc plan"'),
        ('{"format": "apc plan", "version": 3}', "lacks query, cell_fingerprint"),
    ],
)
def test_what_is_no_plan_is_told_as_such(text: str, problem: str) -> None:
    with pytest.raises(InputError) as caught:
        parse_plan(text, "p.json")
    assert problem in str(caught.value) and str(caught.value).startswith("p.json:")


def test_wrong_values_are_told_up_to_a_length(plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    write_plan(replace(plan, certificate=None), path)
    edit(path, _at("fast", "speed_scale"))
    with pytest.raises(InputError, match=r'speed_scale: .*, got "fast"; correct it'):
        read_plan(path)
    edit(path, _at("x" * 10_000, "speed_scale"))
    with pytest.raises(InputError) as caught:
        read_plan(path)
    assert len(str(caught.value)) < 200


def test_a_plan_is_one_line_per_point_segment_and_event(plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    write_plan(plan, path)
    lines = path.read_text().splitlines()
    rows = [json.loads(line.strip().rstrip(",")) for line in lines if line.strip().startswith("{")
            and line.strip().rstrip(",").endswith("}")]  # fmt: skip
    assert sum("time_from_start" in row for row in rows) == len(plan.trajectory.times)
    assert sum("tool_state" in row for row in rows) == len(plan.segments)
    assert sum("device" in row for row in rows) == len(plan.events)
    keys = [line.split(":")[0].strip() for line in lines if line.startswith("  ") and line[2] == '"']
    assert keys == [f'"{key}"' for key in plan_to_dict(plan)]


def test_a_plan_that_is_there_is_kept_unless_it_may_be_replaced(plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    write_plan(plan, path)
    before = path.read_bytes()
    with pytest.raises(InputError):
        write_plan(replace(plan, seed=8), path, replace=False)
    assert path.read_bytes() == before
    write_plan(replace(plan, seed=8, certificate=None), path)
    assert read_plan(path).seed == 8


def test_a_plan_of_nothing_optional_comes_back(plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    bare = replace(plan, grasp=None, events=(), certificate=None, statistics={}, recovery=RecoveryLevel.JOG)
    write_plan(bare, path)
    again = read_plan(path)
    assert (again.grasp, again.events, again.certificate, again.statistics) == (None, (), None, {})
    assert again.recovery is RecoveryLevel.JOG
    assert plan_to_dict(again) == plan_to_dict(bare)


def test_figures_of_numpy_are_written_as_what_they_are(plan: Plan, tmp_path: Path) -> None:
    path = tmp_path / "plan.json"
    first = replace(plan.events[0], anchor=replace(plan.events[0].anchor, segment=np.int64(1)))  # type: ignore[arg-type]
    figures = replace(plan, certificate=None, events=(replace(first, lead=np.float32(0.25)),))  # type: ignore[arg-type]
    write_plan(figures, path)
    (event,) = read_plan(path).events
    assert (event.anchor.segment, event.lead) == (1, 0.25)


def test_a_level_of_recovery_is_part_of_what_was_certified(plan: Plan, tmp_path: Path) -> None:
    assert motion_hash(replace(plan, recovery=RecoveryLevel.OPENING)) != motion_hash(plan)
    path = tmp_path / "plan.json"
    write_plan(plan, path)
    edit(path, _at("opening", "recovery"))
    with pytest.raises(DamagedError, match="edited after it was certified"):
        read_plan(path)


def test_what_is_pushed_is_written_only_where_something_is(plan: Plan, tmp_path: Path) -> None:
    """So a plan that pushes nothing has the bytes and the hash that it had before there was such a field."""
    first, *rest = plan.segments
    pushing = replace(plan, segments=(replace(first, pushing=("book", "box")), *rest), certificate=None)
    write_plan(pushing, tmp_path / "plan.json")
    written = json.loads((tmp_path / "plan.json").read_text())["segments"]
    assert written[0]["pushing"] == ["book", "box"]
    assert all("pushing" not in segment for segment in written[1:])
    assert read_plan(tmp_path / "plan.json").segments == pushing.segments
    assert motion_hash(pushing) != motion_hash(plan)
