"""The hand in the engine against sums by hand: pull of belts, slip, weight on the wrist, impedance."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.geometry import GRAVITY, Array
from pickcli.hand.belt_hand import BeltHand
from pickcli.hand.grasp_world import GraspWorld, Standing, WorldDeviation
from pickcli.hand.hand_urdf import pad_offset
from support.belt_hands import HAND, post

HEAVY = 60.0  # kg, which stands still whatever the belts do
DEPTH = 0.108  # m from the palm to the post's middle: far out on the distal pads, which stay straight


def at(x: float = 0.0) -> Array:
    """The wrist before a post at the origin."""
    return np.array([x - DEPTH, 0.0, 0.06, 0.0, 0.0, 0.0])


def run(world: GraspWorld, seconds: float) -> None:
    """Let time pass."""
    for _ in range(round(seconds * 500)):
        world.step()


def gripping(hand: BeltHand, mass: float, current: float) -> GraspWorld:
    """A world in which the straight fingers press on a post."""
    world = GraspWorld(hand, post(mass, hand), [Standing(0.0, 0.0)], at(), WorldDeviation())
    world.hand.wrist.is_level_soft = True
    world.hand.motor.wanted, world.hand.motor.set_point = hand.drive.speed, current
    run(world, 2.0)
    return world


def press(hand: BeltHand, current: float, pull_over_press: float) -> float:
    """N of one finger: the torque over the lever, less what the pull along the pad turns."""
    torque = current * hand.drive.torque_constant / 2
    return torque / (DEPTH + pull_over_press * pad_offset(hand))


def test_fingers_press_by_the_motors_current() -> None:
    world = gripping(HAND, HEAVY, 2.0)
    for link in ("left_distal", "right_distal"):
        assert world.hand.pressing(link)["post 1"] == pytest.approx(press(HAND, 2.0, 0.0), rel=0.05)


def test_belts_that_slip_pull_by_friction_times_force() -> None:
    """The wrist, which is soft, is drawn to the post until its spring bears the pull of both belts."""
    hand = replace(HAND, belts=replace(HAND.belts, force=100.0, friction=0.5))
    world = gripping(hand, HEAVY, 2.0)
    start = world.hand.q[0]
    world.hand.run_belts(0.2, 0.2)
    run(world, 0.15)
    assert world.hand.slipping == ("left_distal", "right_distal")
    pull = 2 * 0.5 * press(hand, 2.0, 0.5)
    run(world, 1.0)
    moved = world.hand.q[0] - start
    # The lever is shorter where the hand has moved; the sum takes the mean.
    shorter = 2 * 0.5 * 2.0 * hand.drive.torque_constant / 2 / (DEPTH - moved + 0.5 * pad_offset(hand))
    assert pull * 0.95 / hand.wrist.level < moved < shorter * 1.05 / hand.wrist.level


def test_belts_below_the_slip_limit_pull_by_their_motors_and_block() -> None:
    hand = replace(HAND, belts=replace(HAND.belts, force=1.0, friction=0.9))
    world = gripping(hand, HEAVY, 2.0)
    start = world.hand.q[0]
    world.hand.run_belts(0.04, 0.04)
    run(world, 1.5)
    assert (world.hand.q[0] - start) * hand.wrist.level == pytest.approx(2 * 1.0, rel=0.05)
    for link in ("left_distal", "right_distal"):
        assert abs(world.hand.drives[link].speed) < 0.004
    assert world.hand.slipping == ()


@pytest.mark.parametrize("share", [0.6, 1.5])
def test_a_weight_slides_beyond_the_friction_of_both_pads_and_not_below(share: float) -> None:
    """Lifted by straight fingers, a post of the share of 2 mu N / g: held, or left on the table."""
    hand = replace(HAND, belts=replace(HAND.belts, friction=0.5))
    mass = share * 2 * 0.5 * press(hand, 3.0, 0.0) / GRAVITY
    world = gripping(hand, mass, 3.0)
    for _ in range(250):
        world.hand.wrist.wanted[2] += 0.05 / 250
        world.step()
    run(world, 0.5)
    before = world.pose("post 1")[2, 3]
    run(world, 1.0)
    risen = world.pose("post 1")[2, 3]
    assert (risen > 0.04) == (share < 1.0)
    assert abs(risen - before) < 1e-3  # neither creeps on
    if share < 1.0:
        sag = 0.06 + 0.05 - world.hand.q[2]
        assert sag * hand.wrist.stiff == pytest.approx(mass * GRAVITY, rel=0.03)


def test_the_wrist_bears_the_hand_and_gives_way_by_force_over_stiffness() -> None:
    world = GraspWorld(HAND, post(1.0), [Standing(1.0, 0.0)], at(), WorldDeviation())
    run(world, 1.0)
    assert world.hand.q[:6] == pytest.approx(at(), abs=2e-5)
    assert not world.hand.wrist.is_overloaded


def test_the_wrist_says_when_a_force_is_beyond_its_threshold() -> None:
    world = GraspWorld(HAND, post(HEAVY), [Standing(0.0, 0.0)], at(-0.05), WorldDeviation())
    goal = at(0.2)[0]
    world.hand.wrist.wanted[0] = goal - 0.2 + 0.01
    run(world, 0.5)
    assert not world.hand.wrist.is_overloaded
    for _ in range(500):
        world.hand.wrist.wanted[0] += 0.2 / 500
        world.step()
    assert world.hand.wrist.is_overloaded
    assert world.hand.q[0] < -world.hand.hand.fingers.base / 2 * 0.5  # the palm stands at the post
