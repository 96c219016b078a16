"""A pick requested on the command line, planned with the named arm or the first able one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from pickcli.commands.arm_options import ArmRequest, preferences_of, seen_by_others
from pickcli.commands.configuration_option import parse_configuration
from pickcli.commands.experience_session import experience_session
from pickcli.commands.logs import stage
from pickcli.commands.planner import load_planner, timed_certifier

if TYPE_CHECKING:
    from pickcli.motion.plan import Plan
    from pickcli.planning.arm_choice import ArmSuitability
    from pickcli.planning.pick_problem import PickQuery
    from pickcli.scene.scene import Scene

    Write = Callable[[Plan, Scene, tuple[ArmSuitability, ...]], None]


@dataclass(frozen=True)
class PickRequest:
    """A requested pick, independent of the arm.

    Attributes:
        query: The pick.
        start: Start configuration, as written.
        seed: Seed of all random choices.
        roadmap: File of the roadmap, None for that of the cache.
        trajectories: File of the database, None for that of the cache.
        learn: Whether experience is stored.
        is_verified: Whether plans are verified, and the next candidate is tried after a rejection.
    """

    query: PickQuery
    start: str
    seed: int
    roadmap: Path | None
    trajectories: Path | None
    learn: bool
    is_verified: bool


def plan_with_first_able(scene: Scene, arms: ArmRequest, asked: PickRequest, write: Write) -> None:
    """Plan with the named arm or the cell's only one, else with the first of all that finds a plan.

    Args:
        scene: The scene as the preferred arm sees it.
        arms: The arms stated on the command line.
        asked: The requested pick.
        write: Called with the plan, certified if requested, the scene as its arm sees it, and the ranking of
            the arms.

    Raises:
        NoPlanError: No arm has a plan; with the reasons of all of them.
    """
    from pickcli.errors import NoPlanError
    from pickcli.planning.arm_choice import rank_arms

    scenes = {each.cell.arm: each for each in (scene, *seen_by_others(scene, arms))}
    if len(scenes) == 1:
        _plan_with(scene, asked, write, ())
        return
    with stage("choice of the arm"):
        ranked = rank_arms(list(scenes.values()), preferences_of(scene.cell), asked.query, asked.seed)
    able = [arm.arm for arm in ranked if arm.is_able] or list(scenes)
    failed: dict[str, NoPlanError] = {}
    for arm in able:
        try:
            _plan_with(scenes[arm], asked, write, ranked)
            return
        except NoPlanError as error:
            failed[arm] = error
    query = next(iter(failed.values())).query
    raise NoPlanError.of_arms(query, [(str(each), failed.get(each.arm)) for each in ranked])


def _plan_with(scene: Scene, asked: PickRequest, write: Write, ranked: tuple[ArmSuitability, ...]) -> None:
    from pickcli.api.arm_states import refuse_standing
    from pickcli.errors import NoPlanError
    from pickcli.planning.blockers import with_blockers
    from pickcli.planning.pick import plan_pick
    from pickcli.planning.start_state import Start

    q, tool_state = parse_configuration(scene.cell, asked.start)
    with stage("reading of roadmap and trajectories"):
        planner = load_planner(scene.cell, asked.roadmap, asked.trajectories)
    begin = Start(q, tool_state or scene.cell.robot.tool.default_state)
    refuse_standing(scene, begin)
    with experience_session(planner, asked.roadmap, asked.trajectories, asked.learn) as session:

        def plan_in(scene: Scene, query: PickQuery) -> Plan:
            certify = timed_certifier(scene) if asked.is_verified else None
            return plan_pick(session.planner, scene, query, begin, asked.seed, session.recorder, certify)

        try:
            plan = plan_in(scene, asked.query)
        except NoPlanError as error:
            raise with_blockers(error, plan_in, scene, asked.query) from None
        write(plan, scene, ranked)
