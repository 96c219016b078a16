"""Whether the vacuum holds: the load on the cup against its limits.

The model: pull along the cup's axis, shear across it, moment about the cup's centre. Limits by
``docs`` of the cell: pressure times area, friction, and lip stiffness (measured figures in the cell file).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.robot import Tool
from pickcli.geometry import Array

GRAVITY = 9.81  # m/s^2


@dataclass(frozen=True)
class Load:
    """Worst load on the cup: pull and shear in N, moment in Nm."""

    pull: float
    shear: float
    moment: float

    def ratio(self, tool: Tool) -> float:
        """The worst of the three over its limit; the cup holds below 1."""
        return max(
            self.pull / tool.cup_limits.max_pull,
            self.shear / tool.cup_limits.max_shear,
            self.moment / tool.cup_limits.max_moment,
        )

    def __str__(self) -> str:
        return f"pull {self.pull:.1f} N, shear {self.shear:.1f} N, moment {self.moment:.2f} Nm"


def load(mass: float, R_world_tip: Array, p_tip_com: Array, accelerations: Array) -> Load:
    """Worst load while the held item's centre of mass moves.

    mass: kg. R_world_tip: (T, 3, 3) tool orientations. p_tip_com: (3,) centre of mass in the tool frame,
    m. accelerations: (T, 3) of the centre of mass in the world, m/s^2.
    """
    force = mass * (accelerations + np.array([0.0, 0.0, GRAVITY]))  # that the cup must exert, world
    in_tip = np.einsum("tji,tj->ti", R_world_tip, force)
    # The cup pulls the item towards -z of the tool; pressing the lip on costs nothing.
    pull = np.maximum(0.0, -in_tip[:, 2])
    shear = np.linalg.norm(in_tip[:, :2], axis=1)
    moment = np.linalg.norm(np.cross(p_tip_com, in_tip)[:, :2], axis=1)
    return Load(float(pull.max()), float(shear.max()), float(moment.max()))


def static_load(mass: float, R_world_tip: Array, p_tip_com: Array) -> Load:
    """Load (see ``load``) at rest in one orientation (3, 3)."""
    weight = mass * GRAVITY
    x, y, z = (weight * float(v) for v in R_world_tip[2])  # of the force, in the tool frame
    px, py, pz = (float(v) for v in p_tip_com)
    return Load(max(0.0, -z), float(np.hypot(x, y)), float(np.hypot(py * z - pz * y, pz * x - px * z)))
