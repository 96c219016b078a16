"""Queries on the command line of ``apc execute``: --pick, --stow and --move, repeatable, in the given order.

A further kind of query is an entry of ``KINDS``, which converts its text to a ``MotionQuery``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.options.configuration_option import named_state, parse_configuration, parse_start
from pickcli.commands.options.stated_pick import destination, example, refuse_impossible
from pickcli.commands.options.stated_stow import bins_for, item_in_tote, stated_bin
from pickcli.errors import InputError, UnknownNameError

if TYPE_CHECKING:
    from pickcli.api.query_sequence import MotionQuery, QueryAnswer
    from pickcli.planning.start_state import Start
    from pickcli.scene.scene import Scene
    from pickcli.simulation.world import World

F = TypeVar("F", bound=Callable[..., Any])


def query_options(function: F) -> F:
    """Give a command the options --pick, --stow and --move, which may be repeated and mixed.

    Args:
        function: The command.

    Returns:
        The command with the options.
    """
    function = click.option(
        "--move", "moves", metavar="FROM:TO[:STATE]", multiple=True,
        help="Query instead of PLAN: move between two configurations, with the tool to end in STATE; may be "
        "repeated.",
    )(function)  # fmt: skip
    function = click.option(
        "--stow", "stows", metavar="ITEM[:BIN]", multiple=True,
        help="Query instead of PLAN: stow an item from the tote into a bin; may be repeated.",
    )(function)  # fmt: skip
    return click.option(
        "--pick", "picks", metavar="PLACE:ITEM[:TO]", multiple=True,
        help="Query instead of PLAN: pick an item (its name, or its id in the scene) from a place, and bring "
        "it to the tote or to TO; may be repeated.",
    )(function)  # fmt: skip


def queries_of(given: Sequence[tuple[str, str]], scene: Scene) -> list[MotionQuery]:
    """Parse the queries of a command line.

    Args:
        given: Pairs of "picks", "stows" or "moves" and the text, in the given order.
        scene: The scene before the first query.

    Returns:
        The queries.

    Raises:
        UsageError: A query has a wrong form.
        InputError: A name is unknown, or the query is impossible in the scene.
    """
    queries: list[MotionQuery] = []
    brought: dict[str, str] = {}  # by an item's id or name, what brings it where
    for kind, words in given:
        option = f"--{kind[:-1]} {words}"
        try:
            queries.append(KINDS[kind](words, scene))
        except UnknownNameError as error:
            if error.kind != "item" or error.name not in brought:
                raise
            raise InputError(f"{option}: {brought[error.name]}; name that place, or leave it out") from None
        except InputError:
            if kind != "stows" or (item := words.partition(":")[0]) not in brought:
                raise
            raise InputError(f"{option}: {brought[item]}, not in the tote; leave this query out") from None
        before = {placed.id: placed.location for placed in scene.items}
        for step in queries[-1].steps:
            scene = step.after(scene)
        for placed in scene.items:
            if placed.location != before[placed.id]:
                whereabouts = f"after {option} {placed.id} is in {placed.location}"
                brought |= dict.fromkeys((placed.id, placed.item.name), whereabouts)
    return queries


def _pick(words: str, scene: Scene) -> MotionQuery:
    from pickcli.api.query_sequence import MotionQuery, PickStep
    from pickcli.planning.pick_problem import PickQuery

    parts = words.split(":")
    if not 2 <= len(parts) <= 3 or not all(parts):
        raise click.UsageError(f"--pick: expected PLACE:ITEM or PLACE:ITEM:TO, got {words!r}{example(scene)}")
    scene.cell.require_places("a pick")
    out_of, item = parts[:2]
    into = destination(scene, parts[2] if len(parts) == 3 else None, out_of, "as in --pick PLACE:ITEM:TO")
    option = f"--pick {words}"
    query = PickQuery(out_of, item, into=into)
    refuse_impossible(scene, query, out_of_option=option, into_option=option)
    label = f"pick {item} from {out_of} to {into}"
    # By its id, because an item of the same name may be brought there before.
    return MotionQuery(label, (PickStep(replace(query, item=scene.find(item, out_of).id)),))


def _stow(words: str, scene: Scene) -> MotionQuery:
    from pickcli.api.query_sequence import MotionQuery, StowStep

    parts = words.split(":")
    if len(parts) > 2 or not all(parts):
        raise click.UsageError(
            f"--stow: expected ITEM or ITEM:BIN, got {words!r}; e.g. dove_beauty_bar:bin_H"
        )
    scene.cell.require_pod_and_tote("a stow")
    placed = item_in_tote(scene, parts[0], f"--stow {words}")
    if len(parts) == 1:
        return MotionQuery(f"stow {parts[0]}", (StowStep(placed.id, bins_for(scene, placed)),))
    name = stated_bin(scene, placed, parts[1], f"--stow {words}")
    return MotionQuery(f"stow {parts[0]} into {name}", (StowStep(placed.id, (name,)),))


def _move(words: str, scene: Scene) -> MotionQuery:
    from pickcli.api.query_sequence import MotionQuery, MoveStep
    from pickcli.planning.move import MoveGoal

    parts = words.split(":")
    if not 2 <= len(parts) <= 3 or not all(parts):
        known = ":".join(list(scene.cell.configurations)[:2])
        raise click.UsageError(f"--move: expected FROM:TO or FROM:TO:STATE, got {words!r}; e.g. {known}")
    q_start, q_goal = (parse_configuration(scene.cell, name)[0] for name in parts[:2])
    state = named_state(scene.cell, parts[2]) if len(parts) == 3 else None
    steps = (MoveStep(parts[0], MoveGoal(q_start)), MoveStep(parts[1], MoveGoal(q_goal, state)))
    ending = "" if state is None else f" with the tool {state}"
    return MotionQuery(f"move from {parts[0]} to {parts[1]}{ending}", steps)


KINDS: dict[str, Callable[[str, Scene], MotionQuery]] = {"picks": _pick, "stows": _stow, "moves": _move}


def configurations_in(given: Sequence[tuple[str, str]]) -> tuple[str, ...]:
    """Return the configurations that queries name; they select the arm if a cell has several.

    Args:
        given: Pairs of "picks", "stows" or "moves" and the text.

    Returns:
        Names, or numbers with commas.
    """
    return tuple(name for kind, words in given if kind == "moves" for name in words.split(":")[:2] if name)


def start_of_queries(given: Sequence[tuple[str, str]], scene: Scene, start: str | None) -> Start:
    """Return the state of the robot before the first query.

    Args:
        given: Pairs of "picks", "stows" or "moves" and the text.
        scene: The scene.
        start: Configuration from the command line; None for the start of the first move, else home.

    Returns:
        Configuration and tool state.

    Raises:
        InputError: The cell has no such configuration.
    """
    kind, words = given[0]
    return parse_start(scene.cell, start or (words.partition(":")[0] if kind == "moves" else "home"))


def answers_summary(
    queries: Sequence[MotionQuery], answers: Sequence[QueryAnswer], world: World
) -> dict[str, Any]:
    """Summarise executed queries as JSON values.

    Args:
        queries: All queries.
        answers: Answers to the queries that were executed.
        world: The world afterwards.

    Returns:
        Values by name.
    """
    from pickcli.commands.output.execution_report import disturbed_items, run_record, runs_counts

    runs = [run for answer in answers for run in answer.runs]
    return {
        **runs_counts(runs),
        "disturbed": disturbed_items([plan for answer in answers for plan in answer.plans], world),
        "held": world.held,
        "queries": [
            {
                "query": answer.query.label,
                "is_complete": answer.is_complete,
                "is_clean": answer.is_clean,
                "item": answer.item or None,
                "item_is_in": answer.item_is_in or None,
                "motions": [
                    {
                        "plan": plan.query,
                        "planning_ms": plan.statistics.get("planning_ms"),
                        **run_record(run),
                    }
                    for plan, run in zip(answer.plans, answer.runs, strict=False)
                ],
            }
            for answer in answers
        ],
        "not_started": [query.label for query in queries[len(answers) :]],
    }


def answers_text(queries: Sequence[MotionQuery], answers: Sequence[QueryAnswer], world: World) -> str:
    """Summarise executed queries in a few lines.

    Args:
        queries: All queries.
        answers: Answers to the queries that were executed.
        world: The world afterwards.

    Returns:
        The text.
    """
    from pickcli.commands.output.execution_report import disturbance_lines, run_lines, whereabouts_line

    lines = []
    for answer in answers:
        if not answer.plans and (answer.is_complete or len(queries) > 1):
            why = "the arm is there already" if answer.is_complete else "no plan"
            lines.append(f"{answer.query.label}: {why}, nothing is executed")
        for plan, run in zip(answer.plans, answer.runs, strict=False):
            lines += run_lines(plan, run, world)
        if answer.item:
            lines.append(whereabouts_line(answer.item, answer.item_is_in, world))
    lines += [f"{query.label}: not started" for query in queries[len(answers) :]]
    plans = [plan for answer in answers for plan in answer.plans]
    return "\n".join([*lines, *disturbance_lines(plans, world)])
