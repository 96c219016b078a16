"""``apc compare-trials``: a comparison of two Monte Carlo runs, with a significance test."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.options.common_options import json_option
from pickcli.commands.options.option_types import PATH
from pickcli.commands.output.table import table_lines
from pickcli.errors import InputError

if TYPE_CHECKING:
    from pickcli.monte_carlo.trial_comparison import FigureComparison
    from pickcli.monte_carlo.trials_kind import TrialsKind

HEAD = ("mean of a trial", "A", "B", "B - A", "95 %", "p")


@click.command("compare-trials", cls=Command)
@click.argument("first", metavar="A", type=PATH)
@click.argument("second", metavar="B", type=PATH)
@json_option
def command(first: Path, second: Path, as_json: bool) -> None:
    """Compare two folders of trials, and test whether the difference is more than chance.

    Trials are paired by order and seed, and the share of the points decides, of commissions their success,
    of streams the share delivered of what came: an exact sign-flip test of the differences, with the interval
    that belongs to it.

    \b
    Example:
      apc compare-trials runs/before runs/after
    """
    from pickcli.commission import commission_trials
    from pickcli.commission.commission_comparison import COMMISSIONS
    from pickcli.monte_carlo.trial_comparison import ORDERS, TrialComparison
    from pickcli.monte_carlo.trials_folder import read_trials, require_folder
    from pickcli.stream_trials import stream_trials
    from pickcli.stream_trials.stream_comparison import STREAMS

    for folder in (first, second):
        require_folder(folder)
    if first.samefile(second):
        raise InputError(f"{first} and {second} are one folder; name two different ones")
    names, read, compared = (str(first), str(second)), read_trials, ORDERS
    for kind, figures in ((commission_trials.TRIALS, COMMISSIONS), (stream_trials.TRIALS, STREAMS)):
        if _are_alike(kind, first, second):
            read, compared = kind.read, figures
    found = TrialComparison.of(names, read(first), read(second), compared)
    if as_json:
        emit_json(found.values())
        return
    click.echo(found.sentence)
    click.echo("\n".join(table_lines(HEAD, [_row(each) for each in found.figures])))
    for name, n in zip(found.names, found.n_unpaired, strict=True):
        if n:
            click.echo(f"only in {name}: {n} trials, which are left out")


def _are_alike(kind: TrialsKind, first: Path, second: Path) -> bool:
    """Whether both folders have trials of a kind; False if none has. Raises InputError if only one has."""
    ours = [folder for folder in (first, second) if kind.is_of(folder)]
    if len(ours) == 1:
        other = second if ours[0] is first else first
        raise InputError(
            f"{ours[0]} has trials of {kind.played} and {other} others, which have other figures; compare "
            "two runs of one kind"
        )
    return bool(ours)


def _row(each: FigureComparison) -> list[str]:
    test = each.test
    return [
        each.name.replace("_", " "), f"{each.mean_a:.3f}", f"{each.mean_b:.3f}", f"{test.mean:+.3f}",
        f"{test.low:+.3f} to {test.high:+.3f}", f"{test.p_value:.2g}",
    ]  # fmt: skip
