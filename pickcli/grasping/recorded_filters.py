"""The two filters of the PR2 system of 2013 over recorded grasps (IV-A): chase and kinematics.

The chase filter throws away what comes to a moving item against its motion; what is left is tested by inverse
kinematics of pregrasp and grasp. All pregrasps that pass both are one goal set for the planner.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.cell.tool import ToolState
from pickcli.errors import InputError, Reason
from pickcli.geometry import Array
from pickcli.grasping.recorded_grasp import RecordedGrasp
from pickcli.kinematics.arm import Arm
from pickcli.seeds import derived_rng

CHASE_ANGLE = float(np.radians(30.0))  # the paper's
N_SEEDS = 16  # of inverse kinematics of one grasp


CHASE, KINEMATIC = "chase filter", "kinematic filter"


@dataclass(frozen=True, eq=False)
class ReachedGrasp:
    """A recorded grasp at an item, and how the arm reaches it.

    Attributes:
        grasp: The grasp.
        q_pregrasp: (n,) configuration at the pregrasp.
        q_grasp: (n,) at the grasp, on the same branch of inverse kinematics.
    """

    grasp: RecordedGrasp
    q_pregrasp: Array
    q_grasp: Array


@dataclass(frozen=True)
class RemovedGrasp:
    """A recorded grasp that a filter removed.

    Attributes:
        number: That of the grasp among all that were recorded, from 1.
        source: Where the grasp is from, in words; empty if that is not stated.
        by: The filter, ``CHASE`` or ``KINEMATIC``.
        why: What it has against the grasp.
    """

    number: int
    source: str
    by: str
    why: str

    @property
    def reason(self) -> Reason:
        """Why there is no plan with the grasp."""
        source = f" ({self.source})" if self.source else ""
        return Reason(self.by, f"recorded grasp {self.number}{source}", self.why)

    def __str__(self) -> str:
        return str(self.reason)


@dataclass(frozen=True, eq=False)
class FilteredGrasps:
    """The recorded grasps of an item after both filters.

    Attributes:
        kept: Those that pass both, in their order.
        removed: The others, in their order.
    """

    kept: tuple[RecordedGrasp, ...]
    removed: tuple[RemovedGrasp, ...]


def filter_grasps(
    recorded: Sequence[RecordedGrasp],
    item: tuple[str, int],
    T_world_item: Array,
    velocity: Array,
    arm: Arm,
    seed: int = 0,
) -> FilteredGrasps:
    """Filter the recorded grasps of an item: by its velocity if it moves, then by kinematics.

    Args:
        recorded: Grasps of any items; removed ones have the number that they have here, from 1.
        item: Name and year of the item.
        T_world_item: (4, 4) its pose.
        velocity: (3,) m/s of it in the world; 0 where it rests, and nothing is to be chased.
        arm: The arm.
        seed: Seed of inverse kinematics.

    Returns:
        The grasps of the item that pass, and why the others do not.
    """
    mine = [(k, grasp) for k, grasp in enumerate(recorded, 1) if (grasp.item, grasp.year) == item]
    removed: dict[int, RemovedGrasp] = {}
    if np.any(velocity):
        for k, grasp in mine:
            if not chase_filter([grasp], T_world_item, velocity):
                removed[k] = RemovedGrasp(k, grasp.source, CHASE, _why_chasing(grasp, T_world_item, velocity))
    for k, grasp in mine:
        if k not in removed and not kinematic_filter([grasp], T_world_item, arm, seed):
            why = _why_unreached(grasp, T_world_item, arm, seed)
            removed[k] = RemovedGrasp(k, grasp.source, KINEMATIC, why)
    kept = tuple(grasp for k, grasp in mine if k not in removed)
    return FilteredGrasps(kept, tuple(removed[k] for k in sorted(removed)))


def chase_cosine(grasp: RecordedGrasp, T_world_item: Array, velocity: Array) -> float:
    """Compute the cosine between an item's velocity and the way back from the grasp to the pregrasp.

    Args:
        grasp: The grasp.
        T_world_item: (4, 4) pose of the item.
        velocity: (3,) m/s of the item in the world, not 0.

    Returns:
        The paper's c: -1 where the tool runs after the item, 1 where it comes straight against it.

    Raises:
        InputError: The velocity is 0 or not finite.
    """
    speed = float(np.linalg.norm(velocity))
    if not 0.0 < speed < np.inf:
        raise InputError("chase filter: the item has no velocity; on a belt that stands leave it out")
    back = T_world_item[:3, :3] @ (grasp.T_item_pregrasp[:3, 3] - grasp.T_item_grasp[:3, 3])
    return float(velocity @ back / (speed * np.linalg.norm(back)))


def chase_filter(
    grasps: Sequence[RecordedGrasp], T_world_item: Array, velocity: Array, angle: float = CHASE_ANGLE
) -> tuple[RecordedGrasp, ...]:
    """Keep grasps whose tool does not run after the item.

    Rejected is what moves from pregrasp to grasp within an angle of the item's velocity: there the relative
    speed is small, and the meeting late.

    Args:
        grasps: The grasps.
        T_world_item: (4, 4) pose of the item.
        velocity: (3,) m/s of the item in the world, not 0.
        angle: rad.

    Returns:
        Those that are kept, in their order.

    Raises:
        InputError: The velocity is 0 or not finite.
    """
    least = -float(np.cos(angle))
    return tuple(grasp for grasp in grasps if chase_cosine(grasp, T_world_item, velocity) >= least)


def kinematic_filter(
    grasps: Sequence[RecordedGrasp], T_world_item: Array, arm: Arm, seed: int = 0
) -> tuple[ReachedGrasp, ...]:
    """Keep grasps whose pregrasp and grasp the arm reaches, by every posture that is found.

    Args:
        grasps: The grasps; those of another tool are left out.
        T_world_item: (4, 4) pose of the item.
        arm: The arm.
        seed: Seed of inverse kinematics.

    Returns:
        The grasps with the configurations, in their order; one grasp may be reached in several postures. What
        is found of a grasp does not depend on the others.
    """
    states = {state.name: state for state in arm.robot.tool.states}
    return tuple(
        reached
        for grasp in grasps
        if grasp.tool_state in states
        for reached in _postures(grasp, T_world_item, arm, states[grasp.tool_state], seed)
    )


def _why_chasing(grasp: RecordedGrasp, T_world_item: Array, velocity: Array) -> str:
    cosine = chase_cosine(grasp, T_world_item, velocity)
    off, within = np.degrees([np.arccos(np.clip(-cosine, -1.0, 1.0)), CHASE_ANGLE])
    return f"it runs after the item, {off:.0f} degrees from its velocity, over {within:.0f} is asked for"


def _why_unreached(grasp: RecordedGrasp, T_world_item: Array, arm: Arm, seed: int) -> str:
    state = next((each for each in arm.robot.tool.states if each.name == grasp.tool_state), None)
    if state is None:
        return f"the tool has no state {grasp.tool_state}"
    if len(_at_grasp(grasp, T_world_item, arm, state, seed)) == 0:
        return "the arm does not reach its grasp"
    return "the arm does not reach its pregrasp in a posture in which it reaches its grasp"


def _at_grasp(grasp: RecordedGrasp, T_world_item: Array, arm: Arm, state: ToolState, seed: int) -> Array:
    """Return configurations at a grasp, from the same draws for every grasp and whenever it is asked."""
    rng = derived_rng(seed, "recorded")
    return arm.solve_spread(T_world_item @ grasp.T_item_grasp, state, rng, N_SEEDS)


def _postures(
    grasp: RecordedGrasp, T_world_item: Array, arm: Arm, state: ToolState, seed: int
) -> Iterator[ReachedGrasp]:
    for q in _at_grasp(grasp, T_world_item, arm, state, seed):
        before = arm.solve_near(T_world_item @ grasp.T_item_pregrasp, state, q)
        if before is not None:
            yield ReachedGrasp(grasp, before, q)
