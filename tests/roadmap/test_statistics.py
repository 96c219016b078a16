"""The figures of ``apc inspect``."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.errors import Reason
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.roadmap_tables import RoadmapGaps
from pickcli.roadmap.statistics import database_statistics, histogram, roadmap_statistics
from pickcli.roadmap.trajectory_database import MotionKey, PayloadClass, TrajectoryDatabase
from support.stored_samples import database, roadmap


def test_the_worst_motions_come_first_and_totals_add_up() -> None:
    bounds = np.array([1.9, 1.0, 1.6])
    stored = replace(database(), lower_bounds=bounds, clearances=np.array([0.02, 0.004, 0.01]))
    gone = (MotionKey("a", "z", PayloadClass.EMPTY), Reason("collision", "z", "cup against tote"))
    told = database_statistics(stored, [gone])
    assert (told["motions"], told["duration_s"], told["lower_bound_s"]) == (3, 6.0, 4.5)
    assert told["by_payload"] == {"cube": 1, "empty": 2} and told["coverage"] == 0.75
    assert told["worst"][0] == "b to c, empty: 2.00 s, 2.00 times its bound, 4 mm clear"
    assert [line.split(",")[0] for line in told["worst"]] == ["b to c", "a to b", "a to b"]
    assert told["share_near_bound"] == round(1 / 3, 4) and told["least_clearance_mm"] == 4.0
    assert told["missing"] == ["a to z, empty: z: collision: cup against tote"]
    assert sum(told["times_its_bound"].values()) == 3 and told["times_its_bound"]["2 and more"] == 1


def test_motions_without_a_bound_have_no_ratio() -> None:
    told = database_statistics(database(), [])
    assert told["worst"] == [] and told["share_near_bound"] is None


def test_a_roadmap_in_figures() -> None:
    gaps = RoadmapGaps(missing=((("a", "b"), Reason("no path", detail="gave up")),))
    told = roadmap_statistics(roadmap(), gaps)
    assert (told["nodes"], told["edges"], told["parts"]) == (6, 5, 1)
    assert told["nodes_by_edges"] == {"1 edges": 2, "2 edges": 4}
    lengths = [float(line.rpartition(" ")[2]) for line in told["worst"]]
    assert lengths == sorted(lengths, reverse=True) and len(lengths) == 5
    assert told["missing"] == ["a to b: no path: gave up"]


def test_what_is_empty_has_figures_too() -> None:
    assert database_statistics(TrajectoryDatabase.of(("x",), []), [])["motions"] == 0
    assert roadmap_statistics(Roadmap.empty(("x",)), RoadmapGaps())["worst"] == []


def test_intervals_of_a_histogram_are_half_open() -> None:
    assert histogram(np.array([1.0, 1.5, 2.0, 9.0]), (1.0, 1.5, 2.0, np.inf)) == {
        "1 to 1.5": 1,
        "1.5 to 2": 1,
        "2 and more": 2,
    }
