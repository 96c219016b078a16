"""The relaxed cup: bellows that shorten by their stroke with a spring's force, whatever they meet.

Rays along the cup's axis, one in the middle and eight on the rim, tell how far each part of the lip is
pressed in, by an item or by shelf and floor alike; each carries its share of the spring. So the force is
even on a face that is square on, and on one side where the cup meets an edge. Beyond the stroke the folds
lie on each other and only rubber, lance and arm give; farther than that the cup's collision shape in the
engine is in the way.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.tool import Tool
from pickcli.geometry import Array, length
from pickcli.simulation.engine import ContactPoint, Engine

N_RIM = 8
PROBE_BACK = 0.02  # m behind the compressed cup where the probing rays start, so never inside an item
RELAXATION = 4e-3  # s, damping over stiffness of the rubber
SOLID_STIFFNESS = 3e4  # N/m beyond the stroke: solid rubber, lance and arm in series (docs/simulation.md)
SOLID_DEPTH = 4e-3  # m beyond the stroke where the rigid collision shape begins
FRICTION = 0.5  # of the lip on a face; the cell's max_shear over max_pull says the same
SLIDING_SPEED = 0.01  # m/s from which the lip slides with its whole friction


@dataclass(frozen=True, eq=False)
class Probe:
    """What stands in front of the cup.

    Attributes:
        names: (9,) body that each ray meets first, "" where none; the middle first, then the rim.
        distances: (9,) m from the lip of the relaxed cup along its axis; negative where it is pressed in,
            infinite where nothing is.
    """

    names: tuple[str, ...]
    distances: Array

    @property
    def nearest(self) -> str:
        """The body that comes first, "" if there is none."""
        return self.names[int(np.argmin(self.distances))]


NOTHING = Probe(("",) * (N_RIM + 1), np.full(N_RIM + 1, np.inf))


class Bellows:
    """The relaxed bellows of one robot's cup in an engine.

    Args:
        engine: Where the robot and the items are.
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

    def probe(self, T_world_tip: Array, ahead: float) -> Probe:
        """Look along the cup's axis.

        Args:
            T_world_tip: (4, 4) tool frame.
            ahead: m in front of the relaxed lip.

        Returns:
            What the rays met.
        """
        back = self._tool.cup.stroke + SOLID_DEPTH + PROBE_BACK
        R, tip = T_world_tip[:3, :3], T_world_tip[:3, 3]
        middle = tip + (ahead - back) / 2 * R[:, 2]
        if self._engine.near(middle, (ahead + back) / 2 + self._tool.cup.radius) <= {self._robot}:
            return NOTHING
        starts = tip + self._points @ R[:, :2].T - back * R[:, 2]
        hits = self._engine.ray_hits(starts, starts + (back + ahead) * R[:, 2])
        distances = [share * (back + ahead) - back if name else np.inf for name, share in hits]
        return Probe(tuple(name for name, _ in hits), np.array(distances))

    def points(self, T_world_tip: Array, probe: Probe) -> Array:
        """Where the rays of a probe met something.

        Args:
            T_world_tip: (4, 4) tool frame.
            probe: What is in front of the cup.

        Returns:
            (9, 3) m in the world; infinite where they met nothing.
        """
        R = T_world_tip[:3, :3]
        across = T_world_tip[:3, 3] + self._points @ R[:, :2].T
        return np.asarray(across + np.outer(probe.distances, R[:, 2]))

    def push(self, T_world_tip: Array, probe: Probe, items: frozenset[str]) -> list[ContactPoint]:
        """Push on whatever presses the bellows in, and back on the robot.

        Args:
            T_world_tip: (4, 4) tool frame.
            probe: What is in front of the cup.
            items: Names of the bodies that can move.

        Returns:
            The contacts.
        """
        pressed = np.maximum(-probe.distances, 0.0)
        if not pressed.any():
            return []
        met = {name for name, depth in zip(probe.names, pressed, strict=True) if depth > 0.0}
        return [self._push_on(name, T_world_tip, probe, pressed, name in items) for name in sorted(met)]

    def _push_on(
        self, name: str, T_world_tip: Array, probe: Probe, pressed: Array, is_free: bool
    ) -> ContactPoint:
        mine = np.array([other == name for other in probe.names]) & (pressed > 0.0)
        depths = pressed[mine]
        R, tool = T_world_tip[:3, :3], self._tool
        # Of a free body's mass, what an explicit time step bears: m / h^2 of stiffness, m / h of damping.
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
        drag = FRICTION * force / max(length(across), SLIDING_SPEED)
        on_body = force * R[:, 2] - min(drag, 0.5 * mass / h) * across
        if is_free:
            self._engine.wake(name)
            self._engine.push(name, on_body, point)
        self._engine.push(self._robot, -on_body, point, tool.last_link)
        return ContactPoint(
            self._robot, tool.last_link, name, "", float(depths.max()), tuple(point.tolist()), force
        )  # fmt: skip
