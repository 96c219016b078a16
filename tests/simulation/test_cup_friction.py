"""Friction of the lip: it sticks below Coulomb's limit, slides above it, and sticks anew where it stopped."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.geometry import Array
from pickcli.simulation.bellows import FRICTION
from pickcli.simulation.cup_friction import CupFriction
from pickcli.simulation.world import World
from support.pedestal import BuildWorld, cube

NORMAL = 2.0  # N between lip and face
ASIDE = np.array([0.0, 1.0, 0.0])


def on_ice(build_world: BuildWorld) -> World:
    """A cube of 0.1 kg before the cup, on a pedestal without friction."""
    world = build_world(gap=0.0005)
    world.engine._dynamics("cube", lateralFriction=0.0)
    return world


def drag(world: World, friction: CupFriction, force: float, duration: float) -> list[float]:
    """Displacement of the cube along the force in each step, m."""
    start = world.engine.pose("cube")[:3, 3]
    moved = []
    for _ in range(round(duration / world.time_step)):
        world.engine.apply_force("cube", force * ASIDE, world.engine.pose("cube")[:3, 3])
        friction.apply("cube", world.tip, NORMAL)
        world.step()
        moved.append(float((world.engine.pose("cube")[:3, 3] - start) @ ASIDE))
    return moved


def lip(world: World) -> CupFriction:
    return CupFriction(world.engine, "robot", world.robot.tool)


@pytest.mark.parametrize("share", [0.3, 0.9])
def test_below_the_limit_it_stands_and_does_not_creep(build_world: BuildWorld, share: float) -> None:
    world = on_ice(build_world)
    moved = drag(world, lip(world), share * FRICTION * NORMAL, 1.0)
    assert abs(moved[-1]) < 1e-3
    assert moved[-1] == pytest.approx(moved[len(moved) // 2], abs=2e-5)


def test_above_the_limit_it_slides_under_the_excess_only(build_world: BuildWorld) -> None:
    world, limit = on_ice(build_world), FRICTION * NORMAL
    moved = drag(world, lip(world), 1.2 * limit, 0.2)
    excess = 0.2 * limit / 0.1  # m/s^2
    assert moved[-1] == pytest.approx(excess * 0.2**2 / 2, rel=0.15)


def test_where_it_stopped_it_sticks_anew(build_world: BuildWorld) -> None:
    world, limit = on_ice(build_world), FRICTION * NORMAL
    friction = lip(world)
    slid = drag(world, friction, 1.2 * limit, 0.1)[-1]
    back: Array = np.array(drag(world, friction, 0.0, 0.5))
    assert abs(back[-1]) < slid
    assert float(np.ptp(back[len(back) // 2 :])) < 2e-5


@pytest.mark.parametrize(("share", "stands"), [(0.8, True), (1.3, False)])
def test_a_relaxed_cup_holds_what_it_presses_on_however_light(
    build_world: BuildWorld, share: float, stands: bool
) -> None:
    """20 g on a pedestal without friction, under bellows without vacuum."""
    world = build_world(cube(mass=0.02), gap=-0.002)
    world.engine._dynamics("cube", lateralFriction=0.0)
    world.wait(0.1)
    limit = FRICTION * 0.002 * world.robot.tool.cup.stiffness
    before = world.engine.pose("cube")[:3, 3]
    for _ in range(round(0.1 / world.time_step)):
        world.engine.apply_force("cube", share * limit * ASIDE, world.engine.pose("cube")[:3, 3])
        world.step()
    moved = float((world.engine.pose("cube")[:3, 3] - before) @ ASIDE)
    assert (abs(moved) < 2e-3) is stands
