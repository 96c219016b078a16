"""The tool: its links, its states and their joint positions or widths."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from pickcli.cell.device import DeviceKind
from pickcli.cell.tools.bare_flange import BareFlange
from pickcli.cell.tools.grip_model import GripModel
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.cell.tools.suction_cup import SuctionCup
from pickcli.errors import InputError
from pickcli.geometry import Array, cross

# Directions of the lance in the tool frame: the cup points along the lance, or at a right angle to it, with
# the lance pointing along -x.
IN_LINE = np.array([0.0, 0.0, 1.0])
ACROSS = np.array([-1.0, 0.0, 0.0])

_SAME_DIRECTION = 0.98  # least cosine between directions that count as equal: 11 degrees
_ACROSS = 0.2  # sine of the angle between a lance and a plane across the tool, up to which it is across
_DIGITS = 12  # for rounding directions, so that a quarter turn in the cell file is exact
_WIDTH_NAME = re.compile(r"w_[0-9]\.[0-9]{4}")
_WIDTH = "w_"  # prefix of states that are a gripper's width, in m


@dataclass(frozen=True, order=True)
class ToolState:
    """A named state of a cell's tool.

    Planners pass states on and compare them; only the cell's ``Tool`` knows their meaning. The state is part
    of the robot's shape, and therefore of segments, stored motions and cache keys.

    Attributes:
        name: As in the cell file, e.g. ``straight``.
    """

    name: str

    def __str__(self) -> str:
        """Return the name, as in files and messages."""
        return self.name

    @classmethod
    def of_width(cls, width: float) -> ToolState:
        """Return the state of a gripper at a width, e.g. closed on an item.

        Args:
            width: m between the pads, rounded to 0.1 mm.

        Returns:
            The state, e.g. ``w_0.0450``.
        """
        return cls(f"{_WIDTH}{width:.4f}")

    @property
    def width(self) -> float | None:
        """Width in m if the state is a gripper's width; None for a state named by the cell."""
        return float(self.name[len(_WIDTH) :]) if _WIDTH_NAME.fullmatch(self.name) else None


# Between any two states: the tool may be at any position in its range, so that a configuration that is free
# in this state is free in every state. Cells may not use this name.
MOVING = ToolState("moving")

# The only state of a tool without states in the cell file.
FIXED = ToolState("fixed")


@dataclass(frozen=True, eq=False)
class Tool:
    """The tool on the flange: a lance with a suction cup, or a hand with two fingers.

    Suction tool: the cup may be moved by a joint; the tool frame is at the tip of the uncompressed cup, +z
    outwards along its axis. Gripper: the tool frame is between the pads (``gripper.py``), as a link without a
    shape that is fixed to the hand and ends the chain. Bare flange: all three links are the flange, and the
    tool frame is the flange's.

    Attributes:
        flange_link: The robot's last link before the tool.
        lance_link: The lance or the hand, fixed to the flange.
        last_link: The last link of the chain: the cup, moved by ``joint`` if there is one; of a gripper the
            frame between the pads.
        joint: The last joint of the chain, if the tool's state moves it; else None.
        positions: By state, in the order of the cell file: position of the joint in rad (prismatic: m), width
            of a gripper in m, or 0. The first state is the default.
        T_lance_tip: By state, pose (4, 4) of the tool frame in the flange link as the tool is mounted on it,
            with z along the lance; of a gripper the identity.
        T_last_tip: Pose (4, 4) of the tool frame in the last link.
        grip: The cup or gripper; a ``BareFlange`` without a tool.
    """

    flange_link: str
    lance_link: str
    last_link: str
    joint: str | None
    positions: dict[ToolState, float]
    T_lance_tip: dict[ToolState, Array]
    T_last_tip: Array
    grip: GripModel

    @classmethod
    def bare(cls, flange_link: str) -> Tool:
        """Return the tool of a flange on which nothing is mounted.

        Args:
            flange_link: The last link of the chain.

        Returns:
            A tool with one state, whose frame is the flange's.
        """
        link, grip = flange_link, BareFlange(flange_link)
        return cls(link, link, link, None, {FIXED: 0.0}, {FIXED: np.eye(4)}, np.eye(4), grip)

    @property
    def is_bare(self) -> bool:
        """Whether no tool is mounted."""
        return isinstance(self.grip, BareFlange)

    @property
    def suction_cup(self) -> SuctionCup | None:
        """The cup; None for other tools."""
        return self.grip if isinstance(self.grip, SuctionCup) else None

    @property
    def gripper(self) -> ParallelGripper | None:
        """The gripper; None for other tools."""
        return self.grip if isinstance(self.grip, ParallelGripper) else None

    @property
    def cup(self) -> SuctionCup:
        """The cup. Raises InputError for other tools."""
        if self.suction_cup is None:
            raise InputError(
                f"no suction cup is mounted on {self.flange_link}: picks need one; add `tool` to the cell"
            )
        return self.suction_cup

    @property
    def contact_speed(self) -> float:
        """Largest speed of the final approach, m/s; infinite without a tool."""
        return self.grip.contact_speed

    @property
    def mover(self) -> DeviceKind:
        """Kind of the device that changes the state."""
        return self.grip.mover

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints moved by the state: the cup's, or those of the fingers."""
        return self.grip.finger_joints if self.joint is None else (self.joint,)

    @property
    def contact_links(self) -> tuple[str, ...]:
        """Names of the links that may touch the grasped item: the cup, or the fingers."""
        return self.grip.finger_links or (self.last_link,)

    @property
    def states(self) -> tuple[ToolState, ...]:
        """States that the tool can rest in, in the order of the cell file."""
        return tuple(self.positions)

    @property
    def states_and_moving(self) -> tuple[ToolState, ...]:
        """All states for which the robot has a collision shape: ``states`` and MOVING."""
        return (*self.positions, MOVING)

    @property
    def default_state(self) -> ToolState:
        """The default state: the first one in the cell file."""
        return next(iter(self.positions))

    @property
    def range(self) -> tuple[float, float]:
        """Least and greatest position in rad or m of the joint, or width, over all states."""
        return min(self.positions.values()), max(self.positions.values())

    def knows(self, state: ToolState) -> bool:
        """Whether the tool can rest in a state: one named by the cell, or a width within their range.

        Args:
            state: State of the tool.

        Returns:
            True if it can.
        """
        least, most = self.range
        is_between = self.grip.takes_widths and state.width is not None and least <= state.width <= most
        return state in self.positions or is_between

    def position(self, state: ToolState) -> float:
        """Return the joint position or gripper width of a state; MOVING counts as the default state.

        Args:
            state: State of the tool.

        Returns:
            rad; m for a prismatic joint or a width.
        """
        if self.grip.takes_widths and state.width is not None and state not in self.positions:
            return state.width
        return self.positions[self.default_state if state == MOVING else state]

    def command(self, state: ToolState) -> str:
        """Return the action of the tool's actuator that leads to a state.

        Args:
            state: State of the tool.

        Returns:
            Name of the state; for a width the narrowest state, as the fingers stop on the item.
        """
        if state in self.positions:
            return state.name
        return min(self.positions, key=self.positions.__getitem__).name

    def joint_position(self, joint: str, state: ToolState) -> float:
        """Return the position of one of the joints that the state moves.

        Args:
            joint: Name of the joint.
            state: State of the tool; MOVING counts as the default state.

        Returns:
            rad, or m of a prismatic joint.
        """
        return self._joint_at(joint, self.position(state))

    def joint_range(self, joint: str) -> tuple[float, float]:
        """Return the least and greatest position of one of these joints over all states.

        Args:
            joint: Name of the joint.

        Returns:
            rad, or m of a prismatic joint.
        """
        ends = [self._joint_at(joint, position) for position in self.range]
        return min(ends), max(ends)

    def _joint_at(self, joint: str, position: float) -> float:
        return self.grip.joint_position(joint, position)

    def tip_on_lance(self, state: ToolState) -> Array:
        """Return the pose of the tool frame in a frame with z along the lance.

        Args:
            state: State of the tool; states not named by the cell count as the default state.

        Returns:
            (4, 4).
        """
        return self.T_lance_tip.get(state, self.T_lance_tip[self.default_state])

    def lance_axis(self, state: ToolState) -> Array:
        """Return the direction of the lance, away from the flange.

        Args:
            state: State of the tool.

        Returns:
            (3,) in the tool frame.
        """
        return np.asarray(np.round(self.tip_on_lance(state)[2, :3], _DIGITS) + 0.0)

    def has_lance(self, state: ToolState, axis: Array) -> bool:
        """Whether the lance points along an axis.

        Args:
            state: State of the tool.
            axis: (3,) unit vector in the tool frame.

        Returns:
            True if it does, within 11 degrees.
        """
        return bool(self.lance_axis(state) @ axis >= _SAME_DIRECTION)

    def tip_to_lance(self, state: ToolState) -> Array:
        """Compute the shortest vector from the tip to the axis of the lance.

        Args:
            state: State of the tool.

        Returns:
            (3,) m in the tool frame.
        """
        T = self.tip_on_lance(state)
        return np.asarray(np.round(T[:3, :3].T @ (-T[0, 3], -T[1, 3], 0.0), _DIGITS) + 0.0)

    def state_with_lance(self, axis: Array) -> ToolState | None:
        """Return the first state in which the lance points along an axis.

        Args:
            axis: (3,) unit vector in the tool frame.

        Returns:
            The state, or None.
        """
        return next((state for state in self.states if self.has_lance(state, axis)), None)

    @property
    def pushing_state(self) -> ToolState | None:
        """State in which a cup in line with its lance pushes items over; None for any other tool."""
        return None if self.grip.takes_widths else self.state_with_lance(np.array([0.0, 0.0, 1.0]))

    @property
    def rolling_state(self) -> ToolState | None:
        """State in which a cup across its lance turns items over in a bin; None for any other tool."""
        if self.grip.takes_widths:
            return None
        return next((state for state in self.states if abs(self.lance_axis(state)[2]) <= _ACROSS), None)

    def R_tip_lance(self, state: ToolState) -> Array:
        """Compute the lance axes in the tool frame: x along the lance, y close to the tool's.

        Args:
            state: State of the tool.

        Returns:
            (3, 3).
        """
        x = self.lance_axis(state)
        side = np.array([0.0, 1.0, 0.0]) if abs(x[1]) < _SAME_DIRECTION else np.array([1.0, 0.0, 0.0])
        y = side - (side @ x) * x
        y /= np.linalg.norm(y)
        return np.column_stack([x, y, cross(x, y)]) + 0.0
