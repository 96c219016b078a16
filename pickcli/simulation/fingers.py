"""Simulated fingers that close on items: pressing forces, adhesion to the pads, and slip.

The fingers are links of the engine, whose contacts push what they close on, and so centre the item. Once both
pads press on one item and the fingers are at rest, the item hangs on the rubber of both (``bushing``), and
the wrench of the bushing is the load. It is limited by the limit surface of soft fingers at the drive's force
(``PinchLimits``): beyond it the item slides on the pads at the largest possible load. Friction is computed
outside the engine because the engine's creeps: between two pads that press it with 70 N, a cube of 0.3 kg
sinks by millimetres in a tenth of a second.
"""

from __future__ import annotations

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.tool import Tool
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.geometry import Array, inverse, pose, rotation_axis_angle, rotation_vector
from pickcli.simulation.bushing import Bushing, BushingItem
from pickcli.simulation.engine import ContactPoint, Engine
from pickcli.simulation.grip import Release
from pickcli.simulation.pads import PadStiffness, Patch, patch_on
from pickcli.simulation.servo import FingerDrive

ON_PAD = 0.7  # least cosine between a contact normal and the closing direction; edges have less
PRESS_TIME = 0.01  # s over which the force on a pad is averaged
HOLDING_FORCE_SHARE = 0.5  # share of the drive's force on both pads above which an item is held
LETS_GO = 0.05  # share of it below which the item is released
STICKING_SPEED = 5e-3  # m/s of any part of the pads over the item, below which the item sticks
LOOK_STEP = 1e-3  # m of slip after which the contact area of the pads is computed again


class Fingers:
    """Simulated fingers of one robot in an engine.

    Attributes:
        held: Name of the item between the pads, or None.
        load: (6,) wrench in N and Nm that the pads exert on the item, about the tool tip, in the tool frame.
        ratio: Load if the item stuck to the pads, as a share of their limits in the contact area; above 1 it
            slides.
        max_ratio: Largest ratio since the item was taken.
        friction: Actual coefficient of friction between pads and items.
        releases: Items that left the pads, in order.
        contact_points: Always empty: all contacts are the engine's.

    Args:
        engine: The engine with the robot and the items.
        robot: Name of the robot's body.
        tool: The robot's tool.
        gripper: Its gripper.
        drive: The drive of the fingers.
        items: Items that can be held, by body name.
    """

    def __init__(
        self,
        engine: Engine,
        robot: str,
        tool: Tool,
        gripper: ParallelGripper,
        drive: FingerDrive,
        items: dict[str, Item],
    ) -> None:
        self._engine, self._robot, self._tool, self._gripper = engine, robot, tool, gripper
        self._drive, self._items = drive, items
        self.held: str | None = None
        self.load, self.ratio, self.max_ratio = np.zeros(6), 0.0, 0.0
        self.friction = gripper.limits.friction
        self.releases: list[Release] = []
        self.contact_points: list[ContactPoint] = []
        self._press = 0.0  # N on either pad, averaged
        self._pressed = ""  # the item that both press on
        self._T_tip_taken = np.eye(4)  # pose of the held item when it was taken
        self._T_item_tip = np.eye(4)  # tool frame in the held item at which its rubber is unloaded
        self._patch: Patch | None = None
        self._p_looked = np.zeros(3)  # of the held item in the tool frame, when the patch was computed
        self._bushing: Bushing | None = None

    @property
    def attached(self) -> str | None:
        """Name of the item that sticks to the pads."""
        return self.held if self._bushing is not None else None

    def is_apart(self, item: str) -> bool:
        """Whether a released item may collide with the fingers: always, as their contacts stay enabled.

        Args:
            item: Name of the item.

        Returns:
            True.
        """
        return True

    @property
    def slip(self) -> float:
        """Displacement in m of the held item's centre between the pads since it was taken."""
        if self.held is None:
            return 0.0
        T_tip_item = inverse(self._tip()) @ self._engine.pose(self.held)
        return float(np.linalg.norm(T_tip_item[:3, 3] - self._T_tip_taken[:3, 3]))

    @property
    def is_holding(self) -> bool:
        """Whether something is held, by the finger encoder: commanded to close, the fingers stopped early."""
        return self._drive.is_stopped

    @property
    def are_standing(self) -> bool:
        """Whether the fingers have stopped, at their target or on an item."""
        return self._drive.is_standing

    @property
    def width(self) -> float:
        """Width in m between the pads, by the finger encoder."""
        return self._drive.width

    def before_step(self, T_world_tip: Array) -> None:
        """Apply the wrench between pads and item to the item and the robot.

        Args:
            T_world_tip: (4, 4) tool frame.
        """
        if self._bushing is not None and (self._drive.is_opening or not self._touches(T_world_tip)):
            self._leave_to_engine()
        if self._bushing is not None:
            self._hang(self._bushing, T_world_tip)

    def after_step(self, t: float) -> None:
        """Take hold of an item that both pads press, and release one that they no longer press.

        Args:
            t: Simulated time, s.
        """
        if self._bushing is not None:
            return
        self._feel()
        if self.held is not None and (
            self._pressed != self.held or self._press < LETS_GO * self._drive.force
        ):
            self._let_go(t)
        if not self._drive.is_stopped or self._press < HOLDING_FORCE_SHARE * self._drive.force:
            return
        if self.held is None:
            self._take(self._pressed)
        T_world_tip = self._tip()
        if self._sliding_speed(T_world_tip) < STICKING_SPEED:
            self._hang_on(T_world_tip)

    def _feel(self) -> None:
        """Average the lesser of both pads' forces on the item that they press most."""
        along = self._tip()[:3, 1]
        on_pads = [self._pressing(finger.link, finger.side * along) for finger in self._gripper.fingers]
        between = {name: min(pad.get(name, 0.0) for pad in on_pads) for name in on_pads[0]}
        name = max(between, key=between.__getitem__, default="")
        if name != self._pressed:
            self._pressed, self._press = name, 0.0
        share = self._engine.time_step / PRESS_TIME
        self._press += share * (between.get(name, 0.0) - self._press)

    def _pressing(self, link: str, outwards: Array) -> dict[str, float]:
        """Force in N of a finger's pad by item; outwards (3,) is the direction from the middle to the pad."""
        forces: dict[str, float] = {}
        for point in self._engine.pressing_points(self._robot, link):
            if point.b in self._items and np.dot(point.normal, outwards) > ON_PAD:
                forces[point.b] = forces.get(point.b, 0.0) + point.force
        return forces

    def _take(self, name: str) -> None:
        self._engine.keep_awake(name, on=True)
        self.held, self.ratio, self.max_ratio = name, 0.0, 0.0
        self._T_tip_taken = inverse(self._tip()) @ self._engine.pose(name)

    def _let_go(self, t: float) -> None:
        assert self.held is not None
        self._engine.keep_awake(self.held, on=False)
        T, is_wanted = self._engine.pose(self.held), self._drive.is_opening
        self.releases.append(Release(self.held, t, is_wanted, T, self.load))
        self.held, self.load, self.ratio = None, np.zeros(6), 0.0

    def _hang_on(self, T_world_tip: Array) -> None:
        """Attach the held item to the pads at its current pose."""
        assert self.held is not None
        name, item = self.held, self._items[self.held]
        T_tip_item = inverse(T_world_tip) @ self._engine.pose(name)
        if not self._look(T_tip_item):
            return
        mass, R = self._engine.mass(name), T_tip_item[:3, :3]
        inertia = R @ (mass * item.shape.inertia_per_mass) @ R.T
        self._bushing = Bushing(PadStiffness(), mass, inertia, T_tip_item[:3, 3], self._engine.time_step)
        self._T_item_tip = inverse(T_tip_item)
        self._drive.stand(True)

    def _touches(self, T_world_tip: Array) -> bool:
        """Whether both pads still touch the held item; recomputed after it has slid."""
        assert self.held is not None
        T_tip_item = inverse(T_world_tip) @ self._engine.pose(self.held)
        has_slid = float(np.abs(T_tip_item[:3, 3] - self._p_looked).max()) > LOOK_STEP
        return self._look(T_tip_item) if has_slid else True

    def _look(self, T_tip_item: Array) -> bool:
        """Compute the contact area of pads and held item, and return whether there is one."""
        assert self.held is not None
        shape = self._items[self.held].shape
        self._patch = patch_on(shape, inverse(T_tip_item), self._drive.width, self._gripper)
        self._p_looked = T_tip_item[:3, 3]
        return self._patch is not None

    def _leave_to_engine(self) -> None:
        """Return the held item to the engine's contacts."""
        self._bushing = None
        self._drive.stand(False)
        self._press = self._drive.force

    def _hang(self, bushing: Bushing, T_world_tip: Array) -> None:
        """Apply the bushing's wrench to the item and the robot."""
        assert self.held is not None and self._patch is not None
        T_world_a = self._engine.pose(self.held) @ self._T_item_tip
        link = self._tool.last_link
        hanging = BushingItem(self._engine, self.held, self._robot, link, T_world_a, T_world_tip)
        self.load = hanging.wrench(bushing)
        self.ratio = self._patch.ratio(self.load, self._drive.force, self.friction)
        self.max_ratio = max(self.max_ratio, self.ratio)
        if self.ratio > 1.0:
            self.load = self.load / self.ratio
            self._slide(T_world_tip, T_world_a)
        hanging.apply(self.load)

    def _slide(self, T_world_tip: Array, T_world_a: Array) -> None:
        """Move the unloaded position of the rubber so far that its wrench is at the limit."""
        assert self.held is not None
        off = inverse(T_world_tip) @ T_world_a
        turn = rotation_vector(off[:3, :3])
        R = rotation_axis_angle(turn, float(np.linalg.norm(turn)) / self.ratio)
        left = pose(off[:3, 3] / self.ratio, R=R)
        self._T_item_tip = inverse(self._engine.pose(self.held)) @ T_world_tip @ left

    def _sliding_speed(self, T_world_tip: Array) -> float:
        """Largest speed of any part of the pads over the held item, m/s."""
        assert self.held is not None
        tip = T_world_tip[:3, 3]
        linear, turn = self._engine.relative_velocity(self.held, self._robot, self._tool.last_link, tip)
        return float(np.linalg.norm(linear)) + max(self._gripper.pad) / 2 * float(np.linalg.norm(turn))

    def _tip(self) -> Array:
        return self._engine.pose(self._robot, self._tool.last_link) @ self._tool.T_last_tip
