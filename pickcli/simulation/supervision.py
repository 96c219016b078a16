"""Supervision during motion: following error, unexplained motor torque, and hold.

Uses only what a real robot has: commands, encoders, motor torques, its own model, the vacuum gauge.
Thresholds and their sources are in docs/supervision.md.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from pickcli.cell.robot import JointType
from pickcli.cell.tool import MOVING, ToolState
from pickcli.geometry import GRAVITY, Array, length
from pickcli.kinematics.arm import Arm
from pickcli.motion.segment import Segment
from pickcli.seeds import derived_rng
from pickcli.simulation.following import JointFollowing
from pickcli.simulation.protective_stop import ProtectiveStop, StopCause
from pickcli.simulation.thresholds import Thresholds
from pickcli.simulation.world import World

TORQUE_NOISE = 0.02  # share of a motor's largest torque: error of a torque estimated from the current
FILTER_TIME = 4e-3  # s, time constant of the filter for the unexplained torque
PAYLOAD_FACTOR = 1.5  # allowance over weight and inertia of the held item, for acceleration and mass error
RELEASED_WEIGHT_TIME = 0.5  # s after a planned release during which the item's weight may still act
_ONES, _ROOT_3 = np.ones(3), float(np.sqrt(3.0))

Dynamics = Callable[[Array, Array, Array], Array]  # q, dq, ddq (m,) -> motor torques (m,)


class ExternalTorque:
    """Motor torque that the robot's own model of its motion does not explain, filtered.

    The residual of inverse dynamics, as used by De Luca and Mattone (2005) and Haddadin, De Luca and
    Albu-Schaeffer (2017, sec. IV) for collision detection. A force f at a point with Jacobian J appears as
    J^T f. The noise floor is that of the torques: ``TORQUE_NOISE`` before the filter.

    Args:
        dynamics: Function from joint positions, velocities and accelerations (m,) to motor torques (m,).
        forces: (n,) largest motor torques.
        time_step: s.
        seed: Seed of the noise.
    """

    def __init__(self, dynamics: Dynamics, forces: Array, time_step: float, seed: int) -> None:
        self._dynamics, self._time_step = dynamics, time_step
        self._noise, self._share = TORQUE_NOISE * forces, time_step / FILTER_TIME
        self._rng = derived_rng(seed, "motor torques")
        self._before: list[Array] = []  # the last two measured configurations, including the tool's joint
        self.value = np.zeros(len(forces))

    def update(self, q: Array, torques: Array) -> Array:
        """Update the unexplained torque with a measurement.

        Args:
            q: (m,) measured joints.
            torques: (n,) measured motor torques.

        Returns:
            (n,) Nm or N.
        """
        if len(self._before) == 2:
            first, second = self._before
            v, w = (second - first) / self._time_step, (q - second) / self._time_step
            needed = self._dynamics(second, v, (w - v) / self._time_step)[: len(torques)]
            noise = self._noise * self._rng.uniform(-1.0, 1.0, len(torques))
            self.value = self.value + self._share * (torques + noise - needed - self.value)
        self._before = [*self._before[-1:], q]
        return self.value


class Supervisor:
    """Supervises every step of one execution.

    Args:
        world: The measured world.
        arm: The robot's kinematics.
        thresholds: Thresholds of a stop.
        p_tip_item: (3,) m, middle of the item that is to be held, in the tool frame; None for the tip itself.
    """

    def __init__(
        self, world: World, arm: Arm, thresholds: Thresholds | None = None, p_tip_item: Array | None = None
    ) -> None:
        self._world, self._arm, self._p_tip_item = world, arm, p_tip_item
        self._thresholds = thresholds or Thresholds()
        self._names = world.robot.joint_names
        self._is_linear = {j.name: j.type is JointType.PRISMATIC for j in world.robot.joints}
        self._forces = np.array([world.robot.motor_forces[name] for name in self._names])
        self._most_torque = self._thresholds.torque * self._forces
        seed = world.seed + round(world.t / world.time_step)
        self.external = ExternalTorque(world.inverse_dynamics, self._forces, world.time_step, seed)
        self._joints = JointFollowing(world.q, world.time_step, self._thresholds)
        is_turning = np.array([not self._is_linear[name] for name in self._names])
        self._acceleration = is_turning * world.robot.limits.acceleration  # (n,) rad/s^2
        self._weight, self._inertia, self._t_held = 0.0, 0.0, -np.inf
        self._weighed: Segment | None = None  # the last segment with a held item, whose payload is cached
        self._payload = 0.0, 0.0
        self._hold_watch = world.tool.watch(self._thresholds)

    def motion(self, command: Array, segment: Segment) -> ProtectiveStop | None:
        """Check after a step that the robot follows and feels no unexpected contact.

        Args:
            command: (n,) commanded configuration.
            segment: The current segment.

        Returns:
            The required stop, or None.
        """
        unexplained = self.external.update(self._world.joints, self._world.torques)
        self._remember(command, segment)
        return self._contact(unexplained) or self._following(command)

    def hold(self, segment: Segment) -> ProtectiveStop | None:
        """Check after a step that the seal or grasp is as the plan requires.

        Args:
            segment: The current segment.

        Returns:
            The required stop, or None.
        """
        return self._hold_watch.stop(segment, self._world.t)

    def feel(self) -> float:
        """Update measurements while the robot brakes.

        Returns:
            Result of ``pressing``.
        """
        self.external.update(self._world.joints, self._world.torques)
        return self.pressing()

    def pressing(self) -> float:
        """Compute the largest unexplained torque of all joints, as a share of its threshold.

        Returns:
            The share.
        """
        return float((np.abs(self.external.value) / self._most_torque).max())

    def _remember(self, command: Array, segment: Segment) -> None:
        world = self._world
        self._joints.remember(command)
        if segment.held is not None:
            if segment is not self._weighed:
                item = world.scene.find(segment.held).item
                inertia = float(np.linalg.eigvalsh(item.inertia)[-1])
                self._weighed = segment
                self._payload = PAYLOAD_FACTOR * GRAVITY * item.mass, PAYLOAD_FACTOR * inertia
            (self._weight, self._inertia), self._t_held = self._payload, world.t
        elif world.t - self._t_held > RELEASED_WEIGHT_TIME:
            self._weight = self._inertia = 0.0

    def _contact(self, unexplained: Array) -> ProtectiveStop | None:
        force = self._weight + (self._thresholds.planned_force if self._world.planned.touching else 0.0)
        limits = self._most_torque
        if not (np.abs(unexplained) > limits).any():
            return None
        if force > 0.0:
            jacobian = self._arm.jacobian(self._world.q, self._tool_state())
            reach = np.linalg.norm(jacobian[:3], axis=0)
            limits = limits + force * reach + self._weight * self._farther(jacobian, reach)
            limits = limits + self._inertia * self._acceleration
        worst = int(np.argmax(np.abs(unexplained) / limits))
        if abs(unexplained[worst]) <= limits[worst]:
            return None
        unit = "N" if self._is_linear[self._names[worst]] else "Nm"
        return self._stop(
            StopCause.CONTACT, self._names[worst], abs(unexplained[worst]), limits[worst], unit
        )  # fmt: skip

    def _farther(self, jacobian: Array, reach: Array) -> Array:
        """Return m by which the held item's middle is farther from the axes than the tip, where it is.

        jacobian: (6, n) of the tip. reach: (n,) m, of the tip
        """
        if self._p_tip_item is None or self._weight == 0.0:
            return np.zeros(len(reach))
        lever = self._arm.tip(self._world.q, self._tool_state())[:3, :3] @ self._p_tip_item
        at_item = jacobian[:3] + np.cross(jacobian[3:].T, lever).T
        return np.asarray(np.maximum(np.linalg.norm(at_item, axis=0) - reach, 0.0))

    def _following(self, command: Array) -> ProtectiveStop | None:
        q = self._world.q
        if (off := self._joints.worst(q)) is not None:
            joint, error, allowed = off
            unit = "m" if self._is_linear[self._names[joint]] else "rad"
            return self._stop(StopCause.FOLLOWING_ERROR, self._names[joint], error, allowed, unit)
        return self._tool_following(command, q)

    def _tool_following(self, command: Array, q: Array) -> ProtectiveStop | None:
        """Check the tool's following error, by the Jacobian because this runs every millisecond."""
        jacobian = self._arm.jacobian(q, self._tool_state())[:3]
        error = length(jacobian @ (command - q))
        speed = float(np.abs(jacobian) @ self._joints.speed @ _ONES) / _ROOT_3
        allowed = self._thresholds.tool + self._thresholds.lag * speed
        if error > allowed:
            return self._stop(StopCause.FOLLOWING_ERROR, "tool", error, allowed, "m")
        return None

    def _tool_state(self) -> ToolState:
        tool_state = self._world.tool_state
        return self._arm.robot.tool.default_state if tool_state == MOVING else tool_state

    def _stop(
        self, cause: StopCause, where: str, measured: float, threshold: float, unit: str
    ) -> ProtectiveStop:  # fmt: skip
        return ProtectiveStop(cause, where, float(measured), float(threshold), unit, self._world.t)
