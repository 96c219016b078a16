"""Simulated suction cup: contact of the relaxed bellows, sealing, holding, and release.

Relaxed bellows push on any body that they meet (``bellows``). With the valve open the cup seals if its rim is
on one face that leaks little enough, also where it stands over the edges of a box, and cup and face are at
rest relative to each other. From then on
the item hangs on the collapsed cup by a bushing (``bushing``), whose wrench is the load.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.shapes import ShapeKind
from pickcli.cell.tool import Tool
from pickcli.cell.tools.lip_leak import FULL_VACUUM
from pickcli.geometry import Array, inverse, length, transform_points
from pickcli.simulation.bellows import NOTHING, SOLID_DEPTH, Bellows, Probe
from pickcli.simulation.bushing import Bushing, BushingItem, Stiffness
from pickcli.simulation.cup_friction import CupFriction
from pickcli.simulation.engine import ContactPoint, Engine
from pickcli.simulation.grip import Release
from pickcli.simulation.vacuum import Vacuum

MAX_SEAL_GAP = 1.5e-3  # m, largest distance from the tip at which a cup draws a face on
CONFORMITY = 5e-3  # m, unevenness of a face that the lip follows: 10 degrees of tilt, or a bottle's curvature
BREAK_TIME = 3 / 240  # s above a limit until the item separates: 3 steps in a row at the measured 240 Hz
DRAG_REACH = 0.01  # m in front of the cup in which its open flow still moves items
DRAG_SHARE = 0.05  # share of the closed cup's force, directly at the cup
SEAL_VACUUM = 9e3  # Pa in the cup from which the sensor reads a hold: over twice that of the open flow
HOLD_VACUUM = 6e3  # Pa in the cup from which a face at rest hangs on it
RELEASE_VACUUM = 5e3  # Pa in the vented cup below which the item separates
SEALING_SPEED = 5e-3  # m/s of any part of the rim over the face, in any direction, below which it seals
LEAKING_SPEED = 30e-3  # m/s over the face at which the lip leaks fully; in proportion below
COLLISION_DISTANCE = 1e-3  # m from the relaxed lip at which the cup collides again with a released item


@dataclass(frozen=True, eq=False)
class CupWrench:
    """Wrench that the cup carries.

    Attributes:
        wrench: (6,) force in N and torque in Nm that the cup exerts on the item, about the tool tip, in the
            tool frame (+z out of the cup), as in ``CupLimits``.
    """

    wrench: Array

    @property
    def pull(self) -> float:
        """Pull along the cup's axis, N; negative if the item presses against the cup."""
        return -float(self.wrench[2])

    @property
    def shear(self) -> float:
        """Shear perpendicular to the cup's axis, N."""
        return float(np.hypot(self.wrench[0], self.wrench[1]))

    @property
    def bending(self) -> float:
        """Bending about axes perpendicular to the cup's, Nm."""
        return float(np.hypot(self.wrench[3], self.wrench[4]))

    @property
    def twist(self) -> float:
        """Absolute torque about the cup's axis, Nm."""
        return abs(float(self.wrench[5]))

    def __str__(self) -> str:
        return (
            f"pull {self.pull:.1f} N, shear {self.shear:.1f} N, bending {self.bending:.2f} Nm, "
            f"twist {self.twist:.2f} Nm"
        )


NO_LOAD = CupWrench(np.zeros(6))


@dataclass(frozen=True, eq=False)
class CupModel:
    """The physics of one cup.

    Attributes:
        vacuum: Pump, valve, line and cup pressures.
        bellows: The relaxed bellows.
        stiffness: Stiffness of the sealed cup.
    """

    vacuum: Vacuum
    bellows: Bellows
    stiffness: Stiffness


@dataclass(frozen=True)
class _Seal:
    """How well a face closes the cup.

    Attributes:
        vacuum: Share of full vacuum that the pump can keep: 1 is airtight, 0 is open.
        lever: Share of the lip's radius that is on the face, the lever of the load limits.
    """

    vacuum: float
    lever: float = 1.0


OPEN = _Seal(0.0)


class Suction:
    """Suction cup of one robot in an engine.

    Attributes:
        held: Name of the item that hangs on the cup, or None.
        load: Last measured load.
        ratio: Last load with the valve open, as a share of the limits at the present vacuum.
        max_ratio: Largest ratio since the last seal.
        releases: Items that left the cup, in order.
        contact_points: Contacts of the relaxed bellows in the last step.

    Args:
        engine: The engine with the robot and the items.
        robot: Name of the robot's body.
        tool: The robot's tool.
        cup: Its cup.
        items: Items that can be held, by body name.
        honest_seals: Whether faces leak as the items state; otherwise every face is airtight.
    """

    def __init__(
        self,
        engine: Engine,
        robot: str,
        tool: Tool,
        cup: CupModel,
        items: dict[str, Item],
        honest_seals: bool,
    ) -> None:
        self._engine, self._robot, self._tool = engine, robot, tool
        self._bellows, self._stiffness = cup.bellows, cup.stiffness
        self._friction = CupFriction(engine, robot, tool)
        self._area = np.pi * tool.cup.radius**2  # m^2 on which the vacuum acts
        self._items, self._has_honest_seals = items, honest_seals
        self.vacuum = cup.vacuum
        self.held: str | None = None
        self.load, self.ratio, self.max_ratio = NO_LOAD, 0.0, 0.0
        self.releases: list[Release] = []
        self.contact_points: list[ContactPoint] = []
        self._T_item_tip = np.eye(4)  # tool frame in the held item at the time of sealing
        self._sealed = OPEN
        self._bushing: Bushing | None = None
        self._time_over = 0.0

    @property
    def is_holding(self) -> bool:
        """Reading of the vacuum sensor: enough vacuum in the cup, whether on an item or not."""
        return self.vacuum.cup >= SEAL_VACUUM

    @property
    def attached(self) -> str | None:
        """Name of the item on the cup, whose collision with the cup's shape would eject it."""
        return self.held

    def is_apart(self, item: str) -> bool:
        """Whether the relaxed cup is clear of an item that hung on it.

        Args:
            item: Name of the item.

        Returns:
            True if it does.
        """
        far = self._tool.cup.stroke + SOLID_DEPTH + COLLISION_DISTANCE
        return self._engine.distance(self._robot, self._tool.last_link, item, far) >= far

    def before_step(self, T_world_tip: Array) -> None:
        """Update pressures, seal and the cup's forces on bodies; call before a step.

        Args:
            T_world_tip: (4, 4) tool frame.
        """
        time_step = self._engine.time_step
        self.contact_points = []
        if self._bushing is not None:
            self.vacuum.advance(time_step, self._sealed.vacuum)
            self._hang(self._bushing, T_world_tip)
            return
        probe = self._bellows.probe(T_world_tip, DRAG_REACH)
        if probe is NOTHING:
            self.vacuum.advance(time_step, 0.0)
            self._friction.release()
            return
        seal = self._seal(probe, T_world_tip)
        share = seal.vacuum
        speed = self._sliding_speed(probe.nearest, T_world_tip) if share > 0.0 else np.inf
        self.vacuum.advance(time_step, share * max(0.0, 1.0 - speed / LEAKING_SPEED) if share > 0.0 else 0.0)
        # Without vacuum the lip sticks to the item in front of it by the force of the bellows alone.
        sticks_to = probe.nearest if self.vacuum.cup <= 0.0 else ""
        self.contact_points = self._bellows.act(T_world_tip, probe, frozenset(self._items), sticks_to)
        pressed = sum(point.force for point in self.contact_points if point.b == sticks_to in self._items)
        if speed < SEALING_SPEED and min(self.vacuum.cup, share * FULL_VACUUM) >= HOLD_VACUUM:
            self._attach(probe.nearest, T_world_tip, seal)
        elif self.vacuum.cup > 0.0:
            touching = float((probe.distances[1:] <= 0.0).mean())  # share of the rim
            self._friction.apply(probe.nearest, T_world_tip, touching * self.vacuum.cup * self._area)
        elif pressed > 0.0:
            self._friction.apply(probe.nearest, T_world_tip, pressed)
        else:
            self._friction.release()
            if self.vacuum.is_valve_open:
                self._draw(probe, T_world_tip)

    def after_step(self, t: float) -> None:
        """Release the item if the valve is closed or a limit is exceeded; call after the engine's step.

        Args:
            t: Simulated time, s.
        """
        if self.held is None:
            return
        share = self._sealed.lever * self.vacuum.cup / FULL_VACUUM
        ratio = float(self._tool.cup.limits.ratio(self.load.wrench, share))
        if not self.vacuum.is_valve_open:
            if ratio > 1.0 or self.vacuum.cup < RELEASE_VACUUM:
                self._detach(t, is_intended=True)
            return
        self.ratio, self.max_ratio = ratio, max(self.max_ratio, ratio)
        time_step = self._engine.time_step
        self._time_over = self._time_over + time_step if ratio > 1.0 else 0.0
        if self._time_over > BREAK_TIME - time_step / 2:
            self._detach(t, is_intended=False)
            self.vacuum.burst()

    def _seal(self, probe: Probe, T_world_tip: Array) -> _Seal:
        """Seal between the face in front of the cup and its rim; that of an open cup without such a face."""
        name = probe.nearest
        on_it = np.array([other == name for other in probe.names])
        if name not in self._items or not on_it[0] or np.any(probe.distances[~on_it] < MAX_SEAL_GAP):
            return OPEN
        met = probe.distances[on_it]
        if float(met.min()) > MAX_SEAL_GAP or float(np.ptp(met)) > CONFORMITY:
            return OPEN
        item, T_item_world = self._items[name], inverse(self._engine.pose(name))
        tip = T_item_world[:3] @ T_world_tip[:, 3]
        # Of a thin bottom the tip of a cup that is pressed on may be nearer to the other side.
        face = face_at(item, tip + float(np.median(met)) * (T_item_world[:3, :3] @ T_world_tip[:3, 2]))
        rooms, cup = item.rooms(face, tip), self._tool.cup
        if float(rooms.min()) < cup.radius:  # air comes in beyond the edges of a box
            seal = item.seals[face] if self._has_honest_seals else 1.0
            return _Seal(cup.kept_vacuum(seal, rooms), cup.covered(rooms))
        if not on_it.all():
            return OPEN
        if not self._has_honest_seals:
            return _Seal(1.0)
        low, high = item.area(face)
        lip = transform_points(T_item_world, self._bellows.points(T_world_tip, probe))
        return _Seal(item.seals[face]) if np.all((low <= lip) & (lip <= high)) else OPEN

    def _sliding_speed(self, item: str, T_world_tip: Array) -> float:
        """Largest speed of any part of the rim relative to the face, in any direction, m/s."""
        tip = T_world_tip[:3, 3]
        linear, turn = self._engine.relative_velocity(item, self._robot, self._tool.last_link, tip)
        return length(linear) + self._tool.cup.radius * length(turn)

    def _draw(self, probe: Probe, T_world_tip: Array) -> None:
        """Pull on an item in front of the open cup by its air flow."""
        item, distance = probe.nearest, float(probe.distances.min())
        if item not in self._items or not 0.0 < distance < DRAG_REACH:
            return
        axis = T_world_tip[:3, 2]
        force = DRAG_SHARE * self.vacuum.line * self._area * (1.0 - distance / DRAG_REACH)
        self._engine.wake(item)
        self._engine.apply_force(item, -force * axis, T_world_tip[:3, 3] + distance * axis)

    def _attach(self, name: str, T_world_tip: Array, seal: _Seal) -> None:
        T_tip_item = inverse(T_world_tip) @ self._engine.pose(name)
        mass, R = self._engine.mass(name), T_tip_item[:3, :3]
        inertia = R @ (mass * self._items[name].shape.inertia_per_mass) @ R.T
        self._bushing = Bushing(
            self._stiffness, mass, inertia, T_tip_item[:3, 3], self._engine.time_step
        )  # fmt: skip
        self._engine.keep_awake(name, on=True)
        self._friction.release()
        self.held, self._T_item_tip, self._sealed = name, inverse(T_tip_item), seal
        self.load, self.ratio, self.max_ratio, self._time_over = NO_LOAD, 0.0, 0.0, 0.0

    def _detach(self, t: float, is_intended: bool) -> None:
        assert self.held is not None
        self._engine.keep_awake(self.held, on=False)
        self.releases.append(Release(self.held, t, is_intended, self._engine.pose(self.held), self.load))
        self.held, self._bushing, self._sealed = None, None, OPEN

    def _hang(self, bushing: Bushing, T_world_tip: Array) -> None:
        """Apply the bushing's wrench to the item and the robot."""
        assert self.held is not None
        T_world_a = self._engine.pose(self.held) @ self._T_item_tip
        link = self._tool.last_link
        hanging = BushingItem(self._engine, self.held, self._robot, link, T_world_a, T_world_tip)
        wrench = hanging.wrench(bushing)
        self.load = CupWrench(wrench)
        hanging.apply(wrench)


def face_at(item: Item, point: Array) -> str:
    """Return the name of the face nearest to a point, among ``item.face_names``.

    Args:
        item: The item.
        point: (3,) m in the item frame.

    Returns:
        The name.
    """
    shape = item.shape
    for hollow in item.hollows:
        low, high = hollow.bounds(shape)
        inside = np.clip(point, low, high)
        over = abs(float(point[hollow.axis]) - hollow.height(shape))
        is_near = over < min(hollow.depth, float(shape.extents[hollow.axis]) - hollow.depth) / 2
        if is_near and hollow.contains(shape, np.where(np.arange(3) == hollow.axis, inside, point)):
            return hollow.bottom
    if shape.kind is ShapeKind.SPHERE:
        return "sphere"
    out = np.abs(point) - shape.extents / 2
    if shape.kind is ShapeKind.CYLINDER:
        radial = float(np.hypot(point[0], point[1])) - shape.size[0]
        if radial > out[2]:
            return "mantle"
        axis = 2
    else:
        axis = int(np.argmax(out))
    return ("+" if point[axis] > 0.0 else "-") + "xyz"[axis]
