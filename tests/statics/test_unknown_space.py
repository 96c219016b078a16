"""Unknown space is an obstacle, but bears nothing: it may be empty."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.scene.unknown_space import UnknownSpace
from pickcli.statics.supports import supports_of
from pickcli.verification.landing_statics import keeps_standing
from pickcli.verification.pile_statics import removal
from support.bin_piles import BIN, EXACT, NOISY, at, shaped

BLOCK = (0.05, 0.1, 0.04)


def bridge(cell: Cell, middle: float, is_known: bool, noise: PoseNoise) -> Scene:
    """A plank from one block to another, or to unknown space of the same size, with its middle at x."""
    one, other = (
        at(cell, name, shaped(cell, BLOCK), x, 0.0, 0.02) for name, x in (("one", 0.25), ("other", 0.37))
    )
    plank = at(cell, "plank", shaped(cell, (0.2, 0.08, 0.02)), middle, 0.0, 0.0501)
    known = Scene(cell, cell.T_world_pod, (one, plank, other), noise)
    if is_known:
        return known
    half = np.array(BLOCK) / 2
    space = UnknownSpace(BIN, other.T_world_item, np.array([[-half, half]]))
    return replace(known, items=(one, plank), unknown=(space,))


@pytest.mark.parametrize("noise", [EXACT, NOISY])
def test_what_needs_unknown_space_to_stay_does_not_stay(cell: Cell, noise: PoseNoise) -> None:
    """By planner and verifier."""
    for is_known in (True, False):
        scene = bridge(cell, 0.33, is_known, noise)
        assert supports_of(scene).balance.stays("plank") is is_known
        assert keeps_standing(scene, "plank") is is_known


def test_what_needs_none_stays(cell: Cell) -> None:
    scene = bridge(cell, 0.25, False, EXACT)
    assert supports_of(scene).balance.stays("plank")
    assert keeps_standing(scene, "plank")


@pytest.mark.parametrize("height", [0.0, 0.003, 0.08])
def test_nothing_rests_on_unknown_space_only(cell: Cell, height: float) -> None:
    """Also not as the nearest below what seems to hang in the air; the floor is."""
    plank = at(cell, "plank", shaped(cell, (0.2, 0.08, 0.02)), 0.3, 0.0, 0.0501 + height)
    half = np.array(BLOCK) / 2
    under = at(cell, "under", shaped(cell, BLOCK), 0.3, 0.0, 0.02)
    space = UnknownSpace(BIN, under.T_world_item, np.array([[-half, half]]))
    scene = Scene(cell, cell.T_world_pod, (plank,), EXACT, unknown=(space,))
    carriers = supports_of(scene).graph.carriers("plank")
    assert carriers and not any(name.startswith("unknown") for name in carriers)


def test_what_rests_on_an_item_beside_unknown_space_falls_without_it(cell: Cell) -> None:
    scene = bridge(cell, 0.26, False, EXACT)
    assert "plank" in supports_of(scene).blocking("one")
    assert "plank" in removal(scene, "one").lifted
    assert "plank" in removal(scene, "one").falling
