"""Choice of the arm for a pick: by what its tool can hold, what it reaches, and the cell's preference."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from pickcli.errors import Reason
from pickcli.grasping.search import USUAL
from pickcli.planning.pick_problem import PickProblem, PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import Scene
from pickcli.seeds import derived_rng

MOST_GRASPS = 24  # best grasps that are tested: enough to find out whether an arm reaches a bin
SEEDS = 16  # of inverse kinematics, for each grasp


@dataclass(frozen=True)
class ArmSuitability:
    """Suitability of an arm for one pick.

    Attributes:
        arm: Name of the arm.
        preference: Preference stated by the cell; the lowest comes first.
        n_grasps: Number of tested grasps by which its tool would hold the item, best first.
        n_reached: Number of these that its tip reaches, obstacles ignored.
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
        """Why the arm cannot pick the item, if it is not able."""
        far = Reason("out of reach", f"arm {self.arm}", f"none of {self.n_grasps} grasps is reached")
        return far if self.against is None else self.against.within(f"arm {self.arm}")

    def __str__(self) -> str:
        """Summarise the suitability in one line."""
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
        preferences: Preference by name of the arm.
        query: The requested pick.
        seed: Seed of all random choices.

    Returns:
        Able arms first, by preference, then by the number of grasps that they reach; then the arms that are
        not able.
    """
    judged = [_judged(scene, preferences[scene.cell.arm], query, seed) for scene in scenes]
    return tuple(sorted(judged, key=lambda arm: (not arm.is_able, arm.preference, -arm.n_reached)))


def _judged(scene: Scene, preference: int, query: PickQuery, seed: int) -> ArmSuitability:
    context, name = PlanningContext(scene.cell), scene.cell.arm
    problem = PickProblem.of(context, scene, query, seed)
    rng = derived_rng(seed, "choice of the arm", name, problem.target.id)
    found = context.method.sample(problem.grasp_target, rng, USUAL, context.settings.load_ratio)
    if not found.grasps:
        return ArmSuitability(name, preference, 0, 0, next(iter(found.rejected), None))
    grasps = found.grasps[:MOST_GRASPS]
    tips = [problem.target.T_world_item @ grasp.T_item_tip for grasp in grasps]
    reached = [
        len(context.arm.solve_spread(T_world_tip, grasp.tool_state, rng, SEEDS)) > 0
        for T_world_tip, grasp in zip(tips, grasps, strict=True)
    ]
    return ArmSuitability(name, preference, len(grasps), sum(reached))
