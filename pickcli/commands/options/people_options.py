"""Options of commissions that are played with people in the booth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from pickcli.commands.options.common_options import passed_as
from pickcli.commands.options.trial_options import is_stated

if TYPE_CHECKING:
    from pickcli.commission.commission_station import CommissionStation
    from pickcli.commission.people_watch import BoothWatch

F = TypeVar("F", bound=Callable[..., Any])
MOST_PEOPLE = 20
GUARDS = ("scanner", "vests", "both")
WATCH = "apple_booth"  # under data/watches


@dataclass(frozen=True)
class PeopleOptions:
    """Who walks through the booth, and what brakes the truck for them.

    Attributes:
        people: A number, or the path of a watched scene; None for nobody.
        guards: Which guards brake the truck.
    """

    people: str | None
    guards: str

    @property
    def path(self) -> Path | None:
        """The watched scene, if people are not drawn."""
        return None if self.people is None or self.people.isdecimal() else Path(self.people)

    def booth_watch(self, station: CommissionStation) -> BoothWatch | None:
        """Return how drives are watched.

        Args:
            station: The commission in its cell.

        Returns:
            Sensors and people; None without people.

        Raises:
            InputError: The watched scene cannot be read, or does not fit the booth.
            UsageError: ``--guards`` was stated without people, or there are too many.
        """
        from pickcli.commission.booth_people import DrawnPeople, StatedPeople
        from pickcli.commission.people_watch import BoothWatch
        from pickcli.watching.drive_watch import Guards
        from pickcli.watching.watch_file import read_watch, watch_file
        from pickcli.watching.watched_scene_file import read_watched_scene

        if self.people is None:
            if is_stated("guards"):
                raise click.UsageError("--guards brake for people; add --people, or leave it out")
            return None
        guards = Guards(self.guards != "vests", self.guards != "scanner")
        watch = read_watch(watch_file(WATCH))
        if self.path is None:
            number = int(self.people)
            if number > MOST_PEOPLE:
                raise click.UsageError(f"--people {number}: expected at most {MOST_PEOPLE}")
            return BoothWatch(DrawnPeople(number), watch, guards)
        scene = read_watched_scene(self.path, station.entering(station.commission.area.start))
        return BoothWatch(StatedPeople(scene.walkers, scene.reflectors, scene.sun), watch, guards)


def people_options(function: F) -> F:
    """Give a command the options --people FILE|N and --guards NAME.

    Args:
        function: The command.

    Returns:
        The command with the options, which are passed to it as ``people``, a ``PeopleOptions``.
    """
    function = passed_as("people", PeopleOptions)(function)
    function = click.option(
        "--guards", type=click.Choice(GUARDS), default="both", show_default=True,
        help="Of --people: what brakes the truck: its laser scanners, the vest cameras, or both.",
    )(function)  # fmt: skip
    return click.option(
        "--people", "people", metavar="FILE|N",
        help="Of a commission: N people, or those of a watched scene, walk through the booth while the truck "
             "drives, which is watched and brakes for them.",
    )(function)  # fmt: skip


def refuse_people() -> None:
    """Refuse the options, before any work, where no commission is played.

    Raises:
        UsageError: One was stated.
    """
    for name in ("people", "guards"):
        if is_stated(name):
            raise click.UsageError(f"--{name} applies to commissions, and this is none; leave it out")
