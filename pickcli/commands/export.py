"""``apc export``: write a plan for a robot or for other tools."""

from __future__ import annotations

import re
from pathlib import Path

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.operations.plan_verification import refuse_tracking, trusted
from pickcli.commands.options.arm_options import ArmRequest, standing_option
from pickcli.commands.options.common_options import json_option, output_option, refuse_output
from pickcli.commands.options.option_types import PATH, FiniteRange, RenamedOption, refuse_suffix
from pickcli.commands.options.scene_options import refuse_held, scene_or_cell_options
from pickcli.commands.options.stream_options import StreamOptions, stream_options
from pickcli.export.formats import format_names

_NUMBER = re.compile("[0-9]{1,9}")  # number of a channel


@click.command("export", cls=Command)
@click.argument("plan_path", metavar="PLAN", type=PATH)
@click.option("--format", "format_name", cls=RenamedOption, old=("--to",), metavar="FORMAT", required=True,
              help=f"Format of the output: {', '.join(format_names())}.")  # fmt: skip
@output_option("exported plan")
@scene_or_cell_options
@stream_options
@standing_option
@click.option("--rate", type=FiniteRange(1.0, 1000.0), metavar="HZ",
              help="Samples per second.  [default: the plan's own points; urscript: 125]")  # fmt: skip
@click.option("--channel", "channel_texts", metavar="DEVICE=N", multiple=True,
              help="Digital output or input of a device, for urscript; may be repeated.  "
                   "[default: in the order of the cell file]")  # fmt: skip
@json_option
def command(
    plan_path: Path, format_name: str, output: Path, overwrite: bool, scene_path: Path | None,
    cell_name: str | None, items_path: Path | None, standing: tuple[str, ...], rate: float | None,
    channel_texts: tuple[str, ...], as_json: bool, request: StreamOptions,
) -> None:  # fmt: skip
    """Write a verified plan for a robot or for other tools.

    The plan is verified first, even if it has a certificate: in the scene that it was made for; name only
    --cell if it was made without one. The same plan gives the same bytes.

    Off a conveyor that stands, name the stream. A plan for one that runs cannot be exported: its set points
    follow the encoder, by a driver (apc execute --stream; docs/how-to/pick-from-a-conveyor.md).

    \b
    Example:
      apc export plan.json --format joint-trajectory --scene scene.json -o trajectory.json
      apc export plan.json --format mcap --scene scene.json --rate 100 -o plan.mcap
      apc export standing.json --format csv --stream stream.json -o standing.csv
      apc export move.json --format urscript --cell ur5e_crates --channel valve=3 -o move.script
    """
    from pickcli.errors import InputError, UnknownNameError
    from pickcli.export.exporter import ExportRequest
    from pickcli.export.formats import exporter
    from pickcli.files.atomic_write import write_bytes
    from pickcli.motion.plan_file import read_plan

    try:
        format_ = exporter(format_name)
    except UnknownNameError as error:
        raise click.UsageError(f"--format: {error}") from None
    refuse_suffix(output, (format_.suffix,), f"the format {format_name}")
    if channel_texts and not format_.has_channels:
        raise click.UsageError(f"--channel: the format {format_name} has no channels; leave it out")
    channels = _channels(channel_texts)
    request.refuse_scene(scene_path)
    refuse_output(output, overwrite, plan_path, scene_path, cell_name, items_path, request.stream_path)
    plan = read_plan(plan_path)
    refuse_tracking(plan, plan_path)
    scene = request.surroundings(plan, scene_path, cell_name, ArmRequest.of_plan(plan, standing, items_path))
    refuse_held(scene, scene_path)
    option = "--scene" if request.stream_path is None else "--stream"
    plan = trusted(plan, plan_path, scene, "plan it again", request.stream_path or scene_path, option)
    try:
        with stage("export"):
            content = format_.encode(ExportRequest(plan, scene, rate, channels))
    except InputError as error:
        raise InputError(f"{plan_path} to {format_name}: {error}") from None
    write_bytes(output, content, overwrite)
    if as_json:
        emit_json({"path": str(output), "format": format_name, "bytes": len(content)})
    else:
        click.echo(f"wrote {output}: {format_.description}, {len(content)} bytes")


def _channels(texts: tuple[str, ...]) -> dict[str, int]:
    """Parse channel numbers by device. Raises UsageError for anything else."""
    found: dict[str, int] = {}
    for text in texts:
        device, equals, number = text.partition("=")
        if not equals or not _NUMBER.fullmatch(number):
            raise click.UsageError(f"--channel {text!r}: expected DEVICE=N, e.g. valve=3")
        if device in found:
            raise click.UsageError(f"--channel: {device} is given twice; keep one")
        found[device] = int(number)
    return found
