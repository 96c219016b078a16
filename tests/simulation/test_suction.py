"""The cup: seals, holds to its stated limits, breaks beyond them, and obeys the valve."""

from __future__ import annotations

import numpy as np
import pytest
from pedestal import BuildWorld, cube, evacuate

from pickcli.cell.robot import PivotState
from pickcli.geometry import Array
from pickcli.simulation.suction import BREAK_TIME
from pickcli.simulation.vacuum import FULL_VACUUM
from pickcli.simulation.world import World

DOWN, ASIDE = np.array([0.0, 0.0, -1.0]), np.array([0.0, 1.0, 0.0])
WEIGHT = 0.1 * 9.81


def push(world: World, force: Array, offset: Array, duration: float) -> None:
    """A force on the held cube at an offset from the tip, in world axes."""
    for _ in range(round(duration / world.time_step)):
        if world.held is None:
            return
        world.engine.push("cube", force, world.tip[:3, 3] + offset)
        world.step()


def twist(world: World, moment: float, duration: float) -> None:
    """A pure moment about the y axis: two opposite forces 0.1 m apart."""
    for _ in range(round(duration / world.time_step)):
        if world.held is None:
            return
        tip = world.tip[:3, 3]
        for side in (-0.05, 0.05):
            force = np.array([0.0, 0.0, np.sign(side) * moment / 0.1])
            world.engine.push("cube", force, tip + np.array([side, 0.0, 0.0]))
        world.step()


def test_the_load_is_the_weight_and_hangs_straight(holding: World) -> None:
    load = holding.suction.load
    assert load.pull == pytest.approx(WEIGHT, rel=0.01)
    assert load.shear == pytest.approx(0.0, abs=0.02)
    assert load.moment == pytest.approx(0.0, abs=0.002)
    assert holding.act("vacuum_sensor", "read") is True


@pytest.mark.parametrize(("share", "holds"), [(0.95, True), (1.06, False)])
def test_pull(holding: World, share: float, holds: bool) -> None:
    limit = holding.robot.tool.cup_limits.max_pull
    push(holding, DOWN * (share * limit - WEIGHT), np.zeros(3), 0.2)
    assert (holding.held == "cube") is holds


@pytest.mark.parametrize(("share", "holds"), [(0.93, True), (1.06, False)])
def test_shear(holding: World, share: float, holds: bool) -> None:
    push(holding, ASIDE * share * holding.robot.tool.cup_limits.max_shear, np.zeros(3), 0.2)
    assert (holding.held == "cube") is holds


@pytest.mark.parametrize(("share", "holds"), [(0.93, True), (1.06, False)])
def test_moment(holding: World, share: float, holds: bool) -> None:
    twist(holding, share * holding.robot.tool.cup_limits.max_moment, 0.2)
    assert (holding.held == "cube") is holds


@pytest.mark.parametrize(("share", "holds"), [(0.45, True), (0.56, False)])
def test_half_the_vacuum_holds_half(holding: World, share: float, holds: bool) -> None:
    vacuum = holding.suction.vacuum
    holding.act("pump", "off")
    vacuum.line = vacuum.cup = 0.5 * FULL_VACUUM
    push(holding, DOWN * (share * holding.robot.tool.cup_limits.max_pull - WEIGHT), np.zeros(3), 0.1)
    assert (holding.held == "cube") is holds


def test_a_peak_shorter_than_three_measured_steps_does_not_break_it(holding: World) -> None:
    push(holding, DOWN * 60.0, np.zeros(3), BREAK_TIME - 2 * holding.time_step)
    holding.wait(0.05)
    assert holding.held == "cube"


def test_breaking_away_is_reported_and_not_wanted(holding: World) -> None:
    push(holding, DOWN * 60.0, np.zeros(3), 0.1)
    (release,) = holding.suction.releases
    assert (release.item, release.is_wanted) == ("cube", False)
    assert release.load.pull > holding.robot.tool.cup_limits.max_pull


def test_the_valve_lets_go(holding: World) -> None:
    holding.act("valve", "off")
    holding.wait(0.15)
    assert holding.held is None
    (release,) = holding.suction.releases
    assert release.is_wanted
    holding.wait(0.2)
    assert holding.engine.pose("cube")[2, 3] < release.T_world_item[2, 3] - 0.1


def test_no_seal_without_vacuum_gap_or_face(build_world: BuildWorld) -> None:
    without_pump = build_world()
    without_pump.act("valve", "on")
    without_pump.wait(0.5)
    assert without_pump.held is None
    for world in (build_world(gap=0.003), build_world(shift=(0.01, 0.0))):  # too far; rim over the edge
        evacuate(world)
        world.act("valve", "on")
        world.wait(0.5)
        assert world.held is None
        assert world.act("vacuum_sensor", "read") is False


def test_within_the_gap_it_seals(build_world: BuildWorld) -> None:
    world = build_world(gap=0.001)
    evacuate(world)
    world.act("valve", "on")
    world.wait(0.4)
    assert world.held == "cube"


@pytest.mark.parametrize(("shift", "holds"), [(0.0, True), (-0.3, False), (0.3, False)])
def test_the_valve_must_open_at_the_contact(build_world: BuildWorld, shift: float, holds: bool) -> None:
    """A frontal pick by the rail alone: 40 mm towards the item, a quarter second on it, and back."""
    world = build_world(gap=0.04, pivot=PivotState.STRAIGHT)
    evacuate(world)
    speed, depth, dwell = world.robot.tool.contact_speed, 0.043, 0.25
    t_contact = world.t + depth / speed
    home = world.q.copy()
    is_opened = False
    start = world.t
    while world.t < t_contact + dwell + 0.3:
        if not is_opened and world.t >= t_contact - 0.05 + shift:
            world.act("valve", "on")
            is_opened = True
        forward = min(world.t - start, depth / speed) * speed
        back = max(0.0, world.t - t_contact - dwell)
        q = home.copy()
        q[0] += forward - min(1.0 * back**2, 0.25 * back)
        world.command(q)
        world.step()
    assert (world.held == "cube") is holds
    assert not world.suction.releases


def test_an_open_valve_drags_a_light_item_and_not_a_heavy_one(build_world: BuildWorld) -> None:
    moved = []
    for mass in (0.02, 1.0):
        world = build_world(cube(mass=mass), gap=0.004, shift=(0.012, 0.0))
        evacuate(world)
        before = world.engine.pose("cube")
        world.act("valve", "on")
        world.wait(0.3)
        moved.append(float(np.abs(world.engine.pose("cube") - before).max()))
        world.act("valve", "off")
    assert moved[0] > 1e-4
    assert moved[1] < 2e-5


def test_the_bellows_do_not_push_within_their_stroke(build_world: BuildWorld) -> None:
    for gap, pushes in ((-0.006, False), (-0.012, True)):
        world = build_world(cube(mass=0.05), gap=gap)
        world.engine.remove("pedestal")  # in free fall, a push would show at once
        world.wait(0.01)
        fallen = world.scene.items[0].T_world_item[2, 3] - world.engine.pose("cube")[2, 3]
        free = 0.5 * 9.81 * 0.01**2
        assert bool(fallen > 1.5 * free) is pushes
