"""Queries that are answered in turn in one simulated world: each is planned, verified and executed.

Each query is planned for the state of the arm and the scene that the previous query left.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Protocol, TypeAlias

from pickcli.kinematics.continuous_joints import unwound_towards
from pickcli.motion.plan import Plan
from pickcli.planning.destination_choice import plan_into_first
from pickcli.planning.move import MoveGoal, plan_move
from pickcli.planning.pick import plan_pick
from pickcli.planning.pick_problem import PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE, Scene
from pickcli.seeds import derived_seed
from pickcli.verification.verify import certifier, certify

if TYPE_CHECKING:
    from pickcli.simulation.execution import Execution
    from pickcli.simulation.world import World

AT_GOAL = 0.01  # rad or m, per joint, within which the arm counts as at its goal


class QueryStep(Protocol):
    """A motion that is planned and executed as a whole."""

    def plan(self, context: PlanningContext, scene: Scene, start: Start, seed: int) -> Plan | None:
        """Plan the motion of this step and verify it.

        Args:
            context: The cell, its models and its precomputed files.
            scene: The current scene.
            start: State of the arm.
            seed: Seed of all random choices.

        Returns:
            The plan with its certificate; None if there is nothing to do.

        Raises:
            NoPlanError: No motion was found; with the reasons.
            RejectedError: The verifier rejects the only plan.
            InputError: The scene does not meet the requirements of the step.
        """

    def after(self, scene: Scene) -> Scene:
        """Predict the scene after the step.

        Args:
            scene: The scene before, with every item in the place that earlier steps bring it to.

        Returns:
            The scene afterwards, with its items in their new places; their poses are not updated.

        Raises:
            InputError: The item of the step is not there.
        """


@dataclass(frozen=True, eq=False)
class MoveStep:
    """A move of the empty tool.

    Attributes:
        name: Name of the goal.
        goal: The goal.
    """

    name: str
    goal: MoveGoal

    def plan(self, context: PlanningContext, scene: Scene, start: Start, seed: int) -> Plan | None:
        """Plan the move and verify it.

        Args:
            context: The cell, its models and its precomputed files.
            scene: The current scene.
            start: State of the arm.
            seed: Seed of all random choices.

        Returns:
            The plan with its certificate; None if arm and tool are already there.

        Raises:
            NoPlanError: No motion was found; with the reasons.
            RejectedError: The verifier rejects it.
        """
        q = unwound_towards(context.cell.robot.limits, self.goal.q, start.q)
        is_in_state = self.goal.tool_state in (None, start.tool_state)
        if is_in_state and abs(q - start.q).max() <= AT_GOAL:
            return None
        return certify(plan_move(context, scene, start, self.goal, seed, f"move to {self.name}"), scene)

    def after(self, scene: Scene) -> Scene:
        """Return the scene, which a move does not change.

        Args:
            scene: The scene before.

        Returns:
            The same scene.
        """
        return scene


@dataclass(frozen=True)
class PickStep:
    """A pick of one item.

    Attributes:
        query: The requested pick.
    """

    query: PickQuery

    def plan(self, context: PlanningContext, scene: Scene, start: Start, seed: int) -> Plan:
        """Plan the pick; if the verifier rejects a plan, the next candidate is tried.

        Args:
            context: The cell, its models and its precomputed files.
            scene: The current scene.
            start: State of the arm.
            seed: Seed of all random choices.

        Returns:
            The plan with its certificate.

        Raises:
            NoPlanError: No motion was found that the verifier accepts; with the reasons.
        """
        return plan_pick(context, scene, self.query, start, seed, certify=certifier(scene))

    def after(self, scene: Scene) -> Scene:
        """Predict the scene with the item at its destination.

        Args:
            scene: The scene before.

        Returns:
            The scene with the item in its destination.

        Raises:
            UnknownNameError: The item is not in the place that it is taken from.
        """
        placed = scene.find(self.query.item, self.query.out_of)
        return scene.moved(replace(placed, location=self.query.into))


@dataclass(frozen=True)
class StowStep:
    """Stowing of one item from the tote.

    Attributes:
        item: The item's id.
        bins: Names of the bins to try, in this order.
    """

    item: str
    bins: tuple[str, ...]

    def plan(self, context: PlanningContext, scene: Scene, start: Start, seed: int) -> Plan:
        """Plan the stow into the first bin that has a plan which the verifier accepts.

        Args:
            context: The cell, its models and its precomputed files.
            scene: The current scene.
            start: State of the arm.
            seed: Seed of all random choices.

        Returns:
            The plan with its certificate.

        Raises:
            NoPlanError: No bin has a plan that the verifier accepts; with the reasons of each.
        """

        def plan_into(name: str) -> Plan:
            query = PickQuery(TOTE, self.item, name)
            return plan_pick(context, scene, query, start, seed, certify=certifier(scene))

        return plan_into_first(f"stow {self.item}", self.bins, plan_into)

    def after(self, scene: Scene) -> Scene:
        """Predict the scene with the item in the first of the bins.

        Args:
            scene: The scene before.

        Returns:
            The scene with the item in that bin.

        Raises:
            UnknownNameError: The item is not in the tote.
        """
        return scene.moved(replace(scene.find(self.item, TOTE), location=self.bins[0]))


@dataclass(frozen=True)
class MotionQuery:
    """A query as the steps that answer it.

    Attributes:
        label: The query in words, e.g. "pick dove_beauty_bar from bin_C to tote".
        steps: Its steps, in the order of their execution.
    """

    label: str
    steps: tuple[QueryStep, ...]


@dataclass(eq=False)
class QueryAnswer:
    """Answer to a query, as far as it was executed.

    Attributes:
        query: The query.
        plans: Verified plans, in the order of their execution.
        runs: The executions of ``plans``.
        item: Id of the query's item; "" if it has none.
        item_is_in: Place of the item afterwards; "" if the query has none.
        is_complete: Whether all its steps were done.
    """

    query: MotionQuery
    plans: list[Plan] = field(default_factory=list)
    runs: list[Execution] = field(default_factory=list)
    item: str = ""
    item_is_in: str = ""
    is_complete: bool = False

    @property
    def is_clean(self) -> bool:
        """Whether there was a plan for it, and all executed motions went as planned."""
        is_unplanned = not self.is_complete and not self.runs
        return not is_unplanned and all(run.is_clean for run in self.runs)


CarryOut: TypeAlias = Callable[[Plan], "Execution"]


@dataclass(eq=False)
class QuerySequence:
    """Queries that are answered in turn in one world.

    Attributes:
        context: Planning context.
        world: The simulated world.
        seed: Seed of all random choices.
        answers: Answers so far; the last one may be incomplete.
    """

    context: PlanningContext
    world: World
    seed: int = 0
    answers: list[QueryAnswer] = field(default_factory=list)

    def play(self, queries: Sequence[MotionQuery], carry_out: CarryOut) -> None:
        """Answer queries in turn, until one does not go as planned or leaves something in the tool.

        Args:
            queries: The queries.
            carry_out: Executes a verified plan in the world.

        Raises:
            NoPlanError: A query has no plan; with the reasons. Earlier answers are in ``answers``.
            RejectedError: The verifier rejects a move.
            InputError: The item of a query is not where it should be.
        """
        for number, query in enumerate(queries):
            answer = QueryAnswer(query)
            self.answers.append(answer)
            for k, step in enumerate(query.steps):
                self._execute(step, answer, derived_seed(self.seed, "query", str(number), str(k)), carry_out)
                if not all(run.is_clean for run in answer.runs) or self.world.held is not None:
                    return
            answer.is_complete = True

    def _execute(self, step: QueryStep, answer: QueryAnswer, seed: int, carry_out: CarryOut) -> None:
        world = self.world
        scene = world.now()
        plan = step.plan(self.context, scene, Start(world.q, world.tool_state), seed)
        if plan is None:
            return
        answer.plans.append(plan)
        answer.runs.append(carry_out(plan))
        if plan.grasp is not None:
            answer.item = plan.grasp.item
            held = world.held == answer.item
            answer.item_is_in = world.robot.tool.grip.holder if held else world.placed(answer.item).location
