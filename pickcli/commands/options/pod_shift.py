"""Options --pod-shift and --tote-shift of the commands that make a scene."""

from __future__ import annotations

from collections.abc import Callable
from math import isfinite, radians
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from pickcli.cell.pod_tolerance import Displacement

F = TypeVar("F", bound=Callable[..., Any])


def pod_shift_option(default: str) -> Callable[[F], F]:
    """Give a command the option --pod-shift X,Y,YAW|random|none.

    Args:
        default: Effect without the option, for the help.

    Returns:
        A decorator that adds the option.
    """
    return click.option(
        "--pod-shift", metavar="X,Y,YAW|random|none", callback=parse_pod_shift,
        help="Displacement of the pod in mm, mm and degrees, or random within the tolerance of the cell.  "
        f"[default: {default}]",
    )  # fmt: skip


def tote_shift_option(default: str) -> Callable[[F], F]:
    """Give a command the option --tote-shift X,Y,YAW|random|none.

    Args:
        default: Effect without the option, for the help.

    Returns:
        A decorator that adds the option.
    """
    return click.option(
        "--tote-shift", metavar="X,Y,YAW|random|none", callback=parse_pod_shift,
        help="Displacement of the tote in mm, mm and degrees, or random, at most 30 mm and 3 degrees.  "
        f"[default: {default}]",
    )  # fmt: skip


def parse_pod_shift(
    ctx: click.Context | None, param: click.Parameter | None, value: str | None
) -> Displacement | str | None:
    """Parse the value of --pod-shift or --tote-shift.

    Args:
        ctx: Context of click.
        param: The option.
        value: Text from the command line.

    Returns:
        A displacement in m and rad, "random", "none", or None if not given.

    Raises:
        BadParameter: The value is invalid.
    """
    from pickcli.cell.pod_tolerance import Displacement
    from pickcli.trial.pod_shift import NONE, RANDOM

    if value is None:
        return None
    if value.lower() in (RANDOM, NONE):
        return value.lower()
    try:
        x, y, yaw = (float(part) for part in value.split(","))
    except ValueError:
        x = y = yaw = float("nan")
    if not (isfinite(x) and isfinite(y) and isfinite(yaw)):
        what = f"{value!r}: expected three numbers in mm, mm and degrees, e.g. 20,-10,1.5, or random, or none"
        raise click.BadParameter(what, ctx, param)
    return Displacement(x / 1000.0, y / 1000.0, radians(yaw))
