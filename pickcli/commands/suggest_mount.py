"""``apc suggest-mount``: base poses of the robot."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import prod
from typing import TYPE_CHECKING, Any, TypeAlias, TypeVar

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.arm_options import ArmRequest, arm_option, open_cell, standing_option
from pickcli.commands.options.common_options import cell_option, json_option, seed_option
from pickcli.commands.options.configuration_option import named_state, tool_state_option
from pickcli.commands.options.option_types import NumberType
from pickcli.commands.output.progress_bar import progress
from pickcli.commands.output.table import table_lines

if TYPE_CHECKING:
    from pickcli.cell.cell import Cell
    from pickcli.geometry import Array
    from pickcli.reachability.mount_ranking import MountGrid, RankedMount

Bounds: TypeAlias = tuple[float, float]
F = TypeVar("F", bound=Callable[..., Any])

HALF_WIDTHS = {"x": 0.3, "y": 0.3, "z": 0.2, "yaw": 0.7854}  # of the default bounds, m and rad
STEPS = (5, 5, 3, 3)
MOST_POSES = 20_000  # base poses of a grid: about ten minutes
FARTHEST = 100.0  # m: a larger bound is probably in another unit
FULL_TURN = 6.3  # rad: a larger angle is probably in degrees
IN_RAD = "angles are in rad, not degrees"


def _bounds_option(axis: str, unit: str) -> Callable[[F], F]:
    """Give a command the option --AXIS LOW HIGH."""
    return click.option(
        f"--{axis}", nargs=2, type=float, metavar="LOW HIGH",
        show_default=f"{HALF_WIDTHS[axis]:g} to either side of the present one",
        help=f"Bounds of the base in the world, {unit}.",
    )  # fmt: skip


@click.command("suggest-mount", cls=Command)
@cell_option
@arm_option()
@standing_option
@_bounds_option("x", "m")
@_bounds_option("y", "m")
@_bounds_option("z", "m")
@_bounds_option("yaw", "rad")
@click.option("--steps", nargs=4, type=NumberType(1, 1000), metavar="X Y Z YAW", default=STEPS,
              show_default=True, help="Values tried between the bounds.")  # fmt: skip
@click.option("--pose", "stated", multiple=True, metavar="X,Y,Z,ROLL,PITCH,YAW",
              help="Pose of the tool frame in the world to reach, m and rad; may be repeated.")  # fmt: skip
@tool_state_option
@click.option("--count", type=NumberType(1, 100), default=5, show_default=True, help="Base poses to show.")
@click.option("--poses", type=NumberType(1, 10000), default=40, show_default=True,
              help="Tool poses of each place by which the best are judged.")  # fmt: skip
@seed_option
@json_option
def command(
    cell_name: str, arm: str | None, standing: tuple[str, ...],
    x: Bounds | None, y: Bounds | None, z: Bounds | None, yaw: Bounds | None,
    steps: tuple[int, int, int, int], stated: tuple[str, ...], tool_state: str | None, count: int,
    poses: int, seed: int, as_json: bool,
) -> None:  # fmt: skip
    """Rank base poses of the robot by the share of tool poses that it reaches from them.

    Tool poses are sampled all over every place of the cell, or stated with --pose. One is reached if inverse
    kinematics has a solution, at any quarter turn about the tool's own axis, within limits and without a
    collision. Base poses at which the base would collide with something that it does not touch now are left
    out.

    \b
    Example:
      apc suggest-mount --x -2.0 -1.5 --steps 6 1 1 1
    """
    from pickcli.reachability.mount_ranking import MountRanking, MountSettings
    from pickcli.reachability.tool_pose_sampling import poses_by_place

    cell = open_cell(cell_name, ArmRequest(arm, standing))
    state = named_state(cell, tool_state)
    grid = _grid(cell, {"x": x, "y": y, "z": z, "yaw": yaw}, steps)
    targets = {text: _pose(text)[None] for text in stated} or poses_by_place(cell, state, poses, seed)
    ranking = MountRanking(cell, targets, state, MountSettings(n_poses=poses, seed=seed))
    now = ranking.judged(cell.robot.T_world_base, poses)
    with stage("ranking"), progress("judging base poses") as report:
        found = ranking.suggest(grid, count, report)
    if as_json:
        request = {"cell_fingerprint": cell.fingerprint, "tool_state": state.name, "poses": poses}
        ranked = {"now": _values(now), "suggestions": [_values(each) for each in found]}
        emit_json({**request, "seed": seed, **ranked, "yaml": _line(found[0])})
    else:
        adopt = ["best base pose, for robot in the cell file:", _line(found[0])]
        click.echo("\n".join([*_table(now, found), *adopt]))


def _grid(cell: Cell, bounds: dict[str, Bounds | None], steps: Sequence[int]) -> MountGrid:
    """Return the base poses to try. Raises InputError for reversed bounds, and for too many poses."""
    from pickcli.errors import InputError
    from pickcli.geometry import to_rpy
    from pickcli.reachability.mount_ranking import AXES, MountGrid

    T = cell.robot.T_world_base
    now = dict(zip(AXES, (*T[:3, 3].tolist(), float(to_rpy(T[:3, :3])[2])), strict=True))
    chosen = {}
    for axis in AXES:
        low, high = bounds[axis] or (now[axis] - HALF_WIDTHS[axis], now[axis] + HALF_WIDTHS[axis])
        if not -FARTHEST <= low <= high <= FARTHEST:
            fault = f"expected two numbers within {FARTHEST:g} of 0, the lower first"
            raise InputError(f"--{axis}: {fault}, got {low:g} {high:g}")
        if axis == "yaw" and max(-low, high) > FULL_TURN:
            raise InputError(f"--yaw: expected angles within {FULL_TURN} rad, got {low:g} {high:g}; {IN_RAD}")
        chosen[axis] = (low, high)
    if prod(steps) > MOST_POSES:
        raise InputError(f"--steps: {prod(steps)} base poses; at most {MOST_POSES} are tried at once")
    return MountGrid(chosen, dict(zip(AXES, steps, strict=True)))


def _pose(text: str) -> Array:
    """Parse a pose of the tool frame (4, 4). Raises InputError for anything else."""
    import numpy as np

    from pickcli.errors import InputError
    from pickcli.geometry import pose, rotation_rpy

    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 6 or not np.isfinite(numbers).all():
        raise InputError(f"--pose: expected x,y,z,roll,pitch,yaw in m and rad, got {text!r}")
    if max(map(abs, numbers[3:])) > FULL_TURN:
        raise InputError(f"--pose: expected angles within {FULL_TURN} rad, got {text!r}; {IN_RAD}")
    return pose(numbers[:3], R=rotation_rpy(*numbers[3:]))


def _table(now: RankedMount, found: Sequence[RankedMount]) -> list[str]:
    places = list(now.shares)
    rows = [_row("now", now), *(_row(str(i), each) for i, each in enumerate(found, start=1))]
    return table_lines(("", "x y z m, yaw rad", "mean", *places), rows)


def _row(name: str, each: RankedMount) -> list[str]:
    xyz, rpy = _figures(each)
    stands = " ".join(f"{value:6.3f}" for value in (*xyz, rpy[2]))
    return [name, stands, f"{each.share:.0%}", *(f"{share:.0%}" for share in each.shares.values())]


def _values(each: RankedMount) -> dict[str, Any]:
    xyz, rpy = _figures(each)
    return {"T_world_base": {"xyz": xyz, "rpy": rpy}, "share": each.share, "shares": dict(each.shares)}


def _line(best: RankedMount) -> str:
    """Format the line of a cell file."""
    from pickcli.reachability.mount_ranking import DECIMALS

    xyz, rpy = (", ".join(f"{value + 0.0:.{DECIMALS}f}" for value in values) for values in _figures(best))
    return f"  T_world_base: {{xyz: [{xyz}], rpy: [{rpy}]}}"


def _figures(each: RankedMount) -> tuple[list[float], list[float]]:
    """Return position in m and roll, pitch, yaw in rad, rounded as in a cell file."""
    from pickcli.geometry import to_rpy
    from pickcli.reachability.mount_ranking import DECIMALS

    T = each.T_world_base
    return T[:3, 3].round(DECIMALS).tolist(), to_rpy(T[:3, :3]).round(DECIMALS).tolist()
