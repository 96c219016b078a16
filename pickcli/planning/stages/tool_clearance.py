"""Planning for the tool without the arm: ways to the item, and ways out with clearance for the lance.

It is done before any inverse kinematics, for the tool as a free flyer: most infeasible grasps fail here, for
a hundredth of the cost of following a line with the arm.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import islice, product

import numpy as np
from numpy.typing import NDArray

from pickcli.cartesian.corridor import LiftPoses
from pickcli.cartesian.key_waypoints import CONTACT_DISTANCE, PickPoses, pick_poses
from pickcli.cartesian.line import shifted
from pickcli.cell.tool import ToolState
from pickcli.collision.free_flyer import FreeToolChecker
from pickcli.collision.motion_segment import Mode
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, inverse
from pickcli.grasping.grasp_target import CandidateSet
from pickcli.grasping.holding import Laden
from pickcli.motion.plan import Grasp
from pickcli.planning.pick_motion import ToolLines
from pickcli.planning.pick_problem import PickProblem

# m along y and z of the entry, offsets of the pre-approach's start from the straight way; the least first.
OFFSETS_Y, OFFSETS_Z = (0.0, 0.04, -0.04, 0.08, -0.08), (0.0, 0.03, -0.03, 0.06)
PREAPPROACH_OFFSETS = sorted(product(OFFSETS_Y, OFFSETS_Z), key=lambda yz: float(np.hypot(*yz)))
N_WAYS = 2  # that the arm tries to follow
N_EXPLAINED = 32  # about, of the grasps without clearance, from the best to the last
TOOL_SWING = 0.001  # m that the tool may move farther than the item's centre in the first stretch of the lift
LEAST_APPROACH = 0.005  # m along the tool's axis, at least
LIFTED = 1  # index of the end of the lift in the poses of a way out


def with_tool_clearance(
    problem: PickProblem, candidates: CandidateSet, ways_out: Sequence[Array]
) -> tuple[tuple[Grasp, ...], Failures]:
    """Find the grasps with clearance for the tool in front of the target, at it, and after the lift.

    Args:
        problem: The pick.
        candidates: Grasps of the target.
        ways_out: Displacements (K, 4, 4) of each way out for the target as a free flyer, at least one.

    Returns:
        The grasps with clearance, best first, and why some of the others have none.
    """
    are_clear = [
        _have_clearance(problem, batch.face, batch.tool_state, batch.T_item_tip, ways_out)
        for batch in candidates.batches
    ]

    def why_not() -> Iterator[Reason]:
        without = candidates.select([~is_clear for is_clear in are_clear]).grasps
        for grasp in without[:: 1 + len(without) // N_EXPLAINED]:
            yield from _why_not_clear(problem, grasp, ways_out)

    return candidates.select(are_clear).grasps, Failures((why_not,))


def with_room_beside(
    problem: PickProblem, grasps: Sequence[Grasp], by: Array
) -> tuple[tuple[Grasp, ...], Failures]:
    """Find the grasps whose approach keeps clear of the target to its end although the target is displaced.

    That is necessary for a motion on a belt that may be off its plan, whose proof asks it all along.

    Args:
        problem: The pick.
        grasps: Grasps of the target.
        by: (3,) m in the world, by which the target may be displaced, or against it.

    Returns:
        The grasps with room, and why the others have none.
    """
    roomy, failures = list[Grasp](), Failures()
    for grasp in grasps:
        tool = _approaching(problem, grasp.face, grasp.tool_state)
        contact = problem.target.T_world_item @ grasp.T_item_tip
        T = np.repeat(_touch(problem, grasp.face, grasp.T_item_tip[None], contact[None]), 2, axis=0)
        T[:, :3, 3] += np.stack([by, -by])
        are_clear = tool.are_valid_at(T)
        if are_clear.all():
            roomy.append(grasp)
        else:
            failures += _blocked(problem, tool, T[~are_clear][:1], f"{grasp}, with the belt off the plan")
    return tuple(roomy), failures


def room_for_tool(
    problem: PickProblem, face: str, tool_state: ToolState, ways_out: Sequence[Array]
) -> Callable[[Array], NDArray[np.bool_]]:
    """Make the check of poses that tells whether the tool has clearance as ``with_tool_clearance`` asks it.

    Args:
        problem: The pick.
        face: The name of the face under the cup, or of the pinched faces.
        tool_state: State of the tool that the target is grasped with.
        ways_out: Displacements (K, 4, 4) of each way out for the target as a free flyer, at least one.

    Returns:
        Tells (N,) for poses (N, 4, 4) of the tool in the world at the grasp whether it has clearance.
    """
    T_item_world = inverse(problem.target.T_world_item)
    return lambda T: _have_clearance(problem, face, tool_state, T_item_world @ T, ways_out)


def _have_clearance(
    problem: PickProblem, face: str, tool_state: ToolState, T_item_tip: Array, ways_out: Sequence[Array]
) -> NDArray[np.bool_]:
    """Return (N,) whether the tool has clearance for grasps (N, 4, 4) of a face in one tool state."""
    T, left = problem.target.T_world_item @ T_item_tip, np.arange(len(T_item_tip))
    for tool in _at_target(problem, face, tool_state):
        left = left[tool.are_valid_at(T[left])]
    before = _touch(problem, face, T_item_tip[left], T[left])
    left = left[_approaching(problem, face, tool_state).are_valid_at(before)]
    is_clear = np.zeros(len(T), dtype=bool)
    is_clear[left] = _can_be_lifted(_carrying(problem, face, tool_state), T[left], ways_out)
    return is_clear


def _can_be_lifted(tool: FreeToolChecker, T: Array, ways_out: Sequence[Array]) -> NDArray[np.bool_]:
    """Return (N,) whether the tool with the target at T (N, 4, 4) has clearance at the end of any lift."""
    lifted = np.stack([transforms[LIFTED] for transforms in ways_out]) @ T[:, None]
    is_free = tool.are_valid_at(lifted.reshape(-1, 4, 4))
    return np.asarray(is_free.reshape(lifted.shape[:2]).any(axis=1))


def _why_not_clear(problem: PickProblem, grasp: Grasp, ways_out: Sequence[Array]) -> Failures:
    where, T = str(grasp), problem.target.T_world_item @ grasp.T_item_tip
    for tool in _at_target(problem, grasp.face, grasp.tool_state):
        if not tool.are_valid_at(T[None])[0]:
            return _blocked(problem, tool, T[None], f"{where}, contact")
    empty = _approaching(problem, grasp.face, grasp.tool_state)
    touch = _touch(problem, grasp.face, grasp.T_item_tip[None], T[None])
    if not empty.are_valid_at(touch)[0]:
        return _blocked(problem, empty, touch, f"{where}, approach")
    lifted = ways_out[0][LIFTED] @ T
    return _blocked(problem, _carrying(problem, grasp.face, grasp.tool_state), lifted[None], f"{where}, lift")


def tool_lines(problem: PickProblem, grasp: Grasp, ways_out: Sequence[Array]) -> ToolLines | Failures:
    """Find the tool's ways in and out for one grasp.

    Args:
        problem: The pick.
        grasp: Grasp of the target.
        ways_out: Displacements (K, 4, 4) of each way out for the target as a free flyer, at least one.

    Returns:
        Ways in and out, or the obstacles.
    """
    inward = _ways_in(problem, grasp)
    if isinstance(inward, Failures):
        return inward.within(str(grasp))
    outward = _ways_out(problem, grasp, inward[0].contact, ways_out)
    if isinstance(outward, Failures):
        return outward.within(str(grasp))
    modes = problem.context.method.modes(problem.contacts, grasp, problem.context.model.tip_excess)
    return ToolLines(grasp, modes, inward, outward)


def _ways_in(problem: PickProblem, grasp: Grasp) -> tuple[PickPoses, ...] | Failures:
    """Find ways to the contact, the simplest first."""
    empty, slow = _approaching(problem, grasp.face, grasp.tool_state), _slow_distance(problem)
    overtravel = float(_overtravel(problem, grasp.face, grasp.T_item_tip[None])[0])
    hollow = problem.target.item.hollow_at(grasp.face)
    usual = problem.settings.approach_offset + (0.0 if hollow is None else hollow.depth)  # from over its rim
    shortest = max(overtravel + slow, LEAST_APPROACH)

    def poses_of(offset: float) -> PickPoses:
        T_world_item = problem.target.T_world_item
        return pick_poses(problem.T_world_entry, T_world_item, grasp.T_item_tip, offset, overtravel, slow)

    plain = poses_of(usual)
    for tool in _at_target(problem, grasp.face, grasp.tool_state):
        if not _is_valid_path(tool, plain.contact, plain.touch):
            return _blocked(problem, tool, np.stack([plain.contact, plain.touch]), "contact")
    found: list[PickPoses] = []
    for poses in (plain, poses_of(shortest)):
        found += islice(_with_preapproaches(problem, empty, poses), N_WAYS - len(found))
        if len(found) == N_WAYS:
            break
    way_in = np.stack([plain.touch, plain.approach, plain.preapproach])
    return tuple(found) or _blocked(problem, empty, way_in, "approach")


def _with_preapproaches(
    problem: PickProblem, empty: FreeToolChecker, poses: PickPoses
) -> Iterator[PickPoses]:
    """Yield the poses with each start of the pre-approach from which the empty tool can come to the touch."""
    starts = np.repeat(poses.preapproach[None], len(PREAPPROACH_OFFSETS), axis=0)
    starts[:, :3, 3] += np.array(PREAPPROACH_OFFSETS) @ problem.T_world_entry[:3, 1:3].T
    D = empty.displacements(np.concatenate([np.stack([poses.touch, poses.approach]), starts]))
    if not empty.is_valid_path(D[:2]):
        return
    # Most starts are blocked themselves: all are checked at once in less time than one way from there.
    for i in np.flatnonzero(empty.are_valid(D[2:])).tolist():
        if empty.is_valid_path(D[[1, 2 + i]]):
            yield replace(poses, preapproach=starts[i])


def _ways_out(
    problem: PickProblem, grasp: Grasp, contact: Array, ways_out: Sequence[Array]
) -> tuple[LiftPoses, ...] | Failures:
    """Find ways out on which the tool keeps clear of everything and holds the target."""
    tool = _carrying(problem, grasp.face, grasp.tool_state)
    # A line that turns the item moves the tool farther than the item's centre; the verifier measures that.
    longest = problem.settings.first_stretch + TOOL_SWING
    freed = np.stack([transforms[0] for transforms in ways_out]) @ contact
    is_short = np.linalg.norm(freed[:, :3, 3] - contact[:3, 3], axis=1) <= longest
    found = [ways_out[k] @ contact for k in np.flatnonzero(is_short).tolist()]
    if not found:
        what = "the tool swings out too far where the item turns"
        return Failures.of(Reason("touches too long", "lift", what))
    roomy = [poses for poses, is_clear in zip(found, _all_valid(tool, found), strict=True) if is_clear]
    free = [poses for poses in roomy if _is_valid_path(tool, *poses)]
    if not free:
        return _blocked(problem, tool, found[0], "lift")
    held = _held(problem, grasp, free)
    if not held:
        on_it = problem.mass_on_target
        why = f"with {on_it:.2f} kg on it" if on_it > 0.0 else "turned over on every way out"
        return Failures.of(Reason("does not hold", "lift", why))
    return tuple(LiftPoses.of(poses) for poses in held)


def _held(problem: PickProblem, grasp: Grasp, ways: Sequence[Array]) -> list[Array]:
    """Return the ways (K, 4, 4) of the tool on which it holds the target at rest, with what lies on it."""
    T_tip_item, item = inverse(grasp.T_item_tip), problem.target.item
    hold, on_it = problem.hold(grasp.face, T_tip_item), problem.mass_on_target
    laden = Laden.of(item, T_tip_item, on_it) if on_it > 0.0 else None
    ratios = hold.ratios_at_rest(np.concatenate(ways)[:, :3, :3], laden)
    worst = np.maximum.reduceat(ratios, _starts(ways))
    most = problem.settings.load_ratio
    return [poses for poses, ratio in zip(ways, worst.tolist(), strict=True) if ratio <= most]


def _slow_distance(problem: PickProblem) -> float:
    """Return the length in m of the slow motion before the tool can meet the target."""
    return 0.0 if problem.context.method.closes_at_rest else CONTACT_DISTANCE


def _overtravel(problem: PickProblem, face: str, T_item_tip: Array) -> Array:
    """Return (N,) m that the tool travels beyond a face for poses (N, 4, 4)."""
    noise = problem.scene.noise_of(problem.target)
    return problem.context.method.overtravel(face, T_item_tip, noise)


def _touch(problem: PickProblem, face: str, T_item_tip: Array, T_world_tip: Array) -> Array:
    """Return (N, 4, 4) the poses at the start of the slow motion to grasps (N, 4, 4) on a face."""
    usual, slow = problem.settings.approach_offset, _slow_distance(problem)
    before = np.minimum(usual, _overtravel(problem, face, T_item_tip) + slow)
    return shifted(T_world_tip, -before[:, None] * T_world_tip[:, :3, 2])


def _approaching(problem: PickProblem, face: str, tool_state: ToolState) -> FreeToolChecker:
    return problem.tool_checker(Mode(tool_state, contacts=problem.contacts.while_approaching(face)))


def _at_target(problem: PickProblem, face: str, tool_state: ToolState) -> tuple[FreeToolChecker, ...]:
    """Return the checkers of the tool at the target."""
    modes = problem.context.method.at_target(problem.contacts, face, tool_state)
    return tuple(problem.tool_checker(mode) for mode in modes)


def _carrying(problem: PickProblem, face: str, tool_state: ToolState) -> FreeToolChecker:
    return problem.tool_checker(problem.context.method.carrying(problem.contacts, face, tool_state))


def _all_valid(tool: FreeToolChecker, ways: Sequence[Array]) -> NDArray[np.bool_]:
    """Return (W,) whether the tool has clearance at all poses (K, 4, 4) of each of W ways."""
    return np.asarray(np.logical_and.reduceat(tool.are_valid_at(np.concatenate(ways)), _starts(ways)))


def _starts(ways: Sequence[Array]) -> NDArray[np.intp]:
    """Return (W,) indices of the first poses of W ways (K, 4, 4) in their concatenation."""
    return np.cumsum([0, *(len(poses) for poses in ways[:-1])])


def _is_valid_path(tool: FreeToolChecker, *poses: Array) -> bool:
    """Whether the tool has clearance on the straight ways from pose to pose (4, 4)."""
    return tool.is_valid_path(tool.displacements(np.stack(poses)))


def _blocked(problem: PickProblem, tool: FreeToolChecker, poses: Array, where: str) -> Failures:
    """Explain what blocks the tool at a pose (1, 4, 4), or on the straight ways between N; lazily."""

    def blocking() -> Iterator[Reason]:
        D = tool.displacements(poses)
        why = tool.explain_path(D) if len(D) > 1 else tool.explain(D[0])
        in_the_way = why.in_the_way if why.in_the_way != problem.target.id else ""
        yield Reason("no room for the tool", where, why.detail, in_the_way)

    return Failures((blocking,))
