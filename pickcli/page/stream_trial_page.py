"""Page of a trial of a stream: items wait beside the infeed until they come, and again once they are away."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.geometry import Array, pose, to_quaternion
from pickcli.page.motion_parts import segment_lane
from pickcli.page.page_document import PageDocument, PageTable
from pickcli.page.page_motion import Chapter, Lane
from pickcli.page.page_scene import Fact, Tone
from pickcli.page.recorded_parts import joint_signals, replayed, vacuum_signals
from pickcli.page.scene_page import standing_page
from pickcli.page.stream_trials_page import paper_tables
from pickcli.scene.item_stream import ItemStream
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.trial.motion_record import RecordedMotion

WAITING_APART, PER_ROW = 0.35, 10  # m between items that wait, and how many stand beside each other
BEFORE_INFEED = 1.0  # m from the infeed to the first row of them
AWAY_AFTER = 0.5  # s after its last motion at which an item is taken away
MOMENT = 1e-3  # s in which an item comes, or is taken away
_TONES = {"delivered": Tone.GOOD, "not attempted": Tone.FAIR, "lost": Tone.BAD}


def waiting_scene(stream: ItemStream) -> Scene:
    """Return the scene before anything comes.

    Args:
        stream: The stream.

    Returns:
        The cell, with all items in rows on the floor, upstream of the belt.
    """
    T_belt = stream.carrier.T_world_carrier
    items = []
    for k, riding in enumerate(stream.items):
        row, column = divmod(k, PER_ROW)
        aside = (column - (PER_ROW - 1) / 2) * WAITING_APART
        at = (T_belt @ [-BEFORE_INFEED - row * WAITING_APART, aside, 0.0, 1.0])[:3]
        at[2] = float(riding.item.shape.reach(riding.T_belt_item[:3, :3])[2])
        T = pose(at, R=T_belt[:3, :3] @ riding.T_belt_item[:3, :3])
        items.append(PlacedItem(riding.id, riding.item, stream.conveyor, T))
    return Scene(stream.cell, stream.cell.T_world_pod, tuple(items), stream.noise, seed=stream.seed)


def stream_trial_page(
    record: Mapping[str, Any], scene: Scene, cells: Sequence[Cell], motion: RecordedMotion
) -> PageDocument:
    """Create the page of a trial of a stream.

    Args:
        record: Content of its ``trial.json``.
        scene: The cell with the items that wait, of ``waiting_scene``.
        cells: The cell as seen by each arm that plays.
        motion: The recorded motion.

    Returns:
        The page.
    """
    made, duration = record["made_from"], float(motion.times[-1])
    subtitle = f"{made['stream']}, seed {made['seed']}, cell {made['cell']}, {duration:.0f} s simulated"
    title = f"{record['delivered']} of {record['presented']} items at {record['speed_m_s']:g} m/s"
    lanes = tuple(_lane(motion, cell.arm, len(cells) == 1) for cell in cells)
    signals = [signal for cell in cells for signal in joint_signals(motion, cell, len(cells) == 1)]
    return replace(
        standing_page(scene, "stream trial", title, subtitle),
        facts=tuple(_facts(record)),
        motion=replayed(_with_waiting(motion, scene)),
        lanes=lanes,
        signals=(*vacuum_signals(motion), *signals),
        chapters=tuple(_chapters(record, motion)),
        tables=(_table(record), *paper_tables({"": record})),
    )


def _lane(motion: RecordedMotion, arm: str, is_only: bool) -> Lane:
    """Return the segments of the motions of an arm."""
    segments = [s for execution in motion.executions if execution.arm == arm for s in execution.segments]
    return segment_lane(segments, *(() if is_only else (f"segments, {arm}",)))


def _with_waiting(motion: RecordedMotion, scene: Scene) -> RecordedMotion:
    """Return the motion with each item where it waits, until it comes and after it is away."""
    items = dict[str, tuple[Array, Array]]()
    for name, (times, poses) in motion.items.items():
        T = scene.find(name).T_world_item
        row = np.array([*T[:3, 3], *to_quaternion(T[:3, :3])])
        gone = float(times[-1]) + AWAY_AFTER
        at = [max(float(times[0]) - MOMENT, 0.0), *times, gone, gone + MOMENT]
        items[name] = (np.array(at), np.vstack([row, poses, poses[-1:], row]))
    return replace(motion, items=items)


def _facts(record: Mapping[str, Any]) -> Iterator[Fact]:
    yield Fact(
        "delivered", f"{record['delivered']} of {record['presented']}, {record['attempted']} attempted"
    )
    yield Fact("pace", f"{record['delivered_per_minute']:.1f} a minute")
    yield Fact("belt", f"{record['speed_m_s']:g} m/s")
    for key in ("collisions", "limit_violations", "stops"):
        yield Fact(key.replace("_", " "), str(record[key]), Tone.BAD if record[key] else Tone.PLAIN)
    if (offset := record["offset_m"]) is not None:
        yield Fact("tool off its place", f"{1e3 * offset['p95']:.1f} mm in 95 % of the picks")
    if (slip := record["slip_m_s"]) is not None:
        yield Fact("tool over the item", f"{1e3 * slip['p95']:.1f} mm/s along the belt")


def _chapters(record: Mapping[str, Any], motion: RecordedMotion) -> Iterator[Chapter]:
    """One for each item at which an arm moved, from the start of its last motion."""
    for each in record["items"]:
        if each["t_end"] is not None:
            run = min(motion.executions, key=lambda run: abs(run.t_end - each["t_end"]))
            yield Chapter(
                each["item"], each["outcome"], _TONES.get(each["outcome"], Tone.BAD), round(run.t_start, 3),
                round(each["t_end"], 3), each["item"], "", each["reason"],
            )  # fmt: skip


def _table(record: Mapping[str, Any]) -> PageTable:
    rows, tones = [], []
    for each in record["items"]:
        met = "" if each["met"] is None else f"{1e3 * each['met']['offset']:.1f} mm off"
        clear = "" if each["clearance"] is None else f"{1e3 * each['clearance']:.1f} mm"
        rows.append((each["item"], each["outcome"], met, clear, each["reason"]))
        tones.append(_TONES.get(each["outcome"], Tone.BAD))
    columns = ("item", "outcome", "met", "clearance", "why")
    return PageTable("Items", columns, tuple(rows), tuple(tones))
