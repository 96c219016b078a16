"""Grasp candidates for one item in one bin: sampled by seed, filtered by seal, reach of the tool and hold.

This is Delft's first filter (section 2: "impossible grasps are eliminated heuristically"); the second
one, by inverse kinematics and collisions along every line, stands in ``planning``.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.place import Place
from pickcli.cell.tool import ACROSS, IN_LINE, Tool
from pickcli.errors import Reason
from pickcli.geometry import Array, inverse
from pickcli.grasping.aims import aims
from pickcli.grasping.holding import Hold
from pickcli.grasping.search import USUAL, Search
from pickcli.grasping.surfaces import Face, faces, tilted, turned, wide_faces
from pickcli.motion.plan import Grasp

# A straight lance fits into a bin only when it is tilted little (30 degrees: 162 of 360 poses, 60: 54).
MAX_FRONTAL_TILT = np.radians(30.0)
MAX_PIVOTED_TILT = np.radians(25.0)
LANCE_CLEAR = 0.02  # m from the axis of the lance to a lip: its radius, the clearance, the cover's excess
PIVOT_LENGTH = 0.03  # m from the tip to the lance's axis when the cup is pivoted
TRIES_PER_PLACE = 8
SIDE = 0.15  # what a side grasp costs: it needs room beside the item
ROLLING = 0.3  # and more where the cup makes the item roll before it holds
HOLDS = 0.8  # of what the cup bears at rest, beyond which a grasp is dropped
TILTS = (0.0, 0.25, 0.5, 0.75, 1.0)  # shares of the most that the cup may be tilted
DOWN = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])  # a tool pointing straight down


@dataclass(frozen=True)
class CandidateSet:
    """Grasp candidates for one item.

    Attributes:
        grasps: Candidates, best first.
        rejected: Why others were dropped.
    """

    grasps: tuple[Grasp, ...]
    rejected: tuple[Reason, ...]


@dataclass(frozen=True, eq=False)
class GraspTarget:
    """An item that is to be grasped where it lies.

    Attributes:
        id: Id of the item in its scene.
        item: Kind of the item, with its shape and mass.
        T_entry_item: (4, 4) its pose in the frame of the way into its place, x leading in.
        place: Where it lies.
    """

    id: str
    item: Item
    T_entry_item: Array
    place: Place

    @property
    def R_level_entry(self) -> Array:
        """(3, 3) how the way in stands in a frame whose z axis points up."""
        return self.place.T_place_entry[:3, :3]


def sample_grasps(
    target: GraspTarget, tool: Tool, rng: np.random.Generator, search: Search = USUAL, most: float = HOLDS
) -> CandidateSet:
    """Candidates for an item whose pose is known.

    Into a place from the front, frontal grasps use the straight cup, top-down and side grasps the pivoted
    one; from above all are top-down, with the straight cup. Each face yields its centre, random places and
    those of the search's grid. The order follows ``Grasp.score``: load over limit, which is least near the
    centre of mass and on faces that seal well, plus penalties for tilt, turn and pressing from the side.

    Args:
        target: What is to be grasped.
        tool: What it is grasped with.
        rng: Source of the random places.
        search: How many places, turns and tilts are tried.
        most: Largest share of what the cup bears that the item at rest may take up.

    Returns:
        Candidates, best first, and why others were dropped.
    """
    item = target.item
    if not item.suction:
        return CandidateSet((), (Reason("cannot be held by suction", target.id, item.why_not),))
    found: list[Grasp] = []
    rejected: list[Reason] = []
    for face in faces(item, tool):
        places = [face.region.centre(), *_reachable(face, target, tool, rng, search.n_random)]
        places += aims(face, item, target.T_entry_item, search)
        for T_item_tip in places:
            grasps, reason = _placements(target, face.name, T_item_tip, tool, search, most)
            found += grasps
            if reason is not None:
                rejected.append(reason)
    if not found and not rejected:
        rejected.append(_nothing_to_hold(target.id, item, tool))
    return CandidateSet(tuple(sorted(found, key=lambda g: g.score)), tuple(rejected))


def _nothing_to_hold(item_id: str, item: Item, tool: Tool) -> Reason:
    if not wide_faces(item, tool):
        return Reason("no face takes the whole cup", item_id, f"its radius is {tool.cup_radius * 1e3:.0f} mm")
    if not faces(item, tool):
        return Reason("no face that takes the whole cup seals", item_id, item.seal_source)
    sealing = ", ".join(face.name for face in faces(item, tool))
    return Reason("no face within reach", item_id, f"{sealing} point neither at the mouth nor up nor aside")


def _reachable(face: Face, target: GraspTarget, tool: Tool, rng: np.random.Generator, n: int) -> list[Array]:
    """Up to n random places on a face for which a level lance clears the lips of the mouth."""
    samples = face.region.sample(rng, TRIES_PER_PLACE * n)
    T = target.T_entry_item @ samples
    # The pivoted cup points down or aside; its lance then lies above or beside the tip, and may be tilted.
    is_pivoted = T[:, 0, 2] < np.cos(MAX_FRONTAL_TILT)
    gained = PIVOT_LENGTH * -T[:, 2, 2] + np.sin(tool.cup_tilt) * np.maximum(T[:, 0, 3], 0.0)
    height = T[:, 2, 3] + np.where(is_pivoted, gained, 0.0)
    is_clear = (height >= LANCE_CLEAR) & (T[:, 2, 3] <= target.place.access.height - LANCE_CLEAR)
    return list(samples[is_clear][:n])


def _placements(
    target: GraspTarget, face: str, T_item_tip: Array, tool: Tool, search: Search, most: float
) -> tuple[list[Grasp], Reason | None]:
    """The ways in which the tool can point at one place: turned about the cup's axis, and tilted a little."""
    item, T_entry_item = target.item, target.T_entry_item
    R = T_entry_item[:3, :3] @ T_item_tip[:3, :3]
    along = R[:, 2]  # the cup's axis in the frame of the way in
    kind, axis, off = _kind(along)
    tool_state = tool.state_with_lance(axis)
    if kind is None:
        return [], None  # faces away from every way in: not a failure, just another side
    turns = search.turns(kind)
    if target.place.access.is_from_above:
        if kind != "frontal":
            return [], None  # there is no room for a lance that lies level
        kind = "top-down"
    if tool_state is None:
        return [], Reason("no state of the tool for this grasp", f"{target.id}, face {face}", kind)
    hold = Hold.of(item, face, inverse(T_item_tip), tool)
    load = hold.at_rest(np.stack([target.R_level_entry @ R, DOWN]))  # as it lies, and hanging from the cup
    if load.ratio > most:
        where = f"{target.id}, face {face}"
        return [], Reason("does not hold", where, f"{load} at rest, {load.ratio:.2f} of what the cup bears")
    figures = load.moment, load.pull, load.shear, load.twist, load.ratio
    grasps = []
    worse = off / np.pi
    if kind == "side":
        worse += SIDE + (ROLLING if item.can_roll(target.R_level_entry @ T_entry_item[:3, :3]) else 0.0)
    for x_target, turn in turns:
        T_turned = turned(T_item_tip, _turn_towards(R, x_target))
        is_level = axis is ACROSS and kind == "top-down"
        least = _tilt_over_the_lip(T_entry_item @ T_turned, tool.cup_tilt) if is_level else 0.0
        for share in (None, *search.tilts):
            tilt = least if share is None else share * tool.cup_tilt
            T = tilted(T_turned, tilt)
            score = (
                load.ratio + worse + 0.3 * turn / np.pi + (0.0 if share is None else 0.05 + abs(tilt) / np.pi)
            )
            grasps.append(Grasp(target.id, kind, face, tool_state, T, float(score), *figures))
    return grasps, None


def _kind(along: Array) -> tuple[str | None, Array, float]:
    """The kind of grasp for a cup's axis (3,) in the bin frame, and how many rad that is off its ideal.

    Between the two the direction (3,) in the tool frame of a lance that comes in through the mouth for it.
    """
    if along[0] >= np.cos(MAX_FRONTAL_TILT):
        return "frontal", IN_LINE, float(np.arccos(min(1.0, along[0])))
    best = max(-along[2], abs(along[1]))
    kind = "top-down" if -along[2] >= abs(along[1]) else "side"
    off = float(np.arccos(min(1.0, best)))
    return kind if off <= MAX_PIVOTED_TILT else None, ACROSS, off


def _tilt_over_the_lip(T_bin_tip: Array, most: float) -> float:
    """The least tilt in rad at which a lance that lies level over a thin item clears the bin's lip."""
    (x, _, z), height = T_bin_tip[:3, :3].T[:, [0, 2]].tolist(), float(T_bin_tip[2, 3])
    from_mouth = float(T_bin_tip[0, 3])
    for tilt in TILTS:
        c, s = cos(tilt * most), sin(tilt * most)
        along = c * x[0] - s * z[0], c * x[1] - s * z[1]  # of the tilted tool's x axis, into the bin and up
        down = c * z[0] + s * x[0], c * z[1] + s * x[1]  # of its z axis
        rise = along[1] / max(-along[0], 1e-3)  # per m towards the mouth
        if height - PIVOT_LENGTH * down[1] + rise * (from_mouth - PIVOT_LENGTH * down[0]) >= LANCE_CLEAR:
            return tilt * most
    return 0.0


def _turn_towards(R: Array, x_target: Array) -> float:
    """The turn about z that brings the x axis of R (3, 3) closest to a direction (3,)."""
    return float(np.arctan2(R[:, 1] @ x_target, R[:, 0] @ x_target))
