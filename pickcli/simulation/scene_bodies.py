"""Bodies of a scene in an engine: what stands firm, and items with their true masses."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pickcli.geometry import Array
from pickcli.scene.scene import Scene
from pickcli.seeds import derived_rng
from pickcli.simulation.colours import STATIC_COLOURS, item_colour
from pickcli.simulation.engine import Engine
from pickcli.simulation.places import bounds
from pickcli.simulation.reality import Reality


def ground_of(scene: Scene) -> tuple[Array, Array]:
    """Lower and upper corner (3,) of the box around all that stands firm, world axes."""
    corners = [bounds(body.shape, T @ body.T_parent_shape) for body, T in scene.standing]
    return np.min([low for low, _ in corners], axis=0), np.max([high for _, high in corners], axis=0)


def is_over(ground: tuple[Array, Array], point: Array) -> bool:
    """Whether a point (3,) lies over or in a box (lower, upper corner): elsewhere nothing bears an item."""
    low, high = ground
    return bool(np.all(low[:2] <= point[:2]) and np.all(point[:2] <= high[:2]) and low[2] <= point[2])


def add_statics(engine: Engine, scene: Scene) -> None:
    """Pod (where it really stands), tote and obstacles: one body per box."""
    for body in scene.cell.pod.bodies:
        engine.add_static(body, scene.T_world_pod, STATIC_COLOURS["pod"])
    for body in scene.cell.tote.bodies:
        engine.add_static(body, np.eye(4), STATIC_COLOURS["tote"])
    for body in scene.cell.obstacles.bodies:
        engine.add_static(body, np.eye(4), STATIC_COLOURS["obstacle"])


def add_items(engine: Engine, scene: Scene, masses: Mapping[str, float] | None = None) -> None:
    """Every item of the scene, named by its id; of its stated mass unless ``masses`` has another, kg."""
    for placed in scene.items:
        mass = masses[placed.id] if masses else placed.item.mass
        engine.add_item(placed.id, placed.item, placed.T_world_item, item_colour(placed.item), mass)


def true_masses(scene: Scene, reality: Reality, seed: int) -> dict[str, float]:
    """kg by item id: off the stated mass by up to the share that reality says, evenly distributed."""
    return {
        placed.id: placed.item.mass
        * (1.0 + reality.mass_error * float(derived_rng(seed, "mass", placed.id).uniform(-1.0, 1.0)))
        for placed in scene.items
    }
