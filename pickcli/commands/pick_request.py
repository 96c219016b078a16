"""A pick requested on the command line, planned with the named arm or the first able one."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pickcli.commands.arm_options import preferences_of, seen_by_others
from pickcli.commands.logs import stage
from pickcli.commands.plan_verification import timed_certifier

if TYPE_CHECKING:
    from pickcli.commands.plan_options import PlanOptions
    from pickcli.motion.plan import Plan
    from pickcli.planning.arm_choice import ArmSuitability
    from pickcli.planning.pick_problem import PickQuery
    from pickcli.scene.scene import Scene


def plan_with_first_able(scene: Scene, query: PickQuery, options: PlanOptions) -> None:
    """Plan with the named arm or the cell's only one, else the first that has a plan, and write the plan.

    Args:
        scene: The scene as the preferred arm sees it.
        query: The requested pick.
        options: The options of the command.

    Raises:
        NoPlanError: No arm has a plan; with the reasons of all of them.
    """
    from pickcli.errors import NoPlanError
    from pickcli.planning.arm_choice import rank_arms

    scenes = {each.cell.arm: each for each in (scene, *seen_by_others(scene, options.arms()))}
    if len(scenes) == 1:
        _plan_with(scene, query, options, ())
        return
    with stage("choice of the arm"):
        ranked = rank_arms(list(scenes.values()), preferences_of(scene.cell), query, options.seed)
    able = [arm.arm for arm in ranked if arm.is_able] or list(scenes)
    failed: dict[str, NoPlanError] = {}
    for arm in able:
        try:
            _plan_with(scenes[arm], query, options, ranked)
            return
        except NoPlanError as error:
            failed[arm] = error
    what = next(iter(failed.values())).query
    raise NoPlanError.of_alternatives(what, [(str(each), failed.get(each.arm)) for each in ranked])


def _plan_with(
    scene: Scene, query: PickQuery, options: PlanOptions, ranked: tuple[ArmSuitability, ...]
) -> None:  # fmt: skip
    from pickcli.errors import NoPlanError
    from pickcli.planning.blockers import with_blockers
    from pickcli.planning.pick import plan_pick

    begin = options.begin(scene)
    with options.session(scene.cell) as session:

        def plan_in(scene: Scene, query: PickQuery) -> Plan:
            certify = None if options.no_verify else timed_certifier(scene)
            return plan_pick(session.context, scene, query, begin, options.seed, session.recorder, certify)

        try:
            plan = plan_in(scene, query)
        except NoPlanError as error:
            raise with_blockers(error, plan_in, scene, query) from None
        options.deliver(plan, scene, is_judged=True, ranked=ranked)
