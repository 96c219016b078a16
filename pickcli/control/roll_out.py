"""Roll-out of a stack of tasks: the controller alone, period by period, each step with a proof.

Source: Krug et al., RA-L 2016, section III-B. Their controller knows no future: a roll-out ends where nothing
gets better any more, and says so; region queries and planners take over there.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from pickcli.collision.kernel_validator import KernelValidator
from pickcli.control.hierarchical_qp import BoundedRows, solve
from pickcli.control.tasks.task import ControlState, Task
from pickcli.errors import NoPlanError
from pickcli.geometry import Array

PERIOD = 0.01  # s
NO_PROGRESS = 0.2  # s without a smaller error, and still: a local minimum
NO_PROGRESS_MOVING = 2.0  # s without a smaller error while it moves: an overshoot takes less
STILL = 0.05  # rad/s or m/s
NO_NEARER = 1e-4  # m by which a step from within the margin is proven to come nearer at most before its end
LEAST_PROGRESS = 0.01  # of the error, by which it has to shrink in that time


@dataclass(frozen=True, eq=False)
class Stack:
    """Tasks in levels of strict priority.

    Attributes:
        levels: The tasks of each level, the most important level first.
        goal: Name of the task that ends the roll-out when it is met.
        deceleration: (n,) rad/s^2 or m/s^2, with which the joints brake.
    """

    levels: tuple[tuple[Task, ...], ...]
    goal: str
    deceleration: Array

    def braked(self, state: ControlState) -> Array:
        """Return the joint rates of a period in which every joint brakes.

        Args:
            state: The robot now.

        Returns:
            (n,) rad/s or m/s.
        """
        change = self.deceleration * state.period
        return np.asarray(state.dq - np.clip(state.dq, -change, change))


@dataclass(frozen=True, eq=False)
class ControlScene:
    """What the controller knows at an instant.

    Attributes:
        stack: The tasks, with the object where it is seen now.
        validator: Proves the straight step of a period free.
    """

    stack: Stack
    validator: KernelValidator


class End(Enum):
    """How a roll-out ended."""

    REACHED = "reached"
    LOCAL_MINIMUM = "local minimum"
    NOT_PROVEN = "step not proven free"
    NOT_SOLVED = "hierarchy not solved"
    OUT_OF_TIME = "out of time"


@dataclass(frozen=True, eq=False)
class RollOut:
    """What a controller did.

    Attributes:
        end: How it ended.
        Q: (N + 1, n) configurations, a period apart.
        errors: By task, (N + 1,) its error.
        slack: (N, levels) norm of what each level gave way, per s.
        period: s.
    """

    end: End
    Q: Array
    errors: dict[str, Array]
    slack: Array
    period: float

    @property
    def rates(self) -> Array:
        """(n,) joint rates at the end, in rad/s or m/s."""
        last = self.Q[-1] - self.Q[-2] if len(self.Q) > 1 else np.zeros(self.Q.shape[1])
        return np.asarray(last / self.period)

    @property
    def duration(self) -> float:
        """Duration in s."""
        return self.period * (len(self.Q) - 1)

    def then(self, later: RollOut) -> RollOut:
        """Join a roll-out of the same tasks that begins where this one ended.

        Args:
            later: What goes on.

        Returns:
            Both as one.
        """
        errors = {name: np.concatenate([each[:-1], later.errors[name]]) for name, each in self.errors.items()}
        Q, slack = np.vstack([self.Q[:-1], later.Q]), np.vstack([self.slack, later.slack])
        return RollOut(later.end, Q, errors, slack, self.period)


def roll_out(
    scene_at: Callable[[float], ControlScene],
    start: Array,
    most_seconds: float,
    period: float = PERIOD,
    rates: Array | None = None,
) -> RollOut:
    """Let a controller run until its goal is met, or nothing gets better.

    Where a step is not proven free, the joints brake instead. The roll-out ends where that is not proven
    either, where steps are refused until nothing gets better, and where the hierarchy is not solved. If the
    scene changes so that the margin cannot be kept, not even by braking, the joints brake as long as that is
    proven to touch nothing, and take steps that are proven to lead away, until it is kept again.

    Args:
        scene_at: What is known at a time in s from the start: the same object as long as nothing changes.
        start: (n,) configuration, free.
        most_seconds: s after which it ends.
        period: s between two instants of control.
        rates: (n,) joint rates before, in rad/s or m/s; at rest by default.

    Returns:
        The roll-out.
    """
    q, dq = np.array(start, dtype=float), np.zeros(len(start)) if rates is None else rates
    record = _Record(period, [q], [], [], [])
    best, since, refused = np.inf, 0.0, -np.inf
    before, is_too_near = scene_at(0.0), False
    last = int(most_seconds / period + 1e-9)
    for i in range(last + 1):
        now, state = scene_at(i * period), ControlState(q, dq, period)
        left = record.note(now.stack, state)
        if is_too_near or now is not before:
            is_too_near = not _brakes_free(now, state)
        if left <= 0.0 and not is_too_near:
            return record.ended(End.REACHED)
        if left < (1.0 - LEAST_PROGRESS) * best or now is not before:
            best, since, before = left, i * period, now
        stalled, is_still = i * period - since, float(np.abs(dq).max()) < STILL
        if stalled > (NO_PROGRESS if is_still else NO_PROGRESS_MOVING):
            return record.ended(End.NOT_PROVEN if i * period - refused < NO_PROGRESS else End.LOCAL_MINIMUM)
        if i == last:
            break
        try:
            step = control_step(now.stack, state)
        except NoPlanError:
            return record.ended(End.NOT_SOLVED)
        proven = _proven(now, state, step.dq, is_too_near)
        if proven is None:
            return record.ended(End.NOT_PROVEN)
        if proven is not step.dq:
            refused = i * period
        q, dq = q + period * proven, proven
        record.Q.append(q)
        record.slack.append(step.slack)
    return record.ended(End.OUT_OF_TIME)


@dataclass(frozen=True, eq=False)
class _Record:
    """What a roll-out did so far."""

    period: float
    Q: list[Array]
    errors: list[dict[str, float]]
    slack: list[Array]
    n_levels: list[int]

    def note(self, stack: Stack, state: ControlState) -> float:
        """Note the errors of all tasks; return that of the goal."""
        self.errors.append({task.name: task.error(state) for level in stack.levels for task in level})
        self.n_levels.append(len(stack.levels))
        return self.errors[-1][stack.goal]

    def ended(self, end: End) -> RollOut:
        errors = {name: np.array([each[name] for each in self.errors]) for name in self.errors[0]}
        slack = np.array(self.slack).reshape(len(self.slack), self.n_levels[0])
        return RollOut(end, np.stack(self.Q), errors, slack, self.period)


@dataclass(frozen=True, eq=False)
class ControlStep:
    """Answer of a controller at one instant.

    Attributes:
        dq: (n,) joint rates for the next period, in rad/s or m/s.
        slack: (levels,) norm of what each level gives way, per s.
    """

    dq: Array
    slack: Array


def control_step(stack: Stack, state: ControlState) -> ControlStep:
    """Solve a stack at one instant.

    Args:
        stack: The tasks.
        state: The robot now.

    Returns:
        The joint rates, and what each level gives way.

    Raises:
        NoPlanError: The hierarchical QP was not solved.
    """
    levels = [_joined([task.rows(state) for task in level]) for level in stack.levels]
    solved = solve(levels, state.dq)
    return ControlStep(solved.x, np.array([np.linalg.norm(each) for each in solved.violations]))


def _joined(rows: Sequence[BoundedRows]) -> BoundedRows:
    return BoundedRows(
        np.concatenate([each.rows for each in rows]),
        np.concatenate([each.lower for each in rows]),
        np.concatenate([each.upper for each in rows]),
    )


def _brakes_free(now: ControlScene, state: ControlState) -> bool:
    """Whether the margin is kept, and stays so if every joint brakes until it rests."""
    path = [state.q]
    while state.dq.any():
        dq = now.stack.braked(state)
        state = ControlState(state.q + state.period * dq, dq, state.period)
        path.append(state.q)
    validator = now.validator
    # Of a step that begins right at the margin nothing can be proven.
    has_room = validator.at_margin(validator.margin + NO_NEARER).is_valid(path[0])
    return has_room and (len(path) == 1 or validator.is_valid_path(np.stack(path)))


def _proven(now: ControlScene, state: ControlState, dq: Array, is_too_near: bool) -> Array | None:
    """Return rates whose step is proven: dq, or what hard braking leaves of the last ones; else None."""
    q, validator, braked = state.q, now.validator, now.stack.braked(state)
    for rates in (dq, braked):
        to = q + state.period * rates
        if validator.is_valid_edge(q, to) or (is_too_near and _leads_away(validator, q, to)):
            return rates
    if is_too_near and validator.at_margin(NO_NEARER).is_valid_edge(q, q + state.period * braked):
        return braked
    return None


def _leads_away(validator: KernelValidator, q: Array, to: Array) -> bool:
    """Whether a step touches nothing, and comes nearer to nothing that is within the margin at its end."""
    least, _ = validator.clearances(np.stack([q, to]), validator.margin)
    if least <= NO_NEARER or not validator.at_margin(least - NO_NEARER).is_valid_edge(q, to):
        return False
    before, then = (_distances(validator, each) for each in (q, to))
    return all(distance >= before.get(pair, validator.margin) for pair, distance in then.items())


def _distances(validator: KernelValidator, q: Array) -> dict[tuple[int, ...], float]:
    """Return the distances (m) of pairs that are within the margin."""
    distances, _, parts = validator.kernel.near_pairs(q, validator.margin)
    found: dict[tuple[int, ...], float] = {}
    for pair, distance in zip(map(tuple, parts.tolist()), distances.tolist(), strict=True):
        found[pair] = min(distance, found.get(pair, np.inf))
    return found
