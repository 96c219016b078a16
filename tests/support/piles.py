"""Small piles in one bin, at rest: things that lie on each other, lean on each other, or could roll."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import product

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.shapes import Body
from pickcli.errors import Reason
from pickcli.geometry import Array, pose
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.seeds import derived_rng
from pickcli.simulation.engine import Engine
from pickcli.simulation.places import bounds
from pickcli.simulation.settle import settle

BIN = "bin_E"
FLAT = (
    "i_am_a_bunny_book",
    "jane_eyre_dvd",
    "staples_index_cards",
    "scotch_bubble_mailer",
    "dove_beauty_bar",
)
BOXES = ("crayola_24_ct", "kleenex_tissue_box", "expo_dry_erase_board_eraser", "cloud_b_plush_bear", *FLAT)
LIGHT = ("kyjen_squeakin_eggs_plush_puppies", "cloud_b_plush_bear", "staples_index_cards", "dove_beauty_bar")
ROUND = ("rawlings_baseball", "dasani_water_bottle", "up_glucose_bottle", "folgers_classic_roast_coffee")
PATTERNS = ("on", "bridge", "leaning", "rolling", "heap", "counterweight", "see-saw")
GREY = (0.5, 0.5, 0.5, 1.0)
REST = 0.03  # s in which what was settled elsewhere settles here
NEAR = 0.2  # m
WATCHED = 1.0  # s after something is gone


def pile(cell: Cell, pattern: str, seed: int) -> Scene | None:
    """A pile of a kind at rest in ``BIN``; None where the things drawn find no rest."""
    rng = derived_rng("pile", pattern, seed)
    placed = settle(empty(cell), tuple(_named(cell, _DRAWN[pattern](cell, rng))))
    return None if isinstance(placed, Reason) else replace(empty(cell), items=placed)


def empty(cell: Cell) -> Scene:
    return Scene(cell, cell.T_world_pod, (), PoseNoise())


def moved_without(scene: Scene, *gone: str) -> dict[str, float]:
    """How far in m any corner of every other item is from where it was, a while after some have vanished."""
    engine = Engine(1e-3)
    for body in _boards_around(scene):
        engine.add_static(body, scene.T_world_pod, GREY)
    for placed in scene.items:
        engine.add_item(placed.id, placed.item, placed.T_world_item, GREY)
    for _ in range(round(REST / 1e-3)):
        engine.step()
    before = {placed.id: engine.pose(placed.id) for placed in scene.items if placed.id not in gone}
    for name in gone:
        engine.remove(name)
    for _ in range(round(WATCHED / 1e-3)):
        engine.step()
    moved = {}
    for name, T in before.items():
        corners = np.array(list(product((-0.5, 0.5), repeat=3))) * scene.find(name).item.shape.extents
        shift = engine.pose(name) - T
        moved[name] = float(np.linalg.norm(corners @ shift[:3, :3].T + shift[:3, 3], axis=1).max())
    engine.close()
    return moved


def _boards_around(scene: Scene) -> Iterable[Body]:
    """What of the pod the items can get to: it is within ``NEAR`` of one of them along every axis."""
    spans = [bounds(placed.item.shape, placed.T_world_item) for placed in scene.items]
    low, high = np.min([low for low, _ in spans], axis=0), np.max([high for _, high in spans], axis=0)
    for body in scene.cell.pod.bodies:
        lowest, highest = bounds(body.shape, scene.T_world_pod @ body.T_parent_shape)
        if np.all(lowest <= high + NEAR) and np.all(low - NEAR <= highest):
            yield body


def _named(cell: Cell, drawn: Iterable[tuple[str, Array]]) -> Iterable[PlacedItem]:
    """Items (name, pose in the bin's frame) with ids of their own."""
    T_bin = cell.T_world_place(cell.pod.bins[BIN])
    for k, (name, T) in enumerate(drawn):
        yield PlacedItem(f"{name}#{k + 1}", cell.item(name), BIN, T_bin @ T)


def _at(cell: Cell, name: str, x: float, y: float, z: float, rpy: tuple[float, float, float]) -> Array:
    """A pose whose lowest point is z over the back part of the floor."""
    R = pose(rpy=rpy)[:3, :3]
    low = float(cell.item(name).shape.reach(R)[2])
    return pose([x, y, cell.pod.bins[BIN].room.floor_back + z + low], R=R)


def _height(cell: Cell, name: str) -> float:
    return float(cell.item(name).shape.extents[2])


def _on(cell: Cell, rng: np.random.Generator) -> Iterable[tuple[str, Array]]:
    """Two or three boxes, each somewhere on the one below."""
    z = 0.002
    for name in rng.choice(BOXES, rng.integers(2, 4), replace=False).tolist():
        x, y = 0.25 + rng.uniform(-0.04, 0.04), rng.uniform(-0.03, 0.03)
        yield name, _at(cell, name, x, y, z, (0.0, 0.0, rng.uniform(-1.6, 1.6)))
        z += _height(cell, name) + 0.002


def _bridge(cell: Cell, rng: np.random.Generator) -> Iterable[tuple[str, Array]]:
    """A flat thing over two of the same height, and at times one on top of it."""
    pier = str(rng.choice(("dove_beauty_bar", "staples_index_cards", "crayola_24_ct")))
    apart = rng.uniform(0.04, 0.075)
    for side in (-1, 1):
        yield pier, _at(cell, pier, 0.27, side * apart, 0.002, (0.0, 0.0, np.pi / 2))
    z = _height(cell, pier) + 0.004
    plank = str(rng.choice(("i_am_a_bunny_book", "jane_eyre_dvd", "scotch_bubble_mailer")))
    yield plank, _at(cell, plank, 0.27, rng.uniform(-0.03, 0.03), z, (0.0, 0.0, np.pi / 2))
    if rng.random() < 0.5:
        bar = "expo_dry_erase_board_eraser"
        yield bar, _at(cell, bar, 0.27, rng.uniform(-0.06, 0.06), z + 0.03, (0.0, 0.0, rng.uniform(-1, 1)))


def _leaning(cell: Cell, rng: np.random.Generator) -> Iterable[tuple[str, Array]]:
    """Something thin that falls against something that stands."""
    block = str(rng.choice(("kleenex_tissue_box", "folgers_classic_roast_coffee", "dasani_water_bottle")))
    yield block, _at(cell, block, 0.28, 0.0, 0.002, (0.0, 0.0, 0.0))
    thin = str(rng.choice(("jane_eyre_dvd", "i_am_a_bunny_book", "staples_index_cards")))
    reach = float(cell.item(block).shape.extents[1]) / 2
    y = reach + rng.uniform(0.01, 0.05)
    yield thin, _at(cell, thin, 0.28, y, 0.004, (np.pi / 2 + rng.uniform(0.1, 0.4), 0.0, 0.0))


def _rolling(cell: Cell, rng: np.random.Generator) -> Iterable[tuple[str, Array]]:
    """Something round on the sloping front of the floor, before something that keeps it, or behind it."""
    ball = str(rng.choice(ROUND))
    block = str(rng.choice(("crayola_24_ct", "dove_beauty_bar", "cloud_b_plush_bear")))
    x = rng.uniform(0.22, 0.32)
    yield block, _at(cell, block, x, 0.0, 0.002, (0.0, 0.0, rng.choice((0.0, np.pi / 2))))
    lying = (np.pi / 2, 0.0, 0.0) if rng.random() < 0.8 else (0.0, np.pi / 2, 0.0)
    half = float(cell.item(block).shape.extents[:2].max()) / 2
    before = half + float(cell.item(ball).shape.size[0]) + 0.01
    yield ball, _at(cell, ball, x - before, rng.uniform(-0.02, 0.02), 0.02, lying)


def _heap(cell: Cell, rng: np.random.Generator) -> Iterable[tuple[str, Array]]:
    """Anything, dropped one after the other."""
    z = 0.002
    for name in rng.choice((*BOXES, *ROUND), rng.integers(3, 6), replace=False).tolist():
        x, y = 0.24 + rng.uniform(-0.08, 0.08), rng.uniform(-0.05, 0.05)
        rpy = (rng.choice((0.0, np.pi / 2)), 0.0, rng.uniform(-1.6, 1.6))
        yield name, _at(cell, name, x, y, z, rpy)
        z += 2 * float(cell.item(name).shape.reach(pose(rpy=rpy)[:3, :3])[2]) + 0.004


def _counterweight(cell: Cell, rng: np.random.Generator) -> Iterable[tuple[str, Array]]:
    """A flat thing with its middle beyond the edge of what it lies on, and something that keeps it there."""
    pier = str(rng.choice(("dove_beauty_bar", "scotch_duct_tape", "crayola_24_ct")))
    flat = str(rng.choice(("i_am_a_bunny_book", "jane_eyre_dvd")))
    weight = str(rng.choice(("staples_index_cards", "elmers_washable_no_run_school_glue", "dove_beauty_bar")))
    edge = float(cell.item(pier).shape.extents[0]) / 2
    yield pier, _at(cell, pier, 0.3, 0.0, 0.001, (0.0, 0.0, 0.0))
    z = _height(cell, pier) + 0.002
    yield flat, _at(cell, flat, 0.3 - edge - rng.uniform(-0.01, 0.02), 0.0, z, (0.0, 0.0, 0.0))
    z += _height(cell, flat) + 0.001
    yield weight, _at(cell, weight, 0.3 + rng.uniform(-0.02, 0.02), 0.0, z, (0.0, 0.0, np.pi / 2))


def _seesaw(cell: Cell, rng: np.random.Generator) -> Iterable[tuple[str, Array]]:
    """A flat thing across something round that lies, and one to three things on it."""
    roll = str(rng.choice(("kleenex_paper_towels", "dasani_water_bottle", "folgers_classic_roast_coffee")))
    flat = str(rng.choice(("cherokee_easy_tee_shirt", "i_am_a_bunny_book", "scotch_bubble_mailer")))
    yield roll, _at(cell, roll, 0.25, 0.0, 0.001, (0.0, np.pi / 2, 0.0))
    z = 2 * float(cell.item(roll).shape.size[0]) + 0.002
    yield flat, _at(cell, flat, 0.25, rng.uniform(-0.03, 0.03), z, (0.0, 0.0, rng.uniform(-0.2, 0.2)))
    z += _height(cell, flat) + 0.002
    for name in rng.choice(LIGHT, rng.integers(1, 4), replace=False).tolist():
        x, y = 0.25 + rng.uniform(-0.06, 0.06), rng.uniform(-0.07, 0.07)
        yield name, _at(cell, name, x, y, z, (0.0, 0.0, rng.uniform(-1.6, 1.6)))
        z += _height(cell, name) + 0.002


_DRAWN = {
    "on": _on,
    "bridge": _bridge,
    "leaning": _leaning,
    "rolling": _rolling,
    "heap": _heap,
    "counterweight": _counterweight,
    "see-saw": _seesaw,
}
