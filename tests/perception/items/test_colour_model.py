"""Labels of colours tell items apart, under any amount of light."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.perception.items.colour_model import (
    LARGEST,
    N_LABELS,
    WEIGHT,
    colour_costs,
    colour_labels,
    item_colours,
    label_shares,
    own_labels,
)


def test_labels_are_of_all_colours() -> None:
    colours = np.random.default_rng(1).uniform(0.0, 255.0, (40, 50, 3))
    labels = colour_labels(colours)
    assert labels.shape == (40, 50)
    assert labels.min() >= 0
    assert labels.max() < N_LABELS
    assert colour_labels(np.array([[0.0, 0.0, 0.0], [255.0, 255.0, 255.0]])).tolist() != [0, 0]


def test_shares_are_a_distribution_and_no_colour_is_impossible(cell: Cell) -> None:
    shares = label_shares(item_colours(cell.item("crayola_24_ct", 2016), 0))
    assert shares.sum() == np.float64(1.0) or abs(shares.sum() - 1.0) < 1e-12
    assert shares.min() > 0.0


def test_colours_speak_for_their_own_item_in_other_prints_and_less_light(cell: Cell) -> None:
    """Also printed otherwise than the model, and with a third of the light."""
    names = ("crayola_24_ct", "kleenex_tissue_box", "woods_extension_cord", "expo_dry_erase_board_eraser")
    items = [cell.item(name, 2016) for name in names]
    costs = colour_costs([label_shares(item_colours(item, 0)) for item in items])
    assert all(np.abs(cost).max() <= WEIGHT * LARGEST for cost in costs)
    for i, item in enumerate(items):
        seen = colour_labels(item_colours(item, 5) * np.sqrt(0.35))
        means = [cost[seen].mean() for cost in costs]
        assert int(np.argmin(means)) == i, (item.name, means)


def seen(colour: tuple[float, ...], light: float) -> np.ndarray:
    """The label of a colour under an amount of light."""
    return colour_labels(np.sqrt(light) * np.array([colour]))


@pytest.mark.parametrize(
    ("own", "other"),
    [
        ((200.0, 30.0, 30.0), (30.0, 30.0, 200.0)),
        ((240.0, 240.0, 240.0), (30.0, 30.0, 30.0)),
        ((30.0, 30.0, 30.0), (240.0, 240.0, 240.0)),
    ],
)
def test_own_labels_are_those_of_a_surface_in_any_light_and_not_of_another(
    own: tuple[float, ...], other: tuple[float, ...]
) -> None:
    labels = own_labels(np.array([own]), has_highlights=False)
    for light in (0.2, 0.5, 1.0):
        assert labels[seen(own, light)].all()
        assert not labels[seen(other, light)].any()


def test_highlights_are_own_labels_of_what_is_shiny() -> None:
    red, lit = np.array([[200.0, 40.0, 40.0]]), np.array([[228.0, 148.0, 148.0]])
    assert own_labels(red, has_highlights=True)[colour_labels(lit)].all()
    assert not own_labels(red, has_highlights=False)[colour_labels(lit)].any()
