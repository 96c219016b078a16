"""Dry friction of the cup's lip on a face that bellows or vacuum press on it, until it hangs on the cup.

The lip sticks to the face up to the friction limit and slides beyond it: a spring between lip and face whose
foot is dragged along at the limit (Dahl 1968; the bristle of LuGre, Canudas de Wit et al. 1995). Where it is
only proportional to speed, a roll creeps under the cup that presses on it.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.tool import Tool
from pickcli.geometry import Array, inverse, length
from pickcli.simulation.bellows import FRICTION
from pickcli.simulation.engine import Engine

STIFFNESS = 2e4  # N/m of the lip along the face, as that of the sealed cup (bushing)
DAMPING = 0.2  # damping in Ns/m over item mass by time step: stable, and stops it in a few steps
ELASTICITY = 0.05  # most stiffness in N/m over item mass by time step squared: stable on a round item


class CupFriction:
    """Friction between the lip of one robot's cup and the face in front of it.

    Args:
        engine: The engine with the robot and the items.
        robot: Name of the robot's body.
        tool: The robot's tool.
    """

    def __init__(self, engine: Engine, robot: str, tool: Tool) -> None:
        self._engine, self._robot, self._tool = engine, robot, tool
        self._item = ""
        self._p_item_anchor = np.zeros(3)  # m, the point of the item that the middle of the lip sticks to

    def release(self) -> None:
        """Forget where the lip sticks; it sticks anew where it is on the next face."""
        self._item = ""

    def apply(self, item: str, T_world_tip: Array, normal_force: float) -> None:
        """Apply the friction of the next step to item and robot.

        Args:
            item: Name of the item whose face is under the lip.
            T_world_tip: (4, 4) tool frame.
            normal_force: N by which vacuum or bellows press lip and face together.
        """
        tip, axis = T_world_tip[:3, 3], T_world_tip[:3, 2]
        mass, h = self._engine.mass(item), self._engine.time_step
        stiffness = min(STIFFNESS, ELASTICITY * mass / h**2)
        limit = FRICTION * normal_force
        pull = stiffness * self._displacement(item, tip, axis)
        excess = length(pull) - limit
        if excess > 0.0:
            self._p_item_anchor -= self._in_item(item, excess / stiffness * pull / length(pull))
            pull *= limit / length(pull)
        velocity, _ = self._engine.relative_velocity(item, self._robot, self._tool.last_link, tip)
        across = velocity - (velocity @ axis) * axis
        force = -pull - DAMPING * mass / h * across
        force *= min(1.0, limit / max(length(force), 1e-9))
        self._engine.wake(item)
        self._engine.apply_force(item, force, tip)
        self._engine.apply_force(self._robot, -force, tip, self._tool.last_link)

    def _displacement(self, item: str, tip: Array, axis: Array) -> Array:
        """Return how far the item's point has moved along the face since the lip stuck to it, (3,) m."""
        T_world_item = self._engine.pose(item)
        if item != self._item:
            self._item = item
            self._p_item_anchor = np.asarray((inverse(T_world_item) @ np.append(tip, 1.0))[:3])
        moved = T_world_item[:3, :3] @ self._p_item_anchor + T_world_item[:3, 3] - tip
        return np.asarray(moved - (moved @ axis) * axis)

    def _in_item(self, item: str, vector: Array) -> Array:
        return np.asarray(self._engine.pose(item)[:3, :3].T @ vector)
