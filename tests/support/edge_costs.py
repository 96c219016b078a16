"""Costs of the edges of a path."""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array
from pickcli.path_planning.path_cost import step_costs
from pickcli.path_planning.state_space import JointSpace


def edge_costs(space: JointSpace, waypoints: Array) -> Array:
    """Costs (N - 1,) in s of the edges between waypoints (N, n)."""
    return step_costs(space, np.diff(waypoints, axis=0))
