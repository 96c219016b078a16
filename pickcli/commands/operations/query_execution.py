"""Queries of ``apc execute``: planned and executed in one simulated world, and their answers printed."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import emit_json
from pickcli.commands.logs import stage
from pickcli.commands.operations.plan_execution import simulated
from pickcli.commands.options.motion_queries import (
    answers_summary,
    answers_text,
    queries_of,
    start_of_queries,
)
from pickcli.commands.output.progress_bar import progress
from pickcli.simulation.installed_drivers import SIMULATED

if TYPE_CHECKING:
    from pickcli.api.query_sequence import MotionQuery, QuerySequence
    from pickcli.planning.planning_context import PlanningContext
    from pickcli.scene.scene import Scene
    from pickcli.simulation.reality import Reality


@dataclass(frozen=True)
class QueryRequest:
    """Queries, and the options of their execution.

    Attributes:
        given: Option and text of each query, in their order.
        start: Where the arm begins; None for the start of the first query.
        reality: Levels of the world's deviations from its model.
        video: File of the animation; None for none.
        overwrite: Whether an existing one is replaced.
        seed: Seed of all random choices.
        as_json: Whether the answers are printed as JSON.
    """

    given: list[tuple[str, str]]
    start: str | None
    reality: Reality
    video: Path | None
    overwrite: bool
    seed: int
    as_json: bool


def answer_queries(request: QueryRequest, scene: Scene, load: Callable[[], PlanningContext]) -> None:
    """Execute queries in one simulated world and print the results, also if a query fails.

    Args:
        request: The queries and their options.
        scene: The true scene.
        load: Reads the files that the queries are planned with.

    Raises:
        TrialAbortedError: After a collision, a broken limit, a missed event or a protective stop.
        NoPlanError: A query has no plan; with the reasons.
        InputError: A query is impossible in the scene.
    """
    import numpy as np

    from pickcli.api.arm_states import refuse_standing
    from pickcli.api.query_sequence import QuerySequence
    from pickcli.commands.output.execution_report import trouble
    from pickcli.errors import TrialAbortedError
    from pickcli.simulation.camera import GifRecorder
    from pickcli.simulation.camera_view import view_of_motion
    from pickcli.simulation.world import World

    queries = queries_of(request.given, scene)
    begin = start_of_queries(request.given, scene, request.start)
    refuse_standing(scene, begin)
    with stage("reading of roadmap and trajectories"):
        context = load()
    film = None
    if request.video is not None:
        Q = np.array([named.q for named in scene.cell.configurations.values()])
        film = GifRecorder.named(request.video, view_of_motion(scene.cell, Q))
    world = World(scene, begin.q, begin.tool_state, reality=request.reality, seed=request.seed)
    sequence = QuerySequence(context, world, request.seed)
    with closing(world):
        try:
            with stage("simulation"), progress("executing") as report:
                carry_out = simulated(world, film)
                sequence.play(queries, lambda plan: carry_out(plan, report))
        finally:
            _print_answers(request, queries, sequence)
        if film is not None and request.video is not None:
            film.write(request.video, request.overwrite)
            click.echo(f"  wrote {request.video}", err=request.as_json)
    if why := trouble([run for answer in sequence.answers for run in answer.runs]):
        raise TrialAbortedError(why)


def _print_answers(request: QueryRequest, queries: list[MotionQuery], sequence: QuerySequence) -> None:
    """Print the results of queries; nothing if the only one failed before any motion."""
    answers, world = sequence.answers, sequence.world
    if request.as_json:
        emit_json({"driver": SIMULATED, **answers_summary(queries, answers, world)})
    elif text := answers_text(queries, answers, world):
        click.echo(text)
