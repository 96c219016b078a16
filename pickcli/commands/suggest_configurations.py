"""``apc suggest-configurations``: configurations in which the arm can wait in front of a bin."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.logs import stage
from pickcli.commands.options.arm_options import ArmRequest, arm_option, open_cell, standing_option
from pickcli.commands.options.common_options import (
    cell_option,
    json_option,
    overwrite_option,
    refuse_output,
    seed_option,
)
from pickcli.commands.options.configuration_option import named_state, tool_state_option
from pickcli.commands.options.option_types import PATH, NumberType
from pickcli.commands.output.progress_bar import progress
from pickcli.commands.output.table import table_lines

if TYPE_CHECKING:
    from pickcli.reachability.ranked_configuration import RankedConfiguration

HEAD = (
    "",
    "reach",
    "manipulability",
    "margin",
    "clear mm",
    "from home s",
    "tip x y z in the place's frame, m",
)


@click.command("suggest-configurations", cls=Command)
@cell_option
@arm_option()
@standing_option
@click.option("--bin", "bin_name", required=True, metavar="PLACE", help="Place in front of which to wait.")
@tool_state_option
@click.option(
    "--count", type=NumberType(1, 100), default=5, show_default=True, help="Configurations to show."
)
@click.option("--poses", type=NumberType(1, 10000), default=100, show_default=True,
              help="Tool poses in the place by which each is judged.")  # fmt: skip
@click.option("--candidates", type=NumberType(1, 10000), default=40, show_default=True,
              help="Configurations to judge: those with the highest manipulability.")  # fmt: skip
@click.option("-o", "--output", type=PATH, metavar="FILE",
              help="Also write the best as an entry of a cell file (YAML).")  # fmt: skip
@overwrite_option
@seed_option
@json_option
def command(
    cell_name: str, arm: str | None, standing: tuple[str, ...], bin_name: str,
    tool_state: str | None, count: int, poses: int, candidates: int,
    output: Path | None, overwrite: bool, seed: int, as_json: bool,
) -> None:  # fmt: skip
    """Rank configurations in front of a bin by what can be reached from them.

    First by the share of poses in the bin that the tool reaches along one straight line, followed without a
    jump and proven free; then by manipulability, rail included (KTH). All keep away from joint limits and
    from everything in the cell. The cell's own configuration is judged as well.

    \b
    Example:
      apc suggest-configurations --bin bin_C -o bin_C.yaml
    """
    from pickcli.cell.configuration_text import configuration_line
    from pickcli.files.atomic_write import write_text
    from pickcli.reachability.configuration_ranking import ConfigurationRanking
    from pickcli.reachability.ranked_configuration import RankingSettings

    if output is not None:
        refuse_output(output, overwrite, cell_name)
    cell = open_cell(cell_name, ArmRequest(arm, standing))
    cell.require_places()
    settings = RankingSettings(n_kept=candidates, n_poses=poses, seed=seed)
    state = named_state(cell, tool_state)
    suggester = ConfigurationRanking(cell, bin_name, state, settings)
    with stage("ranking"), progress("judging configurations") as report:
        found = suggester.suggest(count, report)
    own = cell.configurations.get(bin_name)
    now = None if own is None else suggester.judged(own.q)
    entry = configuration_line(found[0].configuration)
    if output is not None:
        write_text(output, entry, overwrite)
    if as_json:
        request = {
            "cell_fingerprint": cell.fingerprint,
            "bin": bin_name,
            "tool_state": state.name,
            "poses": poses,
        }
        written = {"yaml": entry, "path": None if output is None else str(output)}
        emit_json({**request, "seed": seed, **_summary(now, found), **written})
    else:
        click.echo("\n".join([*_table(now, found), _how_to_adopt(bin_name, entry)]), nl=False)


def _summary(now: RankedConfiguration | None, found: Sequence[RankedConfiguration]) -> dict[str, Any]:
    return {"now": None if now is None else _values(now), "suggestions": [_values(each) for each in found]}


def _table(now: RankedConfiguration | None, found: Sequence[RankedConfiguration]) -> list[str]:
    rows = [] if now is None else [_row("now", now)]
    return table_lines(HEAD, [*rows, *(_row(str(i + 1), each) for i, each in enumerate(found))])


def _how_to_adopt(bin_name: str, entry: str) -> str:
    return f"best configuration, to replace {bin_name} under configurations in the cell file:\n{entry}"


def _values(each: RankedConfiguration) -> dict[str, Any]:
    return {
        "q": each.configuration.q.tolist(), "reach": each.reach, "manipulability": each.manipulability,
        "joint_margin": each.margin, "clearance_m": each.clearance, "from_home_s": each.travel,
        "T_bin_tip": each.T_bin_tip.tolist(),
    }  # fmt: skip


def _row(name: str, each: RankedConfiguration) -> list[str]:
    travel = "-" if each.travel is None else f"{each.travel:.2f}"
    place = " ".join(f"{value:6.3f}" for value in each.T_bin_tip[:3, 3])
    return [name, f"{each.reach:.0%}", f"{each.manipulability:.4f}", f"{each.margin:.1%}",
            f"{1e3 * each.clearance:.0f}", travel, place]  # fmt: skip
