"""How far a truck goes until it rests, and how long that takes.

S = v T + v^2 / (2 a): after the delay T, in which nothing brakes yet, the speed v falls with the deceleration
a. That is uniform motion and the law of constant deceleration; ISO 13855 adds an approach the same way, as
S = K T + C, and EN 1525 asks that the reach of a truck's detector is no less than its stopping distance. No
conformity with either is claimed: these are figures of a simulated truck.
"""

from __future__ import annotations


def stopping_distance(speed: float, delay: float, deceleration: float) -> float:
    """Return how far a truck goes from a demand to its rest.

    Args:
        speed: m/s, not negative.
        delay: s until it begins to brake: of sensor, output and brake together.
        deceleration: m/s^2, positive.

    Returns:
        m.
    """
    return speed * delay + speed**2 / (2 * deceleration)


def stopping_time(speed: float, delay: float, deceleration: float) -> float:
    """Return how long a truck goes from a demand to its rest.

    Args:
        speed: m/s, not negative.
        delay: s until it begins to brake.
        deceleration: m/s^2, positive.

    Returns:
        s.
    """
    return delay + speed / deceleration


def travel_while_stopping(speed: float, delay: float, deceleration: float, time: float) -> float:
    """Return how far a truck has gone some time after a demand.

    Args:
        speed: m/s at the demand, not negative.
        delay: s until it begins to brake.
        deceleration: m/s^2, positive.
        time: s since the demand.

    Returns:
        m; after the rest that of the rest.
    """
    braking = min(max(time - delay, 0.0), speed / deceleration)
    return speed * min(time, delay) + speed * braking - deceleration * braking**2 / 2
