"""Whether a truck that begins to brake now still comes too near to someone who walks on, or stops."""

from __future__ import annotations

import numpy as np

from pickcli.driving.steering_path import SteeringPath, seen_from
from pickcli.driving.tricycle import Tricycle
from pickcli.geometry import Array
from pickcli.watching.stopping_distance import stopping_time, travel_while_stopping

INSTANTS = 13  # of the time to rest, at which distances are looked at


def outline_distance(truck: Tricycle, poses: Array, places: Array) -> Array:
    """Return distances of places from the truck's outline.

    Args:
        truck: The truck.
        poses: (N, 3) m, m, rad.
        places: (N, 2) m.

    Returns:
        (N,) m, 0 inside.
    """
    local = seen_from(poses, np.column_stack([places, np.zeros(len(places))]))
    x = np.maximum(local[:, 0] - truck.front, -truck.back - local[:, 0])
    y = np.abs(local[:, 1]) - truck.width / 2
    return np.hypot(np.maximum(x, 0.0), np.maximum(y, 0.0))


def stopping_poses(
    truck: Tricycle, pose: Array, motion: tuple[float, float], delay: float, n_instants: int = INSTANTS
) -> tuple[Array, Array]:
    """Return where a truck is while it brakes, with the steering angle that it has.

    Args:
        truck: The truck.
        pose: (3,) m, m, rad.
        motion: Speed of the steered wheel, m/s, negative backwards, and steering angle, rad.
        delay: s until it begins to brake.
        n_instants: How many instants.

    Returns:
        (N,) s from now to the rest, (N, 3) poses.
    """
    speed, steering = abs(motion[0]), motion[1]
    times = np.linspace(0.0, stopping_time(speed, delay, truck.acceleration), n_instants)
    travel = np.array([travel_while_stopping(speed, delay, truck.acceleration, t) for t in times.tolist()])
    if travel[-1] <= 0:
        return times, np.tile(pose, (n_instants, 1))
    path = SteeringPath(truck, pose, np.copysign(travel[-1:], motion[0]), np.full(2, steering))
    return times, path.poses_at(travel)


def nearest_while_stopping(
    truck: Tricycle, stopping: tuple[Array, Array], place: Array, velocity: Array
) -> float:
    """Return how near a braking truck comes to someone who walks on straight.

    Args:
        truck: The truck.
        stopping: (N,) s and (N, 3) poses, of ``stopping_poses``.
        place: (2,) m where the person is now.
        velocity: (2,) m/s.

    Returns:
        m between the outline and the middle of the person, at least.
    """
    times, poses = stopping
    return float(outline_distance(truck, poses, place + times[:, None] * velocity).min())
