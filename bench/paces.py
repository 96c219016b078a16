"""Robots that do not keep up with a plan, for what has to hold for any of them."""

from __future__ import annotations

import numpy as np

from pickcli.simulation.servo import Servo
from pickcli.simulation.stream import Pace

LAGGING = Servo(lag=20e-3)  # a worn or overloaded arm, ten times as late


def slowed(factor: float) -> Pace:
    """Everything at a constant share of the planned speed, as by a speed override."""
    return lambda t: factor


def paused(at: float, duration: float, ramp: float = 0.4) -> Pace:
    """Slow down along the path to a stand ``at`` s, stay for ``duration`` s and go on.

    ramp: s that slowing down takes, and speeding up
    """
    knots = [at, at + ramp, at + ramp + duration, at + 2 * ramp + duration]
    return lambda t: float(np.interp(t, knots, [1.0, 0.0, 0.0, 1.0]))
