"""How the robot sees in trials of orders if nothing is stated: by cameras that see into all bins."""

from __future__ import annotations

import click
import pytest
from click.testing import CliRunner

from pickcli.cell.cell_file import load_workcell
from pickcli.commands.trial_options import TrialOptions, trial_options
from pickcli.simulation.reality import DEFAULT


@click.command()
@trial_options
def told(options: TrialOptions) -> None:
    cell = load_workcell(options.cell_name, options.items_path).preferred
    conditions = options.conditions(DEFAULT, cell)
    click.echo(f"{conditions.perception}, prints by {conditions.sift}")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ((), "camera, prints by all-views"),
        (("--sift", "none"), "camera, prints by None"),
        (("--perception", "truth"), "truth, prints by None"),
        (("--pose-noise", "1,0.5"), "noise, prints by None"),
        (("--cell", "ur5e_crates"), "noise, prints by None"),
        (("--cell", "apc2016_kth_picking"), "noise, prints by None"),
        (("--cell", "apc2016_delft_pinch"), "noise, prints by None"),
        (("--cell", "ur5e_crates", "--perception", "camera"), "camera, prints by all-views"),
    ],
)
def test_cameras_are_looked_by_where_they_see_into_all_bins(words: tuple[str, ...], said: str) -> None:
    answer = CliRunner().invoke(told, words, catch_exceptions=False)
    assert answer.output == f"{said}\n"
