"""What nobody recognised may lie or lean on what it touches."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.scene.unknown_space import UnknownSpace
from pickcli.statics.unrecognised import REACH, unrecognised_at
from support.bin_piles import BIN, EXACT, NOISY, at, shaped

SIZE = np.array([0.06, 0.08, 0.04])
THING = np.array([0.02, 0.03, 0.01])


def block(cell: Cell, noise: PoseNoise, *middles: tuple[float, float, float]) -> Scene:
    """A block on the floor of a bin, and boxes so many m from its middle along its axes."""
    placed = at(cell, "block", shaped(cell, tuple(SIZE)), 0.25, 0.0, 0.02)
    about = np.array([[p - THING / 2, p + THING / 2] for p in np.array(middles)])
    space = UnknownSpace(BIN, placed.T_world_item, np.zeros((0, 2, 3)), about)
    return Scene(cell, cell.T_world_pod, (placed,), noise, unknown=(space,))


@pytest.mark.parametrize("noise", [EXACT, NOISY])
@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_it_touches_up_to_the_error_of_the_pose(cell: Cell, noise: PoseNoise, axis: int, side: float) -> None:
    """On the item, at each of its sides, and below it."""
    for beyond, is_told in ((-1e-4, True), (1e-4, False)):
        placed = block(cell, noise, (0.0, 0.0, 0.0)).find("block")
        off = (SIZE + THING)[axis] / 2 + REACH + noise.bound(placed.item) + beyond
        middle = tuple((side * off * np.eye(3)[axis]).tolist())
        assert bool(unrecognised_at(block(cell, noise, middle), "block")) is is_told


def test_the_nearest_is_told_first(cell: Cell) -> None:
    scene = block(cell, EXACT, (0.0, 0.0, 0.0256), (0.0, 0.02, 0.0251), (0.0, 0.0, 0.2))
    assert unrecognised_at(scene, "block") == (f"unrecognised_{BIN}_1", f"unrecognised_{BIN}_0")


def test_what_is_in_another_place_does_not_count(cell: Cell) -> None:
    scene = block(cell, EXACT, (0.0, 0.0, 0.0))
    assert unrecognised_at(scene, "block")
    other = "bin_A" if BIN != "bin_A" else "bin_B"
    assert unrecognised_at(replace(scene, unknown=(replace(scene.unknown[0], place=other),)), "block") == ()
