"""A pick requested on the command line, planned with the named arm or the first able one."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import TYPE_CHECKING

from pickcli.commands.logs import stage
from pickcli.commands.operations.plan_verification import timed_certifier
from pickcli.commands.options.arm_options import preferences_of, seen_by_others

if TYPE_CHECKING:
    from pickcli.commands.options.plan_options import PlanOptions
    from pickcli.motion.plan import Plan
    from pickcli.planning.arm_choice import ArmSuitability
    from pickcli.planning.blockers import PlanIn
    from pickcli.planning.pick_problem import PickQuery
    from pickcli.scene.scene import Scene


def plan_requested(scene: Scene, queries: Sequence[PickQuery], options: PlanOptions, label: str = "") -> None:
    """Plan into the first destination, and with the first able arm, that have a plan; write the plan.

    Args:
        scene: The scene as the preferred arm sees it.
        queries: The requested pick, by its destination, in the order in which they are tried.
        options: The options of the command.
        label: Name of a request with several destinations.

    Raises:
        NoPlanError: No destination and no arm has a plan; with all reasons, and the blockers if there are
            items without which there is a plan.
    """
    from pickcli.errors import NoPlanError
    from pickcli.planning.blockers import with_blockers
    from pickcli.planning.destination_choice import plan_into_first

    into = {query.into: query for query in queries}
    with ExitStack() as sessions:
        arms = _Arms(scene, options, sessions)
        try:
            plan, ranked = plan_into_first(label, list(into), lambda name: arms.planned(scene, into[name]))
        except NoPlanError as error:
            raise with_blockers(error, lambda *asked: arms.planned(*asked)[0], scene, queries) from None
        options.deliver(plan, arms.sees(scene, plan.arm), is_judged=True, ranked=ranked)


class _Arms:
    """The arms that may carry out a request: the named one or the cell's only one, else all.

    Args:
        scene: The scene as the preferred arm sees it.
        options: The options of the command.
        sessions: Closes the sessions that the arms plan in, which are opened when they are needed.
    """

    def __init__(self, scene: Scene, options: PlanOptions, sessions: ExitStack) -> None:
        seen = (scene, *seen_by_others(scene, options.arms()))
        self._cells = {each.cell.arm: each.cell for each in seen}
        self._options, self._sessions = options, sessions
        self._planners: dict[str, PlanIn] = {}

    def sees(self, scene: Scene, arm: str) -> Scene:
        """Return a scene as an arm sees it."""
        return replace(scene, cell=self._cells[arm])

    def planned(self, scene: Scene, query: PickQuery) -> tuple[Plan, tuple[ArmSuitability, ...]]:
        """Return the plan by the first able arm that has one, and the ranking if there are several.

        Raises NoPlanError with the reasons of all arms.
        """
        from pickcli.errors import NoPlanError
        from pickcli.planning.arm_choice import rank_arms

        if len(self._cells) == 1:
            return self._planned_with(scene.cell.arm, scene, query), ()
        with stage("choice of the arm"):
            scenes = [self.sees(scene, arm) for arm in self._cells]
            ranked = rank_arms(scenes, preferences_of(scene.cell), query, self._options.seed)
        failed: dict[str, NoPlanError] = {}
        for arm in [arm.arm for arm in ranked if arm.is_able] or list(self._cells):
            try:
                return self._planned_with(arm, self.sees(scene, arm), query), ranked
            except NoPlanError as error:
                failed[arm] = error
        what = next(iter(failed.values())).query
        raise NoPlanError.of_alternatives(what, [(str(each), failed.get(each.arm)) for each in ranked])

    def _planned_with(self, arm: str, scene: Scene, query: PickQuery) -> Plan:
        if arm not in self._planners:
            self._planners[arm] = self._planner(scene)
        return self._planners[arm](scene, query)

    def _planner(self, scene: Scene) -> PlanIn:
        """Return the planning function of the arm that sees a scene."""
        from pickcli.planning.pick import plan_pick

        options, begin = self._options, self._options.begin(scene)
        session = self._sessions.enter_context(options.session(scene.cell))

        def plan_in(scene: Scene, query: PickQuery) -> Plan:
            certify = None if options.no_verify else timed_certifier(scene)
            return plan_pick(session.context, scene, query, begin, options.seed, session.recorder, certify)

        return plan_in
