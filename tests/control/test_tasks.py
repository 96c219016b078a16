"""Tasks: their rows are the derivatives of their errors, and limits hold at every instant of a roll-out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.control.roll_out import ControlScene, End, RollOut, Stack, roll_out
from pickcli.control.tasks.joint_limit_task import JointLimitTask
from pickcli.control.tasks.obstacle_task import ObstacleTask
from pickcli.control.tasks.posture_task import PostureTask
from pickcli.control.tasks.task import ControlState, stopping_rate
from pickcli.control.tasks.tool_task import MET, ToolTask
from pickcli.geometry import Array, inverse, pose
from pickcli.kinematics.arm import Arm, ToolGoal
from support.cans import CanScene, can

PERIOD = 0.01
SIDE = 1  # of the envelopes: the hand turned over, which the arm reaches without turning its wrist far


@pytest.fixture(scope="module")
def table() -> Cell:
    return load_cell("panda_table")


@pytest.fixture(scope="module")
def arm(table: Cell) -> Arm:
    return Arm(table.robot)


@pytest.fixture(scope="module")
def scene(table: Cell) -> CanScene:
    return CanScene(table, (can(table, "n", 0.46, 0.3), can(table, "m", 0.75, -0.2)))


def tool_task(scene: CanScene, arm: Arm, T_world_item: Array | None = None) -> ToolTask:
    envelope = scene.envelopes[SIDE]
    T = scene.target.T_world_item if T_world_item is None else T_world_item
    return ToolTask("envelope", arm, scene.state, ToolGoal(envelope.constraints, T, envelope.T_tip_palm), 3.0)


def obstacle_task(scene: CanScene, table: Cell) -> ObstacleTask:
    return ObstacleTask("obstacles", scene.arm, 0.008, 0.005, 0.06, 10.0, table.robot.limits.acceleration)


def control_scene(scene: CanScene, arm: Arm, table: Cell, T: Array | None = None) -> ControlScene:
    home = table.configurations["home"].q
    levels = (
        (JointLimitTask("limits", table.robot.limits),),
        (obstacle_task(scene, table),),
        (tool_task(scene, arm, T),),
        (PostureTask("posture", home, 0.3),),
    )
    return ControlScene(Stack(levels, "envelope", table.robot.limits.acceleration), scene.arm)


@pytest.fixture(scope="module")
def reached(scene: CanScene, arm: Arm, table: Cell) -> RollOut:
    now = control_scene(scene, arm, table)
    return roll_out(lambda _: now, table.configurations["home"].q, 10.0, PERIOD)


def test_rows_of_the_tool_are_derivatives_of_the_terms(scene: CanScene, arm: Arm) -> None:
    task, h = tool_task(scene, arm), 1e-6
    rng = np.random.default_rng(0)
    for q in arm.random_seeds(rng, 10):
        rows = task.rows(ControlState(q, np.zeros(arm.n), PERIOD))
        goal = task.goal

        def terms(q: Array) -> Array:
            tip = inverse(scene.target.T_world_item) @ arm.tip(q, scene.state)
            return np.asarray(scene.envelopes[SIDE].terms(tip[None])[0])

        slopes = np.stack([(terms(q + h * e) - terms(q - h * e)) / (2 * h) for e in np.eye(arm.n)], axis=1)
        assert np.abs(rows.rows - slopes).max() < 1e-6
        assert np.allclose(rows.upper, -task.gain * (terms(q) + task.inside))
        assert len(goal.constraints) == len(rows.rows)


def test_rows_of_obstacles_are_derivatives_of_distances(scene: CanScene, arm: Arm) -> None:
    """Where the nearest sphere does not change, the distance of a pair changes as its row says."""
    rng, h, n_compared = np.random.default_rng(1), 1e-6, 0
    for q in arm.random_seeds(rng, 40):
        distances, gradients, parts = scene.arm.kernel.near_pairs(q, 0.2)
        step = rng.normal(size=arm.n)
        ahead, behind = (scene.arm.kernel.near_pairs(q + s * h * step, 0.2) for s in (1, -1))
        if not (np.array_equal(parts, ahead[2]) and np.array_equal(parts, behind[2])):
            continue
        slope = (ahead[0] - behind[0]) / (2 * h)
        is_smooth = np.abs(ahead[0] + behind[0] - 2 * distances) < 1e-10
        assert np.abs(slope - gradients @ step)[is_smooth].max(initial=0.0) < 1e-4
        n_compared += int(is_smooth.sum())
    assert n_compared > 100


def test_the_least_of_near_distances_is_the_clearance(scene: CanScene, arm: Arm) -> None:
    """Between links the clearance also counts tighter spheres, so it may be more."""
    for q in arm.random_seeds(np.random.default_rng(2), 40):
        distances, _, parts = scene.arm.kernel.near_pairs(q, 1.0)
        least, *_ = scene.arm.kernel.clearance(q, 1.0)
        assert distances.min() <= least + 1e-9
        if parts[int(np.argmin(distances)), 1] == 0:
            assert distances.min() == pytest.approx(least, abs=1e-9)


def test_rates_and_accelerations_hold_at_every_instant(table: Cell, reached: RollOut) -> None:
    limits = table.robot.limits
    assert reached.end is End.REACHED
    rates = np.diff(reached.Q, axis=0) / PERIOD
    assert (np.abs(rates) <= limits.velocity + 1e-9).all()
    changes = np.diff(np.vstack([np.zeros(len(limits.velocity)), rates]), axis=0) / PERIOD
    assert (np.abs(changes) <= limits.acceleration * (1 + 1e-6)).all()
    assert (limits.lower <= reached.Q).all() and (limits.upper >= reached.Q).all()


def test_every_step_is_free_and_the_goal_is_in_the_envelope(
    scene: CanScene, arm: Arm, reached: RollOut
) -> None:
    assert scene.arm.first_blocked_edge(reached.Q) == -1
    tip = inverse(scene.target.T_world_item) @ arm.tip(reached.Q[-1], scene.state)
    assert scene.envelopes[SIDE].contains(tip[None], MET).all()
    assert reached.errors["envelope"][-1] == 0.0 and reached.errors["envelope"][0] > 0.0
    assert reached.duration == pytest.approx(PERIOD * (len(reached.Q) - 1))


def test_the_same_roll_out_twice_is_the_same_to_the_bit(
    scene: CanScene, arm: Arm, table: Cell, reached: RollOut
) -> None:
    now = control_scene(scene, arm, table)
    again = roll_out(lambda _: now, table.configurations["home"].q, 10.0, PERIOD)
    assert np.array_equal(again.Q, reached.Q)


def test_a_target_that_moves_is_followed(scene: CanScene, arm: Arm, table: Cell, reached: RollOut) -> None:
    moved = scene.target.T_world_item @ pose((0.015, -0.01, 0.005), rpy=(0.04, -0.03, 0.3))
    before, after = control_scene(scene, arm, table), control_scene(scene, arm, table, moved)
    when = 0.7 * reached.duration
    found = roll_out(lambda t: before if t < when else after, table.configurations["home"].q, 10.0, PERIOD)
    assert found.end is End.REACHED
    tip = inverse(moved) @ arm.tip(found.Q[-1], scene.state)
    assert scene.envelopes[SIDE].contains(tip[None], MET).all()


def test_what_cannot_be_reached_ends_in_a_local_minimum(scene: CanScene, arm: Arm, table: Cell) -> None:
    far = scene.target.T_world_item.copy()
    far[:3, 3] += (1.0, 0.0, 0.5)
    now = control_scene(scene, arm, table, far)
    found = roll_out(lambda _: now, table.configurations["home"].q, 20.0, PERIOD)
    assert found.end in (End.LOCAL_MINIMUM, End.NOT_PROVEN)
    assert scene.arm.first_blocked_edge(found.Q) == -1
    assert found.slack[-1, 2] > 0.0  # the level of the envelope gave way


def test_a_joint_stops_before_its_limit_from_any_rate_that_the_task_lets_it_have(table: Cell) -> None:
    limits = table.robot.limits
    task = JointLimitTask("limits", limits)
    q, dq = (limits.lower + limits.upper) / 2, np.zeros(7)
    for _ in range(1000):  # as fast as the task lets it towards the upper limits
        dq = task.rows(ControlState(q, dq, PERIOD)).upper
        q = q + PERIOD * dq
        assert (q <= limits.upper + 1e-9).all()
    assert np.abs(q - limits.upper).max() < 1e-3


def test_a_rate_from_which_something_stops_does_stop_within_the_distance() -> None:
    rng = np.random.default_rng(5)
    for distance, deceleration in rng.uniform((0.001, 0.5), (0.5, 10.0), (200, 2)):
        left, rate = distance, float(stopping_rate(np.array([distance]), np.array([deceleration]), PERIOD)[0])
        while rate > 0.0:
            left -= rate * PERIOD
            assert left >= -1e-9
            rate = max(0.0, rate - deceleration * PERIOD)


def test_nothing_moves_where_the_first_level_leaves_no_room(table: Cell) -> None:
    slow = replace(table.robot.limits, velocity=np.full(7, 1e-12))
    rows = JointLimitTask("limits", slow).rows(
        ControlState(table.configurations["home"].q, np.zeros(7), PERIOD)
    )
    assert np.abs(rows.upper).max() <= 1e-12


@pytest.mark.parametrize("seconds", [0.0, 0.005, 0.1, 0.105])
def test_out_of_time_every_array_has_its_length(
    scene: CanScene, arm: Arm, table: Cell, seconds: float
) -> None:
    now = control_scene(scene, arm, table)
    found = roll_out(lambda _: now, table.configurations["home"].q, seconds, PERIOD)
    n = int(seconds / PERIOD + 1e-9)
    assert found.end is End.OUT_OF_TIME and len(found.Q) == n + 1 and found.duration <= seconds + 1e-9
    assert all(len(each) == n + 1 for each in found.errors.values())
    assert found.slack.shape == (n, 4)


def test_what_is_met_at_the_start_ends_there(scene: CanScene, arm: Arm, table: Cell) -> None:
    now = control_scene(scene, arm, table)
    home = table.configurations["home"].q
    there = replace(now, stack=replace(now.stack, goal="posture"))
    found = roll_out(lambda _: there, home, 1.0, PERIOD)
    assert found.end is End.REACHED and len(found.Q) == 1 and found.slack.shape == (0, 4)


def test_a_posture_is_reached(scene: CanScene, table: Cell) -> None:
    home = table.configurations["home"].q
    away = home + 0.1
    levels = ((JointLimitTask("limits", table.robot.limits),), (PostureTask("posture", home, 3.0),))
    now = ControlScene(Stack(levels, "posture", table.robot.limits.acceleration), scene.arm)
    found = roll_out(lambda _: now, away, 10.0, PERIOD)
    assert found.end is End.REACHED
    assert np.abs(found.Q[-1] - home).max() <= 1.1e-3


def test_where_proofs_block_the_way_that_is_told(scene: CanScene, arm: Arm, table: Cell) -> None:
    """The arm is drawn through the target's neighbour by a stack without obstacles: it stops before it."""
    home = table.configurations["home"].q
    levels = ((JointLimitTask("limits", table.robot.limits),), (tool_task(scene, arm),))
    stack = Stack(levels, "envelope", table.robot.limits.acceleration)

    class Blocked:
        def is_valid_edge(self, q0: Array, q1: Array) -> bool:
            return bool((np.abs(q1 - home) <= 0.2).all())

    now = ControlScene(stack, Blocked())  # type: ignore[arg-type]
    found = roll_out(lambda _: now, home, 10.0, PERIOD)
    assert found.end is End.NOT_PROVEN


@pytest.mark.parametrize("share", [0.75, 0.85, 0.95])
def test_from_what_moved_too_near_it_leads_away_and_touches_nothing(
    scene: CanScene, arm: Arm, table: Cell, share: float
) -> None:
    now, home = control_scene(scene, arm, table), table.configurations["home"].q
    nominal = roll_out(lambda _: now, home, 10.0, PERIOD)
    when = int(share * len(nominal.Q))
    at = arm.tip(nominal.Q[when], scene.state)[:3, 3]
    ahead = np.arange(0.06, 0.12, 5e-4)  # m before the hand, where another can turns up
    moved = (CanScene(table, (can(table, "n", at[0] + x, at[1]),)) for x in ahead)
    later = next(each for each in moved if 3e-4 < _gap(each, nominal.Q[when]) < table.clearance)
    then = control_scene(later, arm, table)
    found = roll_out(lambda t: now if t < when * PERIOD else then, home, 10.0, PERIOD)
    assert len(found.Q) > when + 10
    steps = np.diff(found.Q[when:], axis=0)
    between = [found.Q[when:-1] + part * steps for part in np.linspace(0.0, 1.0, 6)]
    assert later.arm.clearances(np.concatenate(between)).min() > 0.0
    assert _gap(later, found.Q[-1]) > table.clearance


def test_a_change_that_is_far_away_costs_no_margin(scene: CanScene, arm: Arm, table: Cell) -> None:
    """Past an obstacle, with an equal scene from some instant on: the same motion."""
    home = table.configurations["home"].q
    now, same = (control_scene(scene, arm, table) for _ in range(2))
    alone = roll_out(lambda _: now, home, 10.0, PERIOD)
    changed = roll_out(lambda t: now if t < 0.02 else same, home, 10.0, PERIOD)
    np.testing.assert_array_equal(alone.Q, changed.Q)


def test_a_range_of_no_width_is_met(arm: Arm, table: Cell) -> None:
    """Bounds of the distance that are equal, as of fingers that just span a ball."""
    scene = CanScene(table)
    side = scene.envelopes[SIDE]
    middle = float(side.low[2] + side.high[2]) / 2
    exact = replace(side, low=np.array([*side.low[:2], middle]), high=np.array([*side.high[:2], middle]))
    goal = ToolGoal(exact.constraints, scene.target.T_world_item, exact.T_tip_palm)
    levels = (
        (JointLimitTask("limits", table.robot.limits),),
        (obstacle_task(scene, table),),
        (ToolTask("envelope", arm, scene.state, goal, 3.0),),
    )
    now = ControlScene(Stack(levels, "envelope", table.robot.limits.acceleration), scene.arm)
    found = roll_out(lambda _: now, table.configurations["home"].q, 20.0, PERIOD)
    assert found.end is End.REACHED and found.duration < 10.0
    tip = inverse(scene.target.T_world_item) @ arm.tip(found.Q[-1], scene.state)
    assert exact.contains(tip[None], MET).all()


def test_it_goes_on_with_the_rates_it_had(scene: CanScene, arm: Arm, table: Cell) -> None:
    now, home = control_scene(scene, arm, table), table.configurations["home"].q
    first = roll_out(lambda _: now, home, 1.0, PERIOD)
    whole = first.then(roll_out(lambda _: now, first.Q[-1], 10.0, PERIOD, first.rates))
    assert np.abs(first.rates).max() > 0.1
    acceleration = np.abs(np.diff(whole.Q, 2, axis=0)) / PERIOD**2
    assert (acceleration <= table.robot.limits.acceleration * (1 + 1e-6)).all()
    assert whole.end is End.REACHED and len(whole.errors["envelope"]) == len(whole.Q)


def _gap(scene: CanScene, q: Array) -> float:
    return float(scene.arm.clearances(q[None])[0])


def test_limits_never_contradict_each_other_beyond_an_end(table: Cell) -> None:
    task, rng = JointLimitTask("limits", table.robot.limits), np.random.default_rng(6)
    lower, upper = table.robot.limits.lower, table.robot.limits.upper
    for _ in range(500):
        q = rng.uniform(lower - 0.1, upper + 0.1)
        rows = task.rows(ControlState(q, rng.normal(size=7), PERIOD))
        assert (rows.lower <= rows.upper).all()
