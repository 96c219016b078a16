"""The arm of a cell: forward and inverse kinematics of its tool, in every tool state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.robot import JointType, Limits, Robot
from pickcli.cell.tool import ToolState
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.kernel import Chain, FollowEnd, PoseConstraint, project_to_constraints
from pickcli.kinematics.chain import build_chain, is_planned
from pickcli.kinematics.follow import HALF_WAY, Deviation, FollowResult
from pickcli.kinematics.manipulability import yoshikawa
from pickcli.kinematics.tip_motion import TipMotion

# Cost of 1 m^2 of a prismatic joint relative to 1 rad^2 of a revolute one (1 m like 2 rad): low enough that a
# rail along the line does the insertion, high enough that it does not run to its end to save the wrist.
PRISMATIC_WEIGHT = 4.0

# m or rad that inverse kinematics keeps from every limit: the configuration at rest is measured, and the next
# plan starts from the measurement.
LIMIT_MARGIN = 1e-3
MOST_TURNED = 100 * 2 * np.pi  # rad, bound in the kernel for joints without limits

_EXACT = 1e-9  # m and rad, tolerance of solutions that are to be the same wherever the descent began

MAX_STEP_PRISMATIC = 0.05  # m, largest joint step between neighbouring poses of a line
MAX_STEP_REVOLUTE = 0.12  # rad

_FOLLOW_REASONS = {
    FollowEnd.NO_CONVERGENCE: "no convergence",
    FollowEnd.JOINT_STEP: "branch jump",
    FollowEnd.LIMIT: "joint limit",
    FollowEnd.OFF_LINE: "leaves the line",
}


@dataclass(frozen=True, eq=False)
class ToolGoal:
    """Inequalities on where a frame of the tool is relative to an object.

    Attributes:
        constraints: They are met where their values are not over 0.
        T_world_object: (4, 4) pose of the object.
        T_tip_palm: (4, 4) pose of the frame relative to the tool frame.
    """

    constraints: Sequence[PoseConstraint]
    T_world_object: Array
    T_tip_palm: Array


class Arm:
    """Kinematics of one robot.

    The tool frame ("tip") is the tip of the uncompressed cup, +z out of it, or the point between the pads of
    a gripper.

    Args:
        robot: The robot of a cell.

    Attributes:
        robot: The robot of a cell.
        weights: (n,) weight of each joint in inverse kinematics, per rad^2 or m^2.
        max_step: (n,) rad or m, largest joint step between neighbouring poses of a line.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self._chains = {state: build_chain(robot, state) for state in robot.tool.states_and_moving}
        self._T_last_tip = np.ascontiguousarray(robot.tool.T_last_tip, dtype=np.float64)
        planned = {joint.name: joint for joint in robot.joints if is_planned(robot, joint)}
        self._is_prismatic = np.array([planned[n].type is JointType.PRISMATIC for n in robot.joint_names])
        self.weights: Array = np.where(self._is_prismatic, PRISMATIC_WEIGHT, 1.0)  # (n,)
        self._lower = np.maximum(robot.limits.lower + LIMIT_MARGIN, -MOST_TURNED)
        self._upper = np.minimum(robot.limits.upper - LIMIT_MARGIN, MOST_TURNED)
        self.max_step: Array = np.where(self._is_prismatic, MAX_STEP_PRISMATIC, MAX_STEP_REVOLUTE)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the planned joints, in the order of every configuration."""
        return self.robot.joint_names

    @property
    def n(self) -> int:
        """Number of planned joints."""
        return len(self.robot.joint_names)

    @property
    def limits(self) -> Limits:
        """Limits of the planned joints."""
        return self.robot.limits

    @property
    def turning_joints(self) -> NDArray[np.bool_]:
        """(n,) whether each joint is a revolute one."""
        return ~self._is_prismatic

    @property
    def window(self) -> tuple[Array, Array]:
        """(n,) and (n,) between which inverse kinematics keeps, with its margin; finite for every joint."""
        return self._lower, self._upper

    def chain(self, tool_state: ToolState) -> Chain:
        """Return the kernel's chain in one tool state.

        Args:
            tool_state: State of the tool; for MOVING, the default state is used.

        Returns:
            The chain, with the tool's joint as a fixed one.
        """
        if tool_state not in self._chains:  # a gripper width that the cell does not name
            self._chains[tool_state] = build_chain(self.robot, tool_state)
        return self._chains[tool_state]

    def tip(self, q: Array, tool_state: ToolState) -> Array:
        """Compute the pose of the tool frame.

        Args:
            q: (n,) configuration.
            tool_state: State of the tool.

        Returns:
            (4, 4) T_world_tip.
        """
        return np.asarray(self.chain(tool_state).fk(q)[-1] @ self._T_last_tip)

    def tips(self, Q: Array, tool_state: ToolState) -> Array:
        """Compute the poses of the tool frame for many configurations.

        Args:
            Q: (N, n) configurations.
            tool_state: State of the tool.

        Returns:
            (N, 4, 4) T_world_tip of each.
        """
        return self.chain(tool_state).tips(np.ascontiguousarray(Q), self._T_last_tip)

    def tip_motion(self, Q: Array, dQ: Array, ddQ: Array, tool_state: ToolState) -> TipMotion:
        """Compute the motion of the tool frame in the world, with the tool's joint at rest.

        Args:
            Q: (N, n) configurations.
            dQ: (N, n) their first derivatives, by time or by the parameter of a path.
            ddQ: (N, n) their second derivatives.
            tool_state: State of the tool.

        Returns:
            Poses, velocities and accelerations of the tool frame at the N states.
        """
        poses, motions = self.chain(tool_state).tip_motion(Q, dQ, ddQ, self._T_last_tip)
        return TipMotion(poses, *(np.ascontiguousarray(motions[:, k]) for k in range(4)))

    def jacobian(self, q: Array, tool_state: ToolState) -> Array:
        """Compute the geometric Jacobian of the tool frame.

        Args:
            q: (n,) configuration.
            tool_state: State of the tool.

        Returns:
            (6, n) in world axes per unit of joint rate: velocity of the tip in m/s, then angular velocity in
            rad/s.
        """
        return np.asarray(self.chain(tool_state).jacobian(q, self._T_last_tip))

    def rates(self, Q: Array, own: Array, twists: Array, tool_state: ToolState) -> Array:
        """Compute joint velocities that move the tool frame as wanted (resolved motion rate, Whitney 1969).

        Args:
            Q: (N, n) configurations.
            own: (N, n) velocities that the joints have anyway.
            twists: (N, 6) wanted of the tool frame in the world: m/s, then rad/s.
            tool_state: State of the tool.

        Returns:
            (N, n): ``own`` plus the rates of least norm (each weighted by its velocity limit) that give the
            twist. In a singular configuration they give another one, or are not finite.
        """
        return self.chain(tool_state).resolved_rates(Q, own, twists, self._T_last_tip, self.limits.velocity)

    def manipulability(self, q: Array, tool_state: ToolState) -> float:
        """Compute Yoshikawa's measure of manipulability.

        Args:
            q: (n,) configuration.
            tool_state: State of the tool.

        Returns:
            The measure of ``yoshikawa``, 0 in a singular configuration.
        """
        return yoshikawa(self.jacobian(q, tool_state))

    def solve(self, T_world_tip: Array, tool_state: ToolState, seeds: Array) -> Array:
        """Solve inverse kinematics from given seeds.

        Args:
            T_world_tip: (4, 4) pose of the tool frame.
            tool_state: State of the tool.
            seeds: (K, n) starting points of the descent.

        Returns:
            (M, n) distinct configurations within limits with the tool frame at the pose, in the seeds' order;
            (0, n) if there is no solution. Joints with a range of more than one turn are in the turn nearest
            to the first seed.
        """
        seeds = np.ascontiguousarray(np.atleast_2d(seeds))
        solutions = self.chain(tool_state).ik(
            T_world_tip, self._T_last_tip, seeds, self._lower, self._upper, self.weights
        )
        return self._in_turn_of(seeds[0], np.asarray(solutions).reshape(-1, self.n))

    def solve_near(
        self, T_world_tip: Array, tool_state: ToolState, q: Array, fixed: Sequence[int] = ()
    ) -> Array | None:
        """Solve inverse kinematics by descent from one configuration, with some joints kept as there.

        Positions of joints are not brought into another turn. What is found is exact up to rounding, so
        descents from several configurations to one solution find the same.

        Args:
            T_world_tip: (4, 4) pose of the tool frame.
            tool_state: State of the tool.
            q: (n,) configuration from which the descent begins.
            fixed: Indices of the joints that are kept.

        Returns:
            (n,) configuration within limits; None if the descent does not end in one.
        """
        lower, upper, kept = self._lower.copy(), self._upper.copy(), list(fixed)
        lower[kept] = upper[kept] = q[kept]
        found = self.chain(tool_state).ik(
            T_world_tip, self._T_last_tip, q[None], lower, upper, self.weights,
            position_tolerance=_EXACT, rotation_tolerance=_EXACT,
        )  # fmt: skip
        return np.asarray(found[0]) if len(found) else None

    def solve_spread(
        self, T_world_tip: Array, tool_state: ToolState, rng: np.random.Generator, n_seeds: int = 16
    ) -> Array:
        """Solve inverse kinematics with solutions spread over the redundancy.

        The prismatic joints of the seeds are stratified over their range, the other joints are random.

        Args:
            T_world_tip: (4, 4) pose of the tool frame.
            tool_state: State of the tool.
            rng: Source of the seeds; the same state of the generator gives the same solutions.
            n_seeds: Number of seeds.

        Returns:
            (M, n) distinct configurations within limits; (0, n) if there is no solution.
        """
        seeds = self.random_seeds(rng, n_seeds)
        strata = (np.arange(n_seeds) + rng.random(n_seeds)) / n_seeds
        lower, upper = self.limits.window
        for j in np.flatnonzero(self._is_prismatic):
            seeds[:, j] = lower[j] + rng.permutation(strata) * (upper[j] - lower[j])
        return self._in_turn_of(np.zeros(self.n), self.solve(T_world_tip, tool_state, seeds))

    def nearest(
        self, goal: ToolGoal, tool_state: ToolState, seeds: Array, reference: Array, most_iterations: int = 40
    ) -> tuple[Array, Array]:
        """Find configurations near a reference whose tool pose meets all inequalities of a goal.

        Args:
            goal: The inequalities.
            tool_state: State of the tool.
            seeds: (K, n) where the descents begin, e.g. solutions of inverse kinematics for poses of the
                goal.
            reference: (n,) configuration.
            most_iterations: Of one descent.

        Returns:
            (M, n) configurations within limits, the one nearest to the reference first, and their (M,)
            distances from it, weighted by ``weights``; a descent that does not reach the goal yields none.
        """
        Q, distances, are_met = project_to_constraints(
            goal.constraints, self.chain(tool_state), self._T_last_tip @ goal.T_tip_palm, goal.T_world_object,
            seeds, reference, self._lower, self._upper, self.weights, most_iterations,
        )  # fmt: skip
        order = np.argsort(np.where(are_met == 1, distances, np.inf), kind="stable")[: int(are_met.sum())]
        return Q[order], distances[order]

    def along_rails(self, q: Array, k: int) -> Array:
        """Return k configurations: one, with its prismatic joints in the middles of k parts of their ranges.

        Args:
            q: (n,) configuration.
            k: Number of parts.

        Returns:
            (k, n) configurations; (0, n) for a robot without prismatic joints.
        """
        if not self._is_prismatic.any():
            return np.empty((0, self.n))
        shares = (np.arange(k) + 0.5)[:, None] / k
        lower, upper = self.limits.window
        spread = lower + shares * (upper - lower)
        return np.where(self._is_prismatic, spread, q)

    def random_seeds(self, rng: np.random.Generator, k: int) -> Array:
        """Sample configurations uniformly within the limits; joints with more than one turn, near 0.

        Another turn is the same posture, but far from all configurations in this one.

        Args:
            rng: Source of the samples.
            k: Number of configurations.

        Returns:
            (k, n) configurations.
        """
        lower, upper = self._sampled
        return lower + (upper - lower) * rng.random((k, self.n))

    @cached_property
    def _sampled(self) -> tuple[Array, Array]:
        """Bounds (n,), (n,) of random configurations."""
        lower, upper = self.limits.window
        nearest = np.clip(0.0, lower + np.pi, upper - np.pi)  # to 0, of the middles of whole turns
        return (
            np.where(self._turns_more, nearest - np.pi, lower),
            np.where(self._turns_more, nearest + np.pi, upper),
        )

    @cached_property
    def _turns_more(self) -> Array:
        """(n,) whether each joint has a range of more than one turn."""
        return np.asarray(~self._is_prismatic & (self.limits.upper - self.limits.lower > 2 * np.pi))

    def _in_turn_of(self, reference: Array, Q: Array) -> Array:
        """Return distinct configurations (M, n), each joint in the turn nearest to a reference (n,)."""
        turned = Q - 2 * np.pi * np.round((Q - reference) / (2 * np.pi))
        better = self._turns_more & (turned != Q) & (turned >= self._lower) & (turned <= self._upper)
        if not better.any():
            return Q
        found = np.where(better, turned, Q)
        _, first = np.unique(found.round(6), axis=0, return_index=True)
        return np.asarray(found[np.sort(first)])

    def follow(
        self, T_world_tips: Array, tool_state: ToolState, q0: Array, deviation: Deviation = HALF_WAY
    ) -> FollowResult:
        """Follow tool poses by inverse kinematics, each configuration near the one before.

        No joint steps farther than ``max_step`` from pose to pose, starting from q0.

        Args:
            T_world_tips: (P, 4, 4) poses of the tool frame.
            tool_state: State of the tool.
            q0: (n,) configuration near the first pose.
            deviation: How far the tool may be off the line half-way between two configurations.

        Returns:
            The configurations up to the last reachable pose, and the reason if that is not the last one.
        """
        poses = np.ascontiguousarray(T_world_tips, dtype=np.float64)
        Q, end, off = self.chain(tool_state).follow(
            poses, self._T_last_tip, q0, self._lower, self._upper, self.weights, self.max_step,
            deviation.position, deviation.angle,
        )  # fmt: skip
        if end is FollowEnd.DONE:
            return FollowResult(Q, None)
        q = Q[-1] if len(Q) else q0
        return FollowResult(Q, self._why_broken(q, end, Deviation(*off), len(Q), len(poses)))

    def longest_chords(
        self, Q: Array, T_world_tips: Array, tool_state: ToolState, deviation: Deviation
    ) -> NDArray[np.int32]:
        """Select waypoints on a straight line so that joint chords between them stay near it.

        Args:
            Q: (N, n) configurations that follow the line, N at least 1.
            T_world_tips: (N, 4, 4) poses of the tool frame on the line.
            tool_state: State of the tool.
            deviation: Largest distance of the tool from the line, at any place along it, and largest angle to
                the orientation at that place.

        Returns:
            Indices (M,) of rows of Q, including the first and the last.
        """
        return self.chain(tool_state).longest_chords(
            Q, T_world_tips, self._T_last_tip, deviation.position, deviation.angle
        )

    def _why_broken(self, q: Array, end: FollowEnd, off: Deviation, i: int, n_poses: int) -> Reason:
        """Convert the kernel's answer to a reason; pose i is the first not reached, coming from q."""
        detail = _place(i, n_poses)
        if end is FollowEnd.OFF_LINE:
            detail = f"{off.position * 1e3:.1f} mm and {np.rad2deg(off.angle):.1f} degrees off {detail}"
        elif end is FollowEnd.LIMIT:
            to_limit = np.minimum(q - self.limits.lower, self.limits.upper - q)
            j = int(np.argmin(to_limit / self.max_step))
            detail = f"{self.names[j]} at {q[j]:.3f} {detail}"
        elif end is FollowEnd.JOINT_STEP:
            detail = f"a joint would step over {MAX_STEP_REVOLUTE} rad or {MAX_STEP_PRISMATIC} m {detail}"
        return Reason(_FOLLOW_REASONS[end], "", detail)


def _place(i: int, n: int) -> str:
    """Describe the position of pose i on a line of n poses."""
    return f"at {100.0 * i / max(n - 1, 1):.0f} % of the line"
