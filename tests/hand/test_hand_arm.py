"""An arm with a hand feels what pushes the hand, and nothing of its own motion."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing

import numpy as np
import pytest

from pickcli.geometry import Array
from pickcli.hand.arm_motions import GIVING_WAY
from pickcli.hand.arm_world import ArmWorld
from pickcli.hand.guarded_grasp import MET
from pickcli.hand.hand_arm import ROBOT
from pickcli.hand.hand_urdf import PALM
from pickcli.hand.place_execution import BACKED, PlaceExecution
from pickcli.hand.staged_execution import SETTLED, StagedExecution
from pickcli.kinematics.arm import Arm
from pickcli.scene.scene import PoseNoise, Scene
from support.belt_hands import HAND
from support.commissions import belts_booth


@pytest.fixture
def world() -> Iterator[ArmWorld]:
    """The arm at home, compliant."""
    cell = belts_booth()
    found = ArmWorld(Scene(cell, cell.T_world_pod, (), PoseNoise()), HAND, cell.home.q, {})
    found.arm.comply()
    yield found
    found.close()


@pytest.mark.parametrize(("joint", "side"), [(0, 1), (1, -1), (2, 1), (3, -1), (5, 1)])
def test_a_compliant_arm_is_kept_within_the_limits_of_its_joints(joint: int, side: int) -> None:
    """The hand is led to where only the joint itself, which is near its limit, moves it most."""
    cell = belts_booth()
    limits, q = cell.robot.limits, cell.home.q.copy()
    q[joint] = limits.upper[joint] - 0.06 if side > 0 else limits.lower[joint] + 0.06
    with closing(ArmWorld(Scene(cell, cell.T_world_pod, (), PoseNoise()), HAND, q, {})) as world:
        arm = Arm(cell.robot)
        ahead = q + side * 0.15 * np.eye(len(q))[joint]
        way = (arm.tip(ahead, world.tool_state) - arm.tip(q, world.tool_state))[:3, 3]
        world.arm.comply()
        wanted = world.arm.impedance.wanted.copy()
        for share in np.minimum(np.arange(1200) / 800, 1.0):
            world.arm.impedance.wanted[:3] = wanted[:3] + share * way
            world.step()
            assert (world.q > limits.lower).all() and (world.q < limits.upper).all()


def felt_while(world: ArmWorld, way: Array, seconds: float) -> Array:
    """(K, 3) N that are felt while the hand moves by (6,) m and rad."""
    felt: list[Array] = []
    moving = StagedExecution(world, lambda: felt.append(world.arm.impedance.felt))
    moving.wait(SETTLED)
    n_before = len(felt)
    moving.move(world.arm.impedance.wanted + way, seconds)
    return np.array(felt[n_before:])


@pytest.mark.parametrize("way", [(0.0, -0.12, 0.0), (-0.08, 0.0, 0.0), (0.0, 0.0, 0.1)])
def test_an_approach_through_free_air_feels_nothing(world: ArmWorld, way: tuple[float, ...]) -> None:
    felt = felt_while(world, np.array([*way, 0.0, 0.0, 0.0]), 1.0)
    assert np.linalg.norm(felt, axis=1).max() < 0.2 * MET
    assert world.arm.impedance.measured[:3] == pytest.approx(world.arm.impedance.wanted[:3], abs=1e-3)


@pytest.mark.parametrize("push", [(3.0, 0.0, 0.0), (0.0, -2.0, 0.0), (1.0, 1.0, -4.0)])
def test_a_push_is_felt_in_size_and_direction(world: ArmWorld, push: tuple[float, ...]) -> None:
    for _ in range(300):
        world.engine.apply_force(ROBOT, np.array(push), world.engine.pose(ROBOT, PALM)[:3, 3], PALM)
        world.step()
    assert world.arm.impedance.felt == pytest.approx(push, abs=0.05)


def test_who_begins_to_comply_forgets_what_was_felt_before(world: ArmWorld) -> None:
    for _ in range(50):
        world.engine.apply_force(ROBOT, np.array([0.0, 5.0, 0.0]), world.arm.T_world_hand[:3, 3], PALM)
        world.step()
    world.arm.follow()
    world.wait(0.2)
    world.arm.comply()
    world.step()
    assert np.linalg.norm(world.arm.impedance.felt) < 0.2 * MET


def test_a_hand_that_backs_off_is_where_it_was_proven_to_be(world: ArmWorld) -> None:
    """What it lags behind stays below what plans keep for a compliant arm."""
    impedance, off = world.arm.impedance, list[float]()
    backing = PlaceExecution(
        world, lambda: off.append(np.abs(impedance.measured - impedance.wanted)[:3].max())
    )
    before = impedance.wanted[:3].copy()
    backing.leave()
    assert not backing.is_stopped and np.linalg.norm(impedance.measured[:3] - before) == pytest.approx(
        BACKED, abs=2e-3
    )
    assert max(off) < GIVING_WAY
