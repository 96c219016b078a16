"""Guarded contact: stops the arm if the cup meets its item too early, before the bellows bottom out.

A tool that approaches a surface with an uncertain position moves until it feels a force (the guarded move of
Will and Grossman, IEEE Transactions on Computers, 1975). The robot senses the force by its motor torques, as
in ``supervision``. Bellows comply, so a touch alone is no reason to stop; the force and the remaining
distance predict how far they will be compressed at the end of the contact.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.simulation.protective_stop import ProtectiveStop, StopCause
from pickcli.simulation.supervision import FILTER_TIME, TORQUE_NOISE, ExternalTorque
from pickcli.simulation.thresholds import Thresholds
from pickcli.simulation.world import World

AVERAGE_TIME = 0.01  # s over which the force is averaged, after the filter of the torques
CERTAIN_DEVIATIONS = 4.5  # standard deviations of the averaged force above which it is not noise
LEAST_LEFT = 1e-3  # m left of the contact below which a stop would make no difference


class ContactGuard:
    """Guard of the contacts in one execution.

    Args:
        world: The measured world.
        arm: The robot's kinematics.
        plan: The plan in execution.
        external: Motor torque that the motion does not explain, updated after every step.
    """

    def __init__(self, world: World, arm: Arm, plan: Plan, external: ExternalTorque) -> None:
        self._world, self._arm, self._plan, self._external = world, arm, plan, external
        self._thresholds = Thresholds()
        self._motor_forces = np.array([world.robot.motor_forces[name] for name in world.robot.joint_names])
        # Noise of each motor's averaged torque, as a share of its largest: white noise after two filters.
        self._noise = (
            TORQUE_NOISE / np.sqrt(3.0) * np.sqrt(world.time_step / 2 / (FILTER_TIME + AVERAGE_TIME))
        )
        self._force = 0.0  # N at the tool, averaged
        self._end: tuple[Segment, Array] | None = None  # the last contact, and its tip pose at the end

    def update(self, segment: Segment) -> ProtectiveStop | None:
        """Decide after a step whether the bellows would be compressed too far at the end of the contact.

        Args:
            segment: The current segment.

        Returns:
            The required stop, or None.
        """
        world, grip = self._world, self._world.robot.tool.grip
        if segment.kind is not SegmentKind.CONTACT or grip.gives_way == 0.0:
            self._force = 0.0
            return None
        tip = self._arm.tip(world.q, segment.tool_state)
        force, noise = self._force_along(tip[:3, 2], segment)
        self._force += world.time_step / AVERAGE_TIME * (force - self._force)
        left = float((self._tip_at_end(segment) - tip)[:3, 3] @ tip[:3, 2])
        if self._force < max(self._thresholds.touch, CERTAIN_DEVIATIONS * noise) or left < LEAST_LEFT:
            return None
        pressed, most = self._force / grip.stiffness + left, self._thresholds.bellows * grip.gives_way
        if pressed <= most:
            return None
        return ProtectiveStop(StopCause.EARLY_CONTACT, "bellows", pressed, most, "m", world.t)

    def _tip_at_end(self, segment: Segment) -> Array:
        """Tool frame (4, 4) at the end of a contact; cached."""
        if self._end is None or self._end[0] is not segment:
            q = self._plan.trajectory.sample(segment.t_end)[0]
            self._end = segment, self._arm.tip(q, segment.tool_state)
        return self._end[1]

    def _force_along(self, axis: Array, segment: Segment) -> tuple[float, float]:
        """Force in N with which the tool presses along an axis (3,), and the noise of its average.

        Weighted least squares: each motor's noise is the same share of its largest torque.
        """
        jacobian = self._arm.jacobian(self._world.q, segment.tool_state)[:3]
        per_newton = axis @ jacobian / self._motor_forces
        certainty = float(per_newton @ per_newton)
        force = float(per_newton @ (self._external.value / self._motor_forces)) / certainty
        return force, float(self._noise / np.sqrt(certainty))
