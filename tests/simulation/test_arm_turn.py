"""Two arms in one world: one moves, the other stands in its way, and they take turns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell import ArmState, Cell
from pickcli.cell.cell_file import load_workcell
from pickcli.cell.workcell import Workcell
from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.simulation.arm_turn import let_move
from pickcli.simulation.servo import IDEAL
from pickcli.simulation.world import World
from support.two_arms import write_two_arms

ACROSS = "across"  # where the arms meet, if both are there


@pytest.fixture
def arms(tmp_path: Path) -> Workcell:
    return load_workcell(write_two_arms(tmp_path))


def world_of(cell: Cell, name: str) -> World:
    named = cell.configurations[name]
    scene = Scene(cell, np.eye(4), (), PoseNoise())
    return World(scene, named.q, named.tool_state, servo=IDEAL)


def move(world: World, name: str, seconds: float = 1.0) -> None:
    """Straight through joint space."""
    start, goal = world.q.copy(), world.scene.cell.configurations[name].q
    n = round(seconds / world.time_step)
    for share in np.linspace(0.0, 1.0, n):
        world.command(start + share * (goal - start))
        world.step()
    world.wait(0.2)


def sides_that_met(world: World) -> set[frozenset[str]]:
    return {frozenset((c.a.partition("_")[0], c.b.partition("_")[0])) for c in world.contacts.collisions}


def test_the_arm_that_stands_is_met_and_told(arms: Workcell) -> None:
    across = arms.arms["right"].configurations[ACROSS]
    world = world_of(arms.cell("left", [ArmState("right", across.q, across.tool_state)]), "parked")
    move(world, ACROSS)
    assert sides_that_met(world) == {frozenset(("left", "right"))}
    world.close()


def test_arms_take_turns_in_one_world(arms: Workcell) -> None:
    world = world_of(arms.cell("left"), "parked")
    move(world, "home")
    move(world, "parked")
    t = world.t
    let_move(world, arms.cell("right"))
    assert world.t == t
    np.testing.assert_allclose(world.q, arms.parked["right"].q, atol=1e-9)
    move(world, "home")
    np.testing.assert_allclose(world.q, arms.arms["right"].configurations["home"].q, atol=1e-3)
    assert world.scene.cell.arm == "right" and not world.contacts.collisions
    world.close()


def test_what_was_met_before_a_turn_stays_told(arms: Workcell) -> None:
    across = arms.arms["right"].configurations[ACROSS]
    standing = ArmState("right", across.q, across.tool_state)
    world = world_of(arms.cell("left", [standing]), "parked")
    move(world, ACROSS)
    move(world, "parked")
    met = sides_that_met(world)
    assert met
    let_move(world, arms.cell("right"))
    assert sides_that_met(world) == met
    np.testing.assert_allclose(world.q, across.q, atol=1e-9)
    world.close()


def test_an_arm_that_is_not_where_it_is_parked_keeps_the_turn(arms: Workcell) -> None:
    world = world_of(arms.cell("left"), "home")
    with pytest.raises(InputError, match=r"arm left stands 1\.\d+ rad or m from where"):
        let_move(world, arms.cell("right"))
    assert world.scene.cell.arm == "left"
    world.close()


@pytest.mark.parametrize("name", ["apc2016_delft_pinch", "apc2016_kth_picking"])
def test_torques_are_those_of_the_arm_that_moves_after_any_number_of_turns(name: str) -> None:
    workcell = load_workcell(name)
    worlds = {arm: world_of(cell, "home") for arm, cell in workcell.arms.items()}
    first, *_ = worlds
    needed = {arm: at_rest(world) for arm, world in worlds.items()}
    world = world_of(workcell.arms[first], "home")
    for arm in [*reversed(worlds), *worlds] * 8:
        if arm != world.scene.cell.arm:
            let_move(world, workcell.arms[arm])
        np.testing.assert_allclose(at_rest(world), needed[arm], atol=1e-6)
    for each in (world, *worlds.values()):
        each.close()


def at_rest(world: World) -> Array:
    """Torques that hold the arm in its home configuration."""
    still = np.zeros(len(world.joints))
    return world.inverse_dynamics(world.joints, still, still)


def test_another_tool_on_the_flange_goes_on_where_the_arm_stands() -> None:
    workcell = load_workcell("apc2016_delft_pinch")
    world = world_of(workcell.arms["suction"], "home")
    home = world.q.copy()
    goal = home + 0.004
    for share in np.linspace(0.0, 1.0, 200):
        world.command(home + share * (goal - home))
        world.step()
    world.wait(0.2)
    stood = world.q.copy()
    let_move(world, workcell.arms["fingers"])
    np.testing.assert_array_equal(world.q, stood)
    assert np.abs(stood - home).max() > 0.003 and world.tool_state.name == "closed"
    world.close()
