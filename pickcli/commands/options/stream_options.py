"""Options --stream and --now of the commands that work on a running conveyor."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.logs import stage
from pickcli.commands.operations.plan_verification import timed_certifier
from pickcli.commands.options.arm_options import ArmRequest, open_alike, open_cell, seen_by_others
from pickcli.commands.options.common_options import passed_as, refuse_output
from pickcli.commands.options.option_types import PATH, FiniteRange
from pickcli.commands.options.scene_options import scene_or_empty
from pickcli.commands.options.trial_options import is_stated
from pickcli.errors import InputError

if TYPE_CHECKING:
    from pickcli.commands.options.plan_options import PlanOptions
    from pickcli.errors import NoPlanError
    from pickcli.motion.plan import Plan
    from pickcli.planning.belt_picks.grasp_filtering import FilteredContext
    from pickcli.scene.item_stream import ItemStream
    from pickcli.scene.scene import Scene

SAME_TIME = 1e-9  # s

F = TypeVar("F", bound=Callable[..., Any])


@dataclass(frozen=True)
class StreamOptions:
    """A stream at a time, as stated on the command line.

    Attributes:
        stream_path: File of the stream; None if a scene is meant.
        now: s, time of the stream; None if not stated.
    """

    stream_path: Path | None
    now: float | None

    def refuse_scene(self, scene_path: Path | None) -> None:
        """Refuse a time without a stream, and a scene beside one.

        Args:
            scene_path: File of the scene, if one is named.

        Raises:
            UsageError: The options contradict each other.
        """
        if self.stream_path is None and self.now is not None:
            raise click.UsageError("--now is the time of a stream; name one with --stream, or leave it out")
        if self.stream_path is not None and scene_path is not None:
            raise click.UsageError("name a scene with --scene or a stream with --stream, not both")

    def stream(self, cell_name: str | None, arms: ArmRequest) -> ItemStream:
        """Read the stream.

        Args:
            cell_name: Name or folder of the cell; None for the one that the stream names.
            arms: The arms stated on the command line; without any, the cell is that of the preferred arm.

        Returns:
            The stream.

        Raises:
            InputError: The file or the cell cannot be read.
            StaleError: It was made for another cell.
        """
        from pickcli.scene.stream_file import read_stream

        assert self.stream_path is not None
        with stage("reading of the stream"):
            opened = open_cell if arms.is_of_plan or arms.configurations else open_alike
            cell = None if cell_name is None else opened(cell_name, arms)
            return read_stream(self.stream_path, cell, partial(opened, request=arms))

    def surroundings(
        self, plan: Plan, scene_path: Path | None, cell_name: str | None, arms: ArmRequest
    ) -> Scene:
        """Return the scene in which a plan begins: of the stream, of a scene, or of an empty cell.

        Args:
            plan: The plan.
            scene_path: File of a scene, if one is named.
            cell_name: Name or folder of the cell; None for the one that scene or stream names.
            arms: The arms stated on the command line.

        Returns:
            The scene.

        Raises:
            UsageError: Nothing is named.
            InputError: A file or the cell cannot be read; or no stream is named, and the plan is for a
                running conveyor.
            StaleError: They are not those of the plan.
        """
        if self.stream_path is not None:
            return self.scene_of(plan, cell_name, arms)
        if plan.tracking is not None:
            raise InputError(
                f"the plan is for the running {plan.tracking.conveyor}; name the stream with --stream"
            )
        return scene_or_empty(scene_path, cell_name, arms)

    def scene_of(self, plan: Plan, cell_name: str | None, arms: ArmRequest) -> Scene:
        """Read the stream that a plan was made for, and return what is on the belt when the plan starts.

        Args:
            plan: The plan.
            cell_name: Name or folder of the cell; None for the one that the stream names.
            arms: The arms stated on the command line.

        Returns:
            The scene.

        Raises:
            InputError: The file or the cell cannot be read.
            StaleError: It was made for another cell, its belt runs otherwise than that of the plan, or the
                time is not that of the plan.
        """
        from pickcli.errors import StaleError

        stream, tracking = self.stream(cell_name, arms), plan.tracking
        starts = 0.0 if tracking is None else tracking.t_stream
        runs = f"{stream.conveyor} runs at {stream.speed:g} m/s within {stream.speed_error:g}"
        if tracking is None and stream.speed > 0.0:
            fault = f"the plan ({plan.query}) takes nothing from a belt that runs"
            raise StaleError(
                f"{self.stream_path}: {runs}, but {fault}; name its own scene with --scene, or its own stream"
            )
        if tracking is not None:
            is_same = (tracking.conveyor, tracking.speed) == (stream.conveyor, stream.speed)
            if not is_same or tracking.speed_error < stream.speed_error:
                planned = f"{tracking.conveyor} at {tracking.speed:g} m/s within {tracking.speed_error:g}"
                fault = f"but the belt of the plan is {planned}"
                raise StaleError(f"{self.stream_path}: {runs}, {fault}; plan it again")
        if tracking is not None and self.now is not None and abs(self.now - starts) > SAME_TIME:
            fault = f"--now {self.now:g}: the plan starts at {starts:g} s of its stream"
            raise StaleError(f"{fault}; leave --now out, or plan it again")
        if plan.grasp is not None and plan.grasp.item in {riding.id for riding in stream.items}:
            stream = stream.presenting(plan.grasp.item)
        return stream.scene_at(starts if self.now is None else self.now)


def stream_options(function: F) -> F:
    """Give a command the options --stream FILE and --now T, passed as ``request``.

    Args:
        function: The command.

    Returns:
        The command with the options.
    """
    function = passed_as("request", StreamOptions)(function)
    function = click.option(
        "--now", type=FiniteRange(0.0, 1e6), metavar="T",
        help="Time of the stream in s at which the plan starts.  [default: that of the plan; of a new one 0]",
    )(function)  # fmt: skip
    return click.option(
        "--stream", "stream_path", type=PATH, metavar="FILE",
        help="Instead of a scene: items that ride on a conveyor (see apc make-stream).",
    )(function)  # fmt: skip


def plan_from_stream(
    request: StreamOptions, item: str | None, into: str | None, stream_rule: str, options: PlanOptions
) -> None:
    """Plan the pick of an item that rides on a conveyor, and write the plan.

    Of several arms, if none is named, the one does it whose plan ends first; by the rules of 2013 the first
    one that has a plan.

    Args:
        request: The stream and its time.
        item: Id of the item; None if not stated.
        into: Destination; None for the tote.
        stream_rule: Name of the rule by which the item is met.
        options: The options of the command.

    Raises:
        UsageError: No item is named.
        InputError: An option has no meaning for the belt as it runs.
        NoPlanError: The item cannot be met, with every reason.
    """
    from pickcli.commands.options.stated_pick import destination
    from pickcli.errors import NoPlanError, UnknownNameError
    from pickcli.planning.belt_picks.belt_query import InterceptQuery
    from pickcli.planning.belt_picks.intercept import plan_intercept
    from pickcli.stream_trials.stream_rules import StreamRule

    if item is None:
        raise click.UsageError("name the item by its id in the stream, with --item")
    read = request.stream_path, options.cell_name, options.items_path, options.roadmap, options.trajectories
    refuse_output(options.output, options.overwrite, *read)
    stream, now = request.stream(options.cell_name, options.arms()), request.now or 0.0
    if item not in (ids := [riding.id for riding in stream.items]):
        raise UnknownNameError("item", item, ids, str(request.stream_path))
    if into == stream.conveyor and stream.speed > 0.0:
        raise InputError(f"--into {into}: it runs, and nothing is set down on it; name another place")
    if stream.speed > 0.0 and is_stated("drop_from"):
        raise InputError("--drop-from: off a running belt items are dropped from over the rim; leave it out")
    stream = stream.presenting(item)
    scene = stream.scene_at(now)
    rule = StreamRule(stream_rule)
    query = InterceptQuery(item, now, destination(scene, into, stream.conveyor))
    plans: list[tuple[Plan, Scene, FilteredContext]] = []
    failed: list[tuple[str, NoPlanError]] = []
    for seen in (scene, *seen_by_others(scene, options.arms())):
        riding, start = replace(stream, cell=seen.cell), options.begin(seen)
        with options.session(seen.cell) as session:
            certify = None if options.no_verify else timed_certifier(seen)
            met = replace(query, meet_at=rule.meeting_place(session.context, riding.carrier))
            filtered = rule.filtered(session.context, riding, met, options.seed)
            try:
                plan = plan_intercept(filtered.context, riding, met, start, options.seed, certify)
            except NoPlanError as error:
                failed.append((f"arm {seen.cell.arm}", filtered.explained(error)))
            else:
                plans.append((plan, seen, filtered))
                if rule is StreamRule.PR2_2013:
                    break
    if not plans and len(failed) == 1:
        raise failed[0][1]
    if not plans:
        raise NoPlanError.of_alternatives(failed[0][1].query, failed)
    first, seen, filtered = min(plans, key=lambda planned: planned[0].trajectory.duration)
    options.deliver(first, seen, is_judged=True, removed=filtered.removed)
