"""Data of a page over time: motion, lanes, signals and failures. See ``page_document``."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.page.page_scene import Packed, Pose, Tone


@dataclass(frozen=True, eq=False)
class Carried:
    """An item that moves with the tool for a time, and stays where it is released.

    Attributes:
        item: Id of the item.
        t_start: s.
        t_end: s.
        pose: Pose of the item in the tool frame.
    """

    item: str
    t_start: float
    t_end: float
    pose: Pose


@dataclass(frozen=True, eq=False)
class Track:
    """Poses of an item over time, interpolated linearly.

    Attributes:
        item: Id of the item.
        times: (N,) s.
        poses: (N, 7).
    """

    item: str
    times: Packed
    poses: Packed


@dataclass(frozen=True, eq=False)
class PageMotion:
    """All motion on a page.

    Attributes:
        duration: s.
        times: (N,) s.
        positions: (N, m) rad or m of the robot's moving joints, interpolated linearly.
        carried: Items held by the tool.
        tracks: Recorded items.
        is_path_drawn: Whether the whole path of the tool is drawn, instead of only that of the current
            chapter.
    """

    duration: float
    times: Packed
    positions: Packed
    carried: tuple[Carried, ...] = ()
    tracks: tuple[Track, ...] = ()
    is_path_drawn: bool = True


@dataclass(frozen=True)
class Span:
    """A time span in a lane.

    Attributes:
        t_start: s.
        t_end: s.
        label: State in that time.
        colour: Name of a colour of the page, or #rrggbb.
        detail: Text shown when the pointer is over it.
    """

    t_start: float
    t_end: float
    label: str
    colour: str
    detail: str = ""


@dataclass(frozen=True)
class Lane:
    """Spans in a row: segments of a motion, or a device's states.

    Attributes:
        name: Heading.
        spans: Spans in order of time.
    """

    name: str
    spans: tuple[Span, ...]


@dataclass(frozen=True, eq=False)
class Signal:
    """Values over time, as curves.

    Attributes:
        name: Heading.
        unit: Unit of displayed values.
        times: (N,) s.
        values: (N, k) as drawn.
        curves: Name of each column.
        scales: Factor of each column that converts its values to its unit.
        units: Unit of each column; empty if all have ``unit``.
        low: Value at the lower edge.
        high: Value at the upper edge.
        limit: Value at which a limit is drawn, also at its negative if ``low`` is negative; None without one.
    """

    name: str
    unit: str
    times: Packed
    values: Packed
    curves: tuple[str, ...]
    scales: tuple[float, ...]
    units: tuple[str, ...]
    low: float
    high: float
    limit: float | None = None


@dataclass(frozen=True, eq=False)
class PathClearance:
    """Clearance of the robot and its held item over time, except for planned contacts.

    Attributes:
        times: (N,) s.
        values: (N,) m, lower bound; at most ``most``.
        pairs: Index (N,) into ``names`` of the nearest pair.
        names: Names of the pairs.
        kept: m, clearance kept by plans.
        most: m, largest measured distance.
        steady: Excluded pairs with nearly constant distance, with their least distance.
    """

    times: Packed
    values: Packed
    pairs: Packed
    names: tuple[str, ...]
    kept: float
    most: float
    steady: tuple[str, ...] = ()


@dataclass(frozen=True)
class Approach:
    """A rejected grasp, as an arrow on a face of an item.

    Attributes:
        item: Id of the item.
        face: Name of the face.
        kind: "frontal", "top-down" or "side".
    """

    item: str
    face: str
    kind: str


@dataclass(frozen=True)
class Mark:
    """A failure with its reason and position.

    Attributes:
        title: Short description.
        detail: Full description.
        t: Time, s; None without one.
        tone: Severity.
        names: Links, bodies and items involved.
        grasp: The rejected grasp, or None.
        depth: m, overlap of two bodies; None without one.
        count: Number of occurrences.
    """

    title: str
    detail: str
    t: float | None = None
    tone: Tone = Tone.BAD
    names: tuple[str, ...] = ()
    grasp: Approach | None = None
    depth: float | None = None
    count: int = 1


@dataclass(frozen=True)
class Chapter:
    """A chapter of a trial: one attempt.

    Attributes:
        title: Task of the attempt.
        outcome: Its outcome.
        tone: Whether that is good.
        t_start: s.
        t_end: s.
        item: Id of its item.
        place: Name of the place that the item was in.
        detail: Reason for the outcome.
        marks: Failures to be drawn.
    """

    title: str
    outcome: str
    tone: Tone
    t_start: float
    t_end: float
    item: str = ""
    place: str = ""
    detail: str = ""
    marks: tuple[Mark, ...] = ()
