"""Relaxed suction cup: bellows that are compressed like a spring by any body.

Rays along the cup's axis, one in the middle and eight on the rim, measure how far each part of the lip is
pressed in, by items, shelf or floor alike; each carries its share of the spring force. So the force is even
on a perpendicular face, and one-sided at an edge. Beyond the stroke the folds are in contact, and only
rubber, lance and arm comply; farther in, the cup's collision shape in the engine takes over.

A body that meets the lip from its side does not compress it, but bends it aside, with a force that is small
compared to that of the collision shape that follows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.tool import Tool
from pickcli.geometry import Array, length
from pickcli.simulation.engine import ContactPoint, Engine

N_RIM = 8
BENT_DEPTH = 1.5e-3  # m that a ray is pressed in within one step if a body comes from the side: 1.5 m/s
STEEP = np.cos(
    np.radians(45.0)
)  # of the angle between axis and normal, up to which a face compresses the lip
PROBE_BACK = 0.02  # m behind the compressed cup where rays start, so that they never start inside an item
RELAXATION = 4e-3  # s, damping over stiffness of the rubber
SOLID_STIFFNESS = 3e4  # N/m beyond the stroke: solid rubber, lance and arm in series (docs/simulation.md)
SOLID_DEPTH = 4e-3  # m beyond the stroke at which the rigid collision shape begins
FRICTION = 0.5  # of the lip on a face; consistent with the cell's max_shear over max_pull
FULL_FRICTION_SPEED = 0.01  # m/s above which the sliding lip has its full friction


@dataclass(frozen=True, eq=False)
class Probe:
    """Measurement of the bodies in front of the cup.

    Attributes:
        names: (9,) first body on each ray, "" if none; the middle first, then the rim.
        distances: (9,) m from the lip of the relaxed cup along its axis; negative if pressed in, infinite
            without a body.
    """

    names: tuple[str, ...]
    distances: Array

    @property
    def nearest(self) -> str:
        """The nearest body, "" if there is none."""
        return self.names[int(np.argmin(self.distances))]


NOTHING = Probe(("",) * (N_RIM + 1), np.full(N_RIM + 1, np.inf))


class Bellows:
    """The relaxed bellows of one robot's cup in an engine.

    Args:
        engine: The engine with the robot and the items.
        robot: Name of the robot's body.
        tool: The robot's tool.
        stiffness: N/m of the bellows along their axis.
    """

    def __init__(self, engine: Engine, robot: str, tool: Tool, stiffness: float) -> None:
        self._engine, self._robot, self._tool = engine, robot, tool
        self.stiffness = stiffness  # N/m over the whole lip
        angles = np.arange(N_RIM) * 2 * np.pi / N_RIM
        rim = tool.cup.radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        self._points = np.concatenate([np.zeros((1, 2)), rim])  # (9, 2) in the tip's x-y plane
        self._before = np.full(
            N_RIM + 1, -np.inf
        )  # distances in the step before; no ray is bent in the first
        self._bent = np.zeros(N_RIM + 1, dtype=bool)  # rays whose part of the lip is bent aside

    def probe(self, T_world_tip: Array, ahead: float) -> Probe:
        """Cast the rays along the cup's axis.

        Args:
            T_world_tip: (4, 4) tool frame.
            ahead: m, range in front of the relaxed lip.

        Returns:
            The measurement.
        """
        back = self._tool.cup.stroke + SOLID_DEPTH + PROBE_BACK
        R, tip = T_world_tip[:3, :3], T_world_tip[:3, 3]
        middle = tip + (ahead - back) / 2 * R[:, 2]
        if self._engine.near(middle, (ahead + back) / 2 + self._tool.cup.radius) <= {self._robot}:
            self._before, self._bent = NOTHING.distances, np.zeros(N_RIM + 1, dtype=bool)
            return NOTHING
        starts = tip + self._points @ R[:, :2].T - back * R[:, 2]
        hits = self._engine.ray_faces(starts, starts + (back + ahead) * R[:, 2])
        distances = np.array([share * (back + ahead) - back if name else np.inf for name, share, _ in hits])
        is_steep = -np.array([normal for _, _, normal in hits]) @ R[:, 2] < STEEP
        is_from_side = is_steep | ((self._before > 0.0) & (distances < -BENT_DEPTH))
        self._bent = (self._bent | is_from_side) & (distances < 0.0)
        self._before = distances
        names = ("" if is_bent else hit[0] for hit, is_bent in zip(hits, self._bent, strict=True))
        return Probe(tuple(names), np.where(self._bent, np.inf, distances))

    def points(self, T_world_tip: Array, probe: Probe) -> Array:
        """Compute the points at which the rays of a probe hit bodies.

        Args:
            T_world_tip: (4, 4) tool frame.
            probe: The measurement.

        Returns:
            (9, 3) m in the world; infinite for rays without a hit.
        """
        R = T_world_tip[:3, :3]
        across = T_world_tip[:3, 3] + self._points @ R[:, :2].T
        return np.asarray(across + np.outer(probe.distances, R[:, 2]))

    def act(
        self, T_world_tip: Array, probe: Probe, items: frozenset[str], sticks_to: str = ""
    ) -> list[ContactPoint]:
        """Apply the spring forces to the bodies that compress the bellows, and the reaction to the robot.

        Args:
            T_world_tip: (4, 4) tool frame.
            probe: The measurement.
            items: Names of the movable bodies.
            sticks_to: Item to which the friction of the lip is applied elsewhere.

        Returns:
            The contacts.
        """
        pressed = np.maximum(-probe.distances, 0.0)
        if not pressed.any():
            return []
        met = {name for name, depth in zip(probe.names, pressed, strict=True) if depth > 0.0}
        found = []
        for name in sorted(met):
            friction = 0.0 if name == sticks_to and name in items else FRICTION
            found.append(self._act_on(name, T_world_tip, probe, pressed, name in items, friction))
        return found

    def _act_on(
        self, name: str, T_world_tip: Array, probe: Probe, pressed: Array, is_free: bool, friction: float
    ) -> ContactPoint:
        mine = np.array([other == name for other in probe.names]) & (pressed > 0.0)
        depths = pressed[mine]
        R, tool = T_world_tip[:3, :3], self._tool
        # The explicit time step is stable up to m / h^2 of stiffness and m / h of damping, for a free body's
        # mass m.
        mass, h = self._engine.mass(name) if is_free else np.inf, self._engine.time_step
        soft, solid = self.stiffness, min(SOLID_STIFFNESS, mass / h**2)
        excess = np.maximum(depths - tool.cup.stroke, 0.0)
        forces = (soft * (depths - excess) + solid * excess) / (N_RIM + 1)
        stiffness = float(np.where(excess > 0.0, solid, soft).sum()) / (N_RIM + 1)
        centre = forces @ self._points[mine] / max(float(forces.sum()), 1e-12)
        point = T_world_tip[:3, 3] + R[:, :2] @ centre - float(depths.mean()) * R[:, 2]
        velocity, _ = self._engine.velocity(name, "", point)
        velocity -= self._engine.velocity(self._robot, tool.last_link, point)[0]
        along = float(velocity @ R[:, 2])
        force = float(forces.sum()) - min(RELAXATION * stiffness, 0.5 * mass / h) * along
        force = max(force, 0.0)
        across = velocity - along * R[:, 2]
        drag = friction * force / max(length(across), FULL_FRICTION_SPEED)
        on_body = force * R[:, 2] - min(drag, 0.5 * mass / h) * across
        if is_free:
            self._engine.wake(name)
            self._engine.apply_force(name, on_body, point)
        self._engine.apply_force(self._robot, -on_body, point, tool.last_link)
        return ContactPoint(
            self._robot, tool.last_link, name, "", float(depths.max()), tuple(point.tolist()), force
        )  # fmt: skip
