"""Page of a single item: grasp regions of the cup, and sampled grasp candidates."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.tool import Tool
from pickcli.files.packed_array import packed
from pickcli.geometry import Array, pose
from pickcli.grasping.grasp_target import CandidateSet
from pickcli.grasping.surfaces import Face, faces
from pickcli.motion.plan import Grasp
from pickcli.page.cell_parts import item_ink
from pickcli.page.page_document import PageDocument, PageTable
from pickcli.page.page_scene import (
    INVISIBLE_ROBOT,
    Fact,
    PageBody,
    PageGroup,
    PageItem,
    PageLine,
    PageShape,
    Tone,
    posed,
    rounded,
)
from pickcli.page.shape_parts import drawn_item

_LIFT = 4e-4  # m between regions and the surface, for visibility
_THIN = 1e-3  # m, least side of a region that is a line or a point
_ARROW = 0.04  # m
_POINT_RESOLUTION = 1e-4  # m, resolution of points
_REGION = "#0072b2"
_LOADS = ((0.33, "#009e73", "up to a third"), (0.67, "#e69f00", "up to two thirds"), (9.9, "#b2182b", "more"))
_T_IDENTITY = pose((0.0, 0.0, 0.0))


def grasps_page(item: Item, tool: Tool, place: str, found: CandidateSet) -> PageDocument:
    """Create the page of an item with its grasp regions and grasp candidates.

    Args:
        item: The item.
        tool: The tool; regions are those of its cup, if it has one.
        place: The place for which the candidates were sampled.
        found: The candidates.

    Returns:
        The page; its world is the item's frame.
    """
    regions = () if tool.is_bare or tool.grip.takes_widths else faces(item, tool)
    loads = [(grasp, _load(grasp)) for grasp in found.grasps]
    name = item.name.replace("_", " ")
    return PageDocument(
        kind="grasps",
        title=f"Grasps of {name}",
        subtitle=f"{len(found.grasps)} candidates in {place}, {len(regions)} regions",
        facts=tuple(_facts(item, found)),
        robot=INVISIBLE_ROBOT,
        groups=tuple(
            PageGroup(f"region {face.name}", posed(_T_IDENTITY), _REGION, (_region(face, item),), 0.6)
            for face in regions
        ),
        items=(PageItem(item.name, name, item_ink(item), drawn_item(item), posed(_T_IDENTITY)),),
        lines=tuple(PageLine(f"{k + 1}: {grasp}", _arrow(grasp), colour)
                    for k, (grasp, (colour, _)) in enumerate(loads)),
        legend=tuple((f"load {words}", colour) for _, colour, words in _LOADS),
        tables=(_face_table(item, regions), _grasp_table(found.grasps)),
    )  # fmt: skip


def _load(grasp: Grasp) -> tuple[str, str]:
    return next((colour, words) for most, colour, words in _LOADS if grasp.load_ratio <= most)


def _region(face: Face, item: Item) -> PageBody:
    """Convert a region of the cup's centre: a rectangle, a band around a cylinder, or a sphere."""
    region = face.region
    if face.name == "sphere":
        shape, T = PageShape("sphere", rounded((item.shape.size[0] + _LIFT,))), _T_IDENTITY
    elif face.name == "mantle":
        low, high = region.bounds[2]
        size = (item.shape.size[0] + _LIFT, max(_THIN, high - low))
        shape, T = PageShape("cylinder", rounded(size)), pose((0.0, 0.0, (low + high) / 2))
    else:
        width, height = np.maximum(_THIN, np.diff(region.bounds[:2])[:, 0])
        shape, T = PageShape("box", rounded((width, height, 2 * _LIFT))), region.T_object_region
    return PageBody(f"region {face.name}", shape, posed(T))


def _arrow(grasp: Grasp) -> dict[str, object]:
    """Line along the approach direction to the contact point on the item."""
    tip, approach = grasp.T_item_tip[:3, 3], grasp.T_item_tip[:3, 2]
    return packed(np.stack([tip - _ARROW * approach, tip]), _POINT_RESOLUTION)


def _facts(item: Item, found: CandidateSet) -> Iterator[Fact]:
    size = " x ".join(f"{1e3 * side:.0f}" for side in item.shape.extents)
    yield Fact("item", f"{item.name} of {item.year}")
    yield Fact("size", f"{size} mm, {item.shape.kind}")
    yield Fact("mass", f"{1e3 * item.mass:.0f} g")
    yield Fact("seals by", item.seal_source)
    for what, n in Counter(reason.what for reason in found.rejected).most_common():
        yield Fact("dropped", f"{n}: {what}", Tone.FAIR)
    if item.why_not:
        yield Fact("no suction", item.why_not, Tone.BAD)


def _face_table(item: Item, regions: tuple[Face, ...]) -> PageTable:
    """Table of all faces: seal, sealing area, and sides of the region."""
    by_name = {face.name: _sides(face.region.bounds) for face in regions}
    rows = tuple(
        (name, f"{share:.0%}", _area(item, name) if share else "", by_name.get(name, "none"))
        for name, share in item.seals.items()
    )
    return PageTable("Faces", ("face", "seal", "part, mm", "centre, mm"), rows)


def _area(item: Item, face: str) -> str:
    limits = item.areas.get(face, {})
    return ", ".join(f"{axis} {1e3 * a:.0f} to {1e3 * b:.0f}" for axis, (a, b) in limits.items()) or "all"


def _sides(bounds: Array) -> str:
    sides = [f"{1e3 * (high - low):.0f}" for low, high in bounds[:3] if high > low]
    around = ["around"] if np.ptp(bounds[3:]) > 0.0 else []
    return " x ".join(sides + around) or "a point"


def _grasp_table(grasps: tuple[Grasp, ...]) -> PageTable:
    rows = tuple(
        (str(k + 1), grasp.kind, grasp.face, f"{grasp.load_ratio:.0%}", f"{grasp.score:.2f}")
        for k, grasp in enumerate(grasps)
    )
    return PageTable(
        "Candidates, best first",
        ("no.", "kind", "face", "load", "score"),
        rows or (("", "none", "", "", ""),),
    )
