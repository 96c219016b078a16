"""``apc show-routes``: by what the items of places would be recognised, without a look."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.options.arm_options import ArmRequest, arm_option, standing_option
from pickcli.commands.options.camera_pictures import named_viewpoint
from pickcli.commands.options.common_options import json_option
from pickcli.commands.options.listed_contents import bin_option, listed_contents, named_places, order_option
from pickcli.commands.options.named_camera import camera_options, deformed_option, sift_option
from pickcli.commands.options.scene_options import scene_or_cell_options, scene_or_empty
from pickcli.commands.output.perceived_lines import route_lines

if TYPE_CHECKING:
    from pickcli.perception.textures.sift_views import SiftRule


@click.command("show-routes", cls=Command)
@scene_or_cell_options
@order_option
@camera_options
@bin_option
@sift_option()
@deformed_option("and what may be rumpled is not looked for by its print")
@arm_option("the preferred one of those that have the configuration")
@standing_option
@json_option
def command(
    scene_path: Path | None, cell_name: str | None, items_path: Path | None, order_path: Path | None,
    name: str, at: str, bin_names: tuple[str, ...], sift: SiftRule, is_deformed: bool, arm: str | None,
    standing: tuple[str, ...], as_json: bool,
) -> None:  # fmt: skip
    """Tell by what apc perceive would look for items, without looking.

    For each place that the camera sees: how many of its pixels a millimetre at the mouth fills, and of each
    item whether it is looked for by its print or by shape and colour alone, why, and what else in the place
    is like it.

    \b
    Example:
      apc show-routes --scene scene.json --camera hand --at cam_E
      apc show-routes --cell apc2016_delft --order jsk_pick_sample --camera hand --at cam_E --json
    """
    from pickcli.perception.items.perceived_file import route_values
    from pickcli.perception.perceived_places import places_in_sight, routes_from

    arms = ArmRequest(arm, standing, (at,), items=items_path, camera=name)
    scene = scene_or_empty(scene_path, cell_name, arms)
    contents = listed_contents(scene, order_path, is_deformed)
    viewpoint, where = named_viewpoint(scene.cell, name, at), f"camera {name} at {at}"
    places = named_places(scene.cell, bin_names) or places_in_sight(
        scene, contents, {where: viewpoint}, "move the arm with --at"
    )
    told = [routes_from(scene, place, contents.get(place.name, ()), viewpoint, sift) for place in places]
    if as_json:
        emit_json(
            {
                "places": [
                    {
                        "place": each.place, "pixels_per_mm": each.pixels_per_mm, "seen": each.seen,
                        "routes": {item: route_values(route) for item, route in each.routes.items()},
                    }
                    for each in told
                ]
            }
        )  # fmt: skip
        return
    for each in told:
        click.echo(
            f"{each.place}: {each.pixels_per_mm:.2f} pixels per mm, {each.seen:.0%} of its room is seen"
        )
        for line in route_lines(each.routes.items()):
            click.echo(f"  {line}")
