"""A* is optimal on small areas, by networkx; heuristic and edges keep what they promise."""

from __future__ import annotations

import networkx
import numpy as np
import pytest

from bench.driving import random_area
from pickcli.driving.driving_area import DrivingArea, FloorBox
from pickcli.driving.free_space_proof import first_encounter
from pickcli.driving.lattice_search import CUSP_COST, LatticeSearch
from pickcli.driving.motion_primitives import N_HEADINGS
from pickcli.driving.state_lattice import StateLattice
from pickcli.driving.steering_path import SteeringPath, posed, seen_from, wrapped
from pickcli.driving.tricycle import Tricycle

TRUCK = Tricycle(wheel_base=0.6, front=0.8, back=0.2, width=0.5)  # a small one, for small areas
BOX = FloorBox("box", (2.0, 0.9), (0.1, 0.1), 0.3)
START, GOAL = np.array([0.6, 0.7, 0.2]), np.array([0.9, 1.2, 0.4])
SMALL = {
    "past a box": DrivingArea((0.0, 0.0), (2.8, 2.0), (BOX,), START, np.array([1.5, 1.5, 0.1]), truck=TRUCK),
    "turned round": DrivingArea((0.0, 0.0), (2.4, 2.2), (), START, np.array([1.4, 1.2, 2.8]), truck=TRUCK),
    "end backwards": DrivingArea((0.0, 0.0), (2.4, 2.0), (), START, GOAL, -0.2, truck=TRUCK),
}


def whole_graph(lattice: StateLattice, search: LatticeSearch) -> networkx.DiGraph:
    """All states that the start leads to, with the costs of the edges between them."""
    n_y, (i, j) = lattice.shape[1], lattice.origin.tolist()
    graph, waiting = networkx.DiGraph(), []
    started = lattice.start_edges(search.start)
    assert started is not None
    for k in np.flatnonzero(lattice.are_free(started)).tolist():
        end = (int((i * n_y + j) * N_HEADINGS + started.places[k]), int(started.directions[k]))
        if float(started.travel[k]) < graph.get_edge_data("start", end, {"weight": np.inf})["weight"]:
            graph.add_edge("start", end, weight=float(started.travel[k]))
        waiting.append(end)
    seen = set(waiting)
    while waiting:
        place, direction = waiting.pop()
        cell, heading = divmod(place, N_HEADINGS)
        edges = lattice.edges[heading]
        for k in np.flatnonzero(lattice.are_free(edges, divmod(cell, n_y))).tolist():
            end = (int(cell * N_HEADINGS + edges.places[k]), int(edges.directions[k]))
            cost = float(edges.travel[k]) + CUSP_COST * (direction != edges.directions[k])
            if cost < graph.get_edge_data((place, direction), end, {"weight": np.inf})["weight"]:
                graph.add_edge((place, direction), end, weight=cost)
            if end not in seen:
                seen.add(end)
                waiting.append(end)
    goal = (i * n_y + j) * N_HEADINGS
    straight = lattice.area.straight
    for direction in (0, 1):
        has_cusp = straight != 0 and (direction == 1) != (straight > 0)
        graph.add_edge((goal, direction), "goal", weight=CUSP_COST * has_cusp)
    return graph


@pytest.mark.parametrize("name", SMALL)
def test_the_path_costs_as_little_as_any_and_the_heuristic_is_admissible(name: str) -> None:
    area = SMALL[name]
    lattice = StateLattice(area, posed(area.goal, np.array([-area.straight, 0.0, 0.0])))
    search = LatticeSearch(lattice, area.start)
    found = search.run()
    graph = whole_graph(lattice, search)
    to_goal = networkx.single_source_dijkstra_path_length(graph.reverse(copy=False), "goal")
    assert found is not None and len(graph) > 500
    assert found.cost == pytest.approx(to_goal["start"], abs=1e-9)
    states = [(place, cost) for (place, *_), cost in to_goal.items() if isinstance(place, int)]
    bounds = np.array([search.heuristic[place] for place, _ in states])
    assert (bounds <= np.array([cost for _, cost in states]) + 1e-9).all()
    assert np.median(bounds) > 0.3
    for begin, end, cost in graph.edges(data="weight"):
        if isinstance(begin, tuple) and isinstance(end, tuple):
            assert search.heuristic[begin[0]] <= cost + search.heuristic[end[0]] + 1e-9


@pytest.mark.parametrize("seed", range(3))
def test_edges_taken_for_free_are_free_by_exact_shapes(seed: int) -> None:
    area = random_area(seed)
    lattice = StateLattice(area, area.goal)
    rng, n_free = np.random.default_rng(seed), 0
    for _ in range(60):
        cell = tuple((lattice.origin + rng.integers(-40, 40, 2)).tolist())
        if min(cell) < 0 or cell[0] >= lattice.shape[0] or cell[1] >= lattice.shape[1]:
            continue
        heading = int(rng.integers(N_HEADINGS))
        edges, pose = lattice.edges[heading], lattice.pose(cell, heading)
        if not area.wall_distance(pose[:2]) > 0:
            continue
        for k in np.flatnonzero(lattice.are_free(edges, cell))[::7].tolist():
            n_free += 1
            assert first_encounter(area, SteeringPath(area.truck, pose, *edges.path(k)), area.margin) is None
    assert n_free > 10


@pytest.mark.parametrize("seed", range(4))
def test_a_path_leads_from_start_to_goal(seed: int) -> None:
    area = random_area(seed)
    found = LatticeSearch(StateLattice(area, area.goal), area.start).run()
    assert found is not None
    np.testing.assert_array_equal(found.path.start, area.start)
    error = seen_from(area.goal, found.path.end)
    error[2] = wrapped(error[2])
    np.testing.assert_allclose(error, 0.0, atol=1e-8)
    assert found.cost == pytest.approx(found.path.length + CUSP_COST * len(found.path.cusps))
    assert first_encounter(area, found.path, area.margin) is None
