"""The roadmap of real configurations."""

from __future__ import annotations

from dataclasses import replace

import networkx as nx
import numpy as np
import pytest
from small_cell import FEW, small_cell

from pickcli.cell.robot import PivotState
from pickcli.collision.model import CollisionModel
from pickcli.errors import InputError
from pickcli.precompute.build_roadmap import RoadmapSettings, build_roadmap, nearest_pairs
from pickcli.precompute.empty_scene import checker
from pickcli.roadmap.database import PayloadClass
from pickcli.roadmap.planners import PlannerName
from pickcli.roadmap.store import roadmap_bytes

QUICK = RoadmapSettings(PlannerName.RRT_CONNECT, n_neighbours=2, max_iterations=2000, n_shortcuts=50)


def test_every_edge_is_proven_with_the_cells_clearance_in_every_pivot_state() -> None:
    cell = small_cell()
    roadmap, _ = build_roadmap(cell, QUICK)
    model = CollisionModel(cell)
    for pivot in PivotState:
        tests = checker(model, pivot, PayloadClass.EMPTY)
        for edge in range(roadmap.n_edges):
            path = roadmap.edge_path(edge)
            assert tests.path_is_free(path) == -1
            assert tests.path_is_free(path[::-1]) == -1


def test_nodes_are_the_free_configurations_and_the_rest_is_reported_with_its_reason() -> None:
    roadmap, report = build_roadmap(small_cell(), QUICK)
    assert set(roadmap.names) == set(FEW) - {"tote_10h"}
    assert [name for name, _ in report.refused] == ["tote_10h"]
    assert report.refused[0][1].what == "collision" and "tote" in report.refused[0][1].detail


def test_the_roadmap_is_connected_and_no_star() -> None:
    roadmap, report = build_roadmap(small_cell(), QUICK)
    graph = nx.Graph(roadmap.edges.tolist())
    assert nx.is_connected(graph) and report.n_components == 1
    home = roadmap.index("home")
    graph.remove_node(home)
    assert graph.number_of_edges() > 0


def test_parts_that_the_nearest_leave_apart_are_bridged_and_the_bridge_is_told() -> None:
    cell = small_cell("tote", "drop_01", "bin_G", "bin_J")
    roadmap, report = build_roadmap(cell, replace(QUICK, n_neighbours=1))
    assert report.n_components == 1
    assert len(report.bridges) == 1
    assert roadmap.n_edges == 3


def test_pairs_that_fail_are_told() -> None:
    cell = small_cell("home", "drop_00_down", "cam_D")
    hopeless = replace(QUICK, n_neighbours=2, max_iterations=1)
    roadmap, report = build_roadmap(cell, hopeless)
    assert ("cam_D", "drop_00_down") in report.failed
    assert roadmap.n_edges + len(report.failed) == 3


def test_the_order_of_the_configurations_changes_no_edge() -> None:
    cell = small_cell("home", "bin_A", "cam_D", "drop_00_down", "drop_02_down")
    turned = replace(cell, configurations=dict(reversed(cell.configurations.items())))
    edges = []
    for variant in (cell, turned):
        roadmap, _ = build_roadmap(variant, QUICK)
        named = {}
        for m, (a, b) in enumerate(roadmap.edges.tolist()):
            key = frozenset((roadmap.names[a], roadmap.names[b]))
            named[key] = float(roadmap.lengths[m])
        edges.append(named)
    assert edges[0] == edges[1]


def test_same_seed_same_bytes_and_progress_counts_up() -> None:
    cell, calls = small_cell("home", "bin_A", "drop_00_down", "tote"), []
    first, _ = build_roadmap(cell, QUICK, lambda done, total, what: calls.append((done, total)))
    second, _ = build_roadmap(cell, QUICK)
    assert roadmap_bytes(first, "", {}) == roadmap_bytes(second, "", {})
    assert [done for done, _ in calls] == list(range(calls[-1][1] + 1))


def test_nearest_pairs_name_each_pair_once() -> None:
    Q = np.array([[0.0], [1.0], [1.5], [9.0]])
    assert nearest_pairs(Q, 1) == [(0, 1), (1, 2), (2, 3)]
    assert len(nearest_pairs(Q, 50)) == 6


def test_a_cell_without_a_free_configuration_is_refused() -> None:
    with pytest.raises(InputError, match="no named configuration is free"):
        build_roadmap(small_cell("tote_10h"), QUICK)
