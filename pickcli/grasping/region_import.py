"""Conversion of KTH's task space regions to seals and areas of an item, the form used in item files.

A region becomes the part of a face that the rim of the cup may cover: its positions, enlarged by the radius
of KTH's cup. Regions do not state how well a face seals; that is taken from the item.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.shapes import ShapeKind
from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.grasping.box_tsr import BoxTsr

KTH_CUP_RADIUS = 0.0175  # m, the radius of KTH's cup according to the calls that made their files
# angle of a tool to a face's normal up to which it is assigned to that face
MAX_FACE_ANGLE = np.radians(15.0)
FITS = 1e-3  # m by which the remaining area on a face may be narrower than the cup
MOST_OFF = 0.02  # m that a region may be off its face; KTH's are up to 2 mm off it, or in the item
_GRAIN = 1e-4  # m that limits are rounded to, outwards: a region may be a point, and has to fit the cup

Areas = dict[str, dict[str, tuple[float, float]]]


@dataclass(frozen=True, eq=False)
class ImportedRegions:
    """Seals and areas of an item made from regions.

    Attributes:
        item: The item with their seals and areas.
        axes: (3, 3) signed permutation from the regions' frame to the item's.
        counts: Number of regions on each face, by face.
        left_out: Regions that were not used, each with the reason.
    """

    item: Item
    axes: Array
    counts: dict[str, int]
    left_out: tuple[str, ...]


def import_regions(
    regions: Sequence[BoxTsr],
    item: Item,
    axes: Array | None = None,
    rim: float = KTH_CUP_RADIUS,
    seal: float | None = None,
) -> ImportedRegions:
    """Make seals and areas of an item from regions.

    Args:
        regions: The regions, in a frame at the centre of the item.
        item: The item with its shape.
        axes: (3, 3) signed permutation that turns that frame into the item's; None to find it by sizes.
        rim: m, radius of the cup that the regions are for.
        seal: Share of full vacuum of a face that the item has no seal for; None for its best one.

    Returns:
        The item with seals and areas, and the unused regions.

    Raises:
        InputError: No region lies on the item, or no seal is known.
    """
    S = axes_by_size(regions, item, rim) if axes is None else axes
    found: dict[str, list[Array]] = {}
    left_out: list[str] = []
    for k, region in enumerate(regions):
        corners = np.sort(region.corners @ S.T, axis=0)
        placed = _on_face(corners, S @ region.approach, item, rim)
        if isinstance(placed, str):
            left_out.append(f"region {k}: {placed}")
        else:
            found.setdefault(placed[0], []).append(placed[1])
    if not found:
        raise InputError(
            f"none of {len(regions)} regions lies on {item.name} ({left_out[0]}); if their frame is turned "
            "otherwise, state --axes"
        )
    best = max(item.seals.values()) or seal
    if best is None:
        raise InputError(f"{item.name}: no face of it seals, so how well these do is not known; state --seal")
    areas: Areas = {}
    for face, parts in found.items():
        area, n_beside = _merged(parts, item.shape.kind is ShapeKind.BOX)
        if n_beside:
            left_out.append(f"{n_beside} regions on {face}: beside the largest one, of which a face has one")
        if limits := _limits(face, area, item):
            areas[face] = limits
    shares = {
        face: (item.seals[face] or (best if seal is None else seal)) if face in found else 0.0
        for face in item.shape.face_names
    }
    # The regions say of all faces which are taken; they know the outer shape alone.
    imported = replace(item, seals=shares, areas=areas, why_not="", seal_inset=0.0, hollows=())
    return ImportedRegions(imported, S, {f: len(parts) for f, parts in found.items()}, tuple(left_out))


def axes_by_size(regions: Sequence[BoxTsr], item: Item, rim: float = KTH_CUP_RADIUS) -> Array:
    """Match the axes of the regions' frame to those of the item by size: longest to longest, and so on.

    Args:
        regions: The regions.
        item: The item.
        rim: m, radius of their cup.

    Returns:
        (3, 3) signed permutation, a rotation. Sizes do not determine the signs of the axes.
    """
    reach = [
        np.abs(r.corners).max(axis=0) + rim * np.sqrt(np.maximum(0.0, 1.0 - r.approach**2)) for r in regions
    ]
    theirs = np.argsort(np.max(reach, axis=0), kind="stable")
    ours = np.argsort(item.shape.extents, kind="stable")
    S = np.zeros((3, 3))
    S[ours, theirs] = 1.0
    if np.linalg.det(S) < 0.0:
        S[2] *= -1.0
    return S


def _on_face(corners: Array, approach: Array, item: Item, rim: float) -> tuple[str, Array] | str:
    """Return face and (2, 3) corners of the rim's area on it, clipped to the face; or why there is none."""
    kind, half = item.shape.kind, item.shape.extents / 2
    if kind is ShapeKind.SPHERE:
        nearest = np.clip(0.0, corners[0], corners[1])
        if (beyond := float(np.linalg.norm(nearest)) - half[0]) > MOST_OFF:
            return f"it is {1e3 * beyond:.0f} mm off the item"
        return "sphere", np.stack([-half, half])
    axis = int(np.argmax(np.abs(approach)))
    off = float(np.arccos(np.clip(np.abs(approach[axis]), 0.0, 1.0)))
    face = f"{'-' if approach[axis] > 0 else '+'}{'xyz'[axis]}"
    if kind is ShapeKind.CYLINDER and axis != 2:
        off, face = float(np.arcsin(np.clip(np.abs(approach[2]), 0.0, 1.0))), "mantle"
    if off > MAX_FACE_ANGLE:
        return f"the tool comes {np.degrees(off):.0f} degrees off every face"
    outer = corners[1, axis] if approach[axis] < 0.0 else -corners[0, axis]
    if not -half[axis] - MOST_OFF <= outer <= half[axis] + MOST_OFF:
        return f"it is {1e3 * abs(outer - half[axis]):.0f} mm off {face}"
    area = np.stack([np.maximum(corners[0] - rim, -half), np.minimum(corners[1] + rim, half)])
    along = [2] if face == "mantle" else [i for i in range(3) if i != axis]
    narrowest = float((area[1] - area[0])[along].min())
    if narrowest < 2.0 * rim - FITS:
        left = max(0.0, 1e3 * narrowest)
        return f"reaches beyond {face}, where {left:.0f} mm of the cup's {2e3 * rim:.0f} are left"
    return face, area


def _merged(parts: Sequence[Array], is_box: bool) -> tuple[Array, int]:
    """Merge several areas on a face to one; also return how many of them it does not cover.

    Regions on a cylinder or ball are samples of one region, so their bounding box is used; on a box they are
    rectangles, of which the largest is used.
    """
    if not is_box:
        return np.stack([np.min([p[0] for p in parts], axis=0), np.max([p[1] for p in parts], axis=0)]), 0
    largest = max(parts, key=lambda part: float(np.sort(part[1] - part[0])[1:].prod()))
    covered = [bool((p[0] >= largest[0] - FITS).all() and (p[1] <= largest[1] + FITS).all()) for p in parts]
    return largest, covered.count(False)


def _limits(face: str, area: Array, item: Item) -> dict[str, tuple[float, float]]:
    """Return the area as item files state it: along the axes of its face, omitted if it is the whole face."""
    half = item.shape.extents / 2
    if face == "sphere":
        return {}
    along = "z" if face == "mantle" else "xyz".replace(face[1], "")
    limits = {}
    for axis in along:
        i = "xyz".index(axis)
        low, high = _outwards(area[0, i], -1.0), _outwards(area[1, i], 1.0)
        if low > -half[i] + FITS or high < half[i] - FITS:
            limits[axis] = (low, high)
    return limits


def _outwards(end: float, way: float) -> float:
    """Round an end of an interval away from its middle."""
    return round(way * float(np.ceil(way * end / _GRAIN - 1e-6)) * _GRAIN, 6) + 0.0
