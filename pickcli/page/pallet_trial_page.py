"""Page of a trial of a pallet: the arm stacks the cartons, which wait beside the infeed until they come."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from pickcli.geometry import Array, pose, to_quaternion
from pickcli.page.motion_parts import segment_lane
from pickcli.page.page_document import PageDocument, PageTable
from pickcli.page.page_motion import Chapter
from pickcli.page.page_scene import Fact, Tone
from pickcli.page.recorded_parts import joint_signals, replayed, vacuum_signals
from pickcli.page.scene_page import standing_page
from pickcli.page.trial_clearance import trial_clearance
from pickcli.pallet_trials.pallet_station import INFEED, PalletStation
from pickcli.palletizing.pallet_stack_file import StackedPallet
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.trial.motion_record import RecordedMotion

WAITING_APART, PER_ROW = 0.7, 4  # m between cartons that wait, and how many stand beside each other
MOMENT = 1e-3  # s in which a carton comes to the infeed, or is taken away
_TONES = {"placed": Tone.GOOD, "left": Tone.FAIR, "lost": Tone.BAD}


def pallet_trial_page(
    record: Mapping[str, Any], stack: StackedPallet, station: PalletStation, motion: RecordedMotion
) -> PageDocument:
    """Create the page of a trial of a pallet.

    Args:
        record: Content of its ``trial.json``.
        stack: The stack that was played.
        station: The cell.
        motion: The recorded motion.

    Returns:
        The page.
    """
    scene = _waiting(stack, station, record["made_from"]["seed"])
    placed = {each["carton"] for each in record["cartons"] if each["outcome"] == "placed"}
    shown = _with_waiting(motion, scene, placed)
    made, duration = record["made_from"], float(motion.times[-1])
    subtitle = f"{made['pallet']}, seed {made['seed']}, cell {made['cell']}, {duration:.0f} s simulated"
    title = f"{record['placed']} of {record['ordered']} cartons"
    segments = [segment for execution in motion.executions for segment in execution.segments]
    return replace(
        standing_page(scene, "pallet trial", title, subtitle),
        facts=tuple(_facts(record)),
        motion=replayed(shown),
        lanes=(segment_lane(segments),),
        signals=(*vacuum_signals(motion), *joint_signals(motion, station.cell)),
        clearance=trial_clearance(scene, (station.cell,), shown),
        chapters=tuple(_chapter(each, duration) for each in record["cartons"]),
        tables=(_table(record),),
    )


def _waiting(stack: StackedPallet, station: PalletStation, seed: int) -> Scene:
    """The scene before anything comes: all cartons wait on the floor beside the infeed."""
    cell = station.cell
    corner = cell.T_world_place(cell.places[INFEED])[:3, 3] + [1.0, 0.0, 0.0]
    items = []
    for k, placement in enumerate(stack.placements):
        row, column = divmod(k, PER_ROW)
        at = (*(corner[:2] + WAITING_APART * np.array([row, column])), placement.carton.size[2] / 2)
        name = placement.carton.id
        items.append(PlacedItem(name, station.items[name], INFEED, pose(at)))
    return replace(station.empty(seed), items=tuple(items))


def _with_waiting(motion: RecordedMotion, scene: Scene, placed: set[str]) -> RecordedMotion:
    """Return the motion with each carton where it waits, until it comes and after it was taken away."""
    items = dict[str, tuple[Array, Array]]()
    for name, (times, poses) in motion.items.items():
        T = scene.find(name).T_world_item
        row = np.array([*T[:3, 3], *to_quaternion(T[:3, :3])])
        times, poses = np.append(max(times[0] - MOMENT, 0.0), times), np.vstack([row, poses])
        if name not in placed:
            times, poses = np.append(times, times[-1] + MOMENT), np.vstack([poses, row])
        items[name] = (times, poses)
    return replace(motion, items=items)


def _facts(record: Mapping[str, Any]) -> Iterator[Fact]:
    yield Fact("stacked", f"{record['placed']} of {record['ordered']} cartons")
    yield Fact("score", f"{record['score']:.2f}")
    if record["collapsed"]:
        yield Fact("stack", "collapsed", Tone.BAD)
    yield Fact("pace", f"{record['boxes_per_hour']:.0f} boxes an hour")
    for key in ("collisions", "limit_violations", "stops"):
        yield Fact(key.replace("_", " "), str(record[key]), Tone.BAD if record[key] else Tone.PLAIN)
    if (aside := record["aside_m"]) is not None:
        yield Fact("set down", f"{1e3 * aside['median']:.1f} mm off, {1e3 * aside['worst']:.1f} mm at worst")


def _chapter(carton: Mapping[str, Any], duration: float) -> Chapter:
    end = carton["t_start"] if carton["t_end"] is None else carton["t_end"]
    return Chapter(
        carton["carton"], carton["outcome"], _TONES.get(carton["outcome"], Tone.BAD),
        round(min(carton["t_start"], duration), 3), round(min(end, duration), 3), carton["carton"],
        INFEED, carton["reason"],
    )  # fmt: skip


def _table(record: Mapping[str, Any]) -> PageTable:
    rows, tones = [], []
    for each in record["cartons"]:
        off = each["set_down"]
        told = "" if off is None else f"{1e3 * off['aside']:.1f} mm aside, {np.degrees(off['turn']):.2f}°"
        rows.append((each["carton"], each["outcome"], told, each["reason"]))
        tones.append(_TONES.get(each["outcome"], Tone.BAD))
    for left in record["left"]:
        rows.append((left["id"], "no place", "", "; ".join(left["reasons"])))
        tones.append(Tone.FAIR)
    return PageTable("Cartons", ("carton", "outcome", "set down", "why"), tuple(rows), tuple(tones))
