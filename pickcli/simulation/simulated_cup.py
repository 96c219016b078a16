"""Simulated suction cup: an optional joint, bellows, vacuum, and the seal that holds items."""

from __future__ import annotations

from pickcli.cell.cell import Cell
from pickcli.cell.device import DeviceKind
from pickcli.cell.item import Item
from pickcli.cell.tool import MOVING, ToolState
from pickcli.cell.tools.lip_leak import FULL_VACUUM
from pickcli.cell.tools.suction_cup import SuctionCup
from pickcli.geometry import Array
from pickcli.grasping.lip_coverage import kept_vacuum
from pickcli.motion.plan import Grasp
from pickcli.scene.scene import PlacedItem, PoseNoise
from pickcli.simulation.bellows import Bellows
from pickcli.simulation.bushing import RIGID, Stiffness
from pickcli.simulation.engine import Engine
from pickcli.simulation.grip import Grip
from pickcli.simulation.hold_watch import HoldWatch, SealWatch
from pickcli.simulation.reality import Reality
from pickcli.simulation.servo import CupDrive
from pickcli.simulation.simulated_tool import SimulatedTool, first_device_of
from pickcli.simulation.suction import CupModel, Suction
from pickcli.simulation.thresholds import Thresholds
from pickcli.simulation.vacuum import Vacuum

TOOL_FORCE = 20.0  # N or Nm, if the cell states no force for the tool's joint
TOOL_TOLERANCE = 0.02  # rad or m, tolerance of the position at which the tool has arrived in a state
SEALED_VACUUM_SHARE = 0.9  # share of the face's expected vacuum from which the item is lifted


class SimulatedCup(SimulatedTool):
    """The suction cup of one robot.

    Args:
        cell: The cell as seen by the robot's arm.
        cup: Its cup.
        reality: Deviations of the world from the planner's model.
        lag: s, lag of the cup's joint.
        state: State of the tool at the start.
    """

    def __init__(self, cell: Cell, cup: SuctionCup, reality: Reality, lag: float, state: ToolState) -> None:
        self.tool, self._cup, self._cell, self._reality = cell.robot.tool, cup, cell, reality
        self.drive = self._drive(lag, state) if self.tool.joints else None

    def _drive(self, lag: float, state: ToolState) -> CupDrive:
        """Create the drive of the cup's joint, at rest. Raises InputError if the cell has none."""
        tool = self.tool
        lead = first_device_of(self._cell, tool.mover).lead
        force = self._cell.robot.motor_forces.get(tool.joints[0], TOOL_FORCE)
        return CupDrive(tool.position(state), lead, force, lag)

    def mount(self, engine: Engine, robot: str, items: dict[str, Item]) -> None:
        """Add bellows and vacuum to the engine.

        Args:
            engine: The engine with the robot and the items.
            robot: Name of the robot's body.
            items: Items that can be held, by body name.

        Raises:
            InputError: The cell lacks a pump or a valve.
        """
        reality = self._reality
        is_compliant = reality.compliant_cup
        bellows = Bellows(engine, robot, self.tool, self._cup.stiffness if is_compliant else 0.0)
        pump, valve = (first_device_of(self._cell, kind) for kind in (DeviceKind.PUMP, DeviceKind.VALVE))
        stiffness = Stiffness.of_cup(self._cup.radius) if is_compliant else RIGID
        cup = CupModel(Vacuum(pump.lead, valve.lead), bellows, stiffness)
        self._suction = Suction(engine, robot, self.tool, cup, items, reality.honest_seals)

    @property
    def grip(self) -> Grip:
        """The grip of the cup."""
        return self._suction

    @property
    def pressure(self) -> float:
        """Pressure (Pa) below ambient in the cup."""
        return self._suction.vacuum.cup

    @property
    def suction(self) -> Suction:
        """The suction of the cup."""
        return self._suction

    @property
    def max_press(self) -> float:
        """Force of fully compressed bellows, N."""
        return self._cup.stiffness * self._cup.stroke

    def state(self, measured: Array) -> ToolState:
        """Return the state at the joint's position.

        Args:
            measured: (k,) joint position, if there is a joint.

        Returns:
            The state, or MOVING.
        """
        if self.drive is None:
            return self.tool.default_state
        position = float(measured[-1])
        resting = (s for s, at in self.tool.positions.items() if abs(at - position) < TOOL_TOLERANCE)
        return next(resting, MOVING)

    def has_hold(self, grasp: Grasp, placed: PlacedItem, noise: PoseNoise) -> bool:
        """Whether the gauge shows the vacuum that the item's face should keep.

        Args:
            grasp: Grasp of the item.
            placed: The item where the robot believes it to be.
            noise: Bounds of the error of that pose.

        Returns:
            True if it does.
        """
        kept = kept_vacuum(placed.item, grasp.face, grasp.T_item_tip[:3, 3], self._cup, noise)
        return self._suction.vacuum.cup >= SEALED_VACUUM_SHARE * kept * FULL_VACUUM

    def watch(self, thresholds: Thresholds) -> HoldWatch:
        """Create the supervision of the seal.

        Args:
            thresholds: Thresholds of a stop.

        Returns:
            A watch of the gauge.
        """
        return SealWatch(self._suction.vacuum, thresholds)
