"""The tool as data: its links, the states that the cell names, and what each of them means."""

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

# Directions of the lance in the tool frame: the cup points on along the lance, or at a right angle to it,
# with the lance leaving it along its -x.
IN_LINE = np.array([0.0, 0.0, 1.0])
ACROSS = np.array([-1.0, 0.0, 0.0])

_SAME_DIRECTION = 0.98  # cosine from which two directions count as one: 11 degrees apart at most
_DIGITS = 12  # of directions: what is a quarter turn in the cell file is exactly one here
_WIDTH_NAME = re.compile(r"w_[0-9]\.[0-9]{4}")
_WIDTH = "w_"  # how names of states begin that are a width of a gripper, in m


@dataclass(frozen=True, order=True)
class ToolState:
    """A state in which the tool of a cell can be, by the name that the cell gives it.

    Planners hand states on and compare them; only the cell's ``Tool`` knows what one means. It is part
    of the robot's shape, hence of segments, of stored motions and of the keys of caches.

    Attributes:
        name: As in the cell file, e.g. ``straight``.
    """

    name: str

    def __str__(self) -> str:
        """The name, as files and messages have it."""
        return self.name

    @classmethod
    def of_width(cls, width: float) -> ToolState:
        """The state of a gripper whose pads stand some way apart, e.g. on an item.

        Args:
            width: m, told to a tenth of a millimetre.

        Returns:
            The state, e.g. ``w_0.0450``.
        """
        return cls(f"{_WIDTH}{width:.4f}")

    @property
    def width(self) -> float | None:
        """The width in m that the name tells; None for a state that the cell names."""
        return float(self.name[len(_WIDTH) :]) if _WIDTH_NAME.fullmatch(self.name) else None


# On the way from any state to any other: the tool may be anywhere in between, so that what is free in this
# state is free in every state. No cell may give this name to a state of its own.
MOVING = ToolState("moving")

# The state of a tool that has only one, where the cell names none.
FIXED = ToolState("fixed")


@dataclass(frozen=True, eq=False)
class Tool:
    """What is mounted on the flange: a lance with a suction cup, or a hand with two fingers.

    Of a suction tool the cup may be moved by a joint of its own, and the tool frame sits at the tip of the
    uncompressed cup, +z out of it along its axis. Of a gripper it sits between the pads (``gripper.py``): a
    link without a shape, fixed to the hand, ends the chain there. Where nothing is mounted, all three links
    are the flange, and the tool frame is its frame.

    Attributes:
        flange_link: The robot's last own link.
        lance_link: Fixed to the flange: the lance, or the hand.
        last_link: The last link of the chain: the cup, moved by ``joint`` if there is one; of a gripper that
            between the pads.
        joint: The joint of the chain that the state moves, its last; None where the state moves none of it.
        positions: What each state is, in the order of the cell file: position in rad (of a prismatic joint:
            m) of the joint, width in m of a gripper, 0 without either. The first is the state where nothing
            else is said.
        T_lance_tip: Pose (4, 4) of the tool frame on the lance, by state: in the flange link as the tool is
            mounted on it, whose z runs along the lance; of a gripper the tool frame itself.
        T_last_tip: Pose (4, 4) of the tool frame in the last link.
        grip: What holds items, of a kind of tool; a ``BareFlange`` where nothing is mounted.
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
        """Nothing on the flange.

        Args:
            flange_link: The last link of the chain.

        Returns:
            A tool with one state, whose frame is that of the flange.
        """
        link, grip = flange_link, BareFlange(flange_link)
        return cls(link, link, link, None, {FIXED: 0.0}, {FIXED: np.eye(4)}, np.eye(4), grip)

    @property
    def is_bare(self) -> bool:
        """Whether nothing is mounted."""
        return isinstance(self.grip, BareFlange)

    @property
    def suction_cup(self) -> SuctionCup | None:
        """The cup; None where none is mounted."""
        return self.grip if isinstance(self.grip, SuctionCup) else None

    @property
    def gripper(self) -> ParallelGripper | None:
        """The gripper; None where none is mounted."""
        return self.grip if isinstance(self.grip, ParallelGripper) else None

    @property
    def cup(self) -> SuctionCup:
        """The cup. Raises InputError where none is mounted."""
        if self.suction_cup is None:
            raise InputError(
                f"no suction cup is mounted on {self.flange_link}: picks need one; add `tool` to the cell"
            )
        return self.suction_cup

    @property
    def contact_speed(self) -> float:
        """The fastest final approach, m/s; without limit where nothing is mounted."""
        return self.grip.contact_speed

    @property
    def mover(self) -> DeviceKind:
        """The kind of device that changes its state."""
        return self.grip.mover

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints that the state moves: the cup's, or those of the fingers."""
        return self.grip.finger_joints if self.joint is None else (self.joint,)

    @property
    def contact_links(self) -> tuple[str, ...]:
        """Names of the links that may touch what is grasped: the cup, or the fingers."""
        return self.grip.finger_links or (self.last_link,)

    @property
    def states(self) -> tuple[ToolState, ...]:
        """The states that the tool can rest in, in the order of the cell file."""
        return tuple(self.positions)

    @property
    def shapes(self) -> tuple[ToolState, ...]:
        """Everything that the robot's shape can depend on: the states, and MOVING."""
        return (*self.positions, MOVING)

    @property
    def default_state(self) -> ToolState:
        """The state where nothing else is said: the first of the cell file."""
        return next(iter(self.positions))

    @property
    def range(self) -> tuple[float, float]:
        """Least and greatest position in rad or m of the joint, or width, over all states."""
        return min(self.positions.values()), max(self.positions.values())

    def knows(self, state: ToolState) -> bool:
        """Whether the tool can rest in a state: one that the cell names, or a width between two of those.

        Args:
            state: State of the tool.

        Returns:
            True if it can.
        """
        least, most = self.range
        is_between = self.grip.takes_widths and state.width is not None and least <= state.width <= most
        return state in self.positions or is_between

    def position(self, state: ToolState) -> float:
        """Position of the joint in a state, or width of a gripper; MOVING counts as the default state.

        Args:
            state: State of the tool.

        Returns:
            rad, or m of a prismatic joint and of a width.
        """
        if self.grip.takes_widths and state.width is not None and state not in self.positions:
            return state.width
        return self.positions[self.default_state if state == MOVING else state]

    def command(self, state: ToolState) -> str:
        """The action of the device that moves the tool which leads to a state.

        Args:
            state: State of the tool.

        Returns:
            The state's name; for a width on an item that of the narrowest state, which ends on the item.
        """
        if state in self.positions:
            return state.name
        return min(self.positions, key=self.positions.__getitem__).name

    def joint_position(self, joint: str, state: ToolState) -> float:
        """Position of one of the joints that the state moves.

        Args:
            joint: Name of the joint.
            state: State of the tool; MOVING counts as the default state.

        Returns:
            rad, or m of a prismatic joint.
        """
        return self._joint_at(joint, self.position(state))

    def joint_range(self, joint: str) -> tuple[float, float]:
        """Least and greatest position that one of these joints takes over all states.

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
        """Pose of the tool frame in a frame whose z runs along the lance.

        Args:
            state: State of the tool; one that the cell does not name counts as the default state.

        Returns:
            (4, 4).
        """
        return self.T_lance_tip.get(state, self.T_lance_tip[self.default_state])

    def lance_axis(self, state: ToolState) -> Array:
        """Direction of the lance, away from the flange.

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
            True if it does.
        """
        return bool(self.lance_axis(state) @ axis >= _SAME_DIRECTION)

    def tip_to_lance(self, state: ToolState) -> Array:
        """The way from the tip straight to the axis of the lance.

        Args:
            state: State of the tool.

        Returns:
            (3,) m, in the tool frame.
        """
        T = self.tip_on_lance(state)
        return np.asarray(np.round(T[:3, :3].T @ (-T[0, 3], -T[1, 3], 0.0), _DIGITS) + 0.0)

    def state_with_lance(self, axis: Array) -> ToolState | None:
        """The first state in which the lance points along an axis.

        Args:
            axis: (3,) unit vector in the tool frame.

        Returns:
            The state, or None.
        """
        return next((state for state in self.states if self.has_lance(state, axis)), None)

    def R_tip_lance(self, state: ToolState) -> Array:
        """Axes of the lance in the tool frame: x along the lance, y nearly the tool's.

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
