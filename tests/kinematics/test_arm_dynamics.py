"""Inverse dynamics: planner, verifier and physics engine agree, and cases worked out by hand."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_workcell
from pickcli.cell.inertial import Inertial
from pickcli.cell.robot import JointType, Robot
from pickcli.geometry import GRAVITY, Array
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.arm_dynamics import ArmDynamics
from pickcli.kinematics.held_body import HeldBody
from pickcli.simulation.engine import Engine
from pickcli.simulation.robot_urdf import write_urdf
from pickcli.verification.forward_kinematics import link_poses, tip_poses
from pickcli.verification.inverse_dynamics import CarriedBody, body_motions, carried_links, efforts

SEEDS = st.integers(0, 2**31)
ROBOTS = ("apc2016_delft", "ur5e_crates", "panda_table", "apc2016_kth")
HELD = HeldBody(0.7, np.array([0.02, -0.03, 0.05]), np.diag([1.1e-3, 2.0e-3, 2.4e-3]))


def robot_of(name: str) -> Robot:
    return load_workcell(name).preferred.robot


def random_motion(robot: Robot, seed: int, n: int = 5) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(seed)
    return Arm(robot).random_seeds(rng, n), *rng.normal(size=(2, n, robot.n_joints))


def by_verifier(robot: Robot, Q: Array, dQ: Array, ddQ: Array, held: HeldBody | None = None) -> Array:
    links = link_poses(robot, Q)
    motions, carried = body_motions(robot, links, dQ, ddQ), carried_links(robot, links)
    if held is not None:
        tips = tip_poses(robot, links, next(iter(robot.tool.states)))
        carried.append(CarriedBody(len(motions) - 1, tips, Inertial(held.mass, held.p_tip_com, held.inertia)))
    return efforts(robot, motions, carried)


@pytest.mark.parametrize("name", ROBOTS)
def test_planner_and_verifier_compute_the_same_efforts(name: str) -> None:
    robot = with_light_tool(robot_of(name))
    for seed, held in ((1, None), (2, HELD)):
        motion = random_motion(robot, seed)
        planned = ArmDynamics(Arm(robot), next(iter(robot.tool.states)), held).efforts(*motion)
        np.testing.assert_allclose(by_verifier(robot, *motion, held), planned, rtol=1e-9, atol=1e-6)


def with_light_tool(robot: Robot) -> Robot:
    """A robot of which what the tool's joints move weighs nothing: the verifier leaves them at 0."""
    moved = {joint.child for joint in robot.joints if joint.name in robot.tool.joints}
    for joint in robot.joints:
        if joint.parent in moved:
            moved.add(joint.child)
    nothing = Inertial(1e-12, np.zeros(3), 1e-15 * np.eye(3))
    links = (replace(link, inertial=nothing) if link.name in moved else link for link in robot.links)
    return replace(robot, links=tuple(links))


@pytest.mark.parametrize("name", ROBOTS)
def test_the_physics_engine_computes_the_same_efforts(name: str, tmp_path: Path) -> None:
    robot = robot_of(name)
    engine = Engine(1e-3)
    engine.load_robot("robot", write_urdf(robot, tmp_path), robot.T_world_base)
    state = next(iter(robot.tool.states))
    Q, dQ, ddQ = random_motion(robot, 3)
    planned = ArmDynamics(Arm(robot), state).efforts(Q, dQ, ddQ)
    order = moving_in_engine(robot)
    for row, expected in enumerate(planned):
        q, dq, ddq = (in_engine(robot, order, rows[row]) for rows in (Q, dQ, ddQ))
        found = engine.inverse_dynamics("robot", q, dq, ddq)
        of_planned = [found[order.index(name)] for name in robot.joint_names]
        np.testing.assert_allclose(of_planned, expected, rtol=2e-3, atol=0.05)


def moving_in_engine(robot: Robot) -> list[str]:
    return [joint.name for joint in robot.joints if joint.type is not JointType.FIXED]


def in_engine(robot: Robot, order: list[str], values: Array) -> Array:
    by_name = dict(zip(robot.joint_names, values.tolist(), strict=True))
    return np.array([by_name.get(name, 0.0) for name in order])


def test_a_rail_is_pushed_with_all_that_rides_on_it(cell: Cell) -> None:
    robot, n = cell.robot, cell.robot.n_joints
    moved = [link.inertial.mass for link in robot.links]
    stands = robot.joints[robot.joint_names.index("rail")].parent
    standing = {stands} | {j.parent for j in robot.joints if j.child == stands}
    total = sum(link.inertial.mass for link in robot.links if link.name not in standing)
    assert total < sum(moved)
    Q, ddQ = np.zeros((1, n)), np.zeros((1, n))
    ddQ[0, robot.joint_names.index("rail")] = 1.5
    dynamics = ArmDynamics(Arm(robot), next(iter(robot.tool.states)), HELD)
    push = dynamics.efforts(Q, np.zeros((1, n)), ddQ)[0, robot.joint_names.index("rail")]
    assert push == pytest.approx(1.5 * (total + HELD.mass), rel=1e-9)


@settings(max_examples=30, deadline=None)
@given(seed=SEEDS)
def test_power_is_the_change_of_energy(seed: int) -> None:
    """Without friction, effort times velocity is the time derivative of kinetic and potential energy."""
    robot = robot_of("ur5e_crates")
    (q,), (dq,), (ddq,) = random_motion(robot, seed, 1)
    dynamics = ArmDynamics(Arm(robot), next(iter(robot.tool.states)), HELD)
    power = float(dynamics.efforts(q[None], dq[None], ddq[None])[0] @ dq)
    step = 1e-5

    def energy(t: float) -> float:
        at, rate = q + t * dq + t * t / 2 * ddq, dq + t * ddq
        kinetic = rate @ dynamics.efforts(at[None], 0 * rate[None], rate[None], 0.0)[0] / 2  # rate M rate / 2
        tip = Arm(robot).tip(at, next(iter(robot.tool.states)))
        held = HELD.mass * GRAVITY * (tip[:3, :3] @ HELD.p_tip_com + tip[:3, 3])[2]
        links = link_poses(robot, at[None])[:, 0]
        weights = [
            link.inertial.mass * GRAVITY * (T[:3, :3] @ link.inertial.centre + T[:3, 3])[2]
            for T, link in zip(links, robot.links, strict=True)
        ]
        return float(kinetic + held + sum(weights))

    assert power == pytest.approx((energy(step) - energy(-step)) / (2 * step), rel=1e-5, abs=1e-3)


@settings(max_examples=30, deadline=None)
@given(seed=SEEDS, u=st.floats(-3.0, 3.0), v=st.floats(-3.0, 3.0))
def test_along_a_path_efforts_are_linear(seed: int, u: float, v: float, cell: Cell) -> None:
    """With q(s): dq = q' v and ddq = q' u + q'' v^2."""
    robot = cell.robot
    Q, first, second = random_motion(robot, seed, 3)
    dynamics = ArmDynamics(Arm(robot), next(iter(robot.tool.states)))
    a, b, c = dynamics.path_efforts(Q, first, second)
    whole = dynamics.efforts(Q, first * v, first * u + second * v * v)
    np.testing.assert_allclose(a * u + b * v * v + c, whole, rtol=1e-9, atol=1e-8)


def test_joined_bodies_weigh_and_turn_like_both() -> None:
    ball = Inertial(2.0, np.array([1.0, 0.0, 0.0]), 0.1 * np.eye(3))
    whole = ball.joined(Inertial(2.0, np.array([-1.0, 0.0, 0.0]), 0.1 * np.eye(3)))
    assert whole.mass == 4.0
    np.testing.assert_allclose(whole.centre, 0.0, atol=1e-15)
    np.testing.assert_allclose(whole.inertia, np.diag([0.2, 4.2, 4.2]))
