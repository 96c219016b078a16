"""All figures of perception that are asked for, beside what is asked, in one table: make bench-perception.

    python -m bench.eyes --seed 15000 [--scenes 3] [--shifts 60] [--sensors ensenso] [--json FILE]

Poses of the pod are ``--shifts`` random ones (``bench.pod_pose``); in ``--scenes`` fresh orders the items of
all bins are found, by three looks into each, as trials take them, and by one (``bench.perceived``); in the
first of these orders lists are wrong by one item; pictures are those of ``bench.perception``. What becomes of
it in trials is another matter: ``apc run-trial --perception camera``. Times are processor time of one thread.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import count, islice
from pathlib import Path
from time import thread_time

import numpy as np

from bench.perceived import (
    SENSORS,
    Row,
    SeenBin,
    fresh_scene,
    rows_of_scene,
    seen_bins,
    summary,
    wrong_lists,
)
from bench.perception import measure as measure_pictures
from bench.pod_pose import measure as measure_pod
from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.schemas.sensor_file import read_sensor, sensor_file
from pickcli.errors import InputError
from pickcli.geometry import inverse
from pickcli.perception.items.listed_item import ListedItem
from pickcli.perception.items.unknown_voxels import unknown_boxes
from pickcli.perception.pod_pose import EXACT
from pickcli.scene.scene import Scene

N_LOOKS = 3


@dataclass(frozen=True)
class Sensed:
    """All that was measured of one sensor.

    Attributes:
        pod: Figures of the located pod, by ``bench.pod_pose``.
        rows: What was said of each item, by three looks.
        single: The same, by one look.
        lists: By kind of list whether something is said of it.
        voxels: ms from a searched picture to boxes of unknown space, by bin.
        pictures: ms of a picture of 640 x 480 with noise, and of colour of 1280 x 1024.
    """

    pod: Mapping[str, float]
    rows: Sequence[Row]
    single: Sequence[Row]
    lists: Sequence[tuple[str, bool]]
    voxels: Sequence[float]
    pictures: tuple[float, float]


def stowed(cell: Cell, first_seed: int) -> Iterator[Scene]:
    """Scenes of orders by seeds from a first one on, without those for whose items no room is found."""
    for seed in count(first_seed):
        try:
            yield fresh_scene(cell, seed)
        except InputError as fault:
            print(f"order {seed} is left out: {fault}")


def ms_of_voxels(seen: SeenBin) -> float:
    """How long it takes from what was found in one picture of a bin to boxes of unknown space."""
    (look,) = seen.looks([ListedItem(each.id, each.item) for each in seen.items])[:1]
    T_place_world = inverse(look.T_world_place)
    within = dict.fromkeys(look.found, 0.004)
    start = thread_time()
    sight = look.search.line_of_sight(look.in_camera(look.poses), within)
    shapes = [(look.listed[i].item.shape.inflated(0.004), T_place_world @ T) for i, T in look.poses.items()]
    unknown_boxes(seen.place.room, [sight], shapes)
    return 1e3 * (thread_time() - start)


def sensed(
    cell: Cell, name: str, scenes: Sequence[Scene], shifts: int, pictures: Mapping[str, float]
) -> Sensed:
    """Measure all of one sensor."""
    sensor = read_sensor(sensor_file(name))
    rows, single = (
        [row for scene in scenes for row in rows_of_scene(scene, sensor, n_looks)] for n_looks in (N_LOOKS, 1)
    )
    return Sensed(
        measure_pod(name, shifts, scenes[0].seed, EXACT, any_view=False),
        rows,
        single,
        list(wrong_lists(scenes[0], sensor)),
        [ms_of_voxels(seen) for seen in seen_bins(scenes[0], sensor)],
        (pictures[f"{name} 640x480"], pictures["colour 1280x1024"]),
    )


def said(of: Sensed, kind: str) -> str:
    """Of how many wrong lists of a kind something is said."""
    found = [is_said for each, is_said in of.lists if each.startswith(kind)]
    return f"{sum(found)} of {len(found)}"


def table_rows() -> dict[tuple[str, str], Callable[[Sensed], str]]:
    """By figure and what is asked of it, how it follows from what was measured."""

    def by_rows(form: Callable[[Mapping[str, float]], str]) -> Callable[[Sensed], str]:
        return lambda of: form(summary(of.rows))

    def bounds(of: Sensed) -> str:
        bounded = [row for row in of.rows if row.bound_mm is not None]
        n_kept = sum(row.is_bound_kept for row in bounded)
        return f"{n_kept / max(len(bounded), 1):.1%} of {len(bounded)}"

    return {
        ("pod, p95", "2 mm, 0.1 degrees"): lambda of: (
            f"{of.pod['position_mm_p95']:.2f} mm, {of.pod['yaw_deg_p95']:.3f}"
        ),
        ("pod, failures", "0"): lambda of: f"{of.pod['failures']:.0f}",
        ("pod, ms: median, p95", "60"): lambda of: (
            f"{of.pod['time_ms_median']:.0f}, {of.pod['time_ms_p95']:.0f}"
        ),
        ("good, of well seen", "85 %"): by_rows(lambda s: f"{s['good_of_well_seen']:.1%}"),
        ("good, of all", "70 %"): by_rows(lambda s: f"{s['good']:.1%}"),
        ("good ones off, median", "2 mm, 1 degree"): by_rows(
            lambda s: f"{s['mm_median']:.2f} mm, {s['deg_median']:.2f}"
        ),
        ("good ones off, p95", "6 mm, 3 degrees"): by_rows(
            lambda s: f"{s['mm_p95']:.1f} mm, {s['deg_p95']:.1f}"
        ),
        ("wrong, of answers", "3 %"): by_rows(
            lambda s: f"{s['wrong_of_answers']:.1%} of {round(s['answered'] * s['items'])}"
        ),
        ("items with a bound", ""): by_rows(lambda s: f"{s['bounded_of_answers'] * s['answered']:.0%}"),
        ("bounds kept", "99 %"): bounds,
        ("bounds, median: position, surface", ""): by_rows(
            lambda s: f"{s['bound_mm_median']:.1f}, {s['bound_surface_mm_median']:.1f} mm"
        ),
        ("ms an item, one look: median, p95", "120, 400"): lambda of: (
            f"{summary(of.single)['ms_median']:.0f}, {summary(of.single)['ms_p95']:.0f}"
        ),
        ("ms an item, three looks: median, p95", ""): by_rows(
            lambda s: f"{s['ms_median']:.0f}, {s['ms_p95']:.0f}"
        ),
        ("ms of a picture: depth 640 x 480, colour 1280 x 1024", "40, 80"): lambda of: (
            f"{of.pictures[0]:.0f}, {of.pictures[1]:.0f}"
        ),
        ("ms to unknown boxes: median, most", "30"): lambda of: (
            f"{np.median(of.voxels):.0f}, {max(of.voxels):.0f}"
        ),
        ("an unlisted item: said so", "80 %"): lambda of: said(of, "well seen"),
        ("a missing item: said so", "80 %"): lambda of: said(of, "item listed"),
        ("the right list, all found: more is said to be there", ""): lambda of: said(of, "right list"),
    }


def main() -> None:
    """Measure, and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, required=True, help="of the first order, used for nothing else")
    parser.add_argument("--scenes", type=int, default=3, help="number of orders")
    parser.add_argument("--shifts", type=int, default=60, help="number of poses of the pod")
    parser.add_argument("--sensors", nargs="+", default=list(SENSORS), help="files under data/sensors")
    parser.add_argument("--json", type=Path, help="also write the table there")
    given = parser.parse_args()
    cell = load_cell("apc2016_delft")
    measured = measure_pictures()
    pictures = {name: times["median_ms"] for name, times in measured.items() if isinstance(times, dict)}
    scenes = list(islice(stowed(cell, given.seed), given.scenes))
    found = {name: sensed(cell, name, scenes, given.shifts, pictures) for name in given.sensors}
    rows = {
        figure: (asked, *(form(found[name]) for name in given.sensors))
        for (figure, asked), form in table_rows().items()
    }
    print(f"| | asked | {' | '.join(given.sensors)} |")
    print("|---|---|" + "---|" * len(given.sensors))
    for figure, cells in rows.items():
        print(f"| {figure} | {' | '.join(cells)} |")
    if given.json is not None:
        given.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
