"""The operator's stop: the robot comes to rest on its path, and goes on along it when it is released.

It is a stop of category 2 (IEC 60204-1): drives, pump and valve stay on, so a held item stays held.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    import numpy as np

OperatorSignal: TypeAlias = Callable[[float], bool]  # s of the driver's clock -> whether to stand still

LONGEST_RANDOM = 10.0  # s until a random stop is released, at most


@dataclass(frozen=True)
class OperatorStop:
    """One stop by the operator.

    Attributes:
        begin: s, when it is requested.
        end: s, when the robot is released; None if it is not.
    """

    begin: float
    end: float | None


def never(t: float) -> bool:
    """Signal of an operator who stops nothing.

    Args:
        t: s of the driver's clock.

    Returns:
        False.
    """
    return False


def signal_of(stops: Iterable[OperatorStop], start: float = 0.0) -> OperatorSignal:
    """Return the signal of an operator who stops the robot at stated times.

    Args:
        stops: The stops.
        start: s of the driver's clock that their times count from.

    Returns:
        The signal.
    """
    stated = tuple(stops)

    def is_stopped(t: float) -> bool:
        now = t - start
        return any(stop.begin <= now and (stop.end is None or now < stop.end) for stop in stated)

    return is_stopped


def random_stops(share: float, duration: float, rng: np.random.Generator) -> tuple[OperatorStop, ...]:
    """Draw whether and when the operator stops a motion.

    Args:
        share: Probability of a stop.
        duration: Duration of the motion, s.
        rng: Source of the random choices.

    Returns:
        One stop, or none.
    """
    if share == 0.0 or rng.uniform() >= share:
        return ()
    begin = rng.uniform(0.0, duration)
    return (OperatorStop(begin, begin + rng.uniform(0.0, LONGEST_RANDOM)),)
