"""Guarded moves: slowly along a line until the tip of the tool feels a surface, and back again.

The guarded move of Will and Grossman (IEEE Transactions on Computers, 1975), by which a robot measures with
its own tool. As in ``contact_guard`` the force is felt by the motor torques; it is zeroed on the first
stretch of the line, where nothing can be met yet.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.geometry import Array
from pickcli.motion.plan import Plan
from pickcli.simulation.contact_guard import CERTAIN_DEVIATIONS
from pickcli.simulation.plan_run import PlanRun
from pickcli.simulation.planned_contacts import PlannedContacts
from pickcli.simulation.protective_stop import ProtectiveStop, StopCause
from pickcli.simulation.supervision import FILTER_TIME, TORQUE_NOISE, Supervisor
from pickcli.simulation.world import World

STARTING_TIME = 0.15  # s from rest, after which the arm moves steadily
ZERO_TIME = 0.2  # s over which the force is zeroed
AVERAGE_TIME = 0.02  # s over which the felt force is averaged
BACK_PACE = 8.0  # largest speed of the way back, as a share of the speed of the way in
FIT_STEPS = 10  # for which one fit of the force to the torques is used: the arm turns little meanwhile
PEAK = 1.875  # of the mean speed, of a minimum-jerk motion


@dataclass(frozen=True)
class TouchSensing:
    """How a robot feels a contact.

    Attributes:
        threshold: N along the tool from which on it stops.
        delay: s from a contact until the control knows of it, besides the filter of the torques.
    """

    threshold: float = 4.0
    delay: float = 0.008


@dataclass(frozen=True, eq=False)
class GuardedMove:
    """Record of a guarded move.

    Attributes:
        stop: Why it stopped before its end; None if it came to its end and felt nothing.
        positions: (K, n) measured joints at every step, from the zeroing to the stop.
        forces: (K,) N along the tool that were known then, zeroed and filtered.
        deviation: N, standard deviation of each of these forces.
        lag: s by which they are older than the joints.
        most_force: N, truly, at the tip.
        overshoot: m that the tool went on from the decision to rest.
    """

    stop: ProtectiveStop | None
    positions: Array
    forces: Array
    deviation: float
    lag: float
    most_force: float
    overshoot: float

    @property
    def is_felt(self) -> bool:
        """Whether it stopped because something was felt."""
        return self.stop is not None and self.stop.cause is StopCause.CONTACT and self.stop.where == "tool"


def guarded_move(
    plan: Plan, world: World, may_touch: frozenset[str], sensing: TouchSensing | None = None
) -> GuardedMove:
    """Move along a slow line until the tool feels something, and back to its start.

    Args:
        plan: The line, by the empty tool along its axis, in one state of it; the robot is at its start.
        world: The world.
        may_touch: Names of the solids that the cup may meet; contacts with any other are unplanned.
        sensing: How a contact is felt.

    Returns:
        The record.
    """
    run = _GuardedRun(plan, world, may_touch, sensing or TouchSensing())
    run.play()
    return run.found()


class _GuardedRun(PlanRun[World]):
    """Run of a line that ends at a force."""

    def __init__(self, plan: Plan, world: World, may_touch: frozenset[str], sensing: TouchSensing) -> None:
        super().__init__(plan, world)
        self.world, self.sensing = world, sensing
        self.allowed = PlannedContacts(touching=may_touch, met=may_touch)
        self.supervisor = Supervisor(world, self.arm)
        self.motor_forces = np.array([world.robot.motor_forces[name] for name in world.robot.joint_names])
        self.positions: list[Array] = []
        self.forces: list[float] = []
        self.deviation = 0.0
        self.most_force = 0.0
        self.zeroing: list[float] = []
        n_delayed = max(1, round(sensing.delay / world.time_step))
        self.known = deque([0.0] * n_delayed, maxlen=n_delayed)
        self.felt = 0.0
        self.tip_at_stop: Array | None = None
        self.overshoot = 0.0
        self._per_force: tuple[Array, float] | None = None  # of ``_fit``, and the steps for which it is used
        self._fit_age = 0

    def play(self) -> None:
        """Move along the line, and back to its start."""
        self.world.planned = self.allowed
        super().play()
        self._back()
        self.world.planned = PlannedContacts()

    def found(self) -> GuardedMove:
        """Return the record."""
        n = self.world.robot.n_joints
        positions = np.array(self.positions).reshape(-1, n)
        return GuardedMove(
            self.stop, positions, np.array(self.forces), self.deviation, FILTER_TIME + self.sensing.delay,
            self.most_force, self.overshoot,
        )  # fmt: skip

    def after_step(self) -> None:
        """Record the largest true force at the tip, and how far it goes on after the decision to stop."""
        force = sum(point.force for point in self.world.grip.contact_points)
        self.most_force = max(self.most_force, force)
        if self.stop is not None:
            tip = self.world.tip
            if self.tip_at_stop is None:
                self.tip_at_stop = tip
            on = float((tip - self.tip_at_stop)[:3, 3] @ tip[:3, 2])
            self.overshoot = max(self.overshoot, on)

    def reason_to_stop(self, command: Array, t_plan: float) -> ProtectiveStop | None:
        """Stop as the tool feels a force above the threshold, or as every motion is supervised."""
        world, segment = self.world, self.plan.segments[0]
        if stop := self.supervisor.motion(command, segment):
            return stop
        force, noise = self._force(segment.tool_state)
        self.deviation = noise * float(np.sqrt(world.time_step / 2 / FILTER_TIME))
        late = self.known[0]
        self.known.append(force)
        t = t_plan
        if t < STARTING_TIME:
            return None
        if t < STARTING_TIME + ZERO_TIME:
            self.zeroing.append(late)
            return None
        late -= float(np.mean(self.zeroing))
        self.positions.append(world.q.copy())
        self.forces.append(late)
        self.felt += world.time_step / AVERAGE_TIME * (late - self.felt)
        share = float(np.sqrt(world.time_step / 2 / (FILTER_TIME + AVERAGE_TIME)))
        threshold = max(self.sensing.threshold, CERTAIN_DEVIATIONS * noise * share)
        if self.felt < threshold:
            return None
        return ProtectiveStop(StopCause.CONTACT, "tool", self.felt, threshold, "N", world.t)

    def _force(self, state: ToolState) -> tuple[float, float]:
        """Force in N along the tool by the motor torques, and its noise if they are not filtered."""
        if self._per_force is None or self._fit_age >= FIT_STEPS:
            self._per_force, self._fit_age = self._fit(state), 0
        self._fit_age += 1
        per_torque, noise = self._per_force
        return float(per_torque @ self.supervisor.external.value), noise

    def _fit(self, state: ToolState) -> tuple[Array, float]:
        """Weighted least squares of a force in any direction, its part along the tool.

        Returns:
            (n,) N per torque, and the noise of the sum, N.
        """
        per_newton = self.arm.jacobian(self.world.q, state)[:3] / self.motor_forces
        covariance = np.linalg.pinv(per_newton @ per_newton.T)
        axis = self.arm.tip(self.world.q, state)[:3, 2]
        white = TORQUE_NOISE / np.sqrt(3.0)
        noise = white * float(np.sqrt(axis @ covariance @ axis))
        return axis @ covariance @ per_newton / self.motor_forces, noise

    def _back(self) -> None:
        """Go back along the line to its start, from rest to rest, with minimum jerk."""
        end = self.trace.plan_times[-1]
        n = max(1, int(np.ceil(PEAK * end / BACK_PACE / self.world.time_step)))
        for x in np.arange(1, n + 1) / n:
            share = 1.0 - x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
            q = self.plan.trajectory.sample(end * share)[0]
            self.trace.sent.append(q)
            self.trace.plan_times.append(end * share)
            self.world.command(q)
            self.step()
        self.world.wait(0.05)
