"""The cell: everything that stands still between two orders, and its fingerprint."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from pickcli.cell.device import Device
from pickcli.cell.item import Item, item_suggestion
from pickcli.cell.place import Place
from pickcli.cell.robot import Robot
from pickcli.cell.shapes import Body
from pickcli.cell.station import POD, TOTE, Carrier, Obstacles, Pod, Tote, swept
from pickcli.cell.tool import ToolState
from pickcli.errors import InputError, UnknownNameError
from pickcli.geometry import Array

SAME_POSITION = 1e-9  # rad or m


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
    """Where an arm stands, at rest.

    Attributes:
        arm: Name of the arm.
        q: (n,) rad or m.
        tool_state: State of its tool.
    """

    arm: str
    q: Array
    tool_state: ToolState

    def is_at(self, other: ArmState) -> bool:
        """Whether another state is this one, as exactly as a fingerprint tells.

        Args:
            other: The other one.

        Returns:
            True if it is.
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


@dataclass(frozen=True, eq=False)
class AllowedPair:
    """Two bodies that are never tested against each other, and why.

    Attributes:
        a: Name of a link.
        b: Name of a link or an obstacle.
        reason: Why they may touch, in a sentence.
    """

    a: str
    b: str
    reason: str


@dataclass(frozen=True, eq=False)
class Cell:
    """A robot cell as one of its arms sees it, which may be the only one.

    World frame = the pod frame of the nominal pod (see docs/formats/cell.md). Other arms stand still: their
    links are links of the robot that no joint moves.

    Attributes:
        name: Of the cell.
        path: The cell's folder.
        robot: The robot with its tool.
        T_world_pod: (4, 4) nominal pose of the pod, identity in the default cell and where there is none.
        pod: The shelf, without bins where there is none.
        tote: The tote; None where there is none.
        own_carriers: What the cell names under ``places``, each with its places.
        obstacles: Everything else that stands still.
        devices: Devices by name.
        configurations: Named configurations by name.
        allowed_pairs: Pairs that may touch.
        items: Items by (name, year).
        speed_scale: Factor on all velocity and acceleration limits.
        clearance: m that every planned motion keeps outside of planned contacts.
        max_tool_speed: m/s of the tool's tip, in every motion; None without a limit.
        arm: Name of the arm; empty where the cell has only one.
        others: Where all other arms stand, in the order of the cell file.
        warnings: What is probably wrong in its file, a line each, with the place.
        fingerprint: SHA-256 over all that the validity of a motion depends on.
        parked_fingerprint: Over the fingerprints of all arms, each with the others parked; empty where the
            cell has only one.
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
    warnings: tuple[str, ...] = ()
    fingerprint: str = field(default="")
    parked_fingerprint: str = field(default="")

    @property
    def scene_fingerprint(self) -> str:
        """What scenes of the cell carry: the same whichever arm moves, and wherever the others stand."""
        return self.parked_fingerprint or self.fingerprint

    @cached_property
    def places(self) -> dict[str, Place]:
        """Everything that can hold items, by name: the bins of the pod, the tote, then those of its own."""
        return {name: place for carrier in self.carriers.values() for name, place in carrier.places.items()}

    @cached_property
    def carriers(self) -> dict[str, Carrier]:
        """What places are part of, by name: pod and tote, if there are, then those of its own."""
        found = []
        if self.pod.bins or self.pod.bodies:
            found.append(
                Carrier(POD, self.T_world_pod, self.pod.bodies, self.pod.bins, self.pod.displacement)
            )
        if self.tote is not None:
            found.append(Carrier(TOTE, np.eye(4), self.tote.bodies, {TOTE: self.tote.place}))
        return {carrier.name: carrier for carrier in (*found, *self.own_carriers)}

    def swept(self) -> Cell:
        """The cell with every carrier grown to the volume that it may take up within its bounds.

        Returns:
            The cell; its fingerprint stays.
        """
        own = tuple(swept(carrier) for carrier in self.own_carriers)
        return replace(self, pod=swept(self.pod), own_carriers=own)

    def configurations_at(self, place: Place) -> list[NamedConfiguration]:
        """The configurations that are named after a place.

        Args:
            place: The place.

        Returns:
            Those that are called as the place is; for the tote also those of the kinds "tote" and "drop" that
            are called as no other place is. A cell need not name any.
        """
        return [
            each
            for each in self.configurations.values()
            if each.name == place.name
            or (place.name == TOTE and each.kind in (TOTE, "drop") and each.name not in self.places)
        ]

    @property
    def tote_bodies(self) -> tuple[Body, ...]:
        """Boxes of the tote in the world frame, none where there is no tote."""
        return () if self.tote is None else self.tote.bodies

    def require_places(self) -> None:
        """Refuse a cell that has only a robot, where something is to be picked or stowed.

        Raises:
            InputError: It has no place for items, or nothing that holds them.
        """
        lacking = [] if self.places else ["pod", "tote", "places"]
        self._refuse_lacking(lacking, "places for items, and a tool")

    def require_pod_and_tote(self) -> None:
        """Refuse a cell in which no official order can be played.

        Raises:
            InputError: It has no pod or no tote, or nothing that holds items.
        """
        lacking = [key for key, has in (("pod", self.pod.bins), ("tote", self.tote)) if not has]
        self._refuse_lacking(lacking, "pod, tote and tool")

    def _refuse_lacking(self, keys: list[str], needed: str) -> None:
        """Raise InputError for keys that the cell's file lacks, and for a tool that holds nothing."""
        lacking = keys + ["tool"] * self.robot.tool.is_bare
        if lacking:
            raise InputError(
                f"{self.path / 'cell.yaml'}: states no {' and no '.join(lacking)}; this command needs "
                f"{needed} (docs/formats/cell.md), apc plan-move, verify and execute do not"
            )

    def T_world_place(self, place: Place) -> Array:
        """Pose of a place's frame in the world, its carrier where that nominally stands.

        Args:
            place: The place.

        Returns:
            (4, 4).
        """
        return np.asarray(self.carriers[place.carrier].T_world_carrier @ place.T_carrier_place)

    def item(self, name: str, year: int = 2016) -> Item:
        """The item of a name: as it was in the given year if it is known there, else in the latest.

        Args:
            name: Of the item.
            year: Preferred year.

        Returns:
            The item.

        Raises:
            UnknownNameError: If there is none.
        """
        years = [found for known, found in self.items if known == name]
        if not years:
            known = sorted({n for n, _ in self.items})
            raise UnknownNameError("item", name, known, hint=item_suggestion(name, known))
        return self.items[name, year if year in years else max(years)]
