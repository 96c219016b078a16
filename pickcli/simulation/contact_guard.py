"""Guarded contact: stops the arm before the bellows bottom out, on an item met too early or one that jams.

A tool that approaches a surface with an uncertain position moves until it feels a force (the guarded move
of Will and Grossman, IEEE Transactions on Computers, 1975). The robot senses the force by its motor
torques, as in ``supervision``. Bellows comply, so a touch alone is no reason to stop; the force and the
remaining way to the end of the contact, relative to the belt if the item rides on one, predict how far they
will be compressed. Both change, their sum does not, so it is averaged since the touch. As the cup pushes an
item over or off others, nothing is predicted: the force along and across the cup says how hard it pushes.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from pickcli.geometry import Array, length
from pickcli.kinematics.arm import Arm
from pickcli.kinematics.linear_axis import linear_axis
from pickcli.motion.plan import Plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.simulation.protective_stop import ProtectiveStop, StopCause
from pickcli.simulation.supervision import FILTER_TIME, TORQUE_NOISE, ExternalTorque
from pickcli.simulation.thresholds import Thresholds
from pickcli.simulation.world import World

AVERAGE_TIME = 0.01  # s over which the force of a touch is averaged, after the filter of the torques
CERTAIN_DEVIATIONS = 4.5  # standard deviations above which an averaged force, or a compression, is not noise
LEAST_LEFT = 1e-3  # m left of the contact below which a stop would make no difference
PUSH_TIME = 0.02  # s over which the force of a push is averaged: pushes are slow
PRESSED_ALONG = 0.7  # cosine between a push and the axis of the cup, from which on it presses
MOST_PUSH = 0.6  # of the force of fully compressed bellows, along them: the arm comes to rest later
# The same as it presses on what it turns over: half compressed by plan, and more by the error of a pose.
MOST_PRESS = 0.75
MOST_KNOCK = 0.35  # of the same, across: the side of the cup is rigid


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
        self._white = TORQUE_NOISE / np.sqrt(3.0)  # noise of each torque, as a share of its largest
        self._following = _axis_along_belt(plan, world)
        self._end: tuple[Segment, Array] | None = None  # the last contact, and its tip pose at the end
        self._forget()

    def _forget(self) -> None:
        """Begin a new contact."""
        self._force = 0.0  # N along the tool, averaged
        self._pushing = np.zeros(3)  # N at the tool, averaged
        self._n_pressed, self._pressed = 0, 0.0  # steps since the touch, and mean of the prediction, m

    def update(self, segment: Segment, t_plan: float) -> ProtectiveStop | None:
        """Decide after a step whether the bellows would be compressed too far at the end of the contact.

        Args:
            segment: The current segment.
            t_plan: s of the plan where the robot is.

        Returns:
            The required stop, or None.
        """
        world, grip = self._world, self._world.robot.tool.grip
        if segment.kind not in (SegmentKind.CONTACT, SegmentKind.PUSH) or grip.gives_way == 0.0:
            self._forget()
            return None
        if segment.kind is SegmentKind.PUSH:
            return self._jam(segment)
        tip = self._arm.tip(world.q, segment.tool_state)
        force, noise = self._force_along(tip[:3, 2], segment)
        self._force += world.time_step / AVERAGE_TIME * (force - self._force)
        left = float(self._way_left(segment, tip, t_plan) @ tip[:3, 2])
        if left < LEAST_LEFT:
            return None
        touch = max(self._thresholds.touch, CERTAIN_DEVIATIONS * noise * self._noise_share(AVERAGE_TIME))
        if self._n_pressed == 0 and self._force < touch:
            return None
        self._n_pressed += 1
        self._pressed += (force / grip.stiffness + left - self._pressed) / self._n_pressed
        share = self._noise_share(world.time_step * self._n_pressed / 2)
        uncertain = CERTAIN_DEVIATIONS * noise * share / grip.stiffness
        most = self._thresholds.bellows * grip.gives_way + uncertain
        if self._pressed <= most:
            return None
        return ProtectiveStop(StopCause.EARLY_CONTACT, "bellows", self._pressed, most, "m", world.t)

    def _jam(self, segment: Segment) -> ProtectiveStop | None:
        """The stop if the cup pushes with more force than what it is to push explains."""
        world = self._world
        axis = self._arm.tip(world.q, segment.tool_state)[:3, 2]
        force, covariance = self._tool_force(segment)
        self._pushing += world.time_step / PUSH_TIME * (force - self._pushing)
        along = float(self._pushing @ axis) * axis
        most_along = MOST_PRESS if self._is_pressed else MOST_PUSH
        for push, share in ((along, most_along), (self._pushing - along, MOST_KNOCK)):
            most, measured = share * world.tool.max_press, length(push)
            if measured <= most:
                continue
            way = push / measured
            noise = self._white * float(np.sqrt(way @ covariance @ way)) * self._noise_share(PUSH_TIME)
            most += CERTAIN_DEVIATIONS * noise
            if measured > most:
                return ProtectiveStop(StopCause.CONTACT, "cup", measured, most, "N", world.t)
        return None

    @cached_property
    def _is_pressed(self) -> bool:
        """Whether the first push of the plan leads along the cup, onto what it then turns over."""
        first = next(s for s in self._plan.segments if s.kind is SegmentKind.PUSH)
        q = [self._plan.trajectory.sample(t)[0] for t in (first.t_start, first.t_end)]
        begin, end = (self._arm.tip(each, first.tool_state) for each in q)
        way = end[:3, 3] - begin[:3, 3]
        return bool(begin[:3, 2] @ way > PRESSED_ALONG * length(way))

    def _noise_share(self, average_time: float) -> float:
        """Noise of a torque after its filter and a second one (s), by that of one reading: it is white.

        A mean over a time has the noise of a filter of half of it.
        """
        return float(np.sqrt(self._world.time_step / 2 / (FILTER_TIME + average_time)))

    def _way_left(self, segment: Segment, tip: Array, t_plan: float) -> Array:
        """Way (3,) in m from the tool (4, 4) to where it is at the end of a contact, relative to the item.

        An axis that follows a belt takes the tool along with the item: a leaning cup comes no deeper by it.
        """
        way = np.asarray((self._tip_at_end(segment) - tip)[:3, 3])
        tracking = self._plan.tracking
        if tracking is None:
            return way
        along, ahead = self._world.cell.carriers[tracking.conveyor].T_world_carrier[:3, 0], 0.0
        if self._following is not None:
            axis, sign = self._following
            ahead = sign * float(self._world.q[axis] - self._plan.trajectory.sample(t_plan)[0][axis])
        return np.asarray(way + (ahead - tracking.speed * (segment.t_end - t_plan)) * along)

    def _tip_at_end(self, segment: Segment) -> Array:
        """Tool frame (4, 4) at the end of a contact; cached."""
        if self._end is None or self._end[0] is not segment:
            q = self._plan.trajectory.sample(segment.t_end)[0]
            self._end = segment, self._arm.tip(q, segment.tool_state)
        return self._end[1]

    def _force_along(self, axis: Array, segment: Segment) -> tuple[float, float]:
        """Force in N with which the tool presses along an axis (3,), and its noise by that of one torque.

        The lip rubs on the face; least squares of a force along the axis alone would take that for pressing.
        """
        force, covariance = self._tool_force(segment)
        return float(force @ axis), self._white * float(np.sqrt(axis @ covariance @ axis))

    def _tool_force(self, segment: Segment) -> tuple[Array, Array]:
        """Force (3,) in N with which the tool presses, and its covariance (3, 3) by that of one torque.

        Weighted least squares: each motor's noise is the same share of its largest torque.
        """
        jacobian = self._arm.jacobian(self._world.q, segment.tool_state)[:3]
        per_newton = jacobian / self._motor_forces
        covariance = np.linalg.pinv(per_newton @ per_newton.T)
        return covariance @ per_newton @ (self._external.value / self._motor_forces), covariance


def _axis_along_belt(plan: Plan, world: World) -> tuple[int, float] | None:
    """Index of the joint that follows the belt, and its sign; None without one."""
    if plan.tracking is None:
        return None
    along = world.cell.carriers[plan.tracking.conveyor].T_world_carrier[:3, 0]
    return linear_axis(world.robot, along)
