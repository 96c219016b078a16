"""Which arm picks an item: by what its tool holds, by what it reaches, and by the preference of the cell."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pickcli.errors import Reason
from pickcli.grasping.grasp_target import GraspTarget
from pickcli.grasping.search import USUAL
from pickcli.planning.pick_problem import PickProblem, PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import Scene
from pickcli.seeds import derived_rng

MOST_GRASPS = 24  # the best ones that are asked about: enough to tell an arm that reaches a bin from another
SEEDS = 16  # of inverse kinematics, for each of them


@dataclass(frozen=True)
class ArmSuitability:
    """What speaks for and against an arm for one pick.

    Attributes:
        arm: Name of the arm.
        preference: Of the cell: the least goes first.
        n_grasps: Grasps by which its tool would hold the item, the best of them at most.
        n_reached: How many of these its tip reaches, whatever is in the way.
        against: Why its tool would not hold the item; None if it would.
    """

    arm: str
    preference: int
    n_grasps: int
    n_reached: int
    against: Reason | None = None

    @property
    def is_able(self) -> bool:
        """Whether the arm reaches a grasp that would hold."""
        return self.n_reached > 0

    @property
    def reason(self) -> Reason:
        """Why the arm cannot do it, where it is not able."""
        far = Reason("out of reach", f"arm {self.arm}", f"none of {self.n_grasps} grasps is reached")
        return far if self.against is None else self.against.within(f"arm {self.arm}")

    def __str__(self) -> str:
        """One line for people."""
        if self.against is not None:
            return f"arm {self.arm}: cannot hold it: {self.against}"
        reach = f"{self.n_reached or 'none'} of {self.n_grasps} grasps"
        return f"arm {self.arm}: reaches {reach}, preference {self.preference}"


def rank_arms(
    scenes: Sequence[Scene], preferences: Mapping[str, int], query: PickQuery, seed: int = 0
) -> tuple[ArmSuitability, ...]:
    """Rank the arms of a cell for a pick.

    Args:
        scenes: The scene as each arm sees it.
        preferences: By name of the arm.
        query: The pick that is asked for.
        seed: Seed of all random choices.

    Returns:
        Those that are able first, the preferred one before the others, and of two that are preferred alike
        the one that reaches more; then those that are not.
    """
    judged = [_judged(scene, preferences[scene.cell.arm], query, seed) for scene in scenes]
    return tuple(sorted(judged, key=lambda arm: (not arm.is_able, arm.preference, -arm.n_reached)))


def _judged(scene: Scene, preference: int, query: PickQuery, seed: int) -> ArmSuitability:
    context, name = PlanningContext(scene.cell), scene.cell.arm
    problem = PickProblem.of(context, scene, query, seed)
    rng = derived_rng(seed, "choice of the arm", name, problem.target.id)
    wanted = GraspTarget(problem.target.id, problem.target.item, problem.T_entry_item, problem.place)
    found = context.method.sample(wanted, rng, USUAL, context.settings.load_ratio)
    if not found.grasps:
        return ArmSuitability(name, preference, 0, 0, next(iter(found.rejected), None))
    grasps = found.grasps[:MOST_GRASPS]
    tips = [problem.target.T_world_item @ grasp.T_item_tip for grasp in grasps]
    reached = [
        len(context.arm.solve_spread(T_world_tip, grasp.tool_state, rng, SEEDS)) > 0
        for T_world_tip, grasp in zip(tips, grasps, strict=True)
    ]
    return ArmSuitability(name, preference, len(grasps), sum(reached))
