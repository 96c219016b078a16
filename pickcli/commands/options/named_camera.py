"""A camera of a cell by its name on the command line, and where the arm is as it looks."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.options.configuration_option import CONFIGURATION, CONFIGURATION_HELP
from pickcli.commands.options.option_types import PATH
from pickcli.perception.textures.sift_views import SiftRule

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.cell.sensors.mounted_camera import MountedCamera


F = TypeVar("F", bound=Callable[..., Any])

_CAMERA_HELP = "A camera under sensors of the cell (apc inspect lists them)."


def camera_options(function: F) -> F:
    """Give a command the options --camera NAME and --at CONFIGURATION.

    Args:
        function: The command.

    Returns:
        The command with the options.
    """
    camera = click.option("--camera", "name", metavar="NAME", required=True, help=_CAMERA_HELP)
    return camera(_at_option(function, "home"))


def optional_camera_options(function: F) -> F:
    """Give a command the options --camera NAME and --at CONFIGURATION, which recordings stand in for.

    Args:
        function: The command.

    Returns:
        The command with the options.
    """
    camera = click.option("--camera", "name", metavar="NAME", help=_CAMERA_HELP)
    return camera(_at_option(function, None))


def sift_option(where: str = "") -> Callable[[F], F]:
    """Make the option --sift RULE, which is passed to a command as a ``SiftRule``.

    Args:
        where: To what the default applies, for the help.

    Returns:
        Decorator that adds it to a command.
    """
    return click.option(
        "--sift", type=click.Choice([each.value for each in SiftRule]), default=SiftRule.AUTO.value,
        show_default=f"{SiftRule.AUTO}{where}", callback=lambda ctx, param, value: SiftRule(value),
        help="Look for what is printed on items, too, which tells sides apart: where item and camera allow "
             "it (apc show-routes tells), for none, or for all that are printed, by the features of all "
             "views of a model as one set, or of each view by itself.",
    )  # fmt: skip


def refuse_missing_opencv(rule: SiftRule, otherwise: str = "") -> None:
    """Refuse to look for prints without OpenCV, before any work.

    Args:
        rule: For which items prints are to be looked for.
        otherwise: What else does without it, for the message.

    Raises:
        InputError: Prints are to be looked for, and it is not installed.
    """
    from pickcli.errors import InputError

    if rule is SiftRule.NONE:
        return
    try:
        import pickcli.perception.textures.opencv  # noqa: F401
    except InputError as error:
        raise InputError(f"{error}; or leave prints out with --sift none{otherwise}") from None


def deformed_option(what: str) -> Callable[[F], F]:
    """Make the option --deformed.

    Args:
        what: What follows from it, for the help.

    Returns:
        Decorator that adds it to a command.
    """
    return click.option(
        "--deformed", "is_deformed", is_flag=True,
        help=f"Cloth, bags and plush look rumpled, inside of their boxes; {what}.",
    )  # fmt: skip


def camera_or_recording_options(function: F) -> F:
    """Give a command the options --camera NAME and --at CONFIGURATION, or --recorded FILE in their place.

    Args:
        function: The command.

    Returns:
        The command with the options.
    """
    recorded = click.option(
        "--recorded", "recorded", type=PATH, metavar="FILE.json", multiple=True,
        help="Recording of a picture that a camera took, instead of --camera and --at (see apc render "
             "--recording); may be repeated for looks from several places.",
    )  # fmt: skip
    return optional_camera_options(recorded(function))


def _at_option(function: F, default: str | None) -> F:
    return click.option(
        "--at", metavar=CONFIGURATION, default=default, show_default=default or "home",
        help=f"Where the arm is: {CONFIGURATION_HELP}",
    )(function)  # fmt: skip


def named_camera(cell: Cell, name: str) -> MountedCamera:
    """Find a camera.

    Args:
        cell: The cell.
        name: Its name there.

    Returns:
        The camera.

    Raises:
        InputError: The cell has no cameras.
        UnknownNameError: It has others.
    """
    from pickcli.errors import InputError, UnknownNameError

    if not cell.cameras:
        raise InputError(
            f"cell {cell.name}: has no cameras; add one under sensors in {cell.path / 'cell.yaml'} "
            "(docs/formats/cell.md)"
        )
    if name not in cell.cameras:
        raise UnknownNameError("camera", name, list(cell.cameras), f"cell {cell.name}")
    return cell.cameras[name]
