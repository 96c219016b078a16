"""Items that look other than their boxes are found by what their files say, with bounds that allow for it."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.perception.items.item_observation import Support
from pickcli.perception.items.listed_item import ListedItem
from pickcli.perception.items.pose_bound import LARGEST, SURFACE_OFF, bound_of
from pickcli.random_scenes.make_scene import make_scene
from support.filled_bins import looked_at

CONTENTS = ("womens_knit_gloves", "scotch_bubble_mailer", "kleenex_tissue_box")
SURE = Support(900, 900, 880, 2, 3, 0.02, 900.0, 1.2, 1.0, 1e-4, 1e-3, 2e-4)


@pytest.mark.parametrize("seed", [4, 5])
def test_what_deforms_is_found_better_if_its_file_is_believed_and_within_its_bounds(
    cell: Cell, seed: int
) -> None:
    filled = looked_at(make_scene({"bin_E": CONTENTS}, cell, seed), deformed_seed=seed)
    off = []
    for may_deform in (False, True):
        listed = [ListedItem.of(each.id, each.item, may_deform) for each in filled.listed]
        answers = {answer.id: answer for answer in filled.perceived(listed).items}
        off.append(filled.error_of(answers["scotch_bubble_mailer"]).position)
    assert off[1] < 0.5 * off[0] and off[1] < 0.004
    for answer in answers.values():
        assert answer.is_answer, answer.refusal
        assert answer.bound is None or answer.bound.holds(filled.error_of(answer)), answer.id
    assert answers["womens_knit_gloves"].bound is not None
    assert answers["kleenex_tissue_box"].bound is not None


def test_the_search_is_for_the_mean_surface_and_rigid_items_stay_as_they_are(cell: Cell) -> None:
    mailer, box = cell.item("scotch_bubble_mailer"), cell.item("kleenex_tissue_box")
    listed = ListedItem.of("a", mailer, may_deform=True)
    assert listed.deformation == mailer.deformation == 0.006
    np.testing.assert_allclose(mailer.shape.extents - listed.seen_as.shape.extents, 2 * 0.3 * 0.006)
    assert listed.item is mailer
    for other in (ListedItem.of("a", mailer, may_deform=False), ListedItem.of("b", box, may_deform=True)):
        assert other.deformation == 0.0 and other.seen_as is other.item


def test_bounds_are_wider_by_the_deformation_and_none_if_too_wide(cell: Cell) -> None:
    item = cell.item("scotch_bubble_mailer")
    depth_model = cell.cameras["hand"].model.depth
    assert depth_model is not None
    rigid = bound_of(item, SURE, depth_model, 0.9999)
    soft = bound_of(item, SURE, depth_model, 0.9999, 0.004)
    assert rigid is not None and soft is not None
    assert rigid.displacement is not None and soft.displacement is not None
    assert soft.position - rigid.position == pytest.approx(0.004)
    assert soft.displacement - rigid.displacement == pytest.approx(SURFACE_OFF * 0.004)
    assert soft.angle - rigid.angle == pytest.approx(np.arctan(0.004 / 0.145))
    assert bound_of(item, SURE, depth_model, 0.9999, LARGEST.position) is None
    assert bound_of(item, SURE, depth_model, 0.9, 0.004) is None
