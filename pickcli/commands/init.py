"""``apc init``: a cell for a robot from its URDF."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.common_options import json_option, refuse_unwritable, seed_option
from pickcli.commands.options.option_types import PATH
from pickcli.commands.output.progress_bar import progress

if TYPE_CHECKING:
    from pickcli.robot_setup.cell_setup import CellSetup
    from pickcli.robot_setup.setup_options import StatedLimit
    from pickcli.robot_setup.sphere_excess import SphereExcess
    from pickcli.robot_setup.suggested_places import SuggestedPlace

FIGURE = "[JOINT=]NUMBER"


@click.command("init", cls=Command)
@click.argument("folder", type=PATH, metavar="FOLDER")
@click.option("--urdf", type=PATH, metavar="FILE", required=True, help="URDF or xacro of the robot.")
@click.option("--srdf", type=PATH, metavar="FILE",
              help="SRDF of the robot (MoveIt): groups, named states, disabled pairs.")  # fmt: skip
@click.option("--group", metavar="NAME", help="Group of the SRDF that is planned.  [default: the only arm]")
@click.option("--tip", metavar="LINK",
              help="Link at the end of the arm.  [default: of the group or the longest chain]")  # fmt: skip
@click.option("--without", metavar="LINK", multiple=True,
              help="Link to leave out, with all links below it; may be repeated.")  # fmt: skip
@click.option("--package-path", "package_path", metavar="[NAME=]FOLDER", multiple=True,
              help="Folder of ROS packages, or of one package; may be repeated.")  # fmt: skip
@click.option("--xacro-arg", "xacro_arguments", metavar="NAME=VALUE", multiple=True,
              help="Argument of a xacro; may be repeated.")  # fmt: skip
@click.option("--joint-limits", type=PATH, metavar="FILE", help="A ROS joint_limits.yaml.")
@click.option("--max-velocity", "velocities", metavar=FIGURE, multiple=True,
              help="rad/s or m/s, of JOINT or of all joints not stated; may be repeated.")  # fmt: skip
@click.option("--max-acceleration", "accelerations", metavar=FIGURE, multiple=True,
              help="rad/s2 or m/s2, likewise.")  # fmt: skip
@click.option("--max-jerk", "jerks", metavar=FIGURE, multiple=True, help="rad/s3 or m/s3, likewise.")
@click.option("--motor-force", "forces", metavar=FIGURE, multiple=True,
              help="N or Nm, likewise; only for simulation.")  # fmt: skip
@click.option("--accept-unshaped", is_flag=True,
              help="Accept links without a collision shape, which are not tested.")  # fmt: skip
@click.option("--tool", metavar="KIND", help="Mounted tool: suction, or gripper (as in the URDF).")
@click.option("--place", "places", metavar="[NAME=]KIND", multiple=True,
              help="Place for items: pod, grid, box or table; may be repeated.")  # fmt: skip
@click.option("--tool-figure", "tool_figures", metavar="KEY=NUMBER", multiple=True,
              help="Figure of the tool, e.g. friction=0.5; may be repeated.")  # fmt: skip
@seed_option
@json_option
def command(
    folder: Path, urdf: Path, srdf: Path | None, group: str | None, tip: str | None, without: tuple[str, ...],
    package_path: tuple[str, ...], xacro_arguments: tuple[str, ...], joint_limits: Path | None,
    velocities: tuple[str, ...], accelerations: tuple[str, ...], jerks: tuple[str, ...],
    forces: tuple[str, ...], accept_unshaped: bool, tool: str | None, places: tuple[str, ...],
    tool_figures: tuple[str, ...], seed: int, as_json: bool,
) -> None:  # fmt: skip
    """Write a cell for a robot, from its URDF.

    FOLDER gets a commented cell.yaml and everything that it needs: URDF, meshes, SRDF. Chain and tip are
    found, spheres fitted, pairs of links that always collide found by sampling, and configurations
    suggested; --tool mounts a tool, --place puts a place where the arm reaches best. What only you know, such
    as a limit of acceleration that no file states, is left blank and listed; nothing is assumed.

    \b
    Example:
      apc init my_robot --urdf panda.urdf --srdf panda.srdf --max-acceleration 5 --max-jerk 50
      apc init my_cell --urdf ur5e.urdf --max-acceleration 5 --max-jerk 50 --tool suction --place crate=box
      apc init left_arm --urdf baxter.urdf --tip left_gripper --joint-limits joint_limits.yaml
    """
    from pickcli.collision.robot_model import CollisionModel
    from pickcli.robot_setup.cell_setup import set_up_cell
    from pickcli.robot_setup.setup_options import SetupOptions
    from pickcli.robot_setup.sphere_excess import sphere_excess
    from pickcli.robot_setup.stated_limits import EFFORT
    from pickcli.robot_setup.suggested_places import requested_places
    from pickcli.robot_setup.suggested_tool import figure_of, tool_kind

    figures = {"velocity": velocities, "acceleration": accelerations, "jerk": jerks, EFFORT: forces}
    named = [text for text in package_path if "=" in text]
    request = SetupOptions(
        urdf=urdf,
        srdf=srdf,
        group=group,
        tip=tip,
        without=without,
        package_path=[Path(text) for text in package_path if "=" not in text],
        packages={name: Path(folder) for name, folder in _assignments("--package-path", named)},
        arguments=dict(_assignments("--xacro-arg", xacro_arguments)),
        joint_limits=joint_limits,
        figures=[_figure(kind, text) for kind, texts in figures.items() for text in texts],
        accepts_unshaped=accept_unshaped,
        tool=None if tool is None else tool_kind(tool),
        tool_figures=dict(map(figure_of, tool_figures)),
        places=requested_places(places),
        seed=seed,
    )
    if folder.parent.is_dir():
        refuse_unwritable(folder.parent, folder, "FOLDER")
    with stage("making the cell"), progress("setting up") as report:
        made = set_up_cell(folder, request, report)
        spheres = sphere_excess(made.cell, CollisionModel(made.cell))
    if as_json:
        emit_json(_summary(made, spheres))
    else:
        click.echo("\n".join(_lines(made, spheres)))


def _assignments(option: str, texts: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Split NAME=VALUE, or NAME:=VALUE as in ROS. Raises UsageError."""
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name.rstrip(":"):
            raise click.UsageError(f"{option} {text}: expected NAME=VALUE")
        yield name.rstrip(":"), value


def _figure(kind: str, text: str) -> StatedLimit:
    """Parse a limit from the command line, of one joint or of all. Raises UsageError if it is invalid."""
    from pickcli.robot_setup.setup_options import StatedLimit
    from pickcli.robot_setup.stated_limits import option_of

    joint, equals, number = text.rpartition("=")
    try:
        value = float(number)
    except ValueError:
        value = -1.0
    if not 0.0 < value < 1e7 or (equals and not joint):
        hint = "; a number has a decimal point" if "," in number else ""
        raise click.UsageError(f"{option_of(kind)} {text}: expected a number over 0, or JOINT= and one{hint}")
    return StatedLimit(kind, joint or None, value)


def _summary(made: CellSetup, spheres: list[SphereExcess]) -> dict[str, Any]:
    from pickcli.robot_setup.sphere_excess import mean_of

    draft, chain = made.draft, made.draft.chain
    return {
        "path": str(made.folder),
        "group": chain.group or None,
        "joints": list(chain.joints),
        "tip": made.cell.robot.tool.last_link,
        "standing": {joint.name: joint.position for joint in draft.standing},
        "unshaped": list(draft.unshaped),
        "spheres": sum(each.n_spheres for each in spheres),
        "mean_excess_m": mean_of(spheres),
        "max_excess_m": max((each.max_excess for each in spheres), default=0.0),
        "pairs": {str(how): n for how, n in made.n_pairs.items()},
        "allowed_pairs": {f"{pair.a} - {pair.b}": pair.reason for pair in draft.pairs},
        "places": {
            each.name: {"kind": each.kind, "xyz": each.xyz, "yaw": each.yaw, "source": each.source}
            for each in draft.places
        },
        "configurations": {each.name: list(each.q) for each in draft.configurations},
        "notes": list(made.notes),
        "left_to_fill_in": list(made.left),
    }


def _stands(place: SuggestedPlace) -> str:
    xyz = ", ".join(f"{value:g}" for value in place.xyz)
    return f"{place.kind} at {xyz} m, yaw {place.yaw:g} rad"


def _lines(made: CellSetup, spheres: list[SphereExcess]) -> list[str]:
    """Format the text report."""
    from pickcli.robot_setup.collision_sampling import N_SPHERES
    from pickcli.robot_setup.sphere_excess import mean_of
    from pickcli.robot_setup.suggested_configurations import HOME

    draft, chain, counts = made.draft, made.draft.chain, made.n_pairs
    why = f"SRDF group {chain.group}" if chain.group else "longest chain"
    lines = [f"chain: {', '.join(chain.joints)}; tip {chain.tip} ({why})"]
    if draft.standing:
        lines.append(f"fixed joints: {', '.join(f'{j.name} at {j.position:g}' for j in draft.standing)}")
    if made.cell.robot.tool.gripper is not None:
        least, most = made.cell.robot.tool.range
        along, deep = (1e3 * side for side in made.cell.robot.tool.gripper.pad)
        lines.append(
            f"gripper: opens from {1e3 * least:g} to {1e3 * most:g} mm, pads of {along:g} x {deep:g} mm"
        )
    if spheres:
        worst = max(spheres, key=lambda each: each.max_excess)
        lines.append(
            f"spheres: {sum(each.n_spheres for each in spheres)}, {1e3 * mean_of(spheres):.1f} mm outside in "
            f"the mean, {1e3 * worst.max_excess:.1f} mm at most ({worst.link})"
        )
    met = ", ".join(f"{n} {how}" for how, n in counts.items())
    lines.append(f"pairs of links that collide in {N_SPHERES} samples: {met}")
    for pair in draft.pairs:
        tested = "; the verifier tests them" if pair.verified else ""
        lines.append(f"  allowed: {pair.a} and {pair.b}, {pair.reason}{tested}")
    lines += [f"place: {each.name}, {_stands(each)}; {each.source}" for each in draft.places]
    lines += [f"configuration: {each.name}, {each.source}" for each in draft.configurations]
    lines += [f"note: {note}" for note in made.notes]
    lines.append(f"wrote {made.folder}: cell.yaml, robot.urdf, {made.meshes} mesh{'es' * (made.meshes != 1)}")
    if made.left:
        return [
            *lines,
            f"left to fill in, in {made.folder / 'cell.yaml'}:",
            *(f"  {each}" for each in made.left),
        ]
    names = [each.name for each in draft.configurations if each.name != HOME and each.kind != "bin"]
    if names:
        words = ("apc", "plan-move", "--cell", str(made.folder), "--from", HOME, "--to", names[-1])
        lines.append(f"next: {shlex.join(words)} -o move.json")
    return lines
