"""The roadmap of real configurations."""

from __future__ import annotations

from dataclasses import replace

import networkx as nx
import numpy as np
import pytest

from pickcli.collision.robot_model import CollisionModel
from pickcli.errors import InputError
from pickcli.jobs.job_run import Build, BuildProgress, RunOptions
from pickcli.path_planning.planner_names import PlannerName
from pickcli.path_planning.planner_options import PlannerOptions
from pickcli.path_planning.sampling_planner import plan
from pickcli.precompute.empty_cell_checkers import checker
from pickcli.precompute.roadmap_builder import build_roadmap, nearest_pairs
from pickcli.precompute.roadmap_edge_job import RoadmapEdgeJob
from pickcli.precompute.roadmap_settings import RoadmapSettings
from pickcli.roadmap.trajectory_database import PayloadClass
from pickcli.seeds import derived_seed
from support.small_cell import FEW, small_cell
from support.tool_states import ALL_STATES

QUICK = RoadmapSettings(PlannerName.RRT_CONNECT, n_neighbours=2, max_iterations=2000, n_shortcuts=50)


def test_every_edge_is_proven_with_the_cells_clearance_in_every_tool_state() -> None:
    cell = small_cell()
    roadmap, _ = build_roadmap(RoadmapEdgeJob(cell, QUICK))
    model = CollisionModel(cell)
    assert roadmap.n_edges > 0
    for tool_state in ALL_STATES:
        tests = checker(model, tool_state, PayloadClass.EMPTY)
        for edge in range(roadmap.n_edges):
            path = roadmap.edge_path(edge)
            assert tests.is_valid_path(path)
            assert tests.is_valid_path(path[::-1])


def test_nodes_are_the_free_configurations_and_the_rest_is_reported_with_its_reason() -> None:
    roadmap, report = build_roadmap(RoadmapEdgeJob(small_cell(), QUICK))
    assert set(roadmap.names) == set(FEW) - {"tote_10h"}
    ((names, reason),) = report.gaps.refused
    assert reason.where == "tool anywhere from straight to down"
    assert names == ("tote_10h",)
    assert reason.what == "collision" and "tote" in reason.detail


def test_the_roadmap_is_connected_and_no_star() -> None:
    roadmap, report = build_roadmap(RoadmapEdgeJob(small_cell(), QUICK))
    graph = nx.Graph(roadmap.edges.tolist())
    assert nx.is_connected(graph) and report.n_components == 1
    home = roadmap.index("home")
    graph.remove_node(home)
    assert graph.number_of_edges() > 0


def test_parts_that_the_nearest_leave_apart_are_bridged_and_the_bridge_is_told() -> None:
    cell = small_cell("tote", "drop_01", "bin_G", "bin_J")
    roadmap, report = build_roadmap(RoadmapEdgeJob(cell, replace(QUICK, n_neighbours=1)))
    assert report.n_components == 1
    assert len(report.bridges) == 1
    assert roadmap.n_edges == 3 + len(report.routes.added)


def test_pairs_that_fail_are_told() -> None:
    cell = small_cell("home", "drop_00_down", "cam_D")
    hopeless = replace(QUICK, n_neighbours=2, max_iterations=0)
    roadmap, report = build_roadmap(RoadmapEdgeJob(cell, hopeless))
    told = dict(report.gaps.missing)
    assert "RRTConnect gave up after 0 iterations" in told["cam_D", "drop_00_down"].detail
    alone = dict(report.gaps.without_second_route)
    assert alone["cam_D", "drop_00_down"].what == "no route"
    assert roadmap.n_edges + len(told) == 3


def test_where_the_chosen_planner_gives_up_rrt_connect_tries() -> None:
    cell = small_cell("cam_G", "drop_10_down")
    one_tree = RoadmapSettings(PlannerName.RRT_STAR, max_iterations=500, n_shortcuts=50)
    job = RoadmapEdgeJob(cell, one_tree)
    ends = [cell.configurations[name].q for name in ("cam_G", "drop_10_down")]
    seed = derived_seed(one_tree.seed, "edge", "cam_G", "drop_10_down")
    alone = plan(
        job.checker, job.space, ends[0], ends[1][None],
        seed=seed, options=PlannerOptions(one_tree.planner, one_tree.max_iterations),
    )  # fmt: skip
    roadmap, report = build_roadmap(job)
    assert alone is None
    assert roadmap.n_edges == 1 and report.gaps.missing == ()


def test_the_order_of_the_configurations_changes_no_edge() -> None:
    cell = small_cell("home", "bin_A", "cam_D", "drop_00_down", "drop_02_down")
    turned = replace(cell, configurations=dict(reversed(cell.configurations.items())))
    edges = []
    for variant in (cell, turned):
        roadmap, _ = build_roadmap(RoadmapEdgeJob(variant, QUICK))
        named = {}
        for m, (a, b) in enumerate(roadmap.edges.tolist()):
            key = frozenset((roadmap.names[a], roadmap.names[b]))
            named[key] = float(roadmap.lengths[m])
        edges.append(named)
    assert edges[0] == edges[1]


def test_progress_counts_each_edge_once() -> None:
    job = RoadmapEdgeJob(small_cell("home", "bin_A", "drop_00_down", "tote"), QUICK)
    told: list[BuildProgress] = []
    roadmap, report = build_roadmap(job, Build(job, RunOptions(report=told.append)))
    assert [p.done for p in told] == list(range(int(told[-1].total) + 1))
    assert told[-1].total == roadmap.n_edges + len(report.gaps.missing)
    assert told[-1].coverage == 1.0 and told[-1].n_kept == 0


def test_nearest_pairs_name_each_pair_once() -> None:
    Q = np.array([[0.0], [1.0], [1.5], [9.0]])
    assert nearest_pairs(Q, 1) == [(0, 1), (1, 2), (2, 3)]
    assert len(nearest_pairs(Q, 50)) == 6


def test_a_cell_without_a_free_configuration_is_refused() -> None:
    with pytest.raises(InputError, match="no named configuration is free"):
        build_roadmap(RoadmapEdgeJob(small_cell("tote_10h"), QUICK))
