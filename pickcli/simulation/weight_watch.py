"""Weighs what the tool carries by the motor torques, and stops if that cannot be the item of the plan.

A load of mass m whose centre accelerates with a is held by the force m (a - g), which the motors measure as
torques m Jᵀ(a - g) beyond those of the robot's own motion, with the Jacobian J of the centre. The mass that
fits them best is found by weighted least squares over lift and retreat (C. G. Atkeson, C. H. An and J. M.
Hollerbach, "Estimation of inertial parameters of manipulator loads and links", IJRR 5(3), 1986, for the mass
alone). Each motor's noise is the same share of its largest torque.
"""

from __future__ import annotations

from collections import deque

import numpy as np

from pickcli.geometry import GRAVITY, Array, inverse
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.simulation.protective_stop import ProtectiveStop, StopCause
from pickcli.simulation.supervision import TORQUE_NOISE, ExternalTorque
from pickcli.simulation.thresholds import Thresholds
from pickcli.simulation.world import World

WEIGHED_IN = (SegmentKind.LIFT, SegmentKind.RETREAT)
LEAST_TIME = 0.3  # s of lift and retreat, below which the mass is not judged
READ_TIME = 0.05  # s after the retreat until the mass is judged: a sensor that reads nothing comes first
SETTLING = 0.1  # s after the beginning of the lift, in which the tool takes the weight up
CERTAIN_DEVIATIONS = 4.5  # standard deviations beyond which a difference is not noise
STEPS = 5  # between the configurations from whose differences the acceleration is computed
UP = np.array([0.0, 0.0, GRAVITY])


class WeightWatch:
    """Watches the mass of the held item in one execution.

    Args:
        world: The measured world.
        arm: The robot's kinematics.
        plan: The plan in execution.
        external: Motor torque that the motion does not explain, updated after every step.
        thresholds: Thresholds of a stop.
    """

    def __init__(
        self,
        world: World,
        arm: Arm,
        plan: Plan,
        external: ExternalTorque,
        thresholds: Thresholds | None = None,
    ) -> None:
        self._world, self._arm, self._plan, self._external = world, arm, plan, external
        self._thresholds = thresholds or Thresholds()
        robot = world.robot
        self._motor_forces = np.array([robot.motor_forces[name] for name in robot.joint_names])
        self._t_lift, self._t_weighed = np.inf, -np.inf  # s: first step of the lift, last step of the retreat
        self._recent: deque[tuple[Array, Array]] = deque(maxlen=2 * STEPS + 1)  # centre, its Jacobian
        self._n_weighed = 0
        self._product = self._square = 0.0  # sums of the least squares
        self._is_judged = plan.grasp is None

    @property
    def mass(self) -> float | None:
        """Mass of what is held, kg; None as long as it has not been weighed."""
        return self._product / self._square if self._n_weighed else None

    @property
    def deviation(self) -> float:
        """Standard deviation of the mass by the noise of the torques, kg: large where motors lack a lever."""
        return TORQUE_NOISE / np.sqrt(3.0 * self._square) if self._n_weighed else np.inf

    def update(self, segment: Segment) -> ProtectiveStop | None:
        """Weigh in a step of lift or retreat; decide once, after them.

        Args:
            segment: The current segment.

        Returns:
            The required stop, or None.
        """
        if self._is_judged or segment.held is None:
            return None
        if segment.kind in WEIGHED_IN and segment.held == self._held:
            self._weigh(segment)
            return None
        if segment.kind is SegmentKind.CONTACT or self._world.t < self._t_weighed + READ_TIME:
            return None
        self._is_judged = True
        return self._judged()

    @property
    def _held(self) -> str:
        assert self._plan.grasp is not None
        return self._plan.grasp.item

    def _weigh(self, segment: Segment) -> None:
        self._t_lift, self._t_weighed = min(self._t_lift, self._world.t), self._world.t
        if segment.pushing:  # neighbours press on it, too
            self._recent.clear()
            return
        self._recent.append(self._centre(segment))
        if len(self._recent) < 2 * STEPS + 1 or self._world.t - self._t_lift < SETTLING:
            return
        first, (middle, jacobian), last = self._recent[0][0], self._recent[STEPS], self._recent[-1][0]
        acceleration = (first - 2.0 * middle + last) / (STEPS * self._world.time_step) ** 2
        per_kg = jacobian.T @ (acceleration + UP) / self._motor_forces
        self._product += float(per_kg @ (self._external.value / self._motor_forces))
        self._square += float(per_kg @ per_kg)
        self._n_weighed += 1

    def _centre(self, segment: Segment) -> tuple[Array, Array]:
        """Centre (3,) of the held item in the world, and its Jacobian (3, n)."""
        assert self._plan.grasp is not None
        T_world_tip = self._arm.tip(self._world.q, segment.tool_state)
        jacobian = self._arm.jacobian(self._world.q, segment.tool_state)
        centre = (T_world_tip @ inverse(self._plan.grasp.T_item_tip))[:3, 3]
        turning = np.cross(jacobian[3:].T, centre - T_world_tip[:3, 3]).T
        return centre, jacobian[:3] + turning

    def _judged(self) -> ProtectiveStop | None:
        """The stop if what is held is lighter or heavier than the item can be."""
        if self.mass is None or self._n_weighed * self._world.time_step < LEAST_TIME:
            return None
        item = self._world.scene.find(self._held).item
        doubt = self._thresholds.mass + CERTAIN_DEVIATIONS * self.deviation
        least, most = item.lightest - doubt, item.heaviest + doubt
        if least <= self.mass <= most:
            return None
        passed = least if self.mass < least else most
        return ProtectiveStop(StopCause.WRONG_WEIGHT, self._held, self.mass, passed, "kg", self._world.t)
