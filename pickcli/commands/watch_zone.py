"""``apc watch-zone``: who a driving truck sees, what brakes it, and how near people it comes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.common_options import json_option, output_option, refuse_output, seed_option
from pickcli.commands.options.option_types import PATH, refuse_suffix
from pickcli.commands.output.progress_bar import progress

if TYPE_CHECKING:
    from collections.abc import Iterator

    from pickcli.watching.watched_drive import PersonReport, RequestReport, WatchedDrive

MOST_PEOPLE = 20
GUARDS = ("scanner", "vests", "both")


@click.command("watch-zone", cls=Command)
@click.argument("area_path", metavar="AREA", type=PATH)
@click.option("--watched", "watched_path", type=PATH, metavar="FILE",
              help="Play this watched scene, instead of drawing one by the seed.")  # fmt: skip
@click.option("--watch", "watch_name", default="citi_truck", show_default=True, metavar="NAME|FILE",
              help="Sensors, fields and brake: a name under data/watches, or a file.")  # fmt: skip
@click.option("--people", type=click.IntRange(0, MOST_PEOPLE), default=3, show_default=True, metavar="N",
              help="Number of people of a drawn scene.")  # fmt: skip
@click.option("--guards", type=click.Choice(GUARDS), default="both", show_default=True,
              help="What brakes the truck: the laser scanner, the vest cameras, or both.")  # fmt: skip
@click.option("--picture", type=PATH, metavar="FILE",
              help="Draw the drive from above, too, as .svg.")  # fmt: skip
@output_option("watched drive")
@seed_option
@json_option
def command(
    area_path: Path,
    watched_path: Path | None,
    watch_name: str,
    people: int,
    guards: str,
    picture: Path | None,
    output: Path,
    overwrite: bool,
    seed: int,
    as_json: bool,
) -> None:
    """Play a drive past people, and report whom the truck sees and when it brakes.

    The truck drives as apc plan-drive plans; cameras look for vests and a laser scanner watches a field, and
    either brakes it; contacts are told. All is simulated: it tells probabilities, delays and distances, and
    makes no claim of safety.

    \b
    Example:
      apc watch-zone hall.yaml --people 2 --seed 3 --picture watch.svg -o watch.json
      apc watch-zone hall.yaml --watched scene.yaml --guards scanner -o watch.json
    """
    from pickcli.driving.drive_plan import plan_drive
    from pickcli.driving.drive_tracking import PERIOD
    from pickcli.driving.driving_area_file import read_driving_area
    from pickcli.files.atomic_write import write_text
    from pickcli.watching.drawn_scene import draw_watched_scene
    from pickcli.watching.drive_watch import Guards
    from pickcli.watching.watch_file import read_watch, watch_file
    from pickcli.watching.watch_svg import watch_svg
    from pickcli.watching.watched_drive_file import write_watched_drive
    from pickcli.watching.watched_scene_file import read_watched_scene
    from pickcli.watching.zone_watch import watch_zone

    given = click.get_current_context().get_parameter_source("people") is ParameterSource.COMMANDLINE
    if watched_path is not None and given:
        raise click.UsageError("--people is for a drawn scene, not with --watched; leave one of them out")
    watch_path = watch_file(watch_name)
    refuse_output(output, overwrite, area_path, watched_path, watch_path)
    if picture is not None:
        refuse_suffix(picture, (".svg",), "a picture of a drive")
        refuse_output(picture, overwrite, area_path, watched_path, watch_path, output)
    area, watch = read_driving_area(area_path), read_watch(watch_path)
    stated = None if watched_path is None else read_watched_scene(watched_path, area)
    with stage("planning"):
        plan = plan_drive(area)
    scene = draw_watched_scene(plan, people, seed) if stated is None else stated
    with stage("the watched drive"), progress("watching") as observe:
        drive = watch_zone(
            plan, scene, watch, seed, Guards(guards != "vests", guards != "scanner"), observe
        )  # fmt: skip
    write_watched_drive(output, drive, overwrite)
    if picture is not None:
        write_text(picture, watch_svg(drive), overwrite)
    figures = drive.figures(PERIOD)
    if as_json:
        emit_json({"path": str(output), **figures})
        return
    end = "at the goal" if drive.arrived else "not at the goal"
    click.echo(f"{end} after {figures['duration']:.1f} s, {figures['braked']:.1f} s of it braked: {output}")
    for line in _lines(drive):
        click.echo(f"  {line}")


def _lines(drive: WatchedDrive) -> Iterator[str]:
    """What is told below the first line."""
    if drive.n_pictures:
        yield from map(_person, drive.people)
        n = drive.n_false
        yield f"{n} track{'s' * (n != 1)} of nobody in {drive.n_pictures} sets of pictures"
    yield from map(_request, drive.requests)
    for touch in drive.touches:
        who = "the truck touches" if touch.is_by_truck else "walks into the truck:"
        avoidable = (
            "" if not touch.is_by_truck else ", avoidable" if touch.is_avoidable else ", not avoidable"
        )
        yield f"{touch.time:.2f} s: {who} {touch.name} at {touch.speed:.2f} m/s{avoidable}"
    if not drive.touches:
        yield "nobody is touched while the truck moves"
    if drive.unwatched:
        yield f"{drive.unwatched:.2f} m backwards, where no sensor looks"


def _person(report: PersonReport) -> str:
    if report.seen_time is None:
        return f"{report.name}: never seen, in view of {report.n_in_view} sets of pictures"
    text = (
        f"{report.name}: seen at {report.seen_time:.2f} s, {report.seen_distance:.1f} m away; "
        f"found in {report.n_found} of {report.n_in_view} pictures with most of the vest in view; "
        f"probability {report.probability:.2f}"
    )
    return f"{text}, off by {report.position_error:.2f} m and {report.velocity_error:.2f} m/s"


def _request(report: RequestReport) -> str:
    free = "nobody ahead" if report.free is None else f"{report.free:.2f} m free"
    delay = "" if report.delay is None else f", {1e3 * report.delay:.0f} ms after its reason"
    why = "for something that is no person" if report.name is None else f"for {report.name}"
    return (
        f"{report.time:.2f} s: brake request by the {report.by}, {why}{delay}, at {report.speed:.2f} m/s: "
        f"rests after {report.stopping:.2f} m, {free}"
    )
