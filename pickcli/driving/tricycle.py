"""The truck: a tricycle, driven and steered by the wheel at its front, on an axle that does not turn.

Its frame is in the middle of the axle, x towards the steered wheel, so that forks point along -x. With the
travel s of the steered wheel as the parameter, in m and negative backwards, and the steering angle phi:
dx/ds = cos(phi) cos(yaw), dy/ds = cos(phi) sin(yaw), d(yaw)/ds = sin(phi) / wheel base. Nothing in it grows
without bounds as phi comes near a right angle, where the truck turns about the middle of its axle.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pickcli.geometry import Array

STEERING_RESERVE = 0.05  # rad of the steering angle that plans leave to the controller
PLANNED_SHARE = 0.9  # of speed, accelerations and steering rate that plans use

_GAUSS, _WEIGHTS = np.polynomial.legendre.leggauss(8)
_FRACTIONS, _WEIGHTS = (_GAUSS + 1) / 2, _WEIGHTS / 2  # of a step, from its start


@dataclass(frozen=True)
class Tricycle:
    """Figures of a truck. Those of the axle and the steering are of the Linde CitiTruck of APPLE.

    Attributes:
        wheel_base: m from the axle to the steered wheel.
        front: m from the axle to the front end of the truck.
        back: m from the axle to its rear end, the tips of its forks.
        width: m.
        steering: rad, largest steering angle either way.
        steering_rate: rad/s.
        speed: m/s of the steered wheel.
        acceleration: m/s^2 of the steered wheel, to brake and to speed up.
        centripetal: m/s^2, speed of the steered wheel times yaw rate.
    """

    wheel_base: float = 1.19
    front: float = 1.6
    back: float = 0.3
    width: float = 0.8
    steering: float = 1.5
    steering_rate: float = 1.0
    speed: float = 1.0
    acceleration: float = 1.0
    centripetal: float = 0.5

    @property
    def planned_steering(self) -> float:
        """Rad, largest steering angle of a plan."""
        return self.steering - STEERING_RESERVE

    @property
    def inner_radius(self) -> float:
        """Radius (m) of the largest disc around the middle of the axle that the truck covers."""
        return min(self.front, self.back, self.width / 2)

    @cached_property
    def corners(self) -> Array:
        """(4, 2) m: corners of the truck seen from above, in its frame, counterclockwise."""
        half = self.width / 2
        return np.array([[-self.back, -half], [self.front, -half], [self.front, half], [-self.back, half]])

    @cached_property
    def sweep(self) -> float:
        """Most that any point of the truck moves per m of travel: in a corner, where it is largest."""
        return float(self.sweeps(self.corners).max())

    def sweeps(self, points: Array) -> Array:
        """Return how far points of the truck move at most, at any steering angle.

        A point (a, b) moves by (cos phi - b sin phi / L, a sin phi / L) per m of travel: the largest singular
        value of that map from (cos phi, sin phi) bounds it.

        Args:
            points: (N, 2) m in the frame of the truck.

        Returns:
            (N,) m per m of travel of the steered wheel.
        """
        a, b = points[:, 0] / self.wheel_base, points[:, 1] / self.wheel_base
        maps = np.stack([np.stack([np.ones_like(b), -b], -1), np.stack([np.zeros_like(a), a], -1)], 1)
        most: Array = np.linalg.norm(maps, 2, axis=(1, 2))
        return most

    def yaw_change(self, before: Array, after: Array, step: Array) -> Array:
        """Return how far a step turns the truck, while the steering angle changes linearly with travel.

        Args:
            before: (...) rad, steering angle before the step.
            after: (...) rad, after it.
            step: (...) m of travel, signed.

        Returns:
            (...) rad, in closed form.
        """
        turn: Array = step / self.wheel_base * np.sin((before + after) / 2)
        return turn * np.sinc((after - before) / (2 * np.pi))

    def displacement(self, yaw: Array, before: Array, after: Array, step: Array) -> Array:
        """Return how far a step moves the middle of the axle; by Gauss's quadrature, exact to 1e-9 m.

        Args:
            yaw: (...) rad before the step.
            before: (...) rad, steering angle before the step.
            after: (...) rad, after it.
            step: (...) m of travel, signed, in which the truck turns by at most 3 rad.

        Returns:
            (..., 2) m in the frame of the yaw.
        """
        parts = np.asarray(step)[..., None] * _FRACTIONS
        phi = before[..., None] + (after - before)[..., None] * _FRACTIONS
        angle = yaw[..., None] + self.yaw_change(before[..., None], phi, parts)
        along = np.cos(phi) * _WEIGHTS * np.asarray(step)[..., None]
        return np.stack([(along * np.cos(angle)).sum(-1), (along * np.sin(angle)).sum(-1)], -1)
