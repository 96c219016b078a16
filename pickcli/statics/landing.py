"""Whether an item that is let go just above another one may tip over as it lands.

It is never quite level. If one edge of its support is met first, the blow turns it about that edge, and then
over the opposite one: the blow is taken as inelastic, and all energy that it leaves as spent on the turn.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.shapes import Shape
from pickcli.geometry import Array

N_DIRECTIONS = 36  # horizontal ones, an even number, in which the edge of a support is looked for
_TURNS = 2.0 * np.pi * np.arange(N_DIRECTIONS) / N_DIRECTIONS
DIRECTIONS = np.column_stack([np.cos(_TURNS), np.sin(_TURNS), np.zeros(N_DIRECTIONS)])


def stays_on(shape: Shape, R: Array, reaches: Array, error: float, fall: float) -> bool:
    """Whether an item that falls a little onto a level support cannot tip over its edge.

    Args:
        shape: Shape of the item.
        R: (3, 3) its orientation, z up.
        reaches: (N_DIRECTIONS,) m from below its centre to the edge of what carries it, along ``DIRECTIONS``.
        error: m by which these may be off.
        fall: m that it falls.

    Returns:
        True if what energy a first contact at one edge leaves does not lift its centre over the other edge.
    """
    nearest, arms = reaches - error, np.roll(reaches, N_DIRECTIONS // 2) + error
    x, y, z = 2.0 * shape.reach(R)
    rises = np.hypot(nearest, z / 2) - z / 2
    gyration = (min(x, y) ** 2 + z**2) / 12.0  # m^2, squared radius of gyration of the box around it
    kept = arms**2 / (arms**2 + gyration)
    return bool((nearest > 0.0).all() and (rises >= kept * fall).all())
