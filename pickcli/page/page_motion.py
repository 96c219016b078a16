"""What happens in a page over time: motion, lanes, curves, and what went wrong. See ``page_document``."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.page.page_scene import Packed, Pose, Tone


@dataclass(frozen=True, eq=False)
class Carried:
    """An item that moves with the tool for a while, and stays where it is let go.

    Attributes:
        item: Its id.
        t_start: s.
        t_end: s.
        pose: Of the item in the tool frame.
    """

    item: str
    t_start: float
    t_end: float
    pose: Pose


@dataclass(frozen=True, eq=False)
class Track:
    """The poses of an item over time, straight in between.

    Attributes:
        item: Its id.
        times: (N,) s.
        poses: (N, 7).
    """

    item: str
    times: Packed
    poses: Packed


@dataclass(frozen=True, eq=False)
class PageMotion:
    """All that moves on a page.

    Attributes:
        duration: s.
        times: (N,) s.
        positions: (N, m) rad or m of the robot's moved joints, straight in between.
        carried: Items in the tool.
        tracks: Items that were recorded.
        is_path_drawn: Whether the whole path of the tool is drawn, and not only that of the chapter shown.
    """

    duration: float
    times: Packed
    positions: Packed
    carried: tuple[Carried, ...] = ()
    tracks: tuple[Track, ...] = ()
    is_path_drawn: bool = True


@dataclass(frozen=True)
class Span:
    """A stretch of time in a lane.

    Attributes:
        t_start: s.
        t_end: s.
        label: What is so in it.
        colour: A name that the page gives a colour to, or #rrggbb.
        detail: What is told when the pointer is over it.
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
        spans: In the order of time.
    """

    name: str
    spans: tuple[Span, ...]


@dataclass(frozen=True, eq=False)
class Signal:
    """Values over time, as curves.

    Attributes:
        name: Heading.
        unit: Of the values as they are told.
        times: (N,) s.
        values: (N, k) as drawn.
        curves: Name of each column.
        scales: What a value of each column is multiplied with to be in its unit.
        units: Unit of each column; empty where all have ``unit``.
        low: Value at the lower edge.
        high: Value at the upper edge.
        limit: Where a limit is drawn, on both sides of 0 where ``low`` is negative; None without.
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
    """How near the robot, and what it holds, comes to what it may not touch.

    Attributes:
        times: (N,) s.
        values: (N,) m, from below; at most ``most``.
        pairs: Index (N,) into ``names`` of the nearest pair.
        names: What is nearest to what.
        kept: m that plans keep.
        most: m, beyond which nothing is measured.
        steady: Pairs that are left out, as they are equally near for long, with their least distance.
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
    """A grasp that was refused, as an arrow on a face of an item.

    Attributes:
        item: Its id.
        face: Name of the face.
        kind: "frontal", "top-down" or "side".
    """

    item: str
    face: str
    kind: str


@dataclass(frozen=True)
class Mark:
    """Something that went wrong, with its reason, to be drawn where it is.

    Attributes:
        title: In a few words.
        detail: All that is known.
        t: s, when; None for something that has no time.
        tone: How bad it is.
        names: Links, bodies and items that are met.
        grasp: The grasp that was refused.
        depth: m, how deep two bodies are in each other; None where that is not the matter.
        count: How often.
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
    """A part of the story: one attempt of a trial.

    Attributes:
        title: What was to be done.
        outcome: How that ended.
        tone: Whether that is good.
        t_start: s.
        t_end: s.
        item: Id of the item that it was about.
        place: Name of the place that the item was in.
        detail: Why it ended so.
        marks: Reasons, to be drawn.
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
