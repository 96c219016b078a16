"""Grasp candidates of a cup for one item in one place: sampled by seed, filtered by seal, reach and hold.

This is Delft's first filter (section 2: "impossible grasps are eliminated heuristically"); the second one, by
inverse kinematics and collision checks along every line, is in ``planning``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pickcli.cell.item import LEAST_SHARE
from pickcli.cell.tool import ACROSS, IN_LINE, Tool, ToolState
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.grasping.envelope import Envelope
from pickcli.grasping.face_poses import face_poses
from pickcli.grasping.grasp_target import CandidateSet, GraspBatch, GraspTarget
from pickcli.grasping.holding import HoldLimits, loads_at_rest
from pickcli.grasping.lip_coverage import bearing_share, kept_vacuum
from pickcli.grasping.search import USUAL, Search
from pickcli.grasping.surfaces import Face, faces, flat_normal, rolled, tilt_on, tilted, wide_faces

# A straight lance fits into a bin only with a small tilt (30 degrees: 162 of 360 poses, 60: 54).
MAX_FRONTAL_TILT = np.radians(30.0)
# From above it may lean as far as walls and neighbours allow, which is checked for the tool without the arm.
MAX_LEAN_FROM_ABOVE = np.radians(80.0)
# A lance across the way in may roll about itself, so that its cup meets faces that lean to either side; its
# pitch is small, and it does not come from below.
MAX_ACROSS_TILT = np.radians(25.0)
MAX_LEAN_ACROSS = np.radians(35.0)  # of a lance from above that is across its cup, beside an upright face
LANCE_CLEAR = 0.02  # m from the axis of the lance to a lip: its radius, the clearance, the cover's excess
TRIES_PER_PLACE = 8
SIDE = 0.15  # cost of a side grasp: it needs clearance beside the item
ROLLING = 0.3  # additional cost if the cup makes the item roll before it holds
HOLDS = 0.8  # of what the cup bears; a grasp with a larger load at rest is dropped
TILTS = np.array([0.0, 0.25, 0.5, 0.75, 1.0])  # shares of the cup's largest tilt


def sample_suctions(
    target: GraspTarget, tool: Tool, rng: np.random.Generator, search: Search = USUAL, most: float = HOLDS
) -> CandidateSet:
    """Sample candidates of a cup for an item with a known pose.

    Into a place from the front, frontal grasps have the lance in line with the cup, top-down and side grasps
    across it. From above it is in line, leaning with the face, or across, beside an upright face. Each face
    yields its centre, random places and those of the search's grid. The score of a grasp is load over limit,
    which is least near the centre of mass and on faces that seal well, plus penalties for tilt, turn and
    pressing from the side.

    Args:
        target: The item to be grasped.
        tool: The tool, with a cup.
        rng: Source of the random places.
        search: How many places, turns and tilts are tried.
        most: Largest share of what the cup bears that the item at rest may take up.

    Returns:
        Candidates, and why others were dropped.
    """
    item = target.item
    if not item.suction:
        return CandidateSet((), (Reason("cannot be held by suction", target.id, item.why_not),))
    found: list[GraspBatch] = []
    rejected: list[Reason] = []
    for face in faces(item, tool):
        centre = face.region.centre()[None]
        # All places on a flat face look the same way.
        if flat_normal(face.name) is not None and not any(
            m.any() for m, _ in _kinds(target, tool, centre).values()
        ):
            continue
        drawn = _reachable(face, target, tool, rng, search.n_random)
        chosen = face_poses(face, item, target.T_entry_item, search)
        places = _places(target, face.name, np.concatenate([centre, drawn, chosen]), tool)
        if isinstance(places, Reason):
            rejected.append(places)
            continue
        grasps, against = _placements(target, places, tool, search, most)
        found += grasps
        rejected += against
    if not found and not rejected:
        rejected.append(_nothing_to_hold(target, tool))
    return CandidateSet(tuple(found), tuple(rejected))


def suctions_in(
    target: GraspTarget, tool: Tool, envelope: Envelope, tool_state: ToolState, T_item_tip: Array, most: float
) -> CandidateSet:
    """Make candidates of poses of a cup in an envelope, scored by load, turn and tilt.

    Args:
        target: The item to be grasped.
        tool: The tool, with a cup.
        envelope: One of the item's envelopes, or a part of one.
        tool_state: State of the tool.
        T_item_tip: (N, 4, 4) poses of the tool in the envelope, up to rounding.
        most: Largest share of what the cup bears that the item at rest may take up.

    Returns:
        Those that seal and hold, and why others were dropped.
    """
    places = _places(target, envelope.face, envelope.clipped(T_item_tip), tool)
    if isinstance(places, Reason):
        return CandidateSet((), (places,))
    held, figures, rejected = _held(target, places, tool, most)
    if not held.any():
        return CandidateSet((), tuple(rejected))
    T, figures = places.T_item_tip[held], figures[held]
    kinds, along = _named(target, T)
    off = np.arccos(np.minimum(1.0, along)) + tilt_on(envelope.face, T)
    scores = figures[:, -1] + off / np.pi + np.where(kinds == "side", _cost_of_side(target), 0.0)
    batch = GraspBatch(target.id, envelope.face, tool_state, kinds, T, scores, figures, envelope.name)
    return CandidateSet((batch,), tuple(rejected))


@dataclass(frozen=True, eq=False)
class _Places:
    """Places of the cup on one face.

    Attributes:
        face: Name of the face.
        T_item_tip: (P, 4, 4) tool frames in the item's.
        share: (P,) shares of its limits that the cup bears there.
    """

    face: str
    T_item_tip: Array
    share: Array

    def select(self, chosen: NDArray[np.bool_]) -> _Places:
        """Return some of the places, by a mask (P,)."""
        return _Places(self.face, self.T_item_tip[chosen], self.share[chosen])


def _places(target: GraspTarget, name: str, T_item_tip: Array, tool: Tool) -> _Places | Reason:
    """Return those of places (P, 4, 4) on a face that seal at the largest error; or why none does."""
    item, cup, tips = target.item, tool.cup, T_item_tip[:, :3, 3]
    kept = np.array([kept_vacuum(item, name, tip, cup, target.noise) for tip in tips])
    share = np.array([bearing_share(item, name, tip, cup, target.noise) for tip in tips])
    found = _Places(name, T_item_tip, share).select(kept >= LEAST_SHARE)
    if len(found.share) == 0:
        detail = f"beside its edges the pump keeps {kept.max():.1%} of the vacuum, needs {LEAST_SHARE:.1%}"
        return Reason("does not seal", f"{target.id}, face {name}", detail)
    return found


def _nothing_to_hold(target: GraspTarget, tool: Tool) -> Reason:
    item = target.item
    if not wide_faces(item, tool) and not faces(item, tool):
        detail = (
            f"its radius is {tool.cup.radius * 1e3:.0f} mm, and beside open edges the pump keeps too little"
        )
        return Reason("no face takes the whole cup", target.id, detail)
    if not faces(item, tool):
        return Reason("no face that takes the whole cup seals", target.id, item.seal_source)
    sealing = ", ".join(face.name for face in faces(item, tool))
    if target.place.access.is_from_above:
        most = MAX_LEAN_FROM_ABOVE if tool.state_with_lance(ACROSS) is None else np.pi / 2 + MAX_LEAN_ACROSS
        lean = f"{sealing} lean by over {np.degrees(most):.0f} degrees, or point down"
        return Reason("no face within reach", target.id, lean)
    detail = f"{sealing}: too far from facing the mouth, up or a side, or facing down"
    return Reason("no face within reach", target.id, detail)


def _reachable(face: Face, target: GraspTarget, tool: Tool, rng: np.random.Generator, n: int) -> Array:
    """Return up to n random places (N, 4, 4) on a face for which a level lance clears the mouth's lips."""
    samples = face.region.sample(rng, TRIES_PER_PLACE * n)
    T = target.T_entry_item @ samples
    # A cup across the lance points down or to the side; the lance is above or beside the tip, and may be
    # tilted.
    is_across = T[:, 0, 2] < np.cos(_most_tilt(target))
    gained = T[:, 2, :3] @ _to_lance(tool) + np.sin(tool.cup.tilt) * np.maximum(T[:, 0, 3], 0.0)
    height = T[:, 2, 3] + np.where(is_across, gained, 0.0)
    is_clear = (height >= LANCE_CLEAR) & (T[:, 2, 3] <= target.place.access.height - LANCE_CLEAR)
    return samples[is_clear][:n]


def _most_tilt(target: GraspTarget) -> float:
    """Return how far (rad) a lance in line with the cup may be off the way in."""
    return float(MAX_LEAN_FROM_ABOVE if target.place.access.is_from_above else MAX_FRONTAL_TILT)


def _to_lance(tool: Tool) -> Array:
    """Return (3,) m in the tool frame, from the tip to the axis of a lance that is across the cup's axis."""
    state = tool.state_with_lance(ACROSS)
    return np.zeros(3) if state is None else tool.tip_to_lance(state)


def _placements(
    target: GraspTarget, places: _Places, tool: Tool, search: Search, most: float
) -> tuple[list[GraspBatch], list[Reason]]:
    """Return the grasps at places on one face, and why others have none.

    A place that faces away from every way in is dropped without a reason.
    """
    found: list[GraspBatch] = []
    rejected: list[Reason] = []
    for kind, (mine, off) in _kinds(target, tool, places.T_item_tip).items():
        if mine.any():
            chosen = places.select(mine)
            batch, against = _of_kind(target, kind, chosen, off[mine], tool, search, most)
            found += [] if batch is None else [batch]
            rejected += against
    return found, rejected


def _of_kind(
    target: GraspTarget, kind: str, places: _Places, off: Array, tool: Tool, search: Search, most: float
) -> tuple[GraspBatch | None, list[Reason]]:
    """Return the grasps of one kind at P places, whose axes are off (P,) rad from the ideal."""
    tool_state = tool.state_with_lance(IN_LINE if kind == "frontal" else ACROSS)
    if tool_state is None:
        where = f"{target.id}, face {places.face}"
        return None, [Reason("no state of the tool for this grasp", where, kind)]
    held, figures, rejected = _held(target, places, tool, most)
    if not held.any():
        return None, rejected
    T, costs = _turned_and_tilted(target, kind, places.T_item_tip[held], tool, search)
    if kind == "side":
        costs += _cost_of_side(target)
    scores = figures[held, -1:] + off[held, None] / np.pi + costs
    poses = T.reshape(-1, 4, 4)
    figures = np.repeat(figures[held], T.shape[1], axis=0)
    kinds, _ = _named(target, poses)
    batch = GraspBatch(target.id, places.face, tool_state, kinds, poses, scores.ravel(), figures)
    return batch, rejected


def _cost_of_side(target: GraspTarget) -> float:
    return SIDE + (ROLLING if target.item.can_roll(target.R_level_item) else 0.0)


def _held(
    target: GraspTarget, places: _Places, tool: Tool, most: float
) -> tuple[NDArray[np.bool_], Array, list[Reason]]:
    """Return (P,) where the cup holds the item at rest, the loads (P, 5), and why not elsewhere."""
    at_full, where = HoldLimits(tool.cup.limits), f"{target.id}, face {places.face}"
    loads = [
        replace(load, ratio=load.ratio / share)
        for load, share in zip(
            loads_at_rest(target.item, at_full, places.T_item_tip, target.R_level_item),
            places.share, strict=True,
        )
    ]  # fmt: skip
    rejected = [
        Reason(
            "does not hold", where,
            f"{load} at rest, {load.ratio:.2f} of what the cup bears, {most:g} allowed",
        )
        for load in loads if load.ratio > most
    ]  # fmt: skip
    figures = np.array([(load.moment, load.pull, load.shear, load.twist, load.ratio) for load in loads])
    return figures[:, -1] <= most, figures, rejected


def _named(target: GraspTarget, T_item_tip: Array) -> tuple[NDArray[np.str_], Array]:
    """Return (N,) kinds of grasps (N, 4, 4), by the place's axis nearest to the cup's, and their cosines."""
    x, y, z = target.R_level_item @ T_item_tip[:, :3, 2].T
    along = np.stack([x, -z, np.abs(y)])
    return np.array(["frontal", "top-down", "side"])[np.argmax(along, axis=0)], along.max(axis=0)


def _kinds(target: GraspTarget, tool: Tool, T_item_tip: Array) -> dict[str, tuple[NDArray[np.bool_], Array]]:
    """Return by kind which places (P, 4, 4) of a cup are of it, and rad (P,) off the ideal."""
    along = T_item_tip[:, :3, 2] @ target.T_entry_item[:3, :3].T
    if target.place.access.is_from_above:
        return _kinds_from_above(along, has_across=tool.state_with_lance(ACROSS) is not None)
    return _kinds_from_the_front(along)


def _kinds_from_above(along: Array, has_across: bool) -> dict[str, tuple[NDArray[np.bool_], Array]]:
    """Return by kind which cups with axes (P, 3) in the entry frame are of it, and rad (P,) off the ideal.

    A cup in line with its lance takes faces that lean up to a limit, one across it those that are upright.

    has_across: whether the tool has a state with its lance across the cup's axis
    """
    is_frontal = along[:, 0] >= np.cos(MAX_LEAN_FROM_ABOVE)
    is_side = has_across & (np.abs(along[:, 0]) <= np.sin(MAX_LEAN_ACROSS))
    inwards = np.clip(along[:, 0], -1.0, 1.0)
    return {"frontal": (is_frontal, np.arccos(inwards)), "side": (is_side, np.abs(np.arcsin(inwards)))}


def _kinds_from_the_front(along: Array) -> dict[str, tuple[NDArray[np.bool_], Array]]:
    """Return by kind which cups with axes (P, 3) in the entry frame are of it, and rad (P,) off the ideal."""
    is_frontal = along[:, 0] >= np.cos(MAX_FRONTAL_TILT)
    down, aside = -along[:, 2], np.abs(along[:, 1])
    off = np.arccos(np.minimum(1.0, np.where(is_frontal, along[:, 0], np.maximum(down, aside))))
    is_across = ~is_frontal & (np.maximum(np.abs(along[:, 0]), along[:, 2]) <= np.sin(MAX_ACROSS_TILT))
    is_down = down >= aside
    masks = {"frontal": is_frontal, "top-down": is_across & is_down, "side": is_across & ~is_down}
    return {kind: (mask, off) for kind, mask in masks.items()}


def _turned_and_tilted(
    target: GraspTarget, kind: str, T_item_tip: Array, tool: Tool, search: Search
) -> tuple[Array, Array]:
    """Return every turn and tilt of the tool at places (P, 4, 4): poses (P, M, 4, 4), and costs (P, M)."""
    x_targets, off = _rolls(target, kind, tool, search)
    # The desired directions of x, along the tool's x and y axes.
    wanted = x_targets @ T_item_tip[:, :3, :2]
    T_turned = rolled(T_item_tip[:, None], np.arctan2(wanted[..., 1], wanted[..., 0]))
    tilts = np.zeros((*T_turned.shape[:2], 1 + len(search.tilts)))
    if kind == "top-down":
        tilts[..., 0] = _tilt_over_the_lip(target.T_entry_item @ T_turned, _to_lance(tool), tool.cup.tilt)
    tilts[..., 1:] = tool.cup.tilt * np.array(search.tilts)
    costs = 0.05 + np.abs(tilts) / np.pi
    costs[..., 0] = 0.0
    costs += 0.3 * off[:, None] / np.pi
    n = len(T_item_tip)
    return tilted(T_turned[:, :, None], tilts).reshape(n, -1, 4, 4), costs.reshape(n, -1)


def _rolls(target: GraspTarget, kind: str, tool: Tool, search: Search) -> tuple[Array, Array]:
    """Return directions (R, 3) of the tool's x axis in the item frame, and how many rad (R,) they are off."""
    is_from_above = target.place.access.is_from_above
    is_turnable = is_from_above and tool.state_with_lance(ACROSS) is not None
    rolls = search.rolls(kind, is_from_above, has_quarters=is_turnable)
    x_targets = np.array([roll.x_target for roll in rolls]) @ target.T_entry_item[:3, :3]
    off = np.array([roll.off for roll in rolls])
    if not is_turnable:
        return x_targets, off
    # When the item is laid down, its edges are to be parallel to those of the bin.
    if kind == "frontal":  # the cup turns before
        return np.array([_nearest_axis(x) for x in x_targets]), off
    parallel = _nearest_axis(x_targets[0])
    lean = float(np.arccos(np.clip(parallel @ x_targets[0], -1.0, 1.0)))
    if lean > MAX_LEAN_ACROSS:
        return x_targets, off
    return np.vstack([parallel, x_targets]), np.append(0.0, off)


def _nearest_axis(direction: Array) -> Array:
    """Return the unit vector (3,) along the axis of a frame, either way, nearest to a direction (3,)."""
    axis = int(np.argmax(np.abs(direction)))
    return np.asarray(np.sign(direction[axis]) * np.eye(3)[axis])


def _tilt_over_the_lip(T_entry_tip: Array, to_lance: Array, most: float) -> Array:
    """Return the least tilt in rad at which a level lance over a thin item clears the bin's lip.

    Args:
        T_entry_tip: (..., 4, 4) the tool, its lance across, in the entry frame.
        to_lance: (3,) m in the tool frame, from the tip to the axis of the lance.
        most: rad, the largest tilt.

    Returns:
        (...) rad, 0 if no tilt clears it.
    """
    tilts = most * TILTS
    T = tilted(T_entry_tip[..., None, :, :], tilts)
    on_axis, along = T[..., :3, 3] + T[..., :3, :3] @ to_lance, T[..., :3, 0]
    rise = along[..., 2] / np.maximum(-along[..., 0], 1e-3)  # per m towards the mouth
    is_clear = on_axis[..., 2] + rise * on_axis[..., 0] >= LANCE_CLEAR
    return np.where(is_clear.any(axis=-1), tilts[np.argmax(is_clear, axis=-1)], 0.0)
