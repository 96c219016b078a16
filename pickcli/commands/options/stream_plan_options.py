"""Options of how items of a stream are met: the rule, recorded grasps, and what plans the transit to them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import click

from pickcli.commands.options.common_options import passed_as
from pickcli.commands.options.transit_options import TransitOptions, transit_options
from pickcli.commands.options.trial_options import is_stated

F = TypeVar("F", bound=Callable[..., Any])
OF_STREAMS = {
    "stream_rule": "--stream-rule", "grasps_path": "--grasps", "planner": "--planner",
    "expansions": "--expansions",
}  # fmt: skip


@dataclass(frozen=True)
class StreamPlanOptions(TransitOptions):
    """The options of a trial of how items of a stream are met.

    Attributes:
        stream_rule: Name of the rule by which items are met.
    """

    stream_rule: str


def stream_plan_options(function: F) -> F:
    """Give a command that plays trials the options of how items of a stream are met.

    Args:
        function: The command.

    Returns:
        The command with the options, which are passed to it as ``planned_by``, a ``StreamPlanOptions``.
    """
    return stream_rule_option(transit_options(passed_as("planned_by", StreamPlanOptions)(function)))


def stream_rule_option(function: F) -> F:
    """Give a command the option --stream-rule NAME.

    Args:
        function: The command.

    Returns:
        The command with the option.
    """
    from pickcli.stream_trials.stream_rules import StreamRule

    return click.option(
        "--stream-rule", type=click.Choice([str(each) for each in StreamRule], case_sensitive=False),
        default=str(StreamRule.EARLIEST), show_default=True,
        help="Of a stream: items are met as early as possible, in a trial in the order by which most can be "
             "taken, by arms that move at the same time, or by one after the other; or at one place, by the "
             "arms in turns, recorded grasps past a chase filter and a kinematic filter, as the PR2 did in "
             "2013.",
    )(function)  # fmt: skip


def refuse_stream_rule() -> None:
    """Refuse --stream-rule, before any work, where no stream is planned for.

    Raises:
        UsageError: It was stated.
    """
    _refuse(["stream_rule"])


def refuse_stream_plan() -> None:
    """Refuse options of how items of a stream are met, before any work, where no stream is played.

    Raises:
        UsageError: One of them was stated.
    """
    _refuse([*OF_STREAMS])


def _refuse(names: list[str]) -> None:
    stated = [OF_STREAMS[name] for name in names if is_stated(name)]
    if stated:
        verb, them = ("apply", "them") if len(stated) > 1 else ("applies", "it")
        raise click.UsageError(f"{', '.join(stated)} {verb} to streams, and this is none; leave {them} out")
