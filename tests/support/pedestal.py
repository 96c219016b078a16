"""A small world: the default cell at home, with one item on a pedestal before or under the cup."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind, box
from pickcli.cell.station import Obstacles
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array, pose
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.simulation.planned_contacts import PlannedContacts
from pickcli.simulation.reality import DEFAULT, Reality
from pickcli.simulation.servo import Servo
from pickcli.simulation.world import TIME_STEP, World
from support.tool_states import DOWN, STRAIGHT

BuildWorld = Callable[..., World]
STATED_MASS = replace(DEFAULT, mass_error=0.0)


def cube(side: float = 0.04, mass: float = 0.1, size: tuple[float, float, float] | None = None) -> Item:
    """An item as a cube, or as a box."""
    shape = Shape(ShapeKind.BOX, size or (side, side, side))
    seals = dict.fromkeys(shape.face_names, 1.0)
    return Item("cube", 2016, shape, mass, 0, seals, "made up", "", 0.0, 1.0, "", "made up")


def make_world(
    cell: Cell,
    item: Item | None = None,
    gap: float = -0.002,
    shift: tuple[float, float] = (0.0, 0.0),
    tool_state: ToolState = DOWN,
    servo: Servo | None = None,
    reality: Reality = STATED_MASS,
    time_step: float = TIME_STEP,
) -> World:
    """The item on a pedestal, its nearest face ``gap`` m from the tip of the cup (negative: the cup is
    compressed), its centre ``shift`` m off the cup's axis along world y and the other cross axis."""
    item = item or cube()
    home = start(cell)
    T_tip = _tip(cell, home, tool_state)
    axis, half = T_tip[:3, 2], item.shape.extents[2] / 2
    across = np.array([1.0, 0.0, 0.0]) if tool_state == DOWN else np.array([0.0, 0.0, 1.0])
    centre = T_tip[:3, 3] + (gap + half) * axis + shift[0] * np.array([0.0, 1.0, 0.0]) + shift[1] * across
    x, y, z = centre
    R = np.stack([T_tip[:3, 0], T_tip[:3, 1], axis], axis=1) if tool_state == STRAIGHT else np.eye(3)
    reach = item.shape.reach(R)
    pedestal = box("pedestal", (x - reach[0], y - 0.2, 0.9), (x + 0.2, y + 0.2, float(z - reach[2])))
    changed = replace(cell, obstacles=Obstacles((*cell.obstacles.bodies, pedestal)))
    placed = PlacedItem("cube", item, "bin_A", pose(centre, R=R))
    scene = Scene(changed, cell.T_world_pod, (placed,), PoseNoise())
    world = World(scene, home, tool_state, reality=reality, servo=servo, time_step=time_step)
    world.planned = PlannedContacts().also(frozenset({"cube"}))
    return world


def start(cell: Cell) -> Array:
    """Home, with room to move on the rail in both directions."""
    q = cell.configurations["home"].q.copy()
    q[0] = 0.5
    return q


def evacuate(world: World) -> None:
    """Pump until the line is at full vacuum, and let the item come to rest."""
    world.act("pump", "on")
    world.suction.vacuum.advance(2.5, seal=0.0)
    world.wait(0.3)


def _tip(cell: Cell, q: Array, tool_state: ToolState) -> Array:
    world = World(Scene(cell, cell.T_world_pod, (), PoseNoise()), q, tool_state)
    tip = world.tip.copy()
    world.close()
    return tip
