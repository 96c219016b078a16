"""A controller that keeps a truck on a planned path, for many drives at once.

The errors of a pose against the path are taken in the space (x, y, L yaw), where the path has the unit
tangent (cos phi cos yaw, cos phi sin yaw, sin phi). What is left across it has a part a along the truck's own
y and a part b along the derivative of the tangent by phi. To the first order these obey, with travel and for
every steering angle of the path, a' = b / L and b' = change of phi - a sin^2(phi) / L: a double integrator,
which the steering angle brings to rest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pickcli.driving.drive_plan import DrivePlan
from pickcli.driving.steering_path import wrapped
from pickcli.driving.tricycle import PLANNED_SHARE
from pickcli.geometry import Array

PERIOD = 0.02  # s between two instants of control
RATE = 2.0  # 1 / m of travel, at which errors across the path decay
TABLE_STEP = 0.005  # m of travel between points of the path that the controller looks up
CREEP = 0.03  # m/s, least speed until the end of a part
STOPPED = 0.001  # m from the end of a part at which it is over
OVERSHOOT = 0.05  # m beyond the end of a part at which the truck may be believed to be
PROJECTIONS = 2  # steps by which the point of the path next to the truck is found


class _Reference:
    """The path as a table over travel, with the ends of its parts between cusps."""

    def __init__(self, plan: DrivePlan) -> None:
        path, n = plan.path, int(np.ceil(plan.path.length / TABLE_STEP))
        self.step = path.length / n
        travel = np.linspace(0.0, path.length, n + 1)
        self.poses, self.steering = path.poses_at(travel), path.steering_at(travel)
        self.speeds = np.sqrt(np.interp(travel, plan.profile.travel, plan.profile.speeds**2))
        knots = np.array([0, *path.cusps.tolist(), len(path.steps)])
        self.ends, self.signs = path.knots[knots[1:]], np.sign(path.steps[knots[:-1]])

    def at(self, travel: Array) -> tuple[Array, Array, Array]:
        """(N, 3) poses, (N,) steering angles and (N,) speeds."""
        place = np.clip(travel / self.step, 0.0, len(self.speeds) - 1.001)
        k = place.astype(np.intp)
        part = place - k
        poses = self.poses[k] + part[:, None] * (self.poses[k + 1] - self.poses[k])
        steering = self.steering[k] + part * (self.steering[k + 1] - self.steering[k])
        return poses, steering, self.speeds[k] + part * (self.speeds[k + 1] - self.speeds[k])


def tangents(yaw: Array, steering: Array) -> tuple[Array, Array, Array]:
    """Return the axes in (x, y, L yaw) in which errors against a path are taken.

    Args:
        yaw: (N,) rad of the path.
        steering: (N,) rad of the path.

    Returns:
        (N, 3) each: along the path forwards; along the truck's own y; derivative of the first by steering.
    """
    c, s, cos, sin = np.cos(yaw), np.sin(yaw), np.cos(steering), np.sin(steering)
    return (
        np.column_stack([cos * c, cos * s, sin]),
        np.column_stack([-s, c, np.zeros_like(s)]),
        np.column_stack([-sin * c, -sin * s, cos]),
    )


class TrackingController:
    """The state of the control of many drives of one plan.

    Args:
        plan: The plan.
        n_drives: How many.
    """

    def __init__(self, plan: DrivePlan, n_drives: int) -> None:
        self.truck, self.reference = plan.area.truck, _Reference(plan)
        self.travel = np.zeros(n_drives)  # m along the path
        self.part = np.zeros(n_drives, dtype=np.intp)  # between which cusps
        self.is_done = np.zeros(n_drives, dtype=bool)
        self.speed, self.steering = np.zeros(n_drives), np.zeros(n_drives)  # as commanded
        self.is_held = np.zeros(n_drives, dtype=bool)  # to brake, and stay at rest

    def follow(self, plan: DrivePlan) -> None:
        """Go on by another plan, which is alike up to where the drives are.

        Args:
            plan: The plan.
        """
        self.reference = _Reference(plan)

    @property
    def signs(self) -> Array:
        """(N,) 1 forwards, -1 backwards."""
        signs: Array = self.reference.signs[self.part]
        return signs

    def control(self, believed: Array, is_braked: NDArray[np.bool_] | None = None) -> None:
        """Set speeds and steering angles for the next period, within the limits of the truck.

        Args:
            believed: (N, 3) m, m, rad: poses of the truck as far as is known.
            is_braked: (N,) which trucks brake as hard as they can, and stand then; None for none of them.
        """
        end = self.reference.ends[self.part]
        begin = np.where(self.part > 0, self.reference.ends[self.part - 1], 0.0)
        for _ in range(PROJECTIONS):
            along = self._errors(believed, self.travel)[0]
            self.travel = np.clip(self.travel + self.signs * along, begin, end + OVERSHOOT)
        _, a, b, angles, speeds = self._errors(believed, np.minimum(self.travel, end))
        L = self.truck.wheel_base
        steering = angles + a * np.sin(angles) ** 2 / L - L * RATE**2 * a - 2 * RATE * self.signs * b
        remaining = end - self.travel
        braking = np.sqrt(2 * PLANNED_SHARE * self.truck.acceleration * np.maximum(remaining, 0.0))
        speed = np.where(remaining > STOPPED, np.minimum(np.maximum(speeds, CREEP), braking), 0.0)
        rests = self.is_done if is_braked is None else self.is_done | is_braked
        self._command(np.where(rests | self.is_held, 0.0, speed), steering)

    def _errors(self, believed: Array, travel: Array) -> tuple[Array, Array, Array, Array, Array]:
        """(N,) m along, across and turning; rad of steering and m/s of the path there."""
        poses, angles, speeds = self.reference.at(travel)
        off = believed - poses
        off[:, 2] = self.truck.wheel_base * wrapped(off[:, 2])
        along, across, turning = ((off * axis).sum(1) for axis in tangents(poses[:, 2], angles))
        return along, across, turning, angles, speeds

    def _command(self, speed: Array, steering: Array) -> None:
        """Command what is wanted as far as limits allow: first the speed, which bounds the steering then."""
        truck, L = self.truck, self.truck.wheel_base
        sine = np.maximum(np.abs(np.sin(self.steering)), 1e-9)
        gain = truck.acceleration * PERIOD
        speed = np.minimum(speed, np.sqrt(truck.centripetal * L / sine))
        self.speed = np.clip(np.clip(speed, self.speed - gain, self.speed + gain), 0.0, truck.speed)
        most = np.arcsin(np.minimum(truck.centripetal * L / np.maximum(self.speed, 1e-6) ** 2, 1.0))
        most, turn = np.minimum(most, truck.steering), truck.steering_rate * PERIOD
        steering = np.clip(steering, self.steering - turn, self.steering + turn)
        self.steering = np.where(self.is_done, self.steering, np.clip(steering, -most, most))

    def advance(self) -> None:
        """Count the travel of a period; go on to the next part, or end, where the truck rests at an end."""
        self.travel = self.travel + self.speed * PERIOD
        is_over = (
            ~self.is_held & (self.speed == 0) & (self.reference.ends[self.part] - self.travel <= STOPPED)
        )
        is_last = self.part == len(self.reference.ends) - 1
        self.is_done |= is_over & is_last
        goes_on = is_over & ~is_last
        self.travel[goes_on] = self.reference.ends[self.part[goes_on]]
        self.part[goes_on] += 1
