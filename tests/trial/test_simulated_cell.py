"""The simulated arena: truth comes out of it, refusals are stops, time passes only inside."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.shapes import box
from pickcli.cell.tool import ToolState
from pickcli.geometry import pose
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.start_state import Start
from pickcli.simulation.grip import Release
from pickcli.simulation.places import OUTSIDE
from pickcli.simulation.protective_stop import StopCause
from pickcli.simulation.suction import NO_LOAD
from pickcli.trial.disturbance import DisturbanceKind
from pickcli.trial.simulated_cell import SimulatedArena
from pickcli.trial.trial_interfaces import LONGEST_RELEASE
from support.order_builders import pick_order
from support.scripted_trial import ScriptedTrial, scene_of
from support.tool_states import DOWN, STRAIGHT

ORDER = pick_order({"bin_A": ("crayola_24_ct",)}, ("bin_A", "crayola_24_ct"))


@pytest.fixture
def arena() -> SimulatedArena:
    return SimulatedArena(scene_of(ORDER, load_cell("apc2016_delft")))


def test_it_starts_at_home_with_everything_in_its_place(arena: SimulatedArena) -> None:
    scene = arena.now()
    np.testing.assert_allclose(arena.q, scene.cell.configurations["home"].q, atol=1e-9)
    assert arena.tool_state == STRAIGHT
    assert arena.held is None
    assert [(i.id, i.location) for i in scene.items] == [("crayola_24_ct", "bin_A")]


def test_a_plan_from_elsewhere_is_a_stop_and_moves_nothing(arena: SimulatedArena) -> None:
    cell = arena.now().cell
    fake = ScriptedTrial(arena.now())
    query, start = PickQuery("bin_A", "crayola_24_ct"), Start(arena.q, arena.tool_state)
    plan = fake.plan(arena.now(), query, start, 0, lambda plan: plan)
    before = arena.q.copy()
    done = arena.execute(replace(plan, cell_fingerprint=cell.fingerprint))
    assert "refusing to start" in done.stopped
    assert done.duration == 0.0
    np.testing.assert_array_equal(arena.q, before)


def rail_forward(arena: SimulatedArena, distance: float, tool_state: ToolState = STRAIGHT) -> Plan:
    """From where the robot stands along the rail, in a second."""
    cell, q = arena.now().cell, arena.q
    ends = np.stack([q, q + distance * (np.arange(8) == 0)])
    still = np.zeros((2, 8))
    trajectory = Trajectory(cell.robot.joint_names, np.array([0.0, 1.0]), ends, still, still)
    segments = (Segment(SegmentKind.TRANSIT, 0.0, 1.0, tool_state, None),)
    return Plan("forward", cell.fingerprint, "", 0, segments, trajectory, ())


def wall_ahead(arena: SimulatedArena, gap: float) -> None:
    """A wall nobody knows of, that far before the cup."""
    x, y, z = arena._world.tip[:3, 3]
    wall = box("wall", (x + gap, y - 0.2, z - 0.2), (x + gap + 0.1, y + 0.2, z + 0.2))
    arena._world.engine.add_static(wall, np.eye(4), (1.0, 1.0, 1.0, 1.0))


def test_a_plan_that_begins_with_the_cup_otherwise_is_a_stop_too(arena: SimulatedArena) -> None:
    done = arena.execute(rail_forward(arena, 0.01, DOWN))
    assert "refusing to start" in done.stopped and "cup" in done.stopped
    assert done.duration == 0.0 and arena._world.t == 0.0


def test_a_contact_that_grows_after_the_motion_is_told_once_with_all_its_force(arena: SimulatedArena) -> None:
    wall_ahead(arena, 0.02)
    done = arena.execute(rail_forward(arena, 0.03))
    assert done.stop_cause is StopCause.CONTACT and done.collisions
    n_before = len(arena.collisions)
    arena._world.command(arena.q + 0.012 * (np.arange(8) == 0))  # a drive that creeps on
    arena.wait(0.3)
    grown = arena.collisions[-1]
    assert grown.b == "wall" and grown.t_end == pytest.approx(arena._world.t)
    assert grown.force > 2.0 * max(c.force for c in done.collisions)
    arena.wait(0.3)
    assert len(arena.collisions) <= n_before + 1


def test_a_contact_that_begins_while_the_robot_waits_is_told(arena: SimulatedArena) -> None:
    assert not arena.collisions
    wall_ahead(arena, 0.005)
    arena._world.command(arena.q + 0.02 * (np.arange(8) == 0))
    arena.wait(0.2)
    assert {c.b for c in arena.collisions} == {"wall"}
    # It goes on in what is carried out next, and is in its record, but it is the same contact.
    again = arena.release()
    assert again.collisions == arena.collisions


def test_what_the_cup_was_to_touch_it_may_go_on_touching_where_it_stands(arena: SimulatedArena) -> None:
    wall_ahead(arena, 0.02)
    plan = rail_forward(arena, 0.022)
    touching = replace(plan.segments[0], touching=("wall",))
    done = arena.execute(replace(plan, segments=(touching,)))
    arena.wait(0.2)
    assert done.stopped == "" and arena.collisions == ()


def test_a_fall_is_over_before_it_is_told_and_told_once() -> None:
    scene, item, height = scene_of(ORDER, load_cell("apc2016_delft")), "crayola_24_ct", 2.2
    T = pose((-0.5, -1.5, height))
    arena = SimulatedArena(scene.moved(replace(scene.find(item), T_world_item=T)))
    world, act = arena._world, arena._world.act

    def let_go(device: str, action: str) -> bool | None:
        if (device, action) == ("valve", "off"):
            # Twice: what is left of the vacuum draws it on once more.
            world.suction.releases += 2 * [Release(item, world.t, True, T, NO_LOAD)]
        return act(device, action)

    world.act = let_go  # type: ignore[method-assign]
    told = arena.release()
    world.act = act  # type: ignore[method-assign]
    (drop,) = told.drops
    assert drop.height == pytest.approx(height, abs=0.1) and told.disturbed == ()
    assert told.duration > LONGEST_RELEASE
    arena.wait(0.5)
    after = arena.release()
    assert after.drops == () and after.disturbed == ()


def test_what_falls_while_the_robot_stands_is_told_and_by_the_next_record_too() -> None:
    scene, item = scene_of(ORDER, load_cell("apc2016_delft")), "crayola_24_ct"
    hanging = replace(scene.find(item), location=OUTSIDE, T_world_item=pose((-0.5, -1.5, 1.0)))
    arena = SimulatedArena(scene.moved(hanging))
    assert arena.disturbed() == ()
    arena.wait(1.0)
    (fallen,) = arena.disturbed()
    assert (fallen.item, fallen.kind, fallen.into) == (item, DisturbanceKind.FELL, OUTSIDE)
    assert fallen.fell == pytest.approx(1.0, abs=0.1)
    assert [d.item for d in arena.release().disturbed] == [item]
    assert arena.disturbed() == ()


def test_letting_go_takes_simulated_time(arena: SimulatedArena) -> None:
    assert arena.release().duration == pytest.approx(LONGEST_RELEASE)


def test_the_picture_shows_something(arena: SimulatedArena) -> None:
    picture = arena.picture()
    assert picture.ndim == 3 and picture.shape[2] == 3
    assert picture.std() > 5.0
