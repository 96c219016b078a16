"""What every kind of tool says of how it holds items: who asks here need not know which kind is mounted.

A kind of tool is a class with these figures (``SuctionCup``, ``ParallelGripper``). How items are grasped with
it, verified and simulated is stated once in each of those rooms, in one class for each kind.
"""

from __future__ import annotations

from typing import Any, Protocol

from pickcli.cell.device import DeviceKind
from pickcli.geometry import Array


class GripLimits(Protocol):
    """Limits on the wrench between a tool and the item that it holds.

    The wrench is w = (fx, fy, fz, tx, ty, tz), N and Nm, that the tool exerts on the item, about the tip, in
    the tool frame. Of every kind there is an axis of the hold; forces along it pull, torques about it twist.
    """

    @property
    def max_pull(self) -> float:
        """N of pull, along the axis of the hold."""

    @property
    def max_shear(self) -> float:
        """N of shear, across the axis of the hold."""

    @property
    def max_moment(self) -> float:
        """Nm of bending, about any axis across that of the hold."""

    @property
    def max_twist(self) -> float:
        """Nm of twist, about the axis of the hold."""

    @property
    def bearer(self) -> str:
        """The words for who bears the load, in reasons: "the cup bears"."""

    @property
    def bears_push(self) -> bool:
        """Whether a push along the axis loads nothing; else it counts as a pull does."""

    def along_axis(self, wrench: Array) -> Array:
        """The wrench in axes whose last one is that of the hold.

        Args:
            wrench: (..., 6) about the tip, in the tool frame.

        Returns:
            (..., 6).
        """

    def lip(self, wrench: Array, share: Array | float = 1.0) -> Array:
        """Share of what presses tool and item together that pull and bending take up.

        Args:
            wrench: (..., 6) about the tip, in the tool frame.
            share: Of the limits that may be used.

        Returns:
            (...) the hold opens above 1.
        """

    def slip(self, wrench: Array, share: Array | float = 1.0) -> Array:
        """Share of the friction that shear and twist take up.

        Args:
            wrench: (..., 6) about the tip, in the tool frame.
            share: Of the limits that may be used.

        Returns:
            (...) the hold slips above 1.
        """

    def figures(self, wrench: Array) -> Array:
        """What of a wrench the limits speak of.

        Args:
            wrench: (..., 6) about the tip, in the tool frame.

        Returns:
            (4, ...) pull and shear in N, bending and twist in Nm.
        """

    def ratio(self, wrench: Array, share: Array | float = 1.0) -> Array:
        """The load over what the tool bears: it holds up to 1.

        Args:
            wrench: (..., 6) about the tip, in the tool frame.
            share: Of the limits that may be used.

        Returns:
            (...) the worse of ``lip`` and ``slip``, >= 0.
        """


class GripModel(Protocol):
    """The figures of what holds items, of one kind of tool."""

    @property
    def kind(self) -> str:
        """The kind of tool in words: "suction cup"."""

    @property
    def holder(self) -> str:
        """The word for what holds an item: "cup"."""

    @property
    def limits(self) -> GripLimits:
        """What a hold bears at most."""

    @property
    def contact_speed(self) -> float:
        """The fastest final approach, m/s."""

    @property
    def mover(self) -> DeviceKind:
        """The kind of device that changes the state of the tool."""

    @property
    def holds_by_vacuum(self) -> bool:
        """Whether it holds by vacuum, which pump and valve switch, and not by where its parts stand."""

    @property
    def tip_radius(self) -> float:
        """Radius in m around the tip within which what is held begins."""

    @property
    def gives_way(self) -> float:
        """How far in m what meets an item gives way along the tool's axis; 0 where it does not."""

    @property
    def stiffness(self) -> float:
        """N/m with which it gives way."""

    @property
    def takes_widths(self) -> bool:
        """Whether the tool rests in states between those that the cell names: at widths, in m."""

    @property
    def finger_joints(self) -> tuple[str, ...]:
        """Names of the joints beside the chain that the state of the tool moves."""

    @property
    def finger_links(self) -> tuple[str, ...]:
        """Names of the links that may touch an item, where that is not the last one of the chain."""

    def joint_position(self, joint: str, stated: float) -> float:
        """Position of one of the joints that the state moves.

        Args:
            joint: Name of the joint.
            stated: What the cell states of the state: rad or m.

        Returns:
            rad, or m of a prismatic joint.
        """

    def motion_figures(self) -> dict[str, Any]:
        """What stored motions depend on, for fingerprints: names and figures as JSON has them, unrounded."""

    def limit_figures(self) -> dict[str, Any]:
        """What the hold bears, for the hash of a scene: names and figures as JSON has them, unrounded."""
