"""Page of a trial of a commission, as seen from the truck: while it drives, everything else moves past it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.commission.commission import LOAD, PALLET
from pickcli.commission.commission_station import CommissionStation
from pickcli.driving.steering_path import posed as placed_in
from pickcli.driving.truck_camera import floor_pose
from pickcli.files.packed_array import packed
from pickcli.geometry import Array, from_quaternion, inverse, pose, to_quaternion
from pickcli.page.motion_parts import TIME_RESOLUTION, segment_lane
from pickcli.page.page_document import PageDocument, PageTable
from pickcli.page.page_motion import Chapter, Lane, PageMotion, Span, Track
from pickcli.page.page_scene import Fact, PageItem, Tone
from pickcli.page.page_scene import posed as page_pose
from pickcli.page.recorded_parts import JOINT, POSE, joint_signals
from pickcli.page.scene_page import standing_page
from pickcli.page.shape_parts import drawn_shape
from pickcli.page.trial_clearance import trial_clearance
from pickcli.scene.scene import Scene
from pickcli.trial.motion_record import RecordedMotion

WALL_HEIGHT, WALL = 0.3, 0.05  # m of walls as they are drawn: one looks over them
BODY = 0.2  # m, radius of people as they are drawn
SAMPLE = 0.2  # s between poses of what is passed
_WALL, _LOAD, _WOOD, _BOX = "#9aa4ad", "#7d8b99", "#b58b5a", "#c0a060"
_VEST, _NO_VEST = "#ff8c1a", "#5b6b7a"
_TONES = {"placed": Tone.GOOD, "left": Tone.FAIR, "lost": Tone.BAD}


def commission_page(
    record: Mapping[str, Any], station: CommissionStation, scene: Scene | None, motion: RecordedMotion | None
) -> PageDocument:
    """Create the page of a trial of a commission.

    Args:
        record: Content of its ``trial.json``.
        station: The commission in its cell.
        scene: The true scene as the truck came to the load; None if it did not.
        motion: The recorded motion; None likewise.

    Returns:
        The page; its world is the frame of the truck.
    """
    shown = scene or station.scene(station.at_load, station.pallet_in_truck)
    drives, duration = _Drives.of(record, station), max(float(record["duration_s"]), 1e-3)
    late = None if motion is None else _later(motion, float(record["arm_from_s"]))
    made = record["made_from"]
    page = standing_page(
        shown, "commission trial", "Commission" if record["success"] else "Commission, not done",
        f"{made['commission']}, seed {made['seed']}, cell {made['cell']}, {duration:.0f} s",
    )  # fmt: skip
    people = _people(record)
    tracks = (
        *_passed(drives, station), *_walked(drives, people), *_items(drives, shown, late, record),
    )  # fmt: skip
    segments = [] if late is None else [each for run in late.executions for each in run.segments]
    return replace(
        page,
        facts=tuple(_facts(record)),
        groups=tuple(group for group in page.groups if group.name not in (LOAD, PALLET)),
        items=(*page.items, *(item for item, _ in _solids(station)), *(each.item for each in people)),
        places=(),
        motion=_motion(page, late, tracks, duration),
        lanes=(_steps(record), segment_lane(segments)),
        signals=() if late is None else tuple(joint_signals(late, station.cell)),
        clearance=None if late is None or scene is None else trial_clearance(scene, (station.cell,), late),
        chapters=tuple(_chapters(record)),
        tables=(_step_table(record), _item_table(record)),
    )


@dataclass(frozen=True, eq=False)
class _Drives:
    """Where truck and pallet truly are over time, seen from above.

    times: (N,) s. truck: (N, 3) m, m, rad. pallet: (N, 3) likewise, in the area. leaves: s at which the truck
    leaves the load. set_down: s from which the pallet stands where it was set down; infinite if never
    """

    times: Array
    truck: Array
    pallet: Array
    leaves: float
    set_down: float

    @classmethod
    def of(cls, record: Mapping[str, Any], station: CommissionStation) -> _Drives:
        """Read them from a record."""
        times, poses = (
            [0.0],
            [np.array(record["drives"][0]["poses"][0] if record["drives"] else station.at_load)],
        )
        for drive in record["drives"]:
            at = np.minimum(
                np.arange(len(drive["poses"])) * drive["step_s"] + drive["t_start"], drive["t_end"]
            )
            times += at.tolist()
            poses += [np.array(each) for each in drive["poses"]]
        end = max(float(record["duration_s"]), times[-1])
        grid = np.unique(np.append(np.arange(0.0, end, SAMPLE), [*times, end]))
        columns = np.array(poses)
        columns[:, 2] = np.unwrap(columns[:, 2])
        truck = np.column_stack([np.interp(grid, times, column) for column in columns.T])
        lifted = _end_of(record, "lift_pallet")
        set_down = _end_of(record, "set_down_pallet")
        leaves = min(
            (d["t_start"] for d in record["drives"] if d["name"] == "drive delivery"), default=np.inf
        )
        return cls(grid, truck, _pallet(record, station, grid, truck, (lifted, set_down)), leaves, set_down)

    def seen(self, poses: Array) -> Array:
        """(N, 7) of what is upright at (N, 3) m, m, rad on the floor, in the frame of the truck."""
        relative = [
            inverse(floor_pose(truck)) @ floor_pose(at) for truck, at in zip(self.truck, poses, strict=True)
        ]
        return _rows(relative)

    def at(self, t: float) -> Array:
        """(3,) where the truck is at a time."""
        return np.array([np.interp(t, self.times, column) for column in self.truck.T])


def _end_of(record: Mapping[str, Any], action: str) -> float:
    return max(
        (s["t_end"] for s in record["steps"] if s["action"] == action and s["is_success"]), default=np.inf
    )


def _pallet(
    record: Mapping[str, Any],
    station: CommissionStation,
    times: Array,
    truck: Array,
    carried: tuple[float, float],
) -> Array:
    """(N, 3) m, m, rad: the pallet, which stands, is carried, and stands where it was set down."""
    on_forks = record["pallet_on_forks"]
    if on_forks is None:
        return np.tile(station.commission.pallet.pose, (len(times), 1))
    moved = placed_in(truck, np.array(on_forks))
    first, last = (int(np.searchsorted(times, min(t, times[-1]))) for t in carried)
    moved[:first], moved[last:] = moved[first], moved[last]
    return np.asarray(moved)


def _solids(station: CommissionStation) -> Iterator[tuple[PageItem, Array]]:
    """Yield what the truck passes, and where it stands in the area: (3,) m, m, rad."""
    area, load = station.commission.area, station.load_box
    (x, y), (far_x, far_y) = area.low, area.high
    middle = np.array([(x + far_x) / 2, (y + far_y) / 2, 0.0])
    long, wide = far_x - x, far_y - y
    walls = (
        ("wall -y", (long, WALL), (0.0, -wide / 2)), ("wall +y", (long, WALL), (0.0, wide / 2)),
        ("wall -x", (WALL, wide), (-long / 2, 0.0)), ("wall +x", (WALL, wide), (long / 2, 0.0)),
    )  # fmt: skip
    for name, size, at in walls:
        yield _solid(name, (*size, WALL_HEIGHT), _WALL), middle + np.array([*at, 0.0])
    yield _solid("load stand", (*load.size, load.height), _LOAD), np.array([*load.centre, load.yaw])
    for box in area.boxes:
        yield _solid(f"box {box.name}", (*box.size, box.height), _BOX), np.array([*box.centre, box.yaw])
    shape = station.commission.pallet.shape
    deck = (shape.length, shape.width, shape.height)
    yield _solid("pallet deck", deck, _WOOD), station.commission.pallet.pose


def _solid(name: str, size: tuple[float, float, float], colour: str) -> PageItem:
    shape = drawn_shape(Shape(ShapeKind.BOX, size))
    return PageItem(name, name, colour, shape, page_pose(pose((0.0, 0.0, size[2] / 2))))


def _passed(drives: _Drives, station: CommissionStation) -> Iterator[Track]:
    """Yield the tracks of what the truck passes, and of the pallet, which is higher while it is carried."""
    raised = (
        float(station.cell.carriers[PALLET].T_world_carrier[2, 3]) - station.commission.pallet.shape.height
    )
    for item, at in _solids(station):
        is_pallet = item.id == "pallet deck"
        rows = drives.seen(drives.pallet if is_pallet else np.tile(at, (len(drives.times), 1)))
        rows[:, 2] = item.pose[2]
        if is_pallet:
            is_carried = np.any(
                np.abs(np.diff(drives.pallet, axis=0, prepend=drives.pallet[:1])) > 0.0, axis=1
            )
            begins = int(np.argmax(is_carried)) if is_carried.any() else len(rows)
            rows[(np.arange(len(rows)) >= begins) & (drives.times < drives.set_down), 2] += raised
        yield _track(item.id, drives.times, rows)


@dataclass(frozen=True, eq=False)
class _Person:
    """A person as it is drawn, with (N,) s and (N, 2) m in the area: where it was while the truck drove."""

    item: PageItem
    times: Array
    places: Array


def _people(record: Mapping[str, Any]) -> list[_Person]:
    """Whom the drives tell of, in any of them."""
    found: dict[str, _Person] = {}
    for drive in record["drives"]:
        for each in drive.get("people", ()):
            places = np.array(each["places"]).reshape(-1, 2)
            times = drive["t_start"] + each["step_s"] * np.arange(len(places))
            if (before := found.get(each["name"])) is None:
                found[each["name"]] = _Person(_drawn(each), times, places)
            else:
                found[each["name"]] = _Person(
                    before.item, np.append(before.times, times), np.vstack([before.places, places])
                )
    return [each for each in found.values() if len(each.times)]


def _drawn(person: Mapping[str, Any]) -> PageItem:
    """A person as a cylinder, in the colour of a vest or without."""
    shape = drawn_shape(Shape(ShapeKind.CYLINDER, (BODY, float(person["height"]))))
    colour = _VEST if person["has_vest"] else _NO_VEST
    standing = page_pose(pose((0.0, 0.0, person["height"] / 2)))
    return PageItem(person["name"], person["name"], colour, shape, standing)


def _walked(drives: _Drives, people: list[_Person]) -> Iterator[Track]:
    """Yield the tracks of people; between two drives they stand where they were seen last."""
    for each in people:
        x, y = (np.interp(drives.times, each.times, column) for column in each.places.T)
        rows = drives.seen(np.column_stack([x, y, np.zeros(len(x))]))
        rows[:, 2] = each.item.pose[2]
        yield _track(each.item.id, drives.times, rows)


def _items(
    drives: _Drives, scene: Scene, late: RecordedMotion | None, record: Mapping[str, Any]
) -> Iterator[Track]:
    """Yield the tracks of items: with the load, as recorded, and then where they were left."""
    outcomes = {each["id"]: each["outcome"] for each in record["items"]}
    came = float(record["arm_from_s"]) if late is not None else 0.0
    for placed in scene.items:
        recorded = None if late is None else late.items.get(placed.id)
        T_last = placed.T_world_item
        if recorded is not None:
            T_last = pose(recorded[1][-1, :3], R=from_quaternion(recorded[1][-1, 3:]))
        freed = drives.set_down if outcomes[placed.id] == "placed" else drives.leaves
        before = drives.times <= came
        after = drives.times >= freed
        times = [drives.times[before]]
        rows = [_standing(drives, before, came, placed.T_world_item)]
        if recorded is not None:
            within = (recorded[0] > came) & (recorded[0] < freed)
            times.append(recorded[0][within])
            rows.append(recorded[1][within])
        if after.any():
            times.append(drives.times[after])
            rows.append(_standing(drives, after, freed, T_last))
        yield _track(placed.id, np.concatenate(times), np.vstack(rows))


def _standing(drives: _Drives, when: NDArray[np.bool_], since: float, T_truck_item: Array) -> Array:
    """(K, 7) of what stands in the area, seen from the truck, where it was in its frame at a time."""
    T_area_item = floor_pose(drives.at(since)) @ T_truck_item
    return _rows([inverse(floor_pose(truck)) @ T_area_item for truck in drives.truck[when]])


def _rows(poses: list[Array]) -> Array:
    """(K, 7) of (4, 4) poses, with quaternions of continuous signs."""
    rows = np.array([[*T[:3, 3], *to_quaternion(T[:3, :3])] for T in poses]).reshape(-1, 7)
    for before, row in pairwise(rows):
        if before[3:] @ row[3:] < 0.0:
            row[3:] *= -1.0
    return rows


def _track(name: str, times: Array, rows: Array) -> Track:
    return Track(name, packed(times, TIME_RESOLUTION), packed(rows, POSE))


def _later(motion: RecordedMotion, by: float) -> RecordedMotion:
    """The motion on the clock of the trial."""
    runs = tuple(
        replace(
            run, t_start=run.t_start + by, t_end=run.t_end + by, times=run.times + by,
            segments=tuple(replace(s, t_start=s.t_start + by, t_end=s.t_end + by) for s in run.segments),
        )
        for run in motion.executions
    )  # fmt: skip
    items = {name: (times + by, rows) for name, (times, rows) in motion.items.items()}
    return replace(motion, times=motion.times + by, executions=runs, items=items)


def _motion(
    page: PageDocument, late: RecordedMotion | None, tracks: tuple[Track, ...], duration: float
) -> PageMotion:
    """The arm rests until the truck came to the load, and then moves as recorded."""
    assert page.robot is not None
    rest = np.array([page.robot.start])
    times, joints = np.array([0.0, duration]), np.vstack([rest, rest])
    if late is not None:
        times = np.concatenate([[0.0], late.times])
        joints = np.vstack([late.joints[:1], late.joints])
    return PageMotion(
        duration, packed(times, TIME_RESOLUTION), packed(joints, JOINT), tracks=tracks, is_path_drawn=False
    )


def _facts(record: Mapping[str, Any]) -> Iterator[Fact]:
    yield Fact("on the pallet", f"{record['items_placed']} of {record['items_ordered']} items")
    off = record["pallet_off"]
    told = "no" if off is None else f"{1e3 * off['distance']:.0f} mm and {np.degrees(off['turn']):.1f}° off"
    yield Fact("delivered", told, Tone.PLAIN if record["delivered"] else Tone.BAD)
    yield Fact("at the load", f"{record['handling_s']:.0f} s of {record['duration_s']:.0f} s")
    for key in ("collisions", "limit_violations", "stops"):
        yield Fact(key.replace("_", " "), str(record[key]), Tone.BAD if record[key] else Tone.PLAIN)
    if (met := record.get("people")) is not None:
        yield Fact("people", f"{met['number']} came, {met['walked_in']} walked into the truck")
        yield Fact("people touched", str(met["touched"]), Tone.BAD if met["touched"] else Tone.PLAIN)
        yield Fact("braked for them", f"{met['braked_s']:.1f} s, {met['brake_requests']} requests")
    if record["aborted"]:
        yield Fact("ended early", record["aborted"], Tone.BAD)


def _timed(record: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    return (each for each in record["steps"] if each["t_end"] > each["t_start"])


def _why(step: Mapping[str, Any]) -> str:
    """Why a step failed, and for how long the truck waited for people."""
    waited = step["figures"].get("braked_s", 0.0)
    told = [step["reason"], f"braked {waited:.1f} s for people" if waited else ""]
    return "; ".join(filter(None, told))


def _steps(record: Mapping[str, Any]) -> Lane:
    spans = (
        Span(
            round(each["t_start"], 3), round(each["t_end"], 3), f"{each['action']} {each['target']}".strip(),
            "#3b82c4" if each["is_success"] else "#c0392b", _why(each),
        )
        for each in _timed(record)
    )  # fmt: skip
    return Lane("steps", tuple(spans))


def _chapters(record: Mapping[str, Any]) -> Iterator[Chapter]:
    for each in _timed(record):
        is_done = each["is_success"]
        yield Chapter(
            f"{each['action']} {each['target']}".strip(), "done" if is_done else "failed",
            Tone.GOOD if is_done else Tone.BAD, round(each["t_start"], 3), round(each["t_end"], 3),
            each["target"], "", _why(each),
        )  # fmt: skip


def _step_table(record: Mapping[str, Any]) -> PageTable:
    rows = tuple(
        (f"{each['t_start']:.1f}", each["action"], each["target"],
         "done" if each["is_success"] else "failed", _why(each))
        for each in record["steps"]
    )  # fmt: skip
    tones = tuple(Tone.PLAIN if each["is_success"] else Tone.BAD for each in record["steps"])
    return PageTable("Steps", ("s", "step", "item", "", "why"), rows, tones)


def _item_table(record: Mapping[str, Any]) -> PageTable:
    rows = tuple(
        (each["id"], each["outcome"], str(each["attempts"]),
         "" if each["at_end"] is None else f"{1e3 * each['at_end']['aside']:.1f} mm aside")
        for each in record["items"]
    )  # fmt: skip
    tones = tuple(_TONES.get(each["outcome"], Tone.BAD) for each in record["items"])
    return PageTable("Items", ("item", "outcome", "attempts", "at the end"), rows, tones)
