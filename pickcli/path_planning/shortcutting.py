"""Shortcutting: shortening of a proven polyline by proven edges."""

from __future__ import annotations

import numpy as np

from pickcli import kernel
from pickcli.collision.motion_validator import MotionValidator
from pickcli.motion.path import JointPath
from pickcli.path_planning.path_cost import CALM
from pickcli.path_planning.state_space import JointSpace

# Least saving of a shortcut, as a share of the whole cost; without it vertices would multiply.
_WORTHWHILE = 1e-3


def shorten(
    checker: MotionValidator, space: JointSpace, path: JointPath, *, seed: int, iterations: int = 100
) -> JointPath:
    """Shorten a path; every new edge is proven. Repeatable by seed.

    First, vertices that are not needed are dropped; then ``iterations`` times two random points of the path
    are joined by a straight edge if it is proven and saves enough (Geraerts and Overmars 2007), and unneeded
    vertices are dropped again. The edges of ``path`` itself are assumed to be proven.

    Args:
        checker: Proves edges.
        space: Metric of the cost (see ``step_costs``).
        path: A proven path.
        seed: Seed of all random choices.
        iterations: Number of shortcuts tried.

    Returns:
        A path with the same ends that costs no more.
    """
    shortcuts = np.sort(np.random.default_rng(seed).random((iterations, 2)), axis=1)
    waypoints = kernel.shorten(
        checker.kernel, path.waypoints, shortcuts, space.velocity, CALM, _WORTHWHILE, checker.margin
    )
    return JointPath(path.joint_names, waypoints) if checker.is_valid_path(waypoints) else path
