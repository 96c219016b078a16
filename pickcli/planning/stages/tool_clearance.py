"""What the tool alone could do for one grasp: ways to the item, and ways out that leave the lance room.

Asked before any inverse kinematics, of the tool as it flies through the bin by itself: most grasps that fail
do so here, for a hundredth of what following a line with the arm costs.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray

from pickcli.cartesian.corridor import LiftPoses
from pickcli.cartesian.key_waypoints import CONTACT_DISTANCE, PickPoses, pick_poses
from pickcli.cell.tool import ToolState
from pickcli.collision.allowed_contacts import AllowedContacts
from pickcli.collision.free_flyer import FreeToolChecker
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, inverse
from pickcli.grasping.cup_press import outward_of, overtravel
from pickcli.grasping.holding import Hold
from pickcli.motion.plan import Grasp
from pickcli.planning.pick_problem import PickProblem
from pickcli.planning.stages.extraction import CorridorSet

# m along y and z of the bin, by which the pre-approach begins off the straight way; the least first.
SIDEWAYS, UPWARDS = (0.0, 0.04, -0.04, 0.08, -0.08), (0.0, 0.03, -0.03, 0.06)
ASIDE = sorted(product(SIDEWAYS, UPWARDS), key=lambda yz: float(np.hypot(*yz)))
STRAIGHT_IN = (0.0, 0.0)
N_WAYS = 2  # that the arm tries to follow
N_EXPLAINED = 32  # of the grasps without room, about, from the best to the last
LONGEST_TOUCH = 0.054  # m of the tool's way on the first stretch of the lift; 0.055 are promised
LIFTED = 1  # where the pushes of a way out have the end of the lift


def with_room(
    problem: PickProblem, grasps: Sequence[Grasp], ways: CorridorSet
) -> tuple[list[Grasp], Failures]:
    """The grasps with room for the tool at the target and where it has been lifted; why others have none."""
    T = problem.target.T_world_item @ np.array([g.T_item_tip for g in grasps]).reshape(-1, 4, 4)
    has_room = np.zeros(len(grasps), dtype=bool)
    kinds = [(g.tool_state, g.face) for g in grasps]
    for kind in dict.fromkeys(kinds):
        mine = np.flatnonzero([k == kind for k in kinds])
        mine = mine[_are_valid(_meeting(problem, *kind), T[mine])]
        has_room[mine] = _can_be_lifted(problem, kind[0], T[mine], ways)
    without = np.flatnonzero(~has_room)
    explained = without[:: 1 + len(without) // N_EXPLAINED]
    failures = Failures(tuple(_why_no_room(problem, grasps[i], T[i], ways) for i in explained))
    return [g for g, has in zip(grasps, has_room, strict=True) if has], failures


def _can_be_lifted(
    problem: PickProblem, tool_state: ToolState, T: Array, ways: CorridorSet
) -> NDArray[np.bool_]:
    """(N,) whether a tool that holds the target at T (N, 4, 4) has room at the end of any lift."""
    lifted = np.stack([pushed[LIFTED] for pushed in problem.extraction.pushes(ways)]) @ T[:, None]
    is_free = _are_valid(_carrying(problem, tool_state), lifted.reshape(-1, 4, 4))
    return np.asarray(is_free.reshape(lifted.shape[:2]).any(axis=1))


def _why_no_room(problem: PickProblem, grasp: Grasp, T: Array, ways: CorridorSet) -> Reason:
    where = f"{grasp.kind} grasp on face {grasp.face}"
    tool = _meeting(problem, grasp.tool_state, grasp.face)
    if not _are_valid(tool, T[None])[0]:
        return _blocked(problem, tool, T, f"{where}, contact")
    lifted = problem.extraction.pushes(ways)[0][LIFTED] @ T
    return _blocked(problem, _carrying(problem, grasp.tool_state), lifted, f"{where}, lift")


def tool_ways_in(problem: PickProblem, grasp: Grasp) -> tuple[PickPoses, ...] | Reason:
    """Ways to the contact that the tool alone can go, the plainest first; or what is in its way."""
    pressed = overtravel(grasp, problem.context.cell.robot.tool, problem.scene.noise)
    empty = _tool(problem, grasp.tool_state, problem.contacts.while_approaching())
    meeting = _meeting(problem, grasp.tool_state, grasp.face)
    usual, shortest = problem.context.settings.approach_offset, pressed + CONTACT_DISTANCE
    plain = _poses(problem, grasp, usual, pressed, STRAIGHT_IN)
    if not _is_valid_path(meeting, plain.contact, plain.touch):
        return _blocked(problem, meeting, plain.contact, "contact")
    found: list[PickPoses] = []
    for offset in (usual, shortest):
        poses = _poses(problem, grasp, offset, pressed, STRAIGHT_IN)
        if not _is_valid_path(empty, poses.touch, poses.approach):
            continue
        for aside in ASIDE:
            poses = _poses(problem, grasp, offset, pressed, aside)
            if _is_valid_path(empty, poses.approach, poses.preapproach):
                found.append(poses)
            if len(found) == N_WAYS:
                return tuple(found)
    return tuple(found) or _blocked(problem, empty, plain.approach, "approach")


def tool_ways_out(
    problem: PickProblem, grasp: Grasp, contact: Array, ways: CorridorSet
) -> tuple[LiftPoses, ...] | Reason:
    """Ways out on which the tool keeps clear of everything and holds the target; or what is in their way."""
    tool = _carrying(problem, grasp.tool_state)
    found = [pushed @ contact for pushed in problem.extraction.pushes(ways)]
    # A push that turns the item moves the tool farther than the item's middle.
    found = [poses for poses in found if np.linalg.norm((poses[0] - contact)[:3, 3]) <= LONGEST_TOUCH]
    if not found:
        return Reason("touches too long", "lift", "the tool swings out too far where the item turns")
    free = [poses for poses in found if _are_valid(tool, poses).all() and _is_valid_path(tool, *poses)]
    if not free:
        return _blocked(problem, tool, found[0][LIFTED], "lift")
    held = [poses for poses in free if _holds(problem, grasp, poses)]
    if not held:
        return Reason("does not hold", "lift", "turned over on every way out")
    return tuple(LiftPoses.of(poses) for poses in held)


def _holds(problem: PickProblem, grasp: Grasp, poses: Array) -> bool:
    """Whether the cup holds the target at rest in every pose (K, 4, 4) of a way out."""
    tool, most = problem.context.cell.robot.tool, problem.context.settings.load_ratio
    hold = Hold.of(problem.target.item, grasp.face, inverse(grasp.T_item_tip), tool)
    return hold.at_rest(poses[:, :3, :3]).ratio <= most


def _tool(problem: PickProblem, tool_state: ToolState, contacts: AllowedContacts) -> FreeToolChecker:
    axes = problem.T_world_bin[:3, :3]
    return problem.context.checkers.tool(problem.scene, tool_state, axes, contacts)


def _meeting(problem: PickProblem, tool_state: ToolState, face: str) -> FreeToolChecker:
    outward = outward_of(face, problem.target.T_world_item[:3, :3])
    return _tool(problem, tool_state, problem.contacts.tool_while_pressing(outward))


def _carrying(problem: PickProblem, tool_state: ToolState) -> FreeToolChecker:
    return _tool(problem, tool_state, problem.contacts.while_carrying())


def _are_valid(tool: FreeToolChecker, T: Array) -> NDArray[np.bool_]:
    """(N,) whether the tool has room at poses (N, 4, 4)."""
    return tool.are_valid(tool.displacements(T))


def _is_valid_path(tool: FreeToolChecker, *poses: Array) -> bool:
    """Whether the tool has room on the straight ways from pose to pose (4, 4)."""
    return tool.is_valid_path(tool.displacements(np.stack(poses)))


def _poses(
    problem: PickProblem, grasp: Grasp, offset: float, pressed: float, aside: tuple[float, float]
) -> PickPoses:
    return pick_poses(
        problem.T_world_bin, problem.target.T_world_item, grasp.T_item_tip, offset, pressed, aside
    )


def _blocked(problem: PickProblem, tool: FreeToolChecker, T: Array, where: str) -> Reason:
    contact = tool.clearance(tool.displacements(T[None])[0])
    detail = f"{contact}, {1e3 * (tool.margin - contact.distance):.0f} mm too close"
    in_the_way = contact.item if contact.item != problem.target.id else ""
    return Reason("no room for the tool", where, detail, in_the_way)
