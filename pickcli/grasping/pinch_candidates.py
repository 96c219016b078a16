"""Grasp candidates of a gripper for one item in one place: pinches that open wide enough and hold at rest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeAlias

import numpy as np

from pickcli.cell.tool import Tool, ToolState
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.grasping.antipodal import Pinch, flattened, limits_of, pinches, width_of
from pickcli.grasping.envelope import Envelope
from pickcli.grasping.grasp_target import CandidateSet, GraspBatch, GraspTarget
from pickcli.grasping.holding import GripLoad, HoldLimits, loads_at_rest
from pickcli.grasping.search import Search
from pickcli.scene.scene import PoseNoise

STATE_COST = 0.05  # for each later state: the first, usual one is tried first
TURN_COST = 0.3  # for a half turn of the hand
WIDTH_ROUNDING = 1e-9  # m
SAME_POSE = 1e-6  # m or difference of cosines by which a flattened pose may be outside of its envelope

_Scored: TypeAlias = tuple[Array, float, GripLoad]  # pose (4, 4) of the tool, score, load at rest


def sample_pinches(
    target: GraspTarget,
    tool: Tool,
    gripper: ParallelGripper,
    rng: np.random.Generator,
    search: Search,
    most: float,
) -> CandidateSet:
    """Sample candidates for an item with a known pose, each in every state of the tool that is wider than it.

    The clearance of the open fingers beside the item, and whether they can close, is checked later with the
    collision model.

    Args:
        target: The item to be grasped.
        tool: The tool.
        gripper: The fingers of the tool.
        rng: Source of the random places.
        search: How many places and turns are tried.
        most: Largest share of what the pads bear that the item at rest may take up.

    Returns:
        Candidates, and why others were dropped.
    """
    item, widest = target.item, max(tool.positions.values())
    way_in = target.way_in
    found: dict[tuple[str, ToolState], list[_Scored]] = {}
    rejected: dict[str, Reason] = {}
    for pinch in pinches(item.shape, gripper.pad, way_in, search.fan, search.grid, rng, search.n_random):
        load = _load(target, gripper, pinch, widest, most)
        if isinstance(load, Reason):
            rejected.setdefault(pinch.face, load)
            continue
        for state, cost in _states(tool, pinch):
            score = load.ratio + cost + _turn_cost(pinch, way_in)
            found.setdefault((pinch.face, state), []).append((pinch.T_item_tip, score, load))
    if not found and not rejected:
        detail = "no two opposite places across the way in take the pads"
        rejected[""] = Reason("nothing to pinch", target.id, detail)
    batches = (_batch(target, face, state, scored) for (face, state), scored in found.items())
    return CandidateSet(tuple(batches), tuple(rejected.values()))


def pinches_in(
    target: GraspTarget,
    tool: Tool,
    gripper: ParallelGripper,
    envelope: Envelope,
    tool_state: ToolState,
    T_item_tip: Array,
    most: float,
) -> CandidateSet:
    """Make candidates of poses of the fingers in an envelope, the pads turned and moved flat onto the item.

    Args:
        target: The item to be grasped.
        tool: The tool.
        gripper: The fingers of the tool.
        envelope: One of the item's envelopes, or a part of one.
        tool_state: State in which the fingers pass the item.
        T_item_tip: (N, 4, 4) poses of the tool in the envelope, up to rounding.
        most: Largest share of what the pads bear that the item at rest may take up.

    Returns:
        Those that are in the envelope and hold, and why others were dropped.
    """
    face, shape, way_in = envelope.face, target.item.shape, target.way_in
    scored: list[_Scored] = []
    rejected: dict[str, Reason] = {}
    for T in (flattened(face, T) for T in envelope.clipped(T_item_tip)):
        pinch = Pinch(face, T, width_of(shape, face))
        load = _load(target, gripper, pinch, tool.positions[tool_state], most)
        if isinstance(load, Reason):
            rejected.setdefault(load.what, load)
        elif envelope.contains(T[None], SAME_POSE)[0]:
            cost = dict(_states(tool, pinch))[tool_state] + _turn_cost(pinch, way_in)
            scored.append((T, load.ratio + cost, load))
    batches = (_batch(target, face, tool_state, scored, envelope.name),) if scored else ()
    return CandidateSet(batches, tuple(rejected.values()))


def _load(
    target: GraspTarget, gripper: ParallelGripper, pinch: Pinch, widest: float, most: float
) -> GripLoad | Reason:
    """Return the load of a pinch at rest; or why fingers that open by ``widest`` (m) do not hold the item."""
    item, where = target.item, f"{target.id}, face {pinch.face}"
    if pinch.width >= widest:
        wide = f"{1e3 * pinch.width:.0f} mm, the fingers open {1e3 * widest:.0f} mm"
        return Reason("too wide for the gripper", where, wide)
    limits = limits_of(gripper, item.shape, pinch.face, pinch.T_item_tip, target.noise)
    if limits is None:
        return Reason("pads beside the item", where, _astray(target.noise))
    load = loads_at_rest(item, HoldLimits(limits), pinch.T_item_tip[None], target.R_level_item)[0]
    if load.ratio > most:
        detail = f"{load} at rest, {load.ratio:.2f} of what the pads bear"
        return Reason("does not hold", where, detail)
    return load


def _astray(noise: PoseNoise) -> str:
    off = f"{1e3 * noise.position:.1f} mm and {np.degrees(noise.angle):.1f} degrees"
    return f"where its pose may be off by {off}; see it more exactly"


def _batch(
    target: GraspTarget, face: str, tool_state: ToolState, scored: Sequence[_Scored], envelope: str = ""
) -> GraspBatch:
    poses, scores, loads = zip(*scored, strict=True)
    kind = "top-down" if target.place.access.is_from_above else "frontal"
    figures = np.array([(load.moment, load.pull, load.shear, load.twist, load.ratio) for load in loads])
    of_each = np.full(len(scored), kind), np.array(poses), np.array(scores), figures
    return GraspBatch(target.id, face, tool_state, *of_each, envelope)


def _states(tool: Tool, pinch: Pinch) -> Iterator[tuple[ToolState, float]]:
    """Yield the states in which the fingers pass the item, and their costs."""
    for k, (state, width) in enumerate(tool.positions.items()):
        if width > pinch.width + WIDTH_ROUNDING:
            yield state, STATE_COST * k


def _turn_cost(pinch: Pinch, way_in: Array) -> float:
    """Return the cost of a hand that does not come straight along the way in."""
    return TURN_COST * float(np.arccos(np.clip(pinch.T_item_tip[:3, 2] @ way_in, -1.0, 1.0))) / np.pi
