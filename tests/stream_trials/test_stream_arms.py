"""Several arms at one belt: which may move, what they keep out of, and where they bring items to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.errors import InputError
from pickcli.scene.scene import TOTE
from pickcli.stream_trials.reserved_motion import ReservedMotion
from pickcli.stream_trials.stream_arms import LATE, StreamArms, destination_of
from support import belt_picks
from support.pr2_picks import arm_pick, context


def both(move_together: bool = True) -> StreamArms:
    return StreamArms([context("left"), context("right")], move_together)


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


def test_arms_that_move_together_are_free_when_they_rest() -> None:
    arms = both()
    left, right = arms.all
    assert arms.free(0.0) == (left, right) and arms.next_free == 0.0
    left.free_at = 4.0
    assert arms.free(3.9) == (right,) and arms.next_free == 0.0
    right.free_at = 6.0
    assert arms.free(3.9) == () and arms.next_free == 4.0 and arms.free(4.0) == (left,)
    assert arms.overlap(5.0, 9.0) == 1.0 and arms.overlap(6.5, 9.0) == 0.0


def test_one_at_a_time_is_free_when_all_rest() -> None:
    arms = both(move_together=False)
    arms.all[0].free_at = 4.0
    assert arms.free(3.9) == () and arms.next_free == 4.0
    assert arms.free(4.0) == arms.all


def test_what_moves_is_kept_out_of_and_nothing_moves_while_an_arm_is_brought_home() -> None:
    arms, pick, other = both(), arm_pick("left"), arm_pick("right")
    left, right = arms.all
    left.reserved = ReservedMotion.planned(left.context.model, pick.plan, pick.scene, 0.0)
    why = arms.why_not_apart(right, other.plan, other.scene, 0.0, LATE)
    assert why is not None and "in the way of the other arm" in str(why)
    assert (
        arms.why_not_apart(right, other.plan, other.scene, pick.plan.trajectory.duration + 1.0, LATE) is None
    )
    right.free_at = 20.0  # it moves until then
    arms.bring_home(left, 10.0)
    assert arms.why_not_apart(right, other.plan, other.scene, 0.0, LATE) is None
    assert arms.free(29.9) == () and arms.free(30.0) == arms.all


@pytest.mark.parametrize(("behind", "is_as_planned"), [(0.02, True), (0.3, False)])
def test_a_motion_that_was_not_in_the_time_of_its_plan_is_kept_out_of_as_it_was(
    behind: float, is_as_planned: bool
) -> None:
    arms, pick = both(), arm_pick("left")
    left, trajectory = arms.all[0], pick.plan.trajectory
    left.reserved = planned = ReservedMotion.planned(left.context.model, pick.plan, pick.scene, 0.0)
    times = np.arange(0.0, trajectory.duration + 0.5, 0.001)
    left.note_measured(list(zip(times.tolist(), trajectory.sample(times - behind), strict=True)), LATE)
    assert left.reserved is (planned if is_as_planned else left.measured)


def test_a_motion_that_stopped_on_its_way_is_kept_out_of_where_it_stopped() -> None:
    arms, pick = both(), arm_pick("left")
    left, trajectory = arms.all[0], pick.plan.trajectory
    left.reserved = ReservedMotion.planned(left.context.model, pick.plan, pick.scene, 0.0)
    times = np.arange(0.0, trajectory.duration / 2, 0.001)
    left.note_measured(list(zip(times.tolist(), trajectory.sample(times), strict=True)), LATE)
    assert left.reserved is left.measured and left.reserved.t_end == times[-1]


def test_arms_that_met_as_they_were_measured_are_told() -> None:
    arms, picks = both(), (arm_pick("left"), arm_pick("right"))
    for arm, pick in zip(arms.all, picks, strict=True):
        arm.reserved = ReservedMotion.planned(arm.context.model, pick.plan, pick.scene, 0.0)
        times = np.arange(0.0, pick.plan.trajectory.duration + 0.1, 0.01)
        arm.note_measured(list(zip(times.tolist(), pick.plan.trajectory.sample(times), strict=True)), LATE)
    why = arms.why_met(arms.all[1], 0.0)
    assert why is not None and "in the way of the other arm" in str(why)


def test_a_single_arm_is_in_nobodys_way() -> None:
    arms, pick = StreamArms([context("left")], move_together=True), arm_pick("left")
    assert arms.why_not_apart(arms.all[0], pick.plan, pick.scene, 0.0, LATE) is None
    assert arms.why_met(arms.all[0], 0.0) is None
