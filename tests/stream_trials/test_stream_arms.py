"""Several arms at one belt: which one acts, where it brings items to, and how it is parked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.errors import InputError
from pickcli.planning.start_state import Start
from pickcli.scene.scene import TOTE
from pickcli.stream_trials.stream_arms import StreamArms, destination_of
from support import belt_picks
from support.pr2_picks import context, stream


def both() -> StreamArms:
    return StreamArms([context("left"), context("right")])


def test_each_arm_brings_items_to_the_nearest_box_and_to_the_tote_if_there_is_one() -> None:
    assert [destination_of(context(arm).cell) for arm in ("left", "right")] == ["bin_left", "bin_right"]
    assert destination_of(belt_picks.cell()) == TOTE
    assert both().destinations == {"bin_left", "bin_right"}


def test_a_cell_without_a_tote_or_a_box_is_refused() -> None:
    cell = context().cell
    belts = tuple(each for each in cell.own_carriers if each.conveyor is not None)
    with pytest.raises(
        InputError, match=r"cell\.yaml: has neither a tote nor a box .*; add a place of kind box"
    ):
        destination_of(replace(cell, own_carriers=belts))


def test_an_arm_that_stands_parked_has_no_way_to_go() -> None:
    assert both().parking(stream(), 0.0, 0) is None


def test_an_arm_is_parked_clear_of_what_the_belt_may_bring_and_another_one_acts() -> None:
    arms = both()
    over_bin = context().cell.configurations["bin_left"]
    arms.start = Start(over_bin.q, over_bin.tool_state)
    parking = arms.parking(stream(), 1.0, 0)
    assert parking is not None and parking.certificate is not None
    off = parking.trajectory.positions[-1] - context().cell.home.q
    assert off - 2.0 * np.pi * np.round(off / (2.0 * np.pi)) == pytest.approx(0.0, abs=1e-9)  # whole turns
    arms.let_act(arms.others[0])
    assert arms.context.cell.arm == "right"
    assert np.array_equal(arms.start.q, context("right").cell.home.q)
