"""``apc inspect``: a summary of a file that apc wrote or reads."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.arm_options import (
    ArmRequest,
    arm_option,
    open_alike,
    open_cell,
    standing_option,
)
from pickcli.commands.options.common_options import (
    CELL_HELP,
    items_option,
    json_option,
    overwrite_option,
    refuse_missing,
    refuse_output,
)
from pickcli.commands.options.option_types import PATH, RenamedOption
from pickcli.commands.options.scene_options import allowed, open_scene
from pickcli.commands.output.cell_summary import cell_summary
from pickcli.commands.output.report import key_lines, plan_summary
from pickcli.commands.output.stored_motion import motions_between
from pickcli.commands.output.summary_text import in_words, on_a_screen
from pickcli.commands.output.table import known_width

if TYPE_CHECKING:
    from pickcli.scene.scene import PoseNoise, Scene


@click.command("inspect", cls=Command)
@click.argument("path", metavar="FILE", type=PATH)
@click.option("--cell", "cell_name", metavar="NAME|FOLDER",
              help=f"{CELL_HELP}  [default: the one that FILE names]")  # fmt: skip
@items_option
@click.option("--all", "is_all", is_flag=True,
              help="For a roadmap or database, also its solids, and every list in full.")  # fmt: skip
@click.option("--motion", "ends", nargs=2, metavar="START GOAL",
              help="For a database, only the motions between two named configurations.")  # fmt: skip
@click.option("--picture", cls=RenamedOption, old=("--plot",), type=PATH, metavar="FILE",
              help="Draw a cell, or a roadmap or database in it: .png, or .html to rotate.")  # fmt: skip
@arm_option("all arms, of a cell")
@standing_option
@overwrite_option
@json_option
def command(
    path: Path, cell_name: str | None, items_path: Path | None, is_all: bool, ends: tuple[str, str] | None,
    picture: Path | None, arm: str | None, standing: tuple[str, ...], overwrite: bool, as_json: bool,
) -> None:  # fmt: skip
    """Show what is in a roadmap, database, plan, scene, stream, cell, pallet or perceived items.

    FILE may also be a cell's folder or name. A roadmap or database is shortened to fit on a screen; --all and
    --json show everything.

    \b
    Example:
      apc inspect scene.json
      apc inspect apc2016_delft --json
      apc inspect roadmap.h5 --picture roadmap.html
      apc inspect trajectories.h5 --motion home bin_A
    """
    if picture is not None and ends is not None:
        raise click.UsageError("--picture draws the whole file; leave out --motion, or --picture")
    if picture is not None:
        _check_picture(picture, overwrite, path, cell_name)
    arms = ArmRequest(arm, standing, items=items_path)
    with stage("reading"):
        summary = (
            _summary(path, cell_name, arms) if ends is None else motions_between(path, *ends, cell_name, arms)
        )
    if picture is not None:
        _draw(path, picture, cell_name, arms, summary, overwrite)
    if as_json:
        emit_json({**summary, "plot": summary["picture"]} if picture is not None else summary)  # former key
    else:
        shown = in_words(summary) if is_all else on_a_screen(in_words(summary))
        click.echo("\n".join(key_lines(shown, known_width())))


def _check_picture(picture: Path, overwrite: bool, *inputs: Path | str | None) -> None:
    """Refuse, before any work, a picture that could not be written."""
    from pickcli.drawing.draw import refuse_suffix

    refuse_suffix(picture)
    refuse_output(picture, overwrite, *inputs)


def _draw(
    path: Path, picture: Path, cell_name: str | None, arms: ArmRequest, summary: dict[str, Any],
    overwrite: bool,
) -> None:  # fmt: skip
    """Draw the described file. Raises InputError if it is not a cell, roadmap or database."""
    from pickcli.cell.cell_file import load_workcell
    from pickcli.drawing.cell_picture import cell_picture
    from pickcli.drawing.draw import cell_of, picture_of
    from pickcli.errors import InputError
    from pickcli.page.picture_page import write_drawing

    if summary["format"] == "apc cell":
        workcell = load_workcell(path)
        cell = workcell.preferred if arms == ArmRequest() else arms.cell_of(workcell)
        if not cell.configurations:
            raise InputError(
                f"{path}: --picture draws the arm in a named configuration, the cell has none; add one"
            )
        write_drawing(cell_picture(cell), cell, picture, overwrite)
    elif summary["format"] in ("roadmap", "trajectory database"):
        cell = cell_of(summary["cell_fingerprint"]) if cell_name is None else open_cell(cell_name, arms)
        write_drawing(picture_of(path, cell), cell, picture, overwrite)
    else:
        raise InputError(
            f"{path}: --picture draws a cell, roadmap or trajectory database, this is: {summary['format']}"
        )
    summary["picture"] = str(picture)


def _summary(path: Path, cell_name: str | None, arms: ArmRequest) -> dict[str, Any]:
    """Determine the kind of the file, and describe it. Raises InputError, DamagedError, StaleError."""
    from pickcli.errors import InputError
    from pickcli.files.bounded_reading import read_kind
    from pickcli.files.file_kind import CELL, PALLET, PERCEIVED, PLAN, SCENE, STACKED, STORE, STREAM

    refuse_missing(path, (".h5", ".json"))
    if path.is_dir() or not path.exists():
        return cell_summary(path, arms)
    kind = read_kind(path)
    if kind == SCENE:
        return _scene(path, cell_name, arms)
    if kind == STREAM:
        return _stream(path, cell_name, arms)
    if kind == PERCEIVED:
        return _perceived(path, cell_name, arms)
    if kind == CELL:
        return cell_summary(path, arms)
    describe = {STORE: _stored, PLAN: _plan, PALLET: _pallet_order, STACKED: _stacked}
    if kind in describe:
        summary = describe[kind](path)
        if kind is STORE and cell_name is not None:
            _refuse_other_cell(path, summary["cell_fingerprint"], cell_name, arms)
        return summary
    found = "is not a file that apc knows" if kind is None else f"is {kind.name}"
    raise InputError(
        f"{path}: {found}, but a roadmap, trajectory database, plan, scene, stream, cell, pallet or file of "
        "perceived items is expected here"
    )


def _refuse_other_cell(path: Path, fingerprint: str, cell_name: str, arms: ArmRequest) -> None:
    """Raise StaleError for a stored file of another cell than the named one."""
    from pickcli.errors import StaleError

    named = open_cell(cell_name, arms).fingerprint
    if fingerprint != named:
        raise StaleError(
            f"{path}: is of a cell with fingerprint {fingerprint[:16]}, {cell_name} has {named[:16]}; "
            "apc refresh updates it for that cell"
        )


def _scene(path: Path, cell_name: str | None, arms: ArmRequest) -> dict[str, Any]:
    from pickcli.cell.pod_tolerance import pod_stand
    from pickcli.scene.scene_file import held_values, scene_hash

    scene = open_scene(path, cell_name, arms)
    places = Counter(placed.location for placed in scene.items)
    return {
        "format": "apc scene",
        "version": 1,
        "scene_hash": scene_hash(scene),
        "cell": scene.cell.name,
        "cell_fingerprint": scene.cell.scene_fingerprint,
        "seed": scene.seed,
        "pod": f"{pod_stand(scene.T_nominal_pod)} (the cell allows for {allowed(scene.cell)})",
        "noise": _noise(scene.noise),
        "noise_of_items": {i.id: _noise(i.noise) for i in scene.items if i.noise is not None},
        "held": None if scene.held is None else held_values(scene.held),
        "n_items": len(scene.items),
        "items": {place: [i.id for i in scene.in_location(place)] for place in sorted(places)},
        "unknown_boxes": {space.place: len(space.boxes) for space in scene.unknown},
        "supports": _supports(scene),
    }


def _stream(path: Path, cell_name: str | None, arms: ArmRequest) -> dict[str, Any]:
    """Describe a stream: its belt, and when each item enters the belt and its window."""
    from functools import partial

    from pickcli.scene.stream_file import read_stream

    cell = None if cell_name is None else open_alike(cell_name, arms)
    stream = read_stream(path, cell, partial(open_alike, request=arms))
    first, last = stream.belt.window
    within = {}
    for riding in stream.items:
        at = float(riding.T_belt_item[0, 3])
        in_window = (
            "stands"
            if stream.speed == 0.0
            else " to ".join(f"{riding.stamp + (edge - at) / stream.speed:.2f}" for edge in (first, last))
        )
        within[riding.id] = in_window if stream.speed == 0.0 else f"{in_window} s"
    return {
        "format": "apc stream",
        "version": 1,
        "cell": stream.cell.name,
        "cell_fingerprint": stream.cell.scene_fingerprint,
        "seed": stream.seed,
        "conveyor": stream.conveyor,
        "speed_m_s": stream.speed,
        "speed_error_m_s": stream.speed_error,
        "noise": _noise(stream.noise),
        "n_items": len(stream.items),
        "within_window": within,
    }


def _noise(noise: PoseNoise) -> dict[str, float]:
    """Bounds of the error of a pose, with their units; of the surface only where they are stated."""
    surface = {} if noise.displacement is None else {"displacement_m": noise.displacement}
    return {"position_m": noise.position, "angle_rad": noise.angle, **surface}


def _pallet_order(path: Path) -> dict[str, Any]:
    from pickcli.palletizing.pallet_order_file import read_pallet_order

    order = read_pallet_order(path)
    pallet, cartons = order.pallet, order.cartons
    volume = sum(c.size[0] * c.size[1] * c.size[2] for c in cartons)
    return {
        "format": "apc pallet",
        "version": 1,
        "pallet_m": list(pallet.size),
        "height_over_deck_m": pallet.height - pallet.deck,
        "n_cartons": len(cartons),
        "mass_kg": sum(carton.mass for carton in cartons),
        "volume_m3": volume,
        "volume_of_room": volume / (pallet.size[0] * pallet.size[1] * (pallet.height - pallet.deck)),
        "cartons": {carton.id: f"{_size(carton.size)} m, {carton.mass:g} kg" for carton in cartons},
    }


def _stacked(path: Path) -> dict[str, Any]:
    from pickcli.palletizing.pallet_stack_file import read_pallet_stack

    stack = read_pallet_stack(path)
    placed = stack.placements
    return {
        "format": "apc stacked pallet",
        "version": 1,
        "pallet_m": list(stack.pallet.size),
        "top_m": stack.top,
        "n_placed": len(placed),
        "n_left": len(stack.left),
        "mass_kg": sum(placement.carton.mass for placement in placed),
        "moved_in_engine_m": max(stack.sinking, stack.shift),
        "in_sequence": {p.carton.id: f"on {', '.join(p.rests_on) or 'the deck'}" for p in placed},
        "left": {name: list(reasons) for name, reasons in stack.left.items()},
    }


def _size(size: tuple[float, ...]) -> str:
    return " x ".join(f"{side:g}" for side in size)


def _perceived(path: Path, cell_name: str | None, arms: ArmRequest) -> dict[str, Any]:
    from functools import partial

    from pickcli.perception.items.perceived_file import perceived_values, read_perceived

    cell = None if cell_name is None else open_alike(cell_name, arms)
    return perceived_values(read_perceived(path, cell, partial(open_alike, request=arms)))


def _supports(scene: Scene) -> dict[str, Any]:
    """Return for each item what it rests on, and what falls, slumps or rolls if it is removed."""
    from pickcli.statics.supports import supports_of

    supports = supports_of(scene)
    found = {}
    for placed in sorted(scene.items, key=lambda placed: (placed.location, placed.id)):
        found[placed.id] = {
            "rests_on": list(supports.graph.carriers(placed.id)),
            "carries": list(supports.graph.lying_on(placed.id)),
            "without_it_fall": list(supports.blocking(placed.id)),
            "without_it_slump": list(supports.slumping(placed.id)),
            "without_it_may_roll": list(supports.rolling(placed.id)),
        }
    return found


def _plan(path: Path) -> dict[str, Any]:
    from pickcli.motion.plan_file import motion_hash, read_plan
    from pickcli.motion.plan_schema import VERSION

    plan = read_plan(path)
    values = plan_summary(plan, path)
    return {
        "format": "apc plan",
        "version": VERSION,
        "query": values.pop("query"),
        "cell_fingerprint": plan.cell_fingerprint,
        "scene_hash": plan.scene_hash,
        "motion_hash": motion_hash(plan),
        "seed": plan.seed,
        "points": len(plan.trajectory.times),
        "joints": list(plan.trajectory.joint_names),
        **values,
    }


def _stored(path: Path) -> dict[str, Any]:
    """Describe a roadmap or database: its metadata, and statistics of its content."""
    from pickcli.roadmap.roadmap_tables import ROADMAP
    from pickcli.roadmap.statistics import database_statistics, roadmap_statistics
    from pickcli.roadmap.store import describe, read_database, read_gaps, read_missing, read_roadmap

    values = {**describe(path), "bytes": path.stat().st_size}
    if values["format"] == ROADMAP.name:
        return values | roadmap_statistics(read_roadmap(path), read_gaps(path))
    return values | database_statistics(read_database(path), read_missing(path))
