"""The cell: robot, tool, places, devices, limits and named configurations, with their fingerprint."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from pickcli.cell.device import Device
from pickcli.cell.item import Item, item_suggestion
from pickcli.cell.place import Place
from pickcli.cell.robot import Robot
from pickcli.cell.sensors.mounted_camera import MountedCamera
from pickcli.cell.shapes import Body
from pickcli.cell.station import POD, TOTE, Carrier, Obstacles, Pod, Tote, swept
from pickcli.cell.tool import ToolState
from pickcli.errors import InputError, UnknownNameError
from pickcli.geometry import Array

SAME_POSITION = 1e-9  # rad or m
HOME = "home"  # name of the configuration at which trials start and recoveries end
COMMAND = "this command"  # what needs places, unless it is one of several queries


@dataclass(frozen=True, eq=False)
class NamedConfiguration:
    """A configuration with a name and the tool state it is meant for.

    Attributes:
        name: Unique in the cell.
        q: (n,) rad or m.
        tool_state: State of the tool.
        kind: "home", "bin", "camera", "tote", "drop" or "midway"; "yardstick" is only to compare with Delft.
    """

    name: str
    q: Array
    tool_state: ToolState
    kind: str

    @property
    def place(self) -> str:
        """The part of the name after its kind: "A" of bin_A, and of cam_A, which looks into that bin."""
        return self.name.rpartition("_")[2]


@dataclass(frozen=True, eq=False)
class ArmState:
    """Configuration and tool state of an arm at rest.

    Attributes:
        arm: Name of the arm.
        q: (n,) rad or m.
        tool_state: State of its tool.
    """

    arm: str
    q: Array
    tool_state: ToolState

    def is_at(self, other: ArmState) -> bool:
        """Whether another state equals this one within ``SAME_POSITION``.

        Args:
            other: The state to compare with.

        Returns:
            True if tool states are equal and all joint positions agree.
        """
        return (
            self.tool_state == other.tool_state
            and self.q.shape == other.q.shape
            and bool(np.allclose(self.q, other.q, rtol=0.0, atol=SAME_POSITION))
        )

    def __str__(self) -> str:
        """The configuration as the command line has it, and the state of the tool."""
        numbers = ",".join(f"{value + 0.0:.4f}" for value in self.q.tolist())
        return f"{numbers} (tool {self.tool_state})"


SRDF_REASON = "disabled in the SRDF: "  # before the reason that the SRDF states


@dataclass(frozen=True, eq=False)
class AllowedPair:
    """Two bodies that are exempt from collision checks against each other.

    Attributes:
        a: Name of a link.
        b: Name of a link or an obstacle.
        reason: Why they may touch, in a sentence.
        verified: Whether only planning leaves the pair out, as its spheres do not tell the two apart; the
            verifier tests their shapes all the same.
        srdf: The SRDF that disables the pair and the line in it; None for a pair of the cell file.
    """

    a: str
    b: str
    reason: str
    verified: bool = False
    srdf: tuple[Path, int] | None = None


@dataclass(frozen=True, eq=False)
class Cell:
    """A robot cell as seen by one of its arms.

    World frame = the pod frame of the nominal pod (see docs/formats/cell.md). Other arms stand still: their
    links are links of the robot that no joint moves.

    Attributes:
        name: Of the cell.
        path: Folder of the cell.
        robot: The robot with its tool.
        T_world_pod: (4, 4) nominal pose of the pod; identity in the default cell and in cells without a pod.
        pod: The shelf; without bins if the cell has none.
        tote: The tote; None if the cell has none.
        own_carriers: The carriers that the cell file lists under ``places``.
        obstacles: Everything else that stands still.
        devices: Devices by name.
        configurations: Named configurations by name.
        allowed_pairs: Pairs that may touch.
        items: Items by (name, year).
        speed_scale: Factor on all velocity and acceleration limits.
        clearance: m that every planned motion keeps except at planned contacts.
        cameras: Cameras by name; motions do not depend on them.
        max_tool_speed: m/s, limit of the tool tip's speed in every motion; None without a limit.
        arm: Name of the arm; empty if the cell has only one.
        others: Parked states of all other arms, in the order of the cell file.
        warnings: Warnings about the cell file, one line each, with the position in the file.
        accepted: Warnings that the cell file accepts, and that would have been given.
        fingerprint: SHA-256 over all that the validity of a motion depends on.
        parked_fingerprint: Hash over the fingerprints of all arms, each with the others parked; empty if the
            cell has only one arm.
        equipment: Hashes of what plans depend on beyond the fingerprint, by what it is: "devices", and "tool"
            for load limits, of all arms; empty in a cell that was not read from a file.
    """

    name: str
    path: Path
    robot: Robot
    T_world_pod: Array
    pod: Pod
    tote: Tote | None
    obstacles: Obstacles
    devices: dict[str, Device]
    configurations: dict[str, NamedConfiguration]
    allowed_pairs: tuple[AllowedPair, ...]
    items: dict[tuple[str, int], Item]
    speed_scale: float
    clearance: float
    max_tool_speed: float | None = None
    arm: str = ""
    others: tuple[ArmState, ...] = ()
    own_carriers: tuple[Carrier, ...] = ()
    cameras: dict[str, MountedCamera] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    accepted: frozenset[str] = frozenset()
    fingerprint: str = field(default="")
    parked_fingerprint: str = field(default="")
    equipment: dict[str, str] = field(default_factory=dict)

    @property
    def scene_fingerprint(self) -> str:
        """The fingerprint stored in scenes; independent of which arm moves and where others stand."""
        return self.parked_fingerprint or self.fingerprint

    @cached_property
    def places(self) -> dict[str, Place]:
        """All places that can hold items, by name: bins of the pod, the tote, then those under ``places``."""
        return {name: place for carrier in self.carriers.values() for name, place in carrier.places.items()}

    @cached_property
    def carriers(self) -> dict[str, Carrier]:
        """All carriers of places, by name: pod and tote if the cell has them, then those under ``places``."""
        found = []
        if self.pod.bins or self.pod.bodies:
            found.append(
                Carrier(POD, self.T_world_pod, self.pod.bodies, self.pod.bins, self.pod.displacement)
            )
        if self.tote is not None:
            found.append(Carrier(TOTE, np.eye(4), self.tote.bodies, {TOTE: self.tote.place}))
        return {carrier.name: carrier for carrier in (*found, *self.own_carriers)}

    def swept(self) -> Cell:
        """Return the cell with every carrier replaced by its swept volume within its displacement bounds.

        Returns:
            The cell, with an unchanged fingerprint.
        """
        own = tuple(swept(carrier) for carrier in self.own_carriers)
        return replace(self, pod=swept(self.pod), own_carriers=own)

    def configurations_at(self, place: Place) -> list[NamedConfiguration]:
        """Return the configurations that belong to a place.

        Args:
            place: The place.

        Returns:
            Configurations with the name of the place; for the tote also those of kind "tote" or "drop" that
            no other place has the name of. The list may be empty.
        """
        return [
            each
            for each in self.configurations.values()
            if each.name == place.name
            or (place.name == TOTE and each.kind in (TOTE, "drop") and each.name not in self.places)
        ]

    @property
    def home(self) -> NamedConfiguration:
        """The configuration at which trials start and recoveries end; raises InputError without one."""
        if HOME not in self.configurations:
            raise InputError(
                f"cell {self.name}: no configuration is named {HOME}, at which trials start and recoveries "
                "end; add one to its configurations (kind: home)"
            )
        return self.configurations[HOME]

    @property
    def tote_bodies(self) -> tuple[Body, ...]:
        """Boxes of the tote in the world frame, empty without a tote."""
        return () if self.tote is None else self.tote.bodies

    def require_places(self, what: str = COMMAND) -> None:
        """Refuse a cell without places or without a tool, for commands that pick or stow.

        Args:
            what: What needs them, for the message.

        Raises:
            InputError: The cell has no place for items, or no tool that can hold them.
        """
        lacking = [] if self.places else ["pod", "tote", "places"]
        self._refuse_lacking(lacking, "places for items, and a tool", what)

    def require_pod_and_tote(self, what: str = COMMAND) -> None:
        """Refuse a cell in which official orders cannot be played.

        Args:
            what: What needs them, for the message.

        Raises:
            InputError: The cell has no pod, no tote, or no tool that can hold items.
        """
        lacking = [key for key, has in (("pod", self.pod.bins), ("tote", self.tote)) if not has]
        self._refuse_lacking(lacking, "pod, tote and tool", what)

    def _refuse_lacking(self, keys: list[str], needed: str, what: str) -> None:
        """Raise InputError if keys, or a tool that can hold items, are missing in the cell file."""
        lacking = keys + ["tool"] * self.robot.tool.is_bare
        if lacking:
            fault = f"{self.path / 'cell.yaml'}: states no {' and no '.join(lacking)}; {what} needs {needed} "
            others = ", apc plan-move, verify and execute do not" if what == COMMAND else ""
            raise InputError(f"{fault}(docs/formats/cell.md){others}")

    def T_world_place(self, place: Place) -> Array:
        """Return the pose of a place's frame in the world, for the nominal pose of its carrier.

        Args:
            place: The place.

        Returns:
            (4, 4).
        """
        return np.asarray(self.carriers[place.carrier].T_world_carrier @ place.T_carrier_place)

    def item(self, name: str, year: int = 2016) -> Item:
        """Return the item of a name, in the given year's version if there is one, else in the latest.

        Args:
            name: Of the item.
            year: Preferred year.

        Returns:
            The item.

        Raises:
            UnknownNameError: No item has that name.
        """
        years = [found for known, found in self.items if known == name]
        if not years:
            known = sorted({n for n, _ in self.items})
            raise UnknownNameError("item", name, known, hint=item_suggestion(name, known))
        return self.items[name, year if year in years else max(years)]
