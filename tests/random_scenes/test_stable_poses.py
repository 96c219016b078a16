"""Stances: turns of the item, and nothing that would fall over or roll away."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.item import Item
from pickcli.cell.shapes import ShapeKind
from pickcli.random_scenes.stable_poses import stable_poses

ITEMS = sorted(load_cell("apc2016_delft").items.values(), key=lambda item: (item.name, item.year))


@pytest.mark.parametrize("item", ITEMS, ids=lambda item: f"{item.name}-{item.year}")
def test_every_stance_is_a_turn_that_stands_its_height(item: Item) -> None:
    found = stable_poses(item)
    assert sum(share for _, share in found) == pytest.approx(1.0)
    heights = [stance.height for stance, _ in found]
    assert heights == sorted(heights)
    assert heights[0] == pytest.approx(item.shape.extents.min())
    for stance, _ in found:
        R = stance.R_up_item
        np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(R) == pytest.approx(1.0)
        x, y, z = 2 * item.shape.reach(R)
        assert z == pytest.approx(stance.height)
        assert x >= y - 1e-12, "the longer side of the base lies along x"
        assert stance.is_on_edge == (y / z < 0.35)


def by_name(name: str) -> Item:
    return next(item for item in ITEMS if item.name == name and item.year == 2016)


def test_leaflets_and_cloth_do_not_stand_on_an_edge_but_a_dvd_does() -> None:
    for name in ("i_am_a_bunny_book", "womens_knit_gloves", "cherokee_easy_tee_shirt"):
        stances = [stance for stance, _ in stable_poses(by_name(name))]
        assert stances and not any(stance.is_on_edge for stance in stances)
    assert any(stance.is_on_edge for stance, _ in stable_poses(by_name("jane_eyre_dvd")))


def test_round_things_know_that_they_roll() -> None:
    assert [s.can_roll for s, _ in stable_poses(by_name("rawlings_baseball"))] == [True]
    bottle = {round(s.height, 3): s for s, _ in stable_poses(by_name("dasani_water_bottle"))}
    assert bottle[0.067].can_roll and not bottle[0.067].is_level
    assert not bottle[0.195].can_roll and bottle[0.195].is_level
    bowl = by_name("platinum_pets_dog_bowl")
    assert bowl.shape.kind is ShapeKind.CYLINDER
    assert len(stable_poses(bowl)) == 1, "a disc does not stay on its rim"
