"""Steps of a workspace lattice, and the cost of each: the length of the path of the hand, turns included."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.errors import InputError


@dataclass(frozen=True)
class LatticeResolution:
    """Steps of the lattice, and what each costs.

    Attributes:
        position: m, step along an axis.
        turns: Number of steps of a whole turn of the hand.
        redundant: rad or m, step of a redundant joint.
        rotation_cost: m that a turn of the hand by 1 rad counts as: about how far it moves an item in it.
        redundant_cost: m that 1 rad or m of a redundant joint counts as.
        near: Steps of position within which a goal is reached by one straight edge.
        near_angle: rad of turn of the hand within which it is.
    """

    position: float = 0.06
    turns: int = 24
    redundant: float = 0.25
    rotation_cost: float = 0.2
    redundant_cost: float = 0.05
    near: float = 3.0
    near_angle: float = float(np.pi / 4)

    def __post_init__(self) -> None:
        """Refuse steps and costs that make no lattice."""
        lengths = (self.position, self.redundant, self.rotation_cost, self.redundant_cost, self.near_angle)
        if not all(0.0 < length < np.inf for length in lengths) or self.near < 1.0:
            raise InputError(
                "steps, costs and angles of a lattice are over 0, and goals near by 1 step at least"
            )
        if self.turns < 4 or self.turns % 4:
            raise InputError(f"turns {self.turns}: a whole turn is divided into a multiple of 4")

    @property
    def angle(self) -> float:
        """Rad, step of a turn of the hand."""
        return 2 * np.pi / self.turns
