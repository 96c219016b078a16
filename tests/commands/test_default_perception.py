"""How the robot sees in trials if nothing is stated: in pick orders by cameras that see into all bins."""

from __future__ import annotations

import click
import pytest
from click.testing import CliRunner

from pickcli.cell.cell_file import load_workcell
from pickcli.commands.options.trial_options import TrialOptions, trial_options
from pickcli.errors import InputError
from pickcli.simulation.reality import DEFAULT
from pickcli.trial.make_order import make_order
from pickcli.trial.order import OrderKind


def told(words: tuple[str, ...], *kinds: OrderKind) -> str:
    orders = [make_order(kind, 2016, seed) for seed, kind in enumerate(kinds)]

    @click.command()
    @trial_options
    def tell(options: TrialOptions) -> None:
        cell = load_workcell(options.cell_name, options.items_path).preferred
        conditions = options.conditions(DEFAULT, cell, orders)
        click.echo(f"{conditions.perception}, prints by {conditions.sift}")

    return CliRunner().invoke(tell, words, catch_exceptions=False).output.strip()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "camera, prints by auto"),
        (("--sift", "none"), "camera, prints by none"),
        (("--perception", "truth"), "truth, prints by none"),
        (("--pose-noise", "1,0.5"), "noise, prints by none"),
        (("--cell", "ur5e_crates"), "noise, prints by none"),
        (("--cell", "apc2016_kth_picking"), "noise, prints by none"),
        (("--cell", "apc2016_delft_pinch"), "noise, prints by none"),
        (("--cell", "apc2016_delft", "--perception", "camera"), "camera, prints by auto"),
    ],
)
def test_cameras_are_looked_by_where_they_see_into_all_bins(words: tuple[str, ...], said: str) -> None:
    assert told(words, OrderKind.PICK, OrderKind.PICK) == said


def test_cameras_that_do_not_see_into_the_bins_are_refused_before_any_work() -> None:
    with pytest.raises(InputError, match="no depth camera of apc2016_kth_picking sees half of its room"):
        told(("--cell", "apc2016_kth_picking", "--perception", "camera"), OrderKind.PICK)


def test_what_is_stowed_is_seen_with_bounded_errors_unless_it_is_stated() -> None:
    assert told((), OrderKind.PICK, OrderKind.STOW) == "noise, prints by none"
    assert told(("--perception", "camera"), OrderKind.STOW) == "camera, prints by auto"
