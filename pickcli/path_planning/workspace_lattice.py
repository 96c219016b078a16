"""Lattice of hand poses with the arm's redundant joints (Cohen, Chitta and Likhachev 2010; 2011).

A state is a position of the hand on a grid, its roll, pitch and yaw, and the steps of each joint beyond the
six that a pose needs: {x, y, z, roll, pitch, yaw, redundant joint} of an arm with seven. Grid and angles
begin at the start. Motion primitives change the position by one step in 26 directions, or one angle, or a
redundant joint; each is the straight edge between two configurations, found by inverse kinematics, and is
proven free as a whole. Near a goal one adaptive primitive ends in it exactly.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

from pickcli.cell.robot import Limits
from pickcli.collision.checker import SceneChecker
from pickcli.geometry import Array, rotation_angle, rotation_rpy
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.continuous_joints import unwound_towards
from pickcli.path_planning.hand_distance import STEPS, HandGrid
from pickcli.path_planning.lattice_cost import LatticeResolution

State: TypeAlias = tuple[int, ...]  # steps of x, y, z, roll, pitch, yaw and the redundant joints

POSE_SIZE = 6  # of a pose
ROOM = 0.5  # m that the hand may go beyond start and goals
# rad or m that a joint may move on an edge; more is a motion to another branch, in which the hand strays.
LARGEST_STEP, LARGEST_LAST_STEP = 0.6, 1.2
SAME = 0.02  # rad or m within which configurations of one state are the same
MOST_GOALS = 8  # that are tried from one state, the nearest first


def redundant_joints(limits: Limits) -> tuple[int, ...]:
    """Choose the joints that a lattice steps through, all beyond the six that a pose needs.

    Joints of a rail, which are before the shoulder, and the roll of the upper arm: of seven revolute joints
    the third, as of the PR2 (its ``upper_arm_roll``).

    Args:
        limits: Limits of the n joints.

    Returns:
        Their indices; none if there are at most six joints.
    """
    beyond = len(limits.lower) - POSE_SIZE
    if beyond <= 0:
        return ()
    return (*range(beyond - 1), beyond + 1)


@dataclass(frozen=True, eq=False)
class HandGoals:
    """Where a motion may end.

    Attributes:
        T_world_tip: (G, 4, 4) poses of the tool frame.
        configurations: (G, n) in which they are to be reached; None for any.
        in_any_turn: Whether joints without limits may be any number of turns from there.
    """

    T_world_tip: Array
    configurations: Array | None = None
    in_any_turn: bool = True


@dataclass(frozen=True, eq=False)
class GoalEdge:
    """The edge from a state into a goal.

    Attributes:
        goal: Index of the goal.
        q: (n,) configuration there.
        cost: m.
    """

    goal: int
    q: Array
    cost: float


@dataclass(frozen=True, eq=False)
class _Turn:
    """An orientation of the hand.

    R: (3, 3) of the tool in the world
    tip: (3,) m, of the tool frame when the hand is at the origin of the grid
    cost: m, of the least turn to a goal
    """

    R: Array
    tip: Array
    cost: float


class WorkspaceLattice:
    """The lattice as a graph, whose nodes are made as they are reached (see ``SearchGraph``).

    Node 0 is the start, node 1 stands for all goals. The heuristic is consistent: the way of the hand's
    sphere past everything (``hand_distance``), the least turn to any goal, and the least way of the redundant
    joints, each times its cost.

    Args:
        arm: The arm.
        checker: Proves edges.
        q_start: (n,) start, valid.
        goals: The goals.
        resolution: Steps and costs.

    Attributes:
        start: Node of the start.
        goal: Node of the goals.
    """

    def __init__(
        self, arm: Arm, checker: SceneChecker, q_start: Array, goals: HandGoals, resolution: LatticeResolution
    ) -> None:
        self.start, self.goal = 0, 1
        self._arm, self._checker, self._goals, self._resolution = arm, checker, goals, resolution
        self._redundant = redundant_joints(arm.limits)
        T_world_tip, sphere = arm.tip(q_start, checker.tool_state), checker.hand_sphere()
        self._tip_hand = np.zeros(3)
        if sphere is not None:
            T_world_frame = arm.chain(checker.tool_state).fk(q_start)[sphere.sphere.frame]
            hand = T_world_frame[:3, :3] @ sphere.sphere.center + T_world_frame[:3, 3]
            self._tip_hand = T_world_tip[:3, :3].T @ (hand - T_world_tip[:3, 3])
        self._R_start, self._q_start = T_world_tip[:3, :3], q_start
        self._goal_hands = goals.T_world_tip[:, :3, 3] + goals.T_world_tip[:, :3, :3] @ self._tip_hand
        points = np.vstack([T_world_tip[:3, 3] + T_world_tip[:3, :3] @ self._tip_hand, self._goal_hands])
        self._grid = HandGrid.around(points, resolution.position, ROOM, sphere)
        # As lists: single entries of arrays are slow to read.
        near = resolution.near * resolution.position
        self._way: list[list[list[float]]] = self._grid.distances(self._goal_hands, near).tolist()
        self._lower, self._shape = self._grid.lower.tolist(), self._grid.is_free.shape
        self._turns: dict[State, _Turn] = {}
        self._redundant_bounds: dict[State, float] = {}
        none = (0,) * (POSE_SIZE + len(self._redundant))
        self._states: list[State] = [none, ()]
        self._q: list[Array] = [q_start, q_start]
        self._heuristics: list[float] = [self._bound(none), 0.0]
        self._nodes: dict[State, list[int]] = {none: [0]}
        self._out: dict[int, list[tuple[int, float]]] = {self.goal: []}
        self._goal_edges: dict[int, GoalEdge] = {}

    def heuristic(self, node: int) -> float:
        """Return the lower bound on the cost from a node to the goals.

        Args:
            node: The node.

        Returns:
            m.
        """
        return self._heuristics[node]

    def successors(self, node: int) -> list[tuple[int, float]]:
        """Return the edges out of a node that are proven free.

        Args:
            node: The node.

        Returns:
            The node at the end of each, and its cost in m.
        """
        if node not in self._out:
            self._out[node] = list(self._edges(node))
        return self._out[node]

    def configurations(self, nodes: tuple[int, ...]) -> tuple[Array, int]:
        """Return the configurations along a path to the goals.

        Args:
            nodes: Nodes from the start to ``goal``.

        Returns:
            (N, n) configurations, and the index of the goal that the last one is in.
        """
        last = self._goal_edges[nodes[-2]]
        return np.array([*(self._q[node] for node in nodes[:-1]), last.q]), last.goal

    @property
    def n_states(self) -> int:
        """Number of states reached so far, the start included."""
        return len(self._states) - 1

    def _edges(self, node: int) -> Iterator[tuple[int, float]]:
        if (last := self._goal_edge(node)) is not None:
            self._goal_edges[node] = last
            yield self.goal, last.cost
        state, q = self._states[node], self._q[node]
        for step, cost in self._primitives:
            after = self._stepped(state, step)
            if self._bound(after) == np.inf:
                continue
            reached = self._solved(after, q)
            if reached is None or np.abs(reached - q).max() > LARGEST_STEP:
                continue
            found = self._node_of(after, reached)
            if found is not None and self._checker.is_valid_edge(q, self._q[found]):
                yield found, cost
            elif found is None and self._checker.is_valid_edge(q, reached):
                yield self._added(after, reached), cost

    @cached_property
    def _primitives(self) -> list[tuple[State, float]]:
        """Steps of the state, and the cost in m of each."""
        given, size = self._resolution, POSE_SIZE + len(self._redundant)
        found = [
            ((*step, *(0,) * (size - 3)), given.position * float(np.linalg.norm(step)))
            for step in STEPS.tolist()
        ]
        for k in range(3, size):
            is_turn = k < POSE_SIZE
            cost = given.angle * given.rotation_cost if is_turn else given.redundant * given.redundant_cost
            found += [(tuple(sign * int(i == k) for i in range(size)), cost) for sign in (-1, 1)]
        return found

    def _stepped(self, state: State, step: State) -> State:
        """Return the state after a step, roll and yaw within one turn."""
        after = [a + b for a, b in zip(state, step, strict=True)]
        half = self._resolution.turns // 2
        for k in (3, 5):
            after[k] = (after[k] + half) % (2 * half) - half
        return tuple(after)

    def _bound(self, state: State) -> float:
        """Return the heuristic of a state, infinite where it is outside of the lattice or never valid."""
        x, y, z = state[0] - self._lower[0], state[1] - self._lower[1], state[2] - self._lower[2]
        n_x, n_y, n_z = self._shape
        if not (0 <= x < n_x and 0 <= y < n_y and 0 <= z < n_z):
            return np.inf
        if abs(state[4]) > self._resolution.turns // 4:
            return np.inf
        way: float = self._way[x][y][z]
        return way if way == np.inf else way + self._turn(state[3:6]).cost + self._redundant_bound(state[6:])

    def _turn(self, angles: State) -> _Turn:
        if angles not in self._turns:
            R = self._R_start @ rotation_rpy(*(self._resolution.angle * k for k in angles))
            least = min(rotation_angle(R.T @ T[:3, :3]) for T in self._goals.T_world_tip)
            tip = self._grid.origin - R @ self._tip_hand
            self._turns[angles] = _Turn(R, tip, self._resolution.rotation_cost * least)
        return self._turns[angles]

    def _redundant_bound(self, steps: State) -> float:
        """Return the cost of the least way of each redundant joint to a goal; 0 if goals are poses only."""
        Q = self._goals.configurations
        if Q is None:
            return 0.0
        if steps not in self._redundant_bounds:
            is_continuous = self._arm.limits.is_continuous
            least = (
                float(np.abs(self._position(j, k) - Q[:, j]).min())
                for j, k in zip(self._redundant, steps, strict=True)
                if not is_continuous[j]
            )
            self._redundant_bounds[steps] = self._resolution.redundant_cost * sum(least)
        return self._redundant_bounds[steps]

    def _position(self, joint: int, steps: int) -> float:
        return float(self._q_start[joint]) + self._resolution.redundant * steps

    def _solved(self, state: State, near: Array) -> Array | None:
        """Return the configuration (n,) of a state on the branch of another one, if there is one."""
        q, turn, step = near.copy(), self._turn(state[3:6]), self._grid.step
        for joint, steps in zip(self._redundant, state[6:], strict=True):
            q[joint] = self._position(joint, steps)
        T = np.eye(4)
        T[:3, :3] = turn.R
        for k in range(3):
            T[k, 3] = turn.tip[k] + step * state[k]
        return self._arm.solve_near(T, self._checker.tool_state, q, self._redundant)

    def _node_of(self, state: State, q: Array) -> int | None:
        for node in self._nodes.get(state, ()):
            if np.abs(self._q[node] - q).max() < SAME:
                return node
        return None

    def _added(self, state: State, q: Array) -> int:
        self._states.append(state)
        self._q.append(q)
        self._heuristics.append(self._bound(state))
        self._nodes.setdefault(state, []).append(len(self._states) - 1)
        return len(self._states) - 1

    def _goal_edge(self, node: int) -> GoalEdge | None:
        """Return the cheapest proven edge from a state into a goal near it."""
        state, q = self._states[node], self._q[node]
        given, R = self._resolution, self._turn(state[3:6]).R
        at = self._grid.origin + self._grid.step * np.array(state[:3])
        ways = np.linalg.norm(self._goal_hands - at, axis=1)
        near = np.flatnonzero(ways <= given.near * given.position).tolist()
        angles = {g: rotation_angle(R.T @ self._goals.T_world_tip[g, :3, :3]) for g in near}
        costs = {
            g: float(ways[g]) + given.rotation_cost * angles[g] for g in near if angles[g] <= given.near_angle
        }
        tried: list[GoalEdge] = []
        for g in sorted(costs, key=costs.__getitem__)[:MOST_GOALS]:
            q_goal = self._in_goal(g, q)
            if q_goal is None or np.abs(q_goal - q).max() > LARGEST_LAST_STEP:
                continue
            joints = list(self._redundant)
            turned = given.redundant_cost * float(np.abs(q_goal - q)[joints].sum())
            tried.append(GoalEdge(g, q_goal, costs[g] + turned))
        for last in sorted(tried, key=lambda last: last.cost):
            if self._checker.is_valid_edge(q, last.q):
                return last
        return None

    def _in_goal(self, g: int, q: Array) -> Array | None:
        """Return a configuration (n,) in a goal, reached from another one without turning round."""
        if (Q := self._goals.configurations) is not None:
            return unwound_towards(self._arm.limits, Q[g], q) if self._goals.in_any_turn else Q[g]
        return self._arm.solve_near(self._goals.T_world_tip[g], self._checker.tool_state, q)
