"""Option --operator-stop: when the operator stops the robot, and when it goes on."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from pickcli.simulation.operator_stop import OperatorStop

F = TypeVar("F", bound=Callable[..., Any])
LONGEST = 3600.0  # s


def operator_stop_option(function: F) -> F:
    """Give a command the option --operator-stop FROM:UNTIL, which may be repeated.

    Args:
        function: The command.

    Returns:
        The command with the option, which is passed as ``operator_stops``.
    """
    return click.option(
        "--operator-stop", "operator_stops", metavar="FROM:UNTIL", multiple=True, callback=parse_stops,
        help="The operator stops the robot FROM seconds after the start, and resumes the motion at UNTIL; "
        "may be repeated.",
    )(function)  # fmt: skip


def parse_stops(
    ctx: click.Context | None, param: click.Parameter | None, values: tuple[str, ...]
) -> tuple[OperatorStop, ...]:
    """Parse the values of --operator-stop.

    Args:
        ctx: Context of click.
        param: The option.
        values: Texts from the command line.

    Returns:
        The stops.

    Raises:
        BadParameter: A value is not two times in seconds, the second after the first.
    """
    from pickcli.simulation.operator_stop import OperatorStop

    stops = []
    for value in values:
        try:
            begin, end = (float(part) for part in value.split(":"))
        except ValueError:
            begin = end = float("nan")
        if not (isfinite(begin) and 0.0 <= begin < end <= LONGEST):
            what = f"{value!r}: expected two times in s, 0 to {LONGEST:g}, the earlier one first, e.g. 2.5:4"
            raise click.BadParameter(what, ctx, param)
        stops.append(OperatorStop(begin, end))
    return tuple(stops)
