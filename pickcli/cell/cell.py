"""The cell: everything that stands still between two orders, and its fingerprint."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from pickcli.cell.device import Device
from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.cell.robot import Robot
from pickcli.cell.station import Obstacles, Pod, Tote
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array


@dataclass(frozen=True, eq=False)
class NamedConfiguration:
    """A configuration with a name and the tool state it is meant for."""

    name: str
    q: Array  # (n,)
    tool_state: ToolState
    kind: str  # "home", "bin", "camera", "tote", "drop", "midway"; "yardstick": only to compare with Delft

    @property
    def place(self) -> str:
        """The part of the name after its kind: "A" of bin_A, and of cam_A, which looks into that bin."""
        return self.name.rpartition("_")[2]


@dataclass(frozen=True, eq=False)
class AllowedPair:
    """Two bodies that are never tested against each other, and why."""

    a: str  # link name
    b: str  # link or obstacle name
    reason: str


@dataclass(frozen=True, eq=False)
class Cell:
    """A station. World frame = the pod frame of the nominal pod (see docs/formats/cell.md)."""

    name: str
    path: Path  # the cell's folder
    robot: Robot
    T_world_pod: Array  # (4, 4) nominal, identity in the default cell
    pod: Pod
    tote: Tote
    obstacles: Obstacles
    devices: dict[str, Device]
    configurations: dict[str, NamedConfiguration]
    allowed_pairs: tuple[AllowedPair, ...]
    items: dict[tuple[str, int], Item]  # by (name, year)
    speed_scale: float  # of all velocity and acceleration limits
    clearance: float  # m, margin that every planned motion keeps outside of planned contacts
    max_tool_speed: float | None = None  # m/s of the tool's tip, in every motion
    fingerprint: str = field(default="")  # SHA-256 over all that the validity of a motion depends on

    @property
    def places(self) -> dict[str, Place]:
        """Everything that can hold items, by name: the bins of the pod, then the tote."""
        return {**self.pod.bins, self.tote.place.name: self.tote.place}

    def T_world_place(self, place: Place) -> Array:
        """Pose (4, 4) of a place's frame in the world, the pod where it nominally stands."""
        return place.in_world(self.T_world_pod)

    def item(self, name: str, year: int = 2016) -> Item:
        """The item of that name, of the year if it has one, else of the other. Raises UnknownNameError."""
        from pickcli.errors import UnknownNameError

        for key in ((name, year), (name, 2016), (name, 2015)):
            if key in self.items:
                return self.items[key]
        raise UnknownNameError("item", name, sorted({n for n, _ in self.items}))
