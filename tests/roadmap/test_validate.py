"""What a store must hold to make sense: each law broken by itself, with checksums that are right."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.motion.trajectory import Trajectory
from pickcli.path_planning.state_space import LIMIT_TOLERANCE
from pickcli.roadmap import validate
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.trajectory_database import TrajectoryDatabase
from support.stored_samples import JOINTS, database, roadmap
from support.tool_states import ALL_STATES, STRAIGHT

ROADMAP, DATABASE = roadmap(), database()
assert DATABASE.points is not None
POINTS = DATABASE.points
CHECK_ROADMAP, CHECK_DATABASE = partial(validate.roadmap, ROADMAP), partial(validate.database, DATABASE)


def _cell(names: Any = JOINTS, lower: Any = -1.0, upper: Any = 1.0) -> Cell:
    """As much of a cell as validation needs."""
    limits = SimpleNamespace(
        lower=np.full(3, lower), upper=np.full(3, upper), velocity=np.ones(3), acceleration=np.ones(3)
    )
    robot = SimpleNamespace(
        joint_names=names, limits=limits, tool=SimpleNamespace(states_and_moving=ALL_STATES)
    )
    return cast(Cell, SimpleNamespace(robot=robot))


def _with(array: Any, place: Any, value: Any) -> Any:
    changed = np.array(array)
    changed[place] = value
    return changed


def test_what_our_own_builders_made_makes_sense() -> None:
    for cell in (None, _cell()):
        validate.roadmap(ROADMAP, cell)
        validate.roadmap(Roadmap.empty(JOINTS), cell)
        validate.database(DATABASE, cell)
        validate.database(replace(DATABASE, points=None), cell)
        validate.database(TrajectoryDatabase.of(JOINTS, []), cell)


def test_what_goes_straight_has_two_points_and_makes_sense() -> None:
    straight = Roadmap.empty(JOINTS)
    for q in ROADMAP.configurations[:2]:
        straight, _ = straight.with_node(q, "", STRAIGHT)
    validate.roadmap(straight.with_edge(0, 1, straight.configurations[[0, 1]]), _cell())
    motion = next(iter(DATABASE))
    assert motion.trajectory is not None and len(motion.path.waypoints) == 2
    timed = motion.trajectory
    ends = [array[[0, -1]] for array in (timed.times, timed.positions, timed.velocities, timed.accelerations)]
    validate.database(
        TrajectoryDatabase.of(JOINTS, [replace(motion, trajectory=Trajectory(JOINTS, *ends))]), _cell()
    )


def test_any_number_of_nodes_may_be_without_a_name() -> None:
    validate.roadmap(replace(ROADMAP, names=("",) * 6), None)
    validate.roadmap(replace(ROADMAP, names=("a", "b", "", "c", "d", "e")), None)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"names": ROADMAP.names[:5]}, "number of nodes"),
        ({"tool_states": ROADMAP.tool_states[:5]}, "number of nodes"),
        ({"lengths": ROADMAP.lengths[:4]}, "number of edges"),
        ({"validities": ROADMAP.validities[:4]}, "number of edges"),
        ({"offsets": ROADMAP.offsets[:5]}, "number of edges"),
        ({"offsets": _with(ROADMAP.offsets, 0, 1)}, "offsets do not divide"),
        ({"offsets": _with(ROADMAP.offsets, -1, 14)}, "offsets do not divide"),
        ({"offsets": _with(ROADMAP.offsets, -1, 16)}, "offsets do not divide"),
        ({"offsets": _with(ROADMAP.offsets, 1, 1)}, "offsets do not divide"),
        ({"offsets": _with(ROADMAP.offsets, 1, 5)}, "offsets do not divide"),
        ({"edges": _with(ROADMAP.edges, (4, 1), 6)}, "not there"),
        ({"edges": _with(ROADMAP.edges, (0, 0), -6)}, "not there"),
        ({"edges": _with(ROADMAP.edges, (0, 0), -1)}, "not there"),
        ({"edges": _with(ROADMAP.edges, (0, 0), 2)}, "does not join"),
        ({"edges": _with(ROADMAP.edges, (0, 1), 2)}, "does not join"),
        ({"edges": ROADMAP.edges[:, ::-1]}, "does not join"),
        ({"waypoints": _with(ROADMAP.waypoints, (0, 0), 0.0)}, "does not join"),
        ({"waypoints": _with(ROADMAP.waypoints, (2, 2), 0.0)}, "does not join"),
        ({"waypoints": _with(ROADMAP.waypoints, (1, 1), 0.0)}, "the length of an edge"),
        ({"waypoints": _with(ROADMAP.waypoints, (1, 1), np.inf)}, "finite"),
        ({"lengths": _with(ROADMAP.lengths, 3, 0.0)}, "the length of an edge"),
        ({"configurations": _with(ROADMAP.configurations, (5, 2), np.nan)}, "finite"),
        ({"configurations": ROADMAP.configurations[:, :2]}, "finite number per joint"),
        ({"joint_names": ("x", "y")}, "finite number per joint"),
        ({"names": ("a", "", "", "", "", "a")}, "same name"),
    ],
)
def test_a_roadmap_that_breaks_one_law_is_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        validate.roadmap(replace(ROADMAP, **change), None)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"tool_states": DATABASE.tool_states[:2]}, "number of motions"),
        ({"durations": DATABASE.durations[:2]}, "number of motions"),
        ({"offsets": DATABASE.offsets[:3]}, "number of motions"),
        ({"lower_bounds": DATABASE.lower_bounds[:2]}, "number of motions"),
        ({"clearances": DATABASE.clearances[:2]}, "number of motions"),
        ({"offsets": _with(DATABASE.offsets, 1, 1)}, "offsets do not divide"),
        ({"keys": (DATABASE.keys[0],) * 2 + DATABASE.keys[2:]}, "stored twice"),
        ({"keys": (DATABASE.keys[0], DATABASE.keys[0].reversed(), DATABASE.keys[2])}, "stored twice"),
        ({"durations": _with(DATABASE.durations, 1, 0.0)}, "not positive"),
        ({"durations": _with(DATABASE.durations, 1, -1.0)}, "not positive"),
        ({"durations": _with(DATABASE.durations, 1, np.inf)}, "not positive"),
        ({"durations": _with(DATABASE.durations, 1, np.nan)}, "not positive"),
        ({"lower_bounds": _with(DATABASE.lower_bounds, 1, -1e-9)}, "faster than its bound"),
        ({"lower_bounds": _with(DATABASE.lower_bounds, 1, 2.0 + 1e-9)}, "faster than its bound"),
        ({"lower_bounds": _with(DATABASE.lower_bounds, 1, np.nan)}, "faster than its bound"),
        ({"clearances": _with(DATABASE.clearances, 1, np.inf)}, "clearance no number"),
        ({"waypoints": _with(DATABASE.waypoints, (3, 1), np.nan)}, "finite"),
        ({"waypoints": DATABASE.waypoints[:, :2]}, "finite number per joint"),
    ],
)  # fmt: skip
def test_a_database_that_breaks_one_law_is_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        validate.database(replace(DATABASE, **change), None)


def test_a_motion_may_be_as_fast_as_its_bound_and_not_faster() -> None:
    validate.database(replace(DATABASE, lower_bounds=DATABASE.durations), None)
    for i, duration in enumerate(DATABASE.durations):
        above = _with(DATABASE.durations, i, np.nextafter(duration, np.inf))
        with pytest.raises(ValueError, match="faster than its bound"):
            validate.database(replace(DATABASE, lower_bounds=above), None)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"positions": POINTS.positions[:8]}, "number of points"),
        ({"velocities": POINTS.velocities[:8]}, "number of points"),
        ({"accelerations": POINTS.accelerations[:8]}, "number of points"),
        ({"times": POINTS.times[:8]}, "number of points"),
        ({"offsets": POINTS.offsets[:3]}, "number of motions"),
        ({"offsets": _with(POINTS.offsets, 1, 1)}, "point_offsets do not divide"),
        ({"offsets": _with(POINTS.offsets, 0, 1)}, "point_offsets do not divide"),
        ({"positions": _with(POINTS.positions, (4, 0), np.nan)}, "finite"),
        ({"velocities": _with(POINTS.velocities, (4, 0), np.nan)}, "finite"),
        ({"accelerations": _with(POINTS.accelerations, (4, 0), np.nan)}, "finite"),
        ({"times": _with(POINTS.times, 0, 0.1)}, "increase from 0"),
        ({"times": _with(POINTS.times, 3, 0.1)}, "increase from 0"),
        ({"times": _with(POINTS.times, 6, -0.1)}, "increase from 0"),
        ({"times": _with(POINTS.times, 1, 0.0)}, "increase from 0"),
        ({"times": _with(POINTS.times, 4, 2.0)}, "increase from 0"),
        ({"times": _with(POINTS.times, 8, 0.5)}, "increase from 0"),
        ({"times": _with(POINTS.times, 4, np.nan)}, "increase from 0"),
    ],
)
def test_timed_points_that_break_one_law_are_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        validate.database(replace(DATABASE, points=replace(POINTS, **change)), None)


def test_motions_have_at_least_two_waypoints_and_points() -> None:
    one = np.array([0, 1])
    with pytest.raises(ValueError, match="offsets do not divide"):
        validate.database(
            replace(
                TrajectoryDatabase.of(JOINTS, list(database())[:1]),
                waypoints=DATABASE.waypoints[:1],
                offsets=one,
            ),
            None,
        )


@pytest.mark.parametrize("side", ["lower", "upper"])
def test_every_configuration_lies_within_the_limits_of_its_joints(side: str) -> None:
    """But for the millionth of a radian that a measured start may lie outside."""
    for rows, check in ((ROADMAP.configurations, CHECK_ROADMAP), (DATABASE.waypoints, CHECK_DATABASE)):
        edge = float(rows.min() if side == "lower" else rows.max())
        inwards = 1.0 if side == "lower" else -1.0
        check(_cell(**{side: edge}))
        check(_cell(**{side: edge + inwards * 0.9e-6}))
        with pytest.raises(ValueError, match="outside of the joint limits"):
            check(_cell(**{side: edge + inwards * 1.1e-6}))


def test_a_cell_s_tool_has_every_state_that_a_store_speaks_of() -> None:
    sideways = ToolState("sideways")
    n, m = len(ROADMAP.tool_states), len(DATABASE.tool_states)
    for at in range(n):
        states = (*ROADMAP.tool_states[:at], sideways, *ROADMAP.tool_states[at + 1 :])
        _refused_for_its_state(partial(validate.roadmap, replace(ROADMAP, tool_states=states)))
    _refused_for_its_state(partial(validate.roadmap, replace(ROADMAP, proven_for=sideways)))
    for at in range(m):
        states = (*DATABASE.tool_states[:at], sideways, *DATABASE.tool_states[at + 1 :])
        _refused_for_its_state(partial(validate.database, replace(DATABASE, tool_states=states)))


def _refused_for_its_state(check: Callable[[Cell | None], None]) -> None:
    check(None)
    with pytest.raises(ValueError, match="the tool of the cell has no state 'sideways'"):
        check(_cell())


@pytest.mark.parametrize(("off", "is_refused"), [(0.9e-9, False), (-0.9e-9, False), (1.1e-9, True)])
def test_an_edge_is_as_long_as_its_polyline_to_a_billionth(off: float, is_refused: bool) -> None:
    longer = replace(ROADMAP, lengths=_with(ROADMAP.lengths, 2, ROADMAP.lengths[2] + off))
    if is_refused:
        with pytest.raises(ValueError, match="the length of an edge"):
            validate.roadmap(longer, None)
    else:
        validate.roadmap(longer, None)


def test_joints_of_another_order_are_refused() -> None:
    for check in (CHECK_ROADMAP, CHECK_DATABASE):
        with pytest.raises(ValueError, match="its joints are x y z, not z y x"):
            check(_cell(("z", "y", "x")))


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_configuration_may_lie_exactly_where_the_tolerance_ends(sign: float) -> None:
    last = sign * (1.0 + LIMIT_TOLERANCE)
    for q, is_inside in ((last, True), (np.nextafter(last, 2.0 * sign), False)):
        built, _ = Roadmap.empty(JOINTS).with_node(np.array([0.0, q, 0.0]), "", STRAIGHT)
        if is_inside:
            validate.roadmap(built, _cell())
        else:
            with pytest.raises(ValueError, match="outside of the joint limits"):
                validate.roadmap(built, _cell())
