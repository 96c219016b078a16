"""Page of a trial: all motion by attempts, with failures and the score."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.workcell import Workcell
from pickcli.errors import Reason
from pickcli.page.cell_parts import robot_part
from pickcli.page.failure_marks import failure_marks, named_parts
from pickcli.page.look_pictures import look_pictures
from pickcli.page.motion_parts import segment_lane, switched_lanes
from pickcli.page.page_document import PageDocument, PageTable
from pickcli.page.page_motion import Chapter, Mark
from pickcli.page.page_scene import Fact, PageRobot, Tone, rounded
from pickcli.page.recorded_parts import joint_signals, replayed, vacuum_signals
from pickcli.page.scene_page import standing_page
from pickcli.page.trial_clearance import trial_clearance
from pickcli.scene.scene import Scene
from pickcli.trial.motion_record import RecordedExecution, RecordedMotion
from pickcli.trial.trial_summary import why_it_ended

_TONES = {
    "in tote": Tone.GOOD, "delivered": Tone.GOOD, "moved aside": Tone.GOOD, "toppled": Tone.GOOD,
    "not picked": Tone.FAIR, "not toppled": Tone.FAIR, "no time": Tone.FAIR,
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Played:
    """A recorded attempt with its executions."""

    record: Mapping[str, Any]
    executions: tuple[tuple[Mapping[str, Any], RecordedExecution], ...]
    t_start: float
    t_end: float


def trial_page(
    record: Mapping[str, Any], scene: Scene, motion: RecordedMotion, workcell: Workcell | None = None,
    pictures: Mapping[tuple[int, str], NDArray[np.uint8]] | None = None,
) -> PageDocument:  # fmt: skip
    """Create the page of a trial.

    Args:
        record: Content of its ``trial.json``.
        scene: The true scene at its start.
        motion: The recorded motion.
        workcell: The cell with all its arms, if several played.
        pictures: (height, width, 3) RGB of looks, by their number and the place.

    Returns:
        The page.
    """
    cells = (scene.cell,) if workcell is None else tuple(workcell.arms.values())
    attempts = _played(record["attempts"], motion)
    duration = float(motion.times[-1])
    segments = [segment for execution in motion.executions for segment in execution.segments]
    made = record["made_from"]
    subtitle = f"{made['order']}, seed {made['seed']}, cell {made['cell']}, {duration:.0f} s simulated"
    base = standing_page(scene, "trial", f"{record['score']} of {record['max_score']} points", subtitle)
    devices = {name: device for cell in cells for name, device in cell.devices.items()}
    return replace(
        base,
        robot=base.robot if workcell is None else _robot(workcell, motion),
        facts=tuple(_facts(record)),
        motion=replayed(motion),
        lanes=(segment_lane(segments), *switched_lanes(_switched(attempts), devices, duration)),
        signals=(
            *vacuum_signals(motion),
            *(signal for cell in cells for signal in joint_signals(motion, cell, is_only=len(cells) == 1)),
        ),
        clearance=trial_clearance(scene, cells, motion),
        chapters=tuple(_chapter(attempt, scene) for attempt in attempts),
        tables=(_score(record), *_looks(record.get("looks", ()))),
        pictures=look_pictures(pictures or {}),
    )


def _robot(workcell: Workcell, motion: RecordedMotion) -> PageRobot:
    """Convert the robot with all its arms, which start as recorded."""
    drawn = robot_part(replace(workcell.preferred, robot=workcell.robot))
    return replace(drawn, moved=motion.joint_names, start=rounded(motion.joints[0]))


def _played(attempts: Sequence[Mapping[str, Any]], motion: RecordedMotion) -> list[_Played]:
    """Assign executions, which were recorded in the same order, to attempts."""
    left, played, now = list(motion.of_attempts), [], 0.0
    for record in attempts:
        own = []
        for each in _executed(record):
            if left:
                own.append((each, left.pop(0)))
        began = own[0][1].t_start if own else now
        now = own[-1][1].t_end if own else now
        played.append(_Played(record, tuple(own), began, now))
    return played


def _executed(attempt: Mapping[str, Any]) -> Iterator[Mapping[str, Any]]:
    """Executions of an attempt in order of time."""
    steps = (attempt.get("parking"), attempt["execution"], *(s["execution"] for s in attempt["recovery"]))
    return (step for step in steps if step is not None)


def _facts(record: Mapping[str, Any]) -> Iterator[Fact]:
    share = record["score"] / record["max_score"] if record["max_score"] else 0.0
    yield Fact("score", f"{record['score']} of {record['max_score']}, {share:.0%}")
    yield Fact("delivered", f"{record['items_in_tote']} of {len(record['items'])} targets")
    for key, label in (
        ("collisions", "collisions"), ("limit_violations", "limit violations"), ("drops", "items lost"),
        ("disturbed", "items disturbed"), ("misjudged", "misjudged"),
    ):  # fmt: skip
        yield Fact(label, str(record[key]), Tone.BAD if record[key] else Tone.PLAIN)
    yield Fact("time", f"{record['clock_s']:.0f} s on the clock, {record['simulated_s']:.0f} s simulated")
    shift = record["pod_shift"]
    yield Fact("pod", f"shifted by {shift['x_mm']:.0f}, {shift['y_mm']:.0f} mm, {shift['yaw_deg']:.1f}°")
    if tote := record.get("tote_shift"):
        yield Fact("tote", f"shifted by {tote['x_mm']:.0f}, {tote['y_mm']:.0f} mm, {tote['yaw_deg']:.1f}°")
    if touches := record.get("tote_touches"):
        yield Fact("touches of the tote", *_told_by_touches(touches))
    if record["aborted"]:
        yield Fact("aborted", record["aborted"], Tone.BAD)
    elif record["items_in_tote"] < len(record["items"]):
        ended = why_it_ended([(tick["node"], tick["status"] == "success") for tick in record["ticks"]])
        if record["cut_short"] or ended:
            yield Fact("ended as", record["cut_short"] or ended)


def _told_by_touches(touches: Mapping[str, Any]) -> tuple[str, Tone]:
    """What touches told of the tote, and the tone of it."""
    off, bound = touches.get("truly_off"), touches.get("bound")
    if off is None or bound is None:
        return f"not located: {touches['reason']}", Tone.FAIR
    is_kept = all(abs(off[name]) <= bound[name] for name in ("x_mm", "y_mm", "yaw_deg"))
    told = f"located in {touches['duration_s']:.0f} s, truly off by {off['x_mm']:.2f}, {off['y_mm']:.2f} mm"
    return told, Tone.PLAIN if is_kept else Tone.BAD


def _score(record: Mapping[str, Any]) -> PageTable:
    lines = record["score_lines"]
    rows = tuple((f"{line['points']:+d}", line["subject"], line["reason"]) for line in lines)
    tones = tuple(Tone.BAD if line["points"] < 0 else Tone.PLAIN for line in lines)
    return PageTable("Score by rule", ("points", "for", "why"), rows or (("0", "", "no line"),), tones)


def _looks(looks: Sequence[Mapping[str, Any]]) -> Iterator[PageTable]:
    """Yield the table of what cameras said of each place, and of what they left out, if there were any."""
    columns = ("look into", "used", "not used, or beyond its bounds")
    found = [_look(look, place) for look in looks for place in look["cameras"]]
    if found:
        yield PageTable("Looks", columns, tuple(row for row, _ in found), tuple(tone for _, tone in found))


def _look(look: Mapping[str, Any], place: str) -> tuple[tuple[str, ...], Tone]:
    """One look into a place as a row, and its tone."""
    camera, at = look["cameras"][place]
    seen = [each for each in look["items"] if each["place"] == place]
    left = [each for each in seen if each["bound_mm"] is None]
    wrong = [each for each in seen if each["bound_mm"] is not None and not _is_bound_kept(each)]
    remarks = [f"{_name(each)}: {each['refusal'] or 'no bounds'}" for each in left]
    for each in wrong:
        remarks.append(f"{_name(each)}: is {_truly_off(each)}")
    used = f"{len(seen) - len(left)} of {len(seen)}"
    tone = Tone.BAD if wrong else Tone.FAIR if left else Tone.PLAIN
    return (f"{look['number']}: {place}, {camera} at {at}", used, "; ".join(remarks)), tone


def _truly_off(seen: Mapping[str, Any]) -> str:
    """By how much a pose is off, in all that has a bound."""
    if seen["truly_off_mm"] is None:
        return "gone"
    units = {"mm": "mm", "deg": "degrees", "surface_mm": "mm of its surface"}
    off = {what: seen.get(f"truly_off_{what}") for what in units}
    return "truly off by " + ", ".join(
        f"{off[w]:.1f} {unit}" for w, unit in units.items() if off[w] is not None
    )


def _name(seen: Mapping[str, Any]) -> str:
    """Name of an item in words, between which lines may break."""
    return str(seen["item"]).replace("_", " ")


def _is_bound_kept(seen: Mapping[str, Any]) -> bool:
    """Whether a pose is truly within its bounds; not if the item is gone."""
    bounds = {what: seen.get(f"bound_{what}") for what in ("mm", "deg", "surface_mm")}
    off = {what: seen.get(f"truly_off_{what}") for what in bounds}
    pairs = [(off[what], bound) for what, bound in bounds.items() if bound is not None]
    return off["mm"] is not None and all(error is None or error <= bound for error, bound in pairs)


def _chapter(attempt: _Played, scene: Scene) -> Chapter:
    record = attempt.record
    item, aside = record["item"], "aside: " if record["is_aside"] else ""
    retry = f" (try {record['number']})" if record["number"] > 1 else ""
    way = f"{record['out_of'] or record['bin']} to {record['into']}"
    if record.get("topples"):
        is_slide = (record.get("plan") or {}).get("query", "").startswith("push ")
        aside, way = "push off others: " if is_slide else "topple: ", str(record["into"])
    return Chapter(
        f"{aside}{item.replace('_', ' ')}, {way}{retry}",
        record["outcome"],
        _TONES.get(record["outcome"], Tone.BAD),
        round(attempt.t_start, 3),
        round(attempt.t_end, 3),
        item,
        record["out_of"] or record["bin"],
        record["reason"],
        tuple(_marks(attempt, scene)),
    )


def _marks(attempt: _Played, scene: Scene) -> Iterator[Mark]:
    """Yield marks for rejected grasps, collisions, contacts, drops and disturbed items."""
    known = named_parts(scene)
    reasons = [
        Reason(each["what"], each["where"], each["detail"], each["in_the_way"])
        for each in attempt.record.get("reasons", ())
        for _ in range(each["count"])
    ]
    for mark in failure_marks(reasons, known, attempt.record["item"]):
        yield replace(mark, t=None)  # failed in planning, before any motion
    for record, execution in attempt.executions:
        yield from _happened(record, execution, known)


def _happened(
    record: Mapping[str, Any], execution: RecordedExecution, known: frozenset[str]
) -> Iterator[Mark]:  # fmt: skip
    """Yield marks for faults during an execution."""
    if record["stopped"]:
        yield Mark("stopped", record["stopped"], execution.t_end, Tone.FAIR)
    for hit in record["collisions"]:
        names = tuple(name for name in (hit["a"], hit["b"]) if name in known)
        detail = f"{hit['a']} and {hit['b']}, {hit['force']:.0f} N"
        yield Mark("contact", detail, hit["t_start"], Tone.BAD, names, depth=hit["depth"])
    for drop in record["drops"]:
        if not drop["is_release"]:
            detail = f"{drop['item']} fell {drop['height']:.2f} m"
            yield Mark("lost", detail, execution.t_end, Tone.BAD, (drop["item"],))
    for moved in record["disturbed"]:
        detail = f"{moved['item']} {moved['kind']}, by {1e3 * moved['moved']:.0f} mm"
        yield Mark("moved", detail, execution.t_end, Tone.FAIR, (moved["item"],))


def _switched(attempts: Sequence[_Played]) -> list[tuple[float, str, str, str]]:
    """(s, device, action, details) of every fired event."""
    found = []
    for attempt in attempts:
        for record, _ in attempt.executions:
            for event in record["events"]:
                off = f"{1e3 * event['distance']:.1f} mm of path from where it was due"
                read = (
                    "" if event["reading"] is None else f"reads {'held' if event['reading'] else 'nothing'}, "
                )
                found.append((event["t"], event["device"], event["action"], read + off))
    return found
