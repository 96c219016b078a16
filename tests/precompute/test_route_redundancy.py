"""Second routes: every important pair has one or a reason, and networkx agrees."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import networkx as nx
import numpy as np

from pickcli.cell.pod_tolerance import ANY_POD, NOMINAL_POD
from pickcli.errors import Reason
from pickcli.path_planning.planner_names import PlannerName
from pickcli.precompute.artifact_files import make_roadmap
from pickcli.precompute.critical_pairs import critical_pairs, neighbouring_bins
from pickcli.precompute.roadmap_builder import build_roadmap
from pickcli.precompute.roadmap_edge_job import RoadmapEdgeJob
from pickcli.precompute.roadmap_settings import RoadmapSettings
from pickcli.precompute.route_redundancy import MOST_TRIES, edge_to_try, for_any_pod, missing_redundancy
from pickcli.roadmap import validate
from pickcli.roadmap.edge_disjoint import edge_disjoint
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.statistics import roadmap_statistics
from pickcli.roadmap.store import read_gaps, read_roadmap
from support.small_cell import small_cell

THIN = RoadmapSettings(PlannerName.RRT_CONNECT, n_neighbours=1, max_iterations=2000, n_shortcuts=50)


def test_every_important_pair_has_two_routes_by_networkx_or_a_reason() -> None:
    cell = small_cell("home", "bin_A", "bin_B", "bin_E", "cam_E", "tote", "drop_00", "drop_01")
    roadmap, report = build_roadmap(RoadmapEdgeJob(cell, THIN))
    graph = nx.Graph((roadmap.names[a], roadmap.names[b]) for a, b in roadmap.edges.tolist())
    double = {names for names, _ in report.routes.detours}
    alone = {names for names, _ in report.routes.without_second_route}
    assert double | alone == set(critical_pairs(cell)) and not double & alone
    for names in double:
        assert nx.edge_connectivity(graph, *names) >= 2
    assert double and not alone


def test_routes_for_any_pod_use_its_edges_alone() -> None:
    roadmap, report = build_roadmap(RoadmapEdgeJob(small_cell("home", "bin_A", "tote"), THIN))
    assert report.summary()["second_routes"]["n_for_any_displaced_pod"] == 3
    part = for_any_pod(replace(roadmap, validities=(ANY_POD, NOMINAL_POD, ANY_POD)))
    assert part.names == roadmap.names and part.n_edges == 2
    np.testing.assert_array_equal(part.edge_path(1), roadmap.edge_path(2))
    validate.roadmap(part, None)
    assert for_any_pod(replace(roadmap, validities=(NOMINAL_POD,) * 3)).n_edges == 0


def test_edges_are_added_for_them_and_told() -> None:
    cell = small_cell("home", "bin_A", "tote")
    roadmap, report = build_roadmap(RoadmapEdgeJob(cell, THIN))
    told = report.summary()["second_routes"]
    assert roadmap.n_edges == 3  # a chain is closed to a ring
    assert len(told["added"]) == 1
    assert told["n_important"] == told["n_with_second_route"] == 3
    assert told["second_over_first_length"]["worst"] >= told["second_over_first_length"]["median"] >= 1.0


def test_a_pair_with_one_edge_in_all_is_told_with_the_edge_that_it_needs() -> None:
    _, report = build_roadmap(RoadmapEdgeJob(small_cell("home", "bin_A"), THIN))
    ((names, reason),) = report.routes.without_second_route
    assert names == ("bin_A", "home")
    assert "all need the edge bin_A to home" in reason.what and "no other pair is left" in reason.detail


def test_an_end_that_is_not_free_is_the_reason() -> None:
    cell = small_cell("home", "bin_A", "bin_B", "tote_10h")
    as_bin = replace(cell.configurations["tote_10h"], kind="bin")
    cell = replace(cell, configurations=cell.configurations | {"tote_10h": as_bin})
    _, report = build_roadmap(RoadmapEdgeJob(cell, THIN))
    reasons = dict(report.routes.without_second_route)
    assert reasons["home", "tote_10h"].what == "collision"


def test_what_was_found_is_in_the_file(tmp_path: Path) -> None:
    path = tmp_path / "roadmap.h5"
    report = make_roadmap(small_cell("home", "bin_A"), path, THIN)
    assert read_gaps(path).without_second_route == report.routes.without_second_route
    (told,) = roadmap_statistics(read_roadmap(path), read_gaps(path))["without_second_route"]
    assert told.startswith("bin_A to home: one route only")


def test_the_nearest_pair_across_the_cut_comes_next_and_failures_are_counted() -> None:
    roadmap = _row(5)
    side = frozenset({0, 1})
    assert edge_to_try(roadmap, side, {}) == (0, 2)  # (1, 2) is an edge
    assert edge_to_try(roadmap, side, {(0, 2)}) == (1, 3)
    reason = Reason("no path", detail="gave up")
    found = edge_disjoint(roadmap, 0, 4)
    told = missing_redundancy(roadmap, found, {(0, 2): reason, (3, 4): reason})
    assert told.what == "one route only: all need the edge q0 to q1"
    assert told.detail == "1 pairs beside it were tried, none has a path, e.g. q0 to q2: no path: gave up"


def test_a_cut_that_failed_often_is_not_tried_for_ever() -> None:
    roadmap = _row(2 * MOST_TRIES)
    side = frozenset({0})
    across = [(0, j) for j in range(2, 2 + MOST_TRIES)]
    assert edge_to_try(roadmap, side, across[:-1]) is not None
    assert edge_to_try(roadmap, side, across) is None
    others = [(1, j) for j in range(3, 3 + MOST_TRIES)]
    assert edge_to_try(roadmap, side, others) == (0, 2)


def test_critical_pairs_are_those_of_an_order() -> None:
    pairs = set(critical_pairs(small_cell("home", "bin_A", "cam_A", "bin_B", "bin_F", "tote", "drop_00")))
    assert ("bin_A", "tote") in pairs and ("cam_A", "drop_00") in pairs and ("bin_A", "cam_A") in pairs
    assert ("bin_A", "bin_B") in pairs and ("bin_A", "bin_F") not in pairs
    assert ("bin_B", "cam_A") not in pairs
    assert all(a < b for a, b in pairs)


def test_bins_of_a_3_by_4_pod_touch_17_times() -> None:
    pairs = list(neighbouring_bins(small_cell().pod))
    assert len(pairs) == len({frozenset(pair) for pair in pairs}) == 4 * 2 + 3 * 3
    touching = {frozenset(pair) for pair in pairs}
    assert {"bin_E", "bin_H"} in touching and {"bin_C", "bin_D"} not in touching


def _row(n_nodes: int) -> Roadmap:
    """A chain of nodes along a line."""
    roadmap = Roadmap.empty(("x",))
    for i in range(n_nodes):
        roadmap, _ = roadmap.with_node(np.array([float(i)]), f"q{i}")
    for a in range(n_nodes - 1):
        roadmap = roadmap.with_edge(a, a + 1, roadmap.configurations[[a, a + 1]])
    return roadmap
