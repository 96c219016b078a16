"""What only slumps between the walls of a box when an item is taken out of it, and what keeps it in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import pose
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.statics.supports import HEAVIEST_SLUMP, Supports, supports_of

CRATES = load_cell("ur5e_crates")
CRATE = "crate_left"
RIM = 0.117  # m over the crate's floor


def at(
    name: str, size: tuple[float, ...], xyz: tuple[float, ...], pitch: float = 0.0, place: str = CRATE
) -> PlacedItem:
    """A box of any size with its middle there in the place's frame, m."""
    item = replace(CRATES.item("crayola_24_ct"), shape=Shape(ShapeKind.BOX, size))
    T = CRATES.T_world_place(CRATES.places[place]) @ pose(xyz, rpy=(0.0, pitch, 0.0))
    return PlacedItem(name, item, place, T)


def of(*items: PlacedItem, noise: float = 0.0) -> Supports:
    return supports_of(Scene(CRATES, CRATES.T_world_pod, items, PoseNoise(noise, 0.0)))


def seesaw(pier: float, place: str = CRATE, x: float = 0.0) -> tuple[PlacedItem, ...]:
    """A plank with its middle past the edge of a pier that is so high (m), kept there by a block on it."""
    return (
        at("pier", (0.1, 0.1, pier), (x, 0.0, pier / 2), place=place),
        at("plank", (0.2, 0.1, 0.02), (x - 0.06, 0.0, pier + 0.01), place=place),
        at("block", (0.05, 0.05, 0.05), (x + 0.02, 0.0, pier + 0.045), place=place),
    )


def test_what_is_under_an_item_and_tips_without_it_only_slumps_in_a_box() -> None:
    supports = of(*seesaw(0.05))
    assert supports.falling("block") == supports.slumping("block") == ("plank",)
    assert supports.blocking("block") == ()


def test_what_leans_on_an_item_only_slumps_in_a_box() -> None:
    lean, thin, tall = 0.7, 0.012, 0.1
    x = 0.04 + np.sin(lean) * tall / 2 + np.cos(lean) * thin / 2
    z = np.cos(lean) * tall / 2 + np.sin(lean) * thin / 2
    supports = of(
        at("block", (0.08, 0.1, 0.09), (0.0, 0.0, 0.045)), at("card", (thin, 0.1, tall), (x, 0, z), -lean)
    )
    assert supports.falling("block") == supports.slumping("block") == ("card",)


def test_what_lies_on_an_item_keeps_it_in_and_all_that_lies_on_that() -> None:
    supports = of(*seesaw(0.05))
    assert supports.slumping("plank") == () and supports.blocking("plank") == ("block",)
    assert supports.blocking("pier") == supports.falling("pier") == ("block", "plank")


@pytest.mark.parametrize(("over", "slumps"), [(-0.002, True), (0.002, False)])
@pytest.mark.parametrize("noise", [0.0, 0.001])
def test_what_may_get_over_the_rim_does_not_slump(over: float, slumps: bool, noise: float) -> None:
    """Its centre may be half of its thickness over the rim, as its pose may be off."""
    supports = of(*seesaw(RIM + over - noise), noise=noise)
    assert "plank" in supports.falling("block")
    assert ("plank" in supports.slumping("block")) is slumps


def test_the_barrier_is_as_high_as_a_ball_inside_of_the_item() -> None:
    """What is straight above a rim that does not enter it has its centre at least that radius higher."""
    ways = np.random.default_rng(0).normal(size=(200, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    for name, _ in sorted(CRATES.items):
        placed = PlacedItem(name, CRATES.item(name), CRATE, CRATES.T_world_place(CRATES.places[CRATE]))
        above = of(placed).barrier(0.0, name)
        assert above > 0.0 and placed.item.shape.contains(0.999 * above * ways).all()


def test_what_is_heavy_does_not_slump() -> None:
    """It could throw out what it falls on."""
    pier, plank, block = seesaw(0.05)
    heavy = replace(plank, item=replace(plank.item, mass=HEAVIEST_SLUMP))
    supports = of(pier, heavy, block)
    assert supports.falling("block") == supports.blocking("block") == ("plank",)


def test_on_a_shelf_nothing_slumps() -> None:
    supports = of(*seesaw(0.05, "shelf_1_1", 0.17))
    assert supports.falling("block") == supports.blocking("block") == ("plank",)
    assert supports.slumping("block") == ()


@given(st.floats(0.02, 0.12), st.floats(0.0, 0.003))
def test_what_falls_either_slumps_or_blocks(pier: float, noise: float) -> None:
    supports = of(*seesaw(pier), noise=noise)
    for name in ("pier", "plank", "block"):
        both = (*supports.blocking(name), *supports.slumping(name))
        assert sorted(both) == sorted(supports.falling(name))
