"""The load that the simulation measures, against sums worked out by hand."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.item import Item
from pickcli.geometry import GRAVITY, Array, inverse
from pickcli.simulation.world import World
from support.pedestal import BuildWorld, cube, evacuate
from support.tool_states import STRAIGHT

MASS, SIZE = 0.4, (0.12, 0.10, 0.05)  # kg, m; the cup sits on the +z or -z face
INERTIA = MASS * (SIZE[0] ** 2 + SIZE[1] ** 2) / 12.0  # kg m^2 about the axis across that face


def box_item() -> Item:
    return cube(mass=MASS, size=SIZE)


def hold(world: World) -> World:
    """Seal, take the support away and let it come to rest."""
    evacuate(world)
    world.act("valve", "on")
    world.wait(0.4)
    assert world.held == "cube"
    world.engine.remove("pedestal")
    world.wait(0.2)
    return world


def lever(world: World) -> float:
    """How far the centre of mass lies in front of the tip of the uncompressed cup, m."""
    return float((inverse(world.tip) @ world.engine.pose("cube"))[2, 3])


def accelerated(world: World, joint: int, acceleration: float, duration: float = 0.3) -> Array:
    """Mean wrench (6,) in the second half of a constant acceleration of one joint.

    The command's acceleration is built up smoothly, in the first quarter.
    """
    home, steps = world.q.copy(), round(duration / world.time_step)
    shape = np.minimum(1.0, np.arange(steps) / (steps / 4))
    travel = acceleration * np.cumsum(np.cumsum(shape)) * world.time_step**2
    wrenches = []
    for way in travel:
        world.command(home + way * (np.arange(8) == joint))
        world.step()
        wrenches.append(world.suction.load.wrench)
    assert world.held == "cube"
    return np.asarray(np.mean(wrenches[steps // 2 :], axis=0))


@pytest.mark.parametrize("aside", [(0.0, 0.0), (0.02, 0.0), (0.01, -0.03)])
def test_top_down_at_rest_the_weight_pulls_and_its_lever_bends(
    build_world: BuildWorld, aside: tuple[float, float]
) -> None:
    load = hold(build_world(box_item(), shift=aside)).suction.load
    weight = MASS * GRAVITY
    assert load.pull == pytest.approx(weight, rel=0.01)
    assert load.bending == pytest.approx(weight * float(np.hypot(*aside)), rel=0.05, abs=0.003)
    assert load.shear < 0.05 and load.twist < 0.005


def test_in_front_at_rest_the_weight_shears_and_bends_with_its_lever(build_world: BuildWorld) -> None:
    world = hold(build_world(box_item(), tool_state=STRAIGHT))
    load, weight = world.suction.load, MASS * GRAVITY
    assert load.shear == pytest.approx(weight, rel=0.01)
    assert load.bending == pytest.approx(weight * lever(world), rel=0.02)
    assert lever(world) == pytest.approx(SIZE[2] / 2, abs=2e-3)  # pressed in by up to 2 mm
    assert abs(load.pull) < 0.05 and load.twist < 0.005


def test_in_front_beside_the_axis_the_weight_twists(build_world: BuildWorld) -> None:
    load = hold(build_world(box_item(), tool_state=STRAIGHT, shift=(0.02, 0.0))).suction.load
    assert load.twist == pytest.approx(MASS * GRAVITY * 0.02, rel=0.05)


def test_acceleration_away_from_the_item_pulls(build_world: BuildWorld) -> None:
    world = hold(build_world(box_item(), tool_state=STRAIGHT))
    wrench = accelerated(world, 0, -1.5)
    assert wrench[2] == pytest.approx(-MASS * 1.5, rel=0.05)


def test_acceleration_across_shears_and_bends(build_world: BuildWorld) -> None:
    world = hold(build_world(box_item()))
    rest = world.suction.load.wrench
    wrench = accelerated(world, 0, -1.5) - rest
    assert float(np.hypot(wrench[0], wrench[1])) == pytest.approx(MASS * 1.5, rel=0.05)
    assert float(np.hypot(wrench[3], wrench[4])) == pytest.approx(MASS * 1.5 * lever(world), rel=0.05)


def test_turning_about_the_axis_twists_with_the_inertia(build_world: BuildWorld) -> None:
    world = hold(build_world(box_item(), tool_state=STRAIGHT))
    wrench = accelerated(world, 7, 8.0)
    assert abs(wrench[5]) == pytest.approx(INERTIA * 8.0, rel=0.05)


def test_a_fine_time_step_measures_the_same(build_world: BuildWorld) -> None:
    peaks = []
    for time_step in (1e-3, 0.25e-3):
        world = hold(build_world(box_item(), time_step=time_step, shift=(0.02, 0.01)))
        home, start, wrenches = world.q.copy(), world.t, []
        while world.t - start < 0.6:
            way = np.sin(np.pi * (world.t - start) / 0.6) ** 2 * np.array([-0.05, *[0.06] * 7])
            world.command(home + way)
            world.step()
            wrenches.append(world.suction.load.wrench)
        peaks.append(np.abs(wrenches).max(axis=0))
    assert np.allclose(peaks[0][:3], peaks[1][:3], rtol=0.05, atol=0.02)
    assert np.allclose(peaks[0][3:], peaks[1][3:], rtol=0.05, atol=0.001)
