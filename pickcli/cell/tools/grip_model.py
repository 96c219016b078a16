"""Protocols of the figures and limits that every kind of tool has, for code that is independent of the kind.

A kind of tool is a class with these figures (``SuctionCup``, ``ParallelGripper``). The rooms for grasping,
verification and simulation have one class each per kind.
"""

from __future__ import annotations

from typing import Any, Protocol

from pickcli.cell.device import DeviceKind
from pickcli.geometry import Array


class GripLimits(Protocol):
    """Limits on the wrench between a tool and the item that it holds.

    The wrench is w = (fx, fy, fz, tx, ty, tz), N and Nm, that the tool exerts on the item, about the tip, in
    the tool frame. Every hold has an axis: forces along it are pull, torques about it are twist.
    """

    @property
    def max_pull(self) -> float:
        """Limit of pull, N along the axis of the hold."""

    @property
    def max_shear(self) -> float:
        """Limit of shear, N perpendicular to the axis of the hold."""

    @property
    def max_moment(self) -> float:
        """Limit of bending, Nm about any axis perpendicular to that of the hold."""

    @property
    def max_twist(self) -> float:
        """Limit of twist, Nm about the axis of the hold."""

    @property
    def bearer(self) -> str:
        """Subject of sentences about the load, for messages: "the cup bears"."""

    @property
    def bears_compression(self) -> bool:
        """Whether a push along the axis is no load; otherwise it counts as pull."""

    def along_axis(self, wrench: Array) -> Array:
        """Return the wrench in axes whose last one is that of the hold.

        Args:
            wrench: (..., 6) about the tip, in the tool frame.

        Returns:
            (..., 6).
        """

    def peel(self, wrench: Array, share: Array | float = 1.0) -> Array:
        """Compute the share of the contact pressure that pull and bending use up.

        Args:
            wrench: (..., 6) about the tip, in the tool frame.
            share: Usable share of the limits.

        Returns:
            (...) share; the hold opens above 1.
        """

    def slip(self, wrench: Array, share: Array | float = 1.0) -> Array:
        """Compute the share of the friction that shear and twist use up.

        Args:
            wrench: (..., 6) about the tip, in the tool frame.
            share: Usable share of the limits.

        Returns:
            (...) share; the hold slips above 1.
        """

    def figures(self, wrench: Array) -> Array:
        """Compute the components of a wrench that the limits apply to.

        Args:
            wrench: (..., 6) about the tip, in the tool frame.

        Returns:
            (4, ...) pull and shear in N, bending and twist in Nm.
        """

    def ratio(self, wrench: Array, share: Array | float = 1.0) -> Array:
        """Compute the load over the limits; the tool holds up to 1.

        Args:
            wrench: (..., 6) about the tip, in the tool frame.
            share: Usable share of the limits.

        Returns:
            (...) the larger of ``peel`` and ``slip``, >= 0.
        """


class GripModel(Protocol):
    """Figures of one kind of tool for holding items."""

    @property
    def kind(self) -> str:
        """Kind of the tool in words: "suction cup"."""

    @property
    def holder(self) -> str:
        """Word for the part that holds an item: "cup"."""

    @property
    def limits(self) -> GripLimits:
        """Load limits of a hold."""

    @property
    def contact_speed(self) -> float:
        """Largest speed of the final approach, m/s."""

    @property
    def mover(self) -> DeviceKind:
        """Kind of the device that changes the tool's state."""

    @property
    def holds_by_vacuum(self) -> bool:
        """Whether it holds by vacuum, switched by pump and valve, and not by finger positions."""

    @property
    def tip_radius(self) -> float:
        """Radius in m around the tip in which a held item may begin."""

    @property
    def gives_way(self) -> float:
        """Compliant travel along the tool's axis in m; 0 if rigid."""

    @property
    def stiffness(self) -> float:
        """Stiffness along the tool's axis in N/m."""

    @property
    def takes_widths(self) -> bool:
        """Whether the tool can rest at widths in m between the states named by the cell."""

    @property
    def finger_joints(self) -> tuple[str, ...]:
        """Names of the joints outside the chain that the tool's state moves."""

    @property
    def finger_links(self) -> tuple[str, ...]:
        """Names of the links that may touch an item, if these are not the last link of the chain."""

    def joint_position(self, joint: str, stated: float) -> float:
        """Return the position of one of the joints that the state moves.

        Args:
            joint: Name of the joint.
            stated: Value of the state in the cell file: rad or m.

        Returns:
            rad, or m of a prismatic joint.
        """

    def motion_figures(self) -> dict[str, Any]:
        """Return the figures that stored motions depend on, for fingerprints: as for JSON, unrounded."""

    def limit_figures(self) -> dict[str, Any]:
        """Return the figures of the limits, for the hash of a scene: as for JSON, unrounded."""
