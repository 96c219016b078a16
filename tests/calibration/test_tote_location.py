"""The tote located by touch in the simulated world, and why it is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.calibration.tote_location import (
    TOLERANCE,
    LocatedTote,
    LocatingSettings,
    locate_in_simulation,
    locate_tote,
    shifted_tote,
    simulated_tote_world,
    tote_offset,
    tote_pose_in_simulation,
)
from pickcli.calibration.tote_shape import tote_shape
from pickcli.calibration.touch_points import touch_points
from pickcli.cell.cell_file import load_cell
from pickcli.cell.pod_tolerance import Displacement
from pickcli.cell.shapes import box
from pickcli.cell.station import Obstacles
from pickcli.errors import InputError
from pickcli.geometry import Array, pose
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import empty_scene

CELL = load_cell("apc2016_delft")
SHIFT = Displacement(0.012, -0.02, 0.03)


def test_random_poses_are_within_the_tolerance_and_follow_the_seed() -> None:
    nominal = shifted_tote(CELL, Displacement())
    drawn = [tote_pose_in_simulation(CELL, "random", seed) for seed in range(50)]
    offsets = np.array([[*tote_offset(nominal, T, ("x", "y", "yaw")).values()] for T in drawn])
    most = np.array([TOLERANCE.x, TOLERANCE.y, TOLERANCE.yaw])
    assert (np.abs(offsets) <= most).all() and (np.abs(offsets).max(axis=0) > 0.8 * most).all()
    np.testing.assert_array_equal(drawn[3], tote_pose_in_simulation(CELL, "random", 3))
    np.testing.assert_array_equal(nominal, tote_pose_in_simulation(CELL, None, 3))
    np.testing.assert_array_equal(nominal, tote_pose_in_simulation(CELL, "none", 3))


@pytest.mark.parametrize(
    "shift", [Displacement(0.031), Displacement(0.0, -0.04), Displacement(0.0, 0.0, 0.06)]
)
def test_a_displacement_beyond_what_touches_reach_is_refused(shift: Displacement) -> None:
    with pytest.raises(
        InputError, match=r"--tote-shift: .* is beyond what touches reach: 30 mm, 30 mm and 3 deg"
    ):
        tote_pose_in_simulation(CELL, shift, 0)


def test_offsets_are_in_the_frame_of_the_first_pose() -> None:
    T = pose((1.0, 2.0, 0.0), rpy=(0.0, 0.0, np.pi / 2))
    off = tote_offset(T, T @ pose((0.01, 0.02, 0.03), rpy=(0.001, 0.002, 0.3)), ("x", "z", "yaw", "pitch"))
    assert [*off] == ["x", "z", "yaw", "pitch"]
    assert [*off.values()] == pytest.approx([0.01, 0.03, 0.3, 0.002])


def test_a_tool_without_a_cup_is_refused() -> None:
    cell = load_cell("apc2016_delft_pinch", "fingers")
    T = shifted_tote(cell, Displacement())
    with pytest.raises(InputError, match="apc2016_delft_pinch: its tool has no cup"):
        locate_in_simulation(PlanningContext(cell), T, LocatingSettings(), 0)


@pytest.fixture(scope="module")
def located() -> tuple[LocatedTote, Array]:
    T = shifted_tote(CELL, SHIFT) @ pose((0.0, 0.0, 0.001))
    return locate_in_simulation(PlanningContext(CELL), T, LocatingSettings(6), 8), T


@pytest.mark.slow
def test_a_displaced_tote_is_located_within_its_bounds(located: tuple[LocatedTote, Array]) -> None:
    found, T = located
    estimate = found.estimate
    off = np.array([*tote_offset(estimate.T_world_tote, T).values()])
    assert (np.abs(off) <= estimate.bounds).all()
    assert (estimate.bounds <= [0.002, 0.002, 0.002, 0.01]).all()
    assert found.collisions == () and len(found.touches) == 6 and 20.0 < found.duration < 60.0
    assert max(touch.record.most_force for touch in found.touches) < 6.5


@pytest.mark.slow
def test_something_that_stands_at_a_wall_is_refused_before_the_rim_is_touched() -> None:
    """A board that nobody knows of, 8 mm before the wall where the second touch is to be."""
    scene, T = empty_scene(CELL), shifted_tote(CELL, Displacement())
    aim = touch_points(tote_shape(CELL), 8, CELL.robot.tool.grip.tip_radius)[1]
    x, y, z = (T @ [*aim.point, 1.0])[:3]
    board = box("board", (x - 0.04, y - 0.008, z - 0.06), (x + 0.04, y, z + 0.04))
    obstacles = Obstacles((*CELL.obstacles.bodies, board))
    world = simulated_tote_world(replace(scene, cell=replace(CELL, obstacles=obstacles)), T, 1)
    try:
        with pytest.raises(InputError, match=f"[:r] {aim.name} .*met something else"):
            locate_tote(PlanningContext(CELL), scene, world, LocatingSettings(8), 1)
        assert {each.b for each in world.contacts.collisions} == {"board"} and world.t < 40.0
    finally:
        world.close()


@pytest.mark.slow
def test_a_missing_tote_is_refused() -> None:
    scene = empty_scene(CELL)
    world = simulated_tote_world(scene, shifted_tote(CELL, Displacement()) @ pose((0.0, 0.0, -0.3)), 1)
    try:
        with pytest.raises(
            InputError, match="touch 1 wall left met nothing: the tote is displaced by more than"
        ):
            locate_tote(PlanningContext(CELL), scene, world, LocatingSettings(6), 1)
    finally:
        world.close()
