"""Moving the vertices of a proven polyline so that it takes less time."""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.motion.path import JointPath
from pickcli.roadmap.cost import estimated_duration
from pickcli.roadmap.space import EdgeChecker, JointSpace

# First and last standard deviation of a step, as shares of what a joint crosses in one second.
_FIRST, _LAST = 0.15, 0.005


def polish(
    checker: EdgeChecker, space: JointSpace, path: JointPath, *, seed: int, iterations: int = 300
) -> JointPath:
    """A path with the same ends that is estimated to take no longer; every new edge is proven.

    One joint sets the duration and the others have slack to dodge in: a vertex at a time is moved at random,
    in smaller and smaller steps, or left out, and what is faster and proven is kept. The edges of ``path``
    itself are taken as proven. Repeatable by seed.
    """
    rng = np.random.default_rng(seed)
    best, seconds = path.waypoints, estimated_duration(space, path.waypoints)
    for sigma in np.geomspace(_FIRST, _LAST, max(iterations, 1)):
        if len(best) == 2:
            break
        i = int(rng.integers(1, len(best) - 1))
        trial = _varied(space, best, i, sigma, rng)
        trial_seconds = estimated_duration(space, trial)
        # The edges around vertex i are the new ones; where it was left out there is one less.
        around = trial[i - 1 : i + len(trial) - len(best) + 2]
        if trial_seconds < seconds and checker.path_is_free(around) == -1:
            best, seconds = trial, trial_seconds
    return JointPath(path.joint_names, best)


def _varied(space: JointSpace, waypoints: Array, i: int, sigma: float, rng: np.random.Generator) -> Array:
    """The polyline with vertex i moved, or, one time in ten, without it."""
    if rng.random() < 0.1:
        return np.delete(waypoints, i, axis=0)
    varied = waypoints.copy()
    # Mostly few joints at a time: a step in all of them is rarely good for the one that counts.
    step = rng.normal(0.0, sigma, space.n) * space.velocity * (rng.random(space.n) < 0.4)
    varied[i] = np.clip(varied[i] + step, space.lower, space.upper)
    return varied
