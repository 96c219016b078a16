"""The world of a grasp: a table, objects that stand on it, and the hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.geometry import Array, pose, rotation_rpy
from pickcli.hand.belt_hand import BeltHand, GraspObject
from pickcli.hand.free_wrist import HAND, FreeWrist
from pickcli.hand.hand_urdf import FINGER_JOINTS, HINGES, PALM
from pickcli.hand.simulated_hand import SimulatedHand
from pickcli.simulation.engine import Engine

TIME_STEP = 2e-3  # s
TABLE = "table"
TABLE_SIZE = (3.0, 3.0, 0.1)  # m
GREY, RED = (0.7, 0.7, 0.7, 1.0), (0.8, 0.2, 0.2, 1.0)


@dataclass(frozen=True)
class Standing:
    """Where an object stands.

    Attributes:
        x: m.
        y: m.
        yaw: rad.
    """

    x: float
    y: float
    yaw: float = 0.0


@dataclass(frozen=True)
class WorldDeviation:
    """By what the world deviates from the file.

    Attributes:
        mass: Factor on masses of objects.
        friction: Factor on the friction of belts.
    """

    mass: float = 1.0
    friction: float = 1.0


class GraspWorld:
    """A simulated world, which advances by steps of ``TIME_STEP``.

    Attributes:
        engine: The engine.
        hand: The hand.
        wrist: The impedance with which it is held.
        names: Names of the objects.
        time: s since the start.

    Args:
        hand: Figures of the hand.
        kind: What stands on the table.
        stand: Where it stands, one or several of them.
        wrist: (6,) m and rad, position of the wrist.
        deviation: By what the world deviates from the file.
    """

    def __init__(
        self,
        hand: BeltHand,
        kind: GraspObject,
        stand: Sequence[Standing],
        wrist: Array,
        deviation: WorldDeviation = WorldDeviation(),
    ) -> None:
        self.engine = Engine(TIME_STEP)
        table = Body(TABLE, Shape(ShapeKind.BOX, TABLE_SIZE), pose((0.0, 0.0, -TABLE_SIZE[2] / 2)))
        self.engine.add_static(table, np.eye(4), GREY)
        mass = kind.mass * deviation.mass
        self._centre, inertia, parts = _as_solid(kind, mass)
        self.names = tuple(f"{kind.name} {k + 1}" for k in range(len(stand)))
        for name, at in zip(self.names, stand, strict=True):
            T = pose((at.x, at.y, self._centre), R=rotation_rpy(0.0, 0.0, at.yaw))
            self.engine.add_solids(name, parts, mass, inertia, T, RED)
        carrier = FreeWrist(self.engine, hand, wrist)
        self.wrist = carrier.impedance
        self.hand = SimulatedHand(self.engine, hand, carrier, hand.belts.friction * deviation.friction)
        for a, b in combinations((PALM, *FINGER_JOINTS, *HINGES), 2):
            if not {a, b} <= {"left_distal", "right_distal"}:
                self.engine.set_collision(HAND, a, HAND, b, False)
        self.time = 0.0

    def step(self) -> None:
        """Advance by a step."""
        self.hand.exert()
        self.engine.step()
        self.time += TIME_STEP

    def pose(self, name: str) -> Array:
        """Return the pose of an object.

        Args:
            name: Its name.

        Returns:
            (4, 4) of the middle of its bottom.
        """
        return self.engine.pose(name) @ pose((0.0, 0.0, -self._centre))

    def middle_in_hand(self, name: str) -> Array:
        """Return where an object's centre of mass is.

        Args:
            name: Its name.

        Returns:
            (3,) m in the frame of the hand.
        """
        palm = self.engine.pose(HAND, PALM)
        return np.asarray(palm[:3, :3].T @ (self.engine.pose(name)[:3, 3] - palm[:3, 3]))

    def contacts(self, name: str) -> dict[str, list[Array]]:
        """Return where an object is touched.

        Args:
            name: Its name.

        Returns:
            Contact points (3,) in m in the frame of the hand, by link of the hand or name of another body.
        """
        palm = self.engine.pose(HAND, PALM)
        found: dict[str, list[Array]] = {}
        for point in self.engine.contact_points(name):
            at = palm[:3, :3].T @ (np.array(point.position) - palm[:3, 3])
            found.setdefault(point.link_b if point.b == HAND else point.b, []).append(at)
        return found


def _as_solid(kind: GraspObject, mass: float) -> tuple[float, Array, tuple[Body, ...]]:
    """Return the height of the centre of mass, the inertia (3,) about it, and parts in its frame."""
    shares = np.array([part.shape.volume for part in kind.parts])
    shares = shares / shares.sum()
    heights = np.array([part.T_parent_shape[2, 3] for part in kind.parts])
    centre = float(shares @ heights)
    inertia = np.zeros(3)
    parts = []
    for part, share, height in zip(kind.parts, shares, heights, strict=True):
        off = height - centre
        inertia += mass * share * (np.diag(part.shape.inertia_per_mass) + np.array([off**2, off**2, 0.0]))
        parts.append(replace(part, T_parent_shape=pose((0.0, 0.0, off))))
    return centre, inertia, tuple(parts)
