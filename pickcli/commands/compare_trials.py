"""``apc compare-trials``: a comparison of two Monte Carlo runs, with a significance test."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from pickcli.commands.command import Command, emit_json
from pickcli.commands.option_types import PATH
from pickcli.commands.options import json_option
from pickcli.commands.table import table_lines
from pickcli.errors import InputError

if TYPE_CHECKING:
    from pickcli.monte_carlo.trial_comparison import FigureComparison

HEAD = ("mean of a trial", "A", "B", "B - A", "95 %", "p")


@click.command("compare-trials", cls=Command)
@click.argument("first", metavar="A", type=PATH)
@click.argument("second", metavar="B", type=PATH)
@json_option
def command(first: Path, second: Path, as_json: bool) -> None:
    """Compare two folders of trials, and test whether the difference is more than chance.

    Trials are paired by order and seed, and the share of the points decides, of commissions their success:
    an exact sign-flip test of the differences, with the interval that belongs to it.

    \b
    Example:
      apc compare-trials runs/before runs/after
    """
    from pickcli.commission.commission_comparison import COMMISSIONS
    from pickcli.commission.commission_trials import are_commissions, read_commission_trials
    from pickcli.monte_carlo.trial_comparison import TrialComparison
    from pickcli.monte_carlo.trials_folder import read_trials, require_folder

    for folder in (first, second):
        require_folder(folder)
    if first.samefile(second):
        raise InputError(f"{first} and {second} are one folder; name two different ones")
    names, kinds = (str(first), str(second)), [are_commissions(each) for each in (first, second)]
    if kinds[0] != kinds[1]:
        ours, other = names if kinds[0] else reversed(names)
        raise InputError(
            f"{ours} has trials of commissions and {other} others, which have other figures; compare two "
            "runs of one kind"
        )
    if kinds[0]:
        records = read_commission_trials(first), read_commission_trials(second)
        found = TrialComparison.of(names, *records, COMMISSIONS)
    else:
        found = TrialComparison.of(names, read_trials(first), read_trials(second))
    if as_json:
        emit_json(found.values())
        return
    click.echo(found.sentence)
    click.echo("\n".join(table_lines(HEAD, [_row(each) for each in found.figures])))
    for name, n in zip(found.names, found.n_unpaired, strict=True):
        if n:
            click.echo(f"only in {name}: {n} trials, which are left out")


def _row(each: FigureComparison) -> list[str]:
    test = each.test
    return [
        each.name.replace("_", " "), f"{each.mean_a:.3f}", f"{each.mean_b:.3f}", f"{test.mean:+.3f}",
        f"{test.low:+.3f} to {test.high:+.3f}", f"{test.p_value:.2g}",
    ]  # fmt: skip
