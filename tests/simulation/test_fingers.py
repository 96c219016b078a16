"""Fingers in the simulated world: how they close, what they hold, how it slides, and what they tell of it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind, box
from pickcli.cell.tool import MOVING, ToolState
from pickcli.geometry import GRAVITY, Array, inverse, pose
from pickcli.kinematics.arm import Arm
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from pickcli.simulation.fingers import Fingers
from pickcli.simulation.planned_contacts import PlannedContacts
from pickcli.simulation.reality import IDEAL
from pickcli.simulation.world import World

OPEN, CLOSED = ToolState("open"), ToolState("closed")
CUBE = (0.06, 0.04, 0.05)  # m; the fingers close along its y
FORCE, FRICTION = 70.0, 0.5  # N, -: of the cell
MOST_SHEAR = 2 * FRICTION * FORCE
ITEM = "thing"


@pytest.fixture(scope="module")
def panda() -> Cell:
    return load_cell("panda_table")


class Hand:
    """A world in which an item stands on a pedestal between the open fingers, which point down."""

    def __init__(
        self,
        cell: Cell,
        shape: Shape,
        mass: float,
        shift: tuple[float, float, float] = (0.0, 0.0, 0.0),
        turn: Array | None = None,
    ) -> None:
        home = cell.configurations["home"].q
        tip = Arm(cell.robot).tip(home, OPEN)
        # Axes of the tool, but for z, which is up.
        upright = pose(tip[:3, 3], R=tip[:3, :3] @ np.diag([1.0, -1.0, -1.0])) @ pose(shift)
        T = upright @ pose(R=np.eye(3) if turn is None else turn)
        item = Item(ITEM, 2026, shape, mass, 0, {}, "", "a test", 0.0, 1.0, "", "")
        scene = Scene(cell, cell.T_world_pod, (PlacedItem(ITEM, item, "table", T),), PoseNoise())
        self.world = World(scene, home, OPEN, reality=IDEAL)
        x, y, low = (*T[:2, 3], T[2, 3] - float(shape.reach(T[:3, :3])[2]))
        pedestal = box("pedestal", (x - 0.1, y - 0.1, low - 0.05), (x + 0.1, y + 0.1, low))
        self.world.engine.add_static(pedestal, np.eye(4), (0.5, 0.5, 0.5, 1.0))
        names = frozenset({ITEM})
        self.world.planned = PlannedContacts(names, names, is_meeting=True)

    @property
    def fingers(self) -> Fingers:
        assert self.world.fingers is not None
        return self.world.fingers

    @property
    def item(self) -> Array:
        """Where the item's middle is in the tool frame, (3,) m."""
        return (inverse(self.world.tip) @ self.world.engine.pose(ITEM))[:3, 3]

    def closed(self, duration: float = 0.8) -> Hand:
        self.world.act("gripper", "closed")
        self.world.wait(duration)
        return self

    def lifted(self) -> Hand:
        """With nothing but the pads under the item."""
        self.world.engine.remove("pedestal")
        self.world.planned = PlannedContacts(frozenset({ITEM}))
        return self


@pytest.fixture
def hand(panda: Cell) -> Iterator[Any]:
    made: list[Hand] = []

    def build(shape: Shape | None = None, mass: float = 0.3, **keywords: Any) -> Hand:
        made.append(Hand(panda, shape or Shape(ShapeKind.BOX, CUBE), mass, **keywords))
        return made[-1]

    yield build
    for one in made:
        one.world.close()


def test_fingers_close_at_their_speed_and_stop_on_what_is_between_them(hand: Any) -> None:
    held = hand().closed(0.2)
    assert held.fingers.width == pytest.approx(0.08 - 0.1 * 0.2, abs=1e-3)
    assert held.world.tool_state == MOVING and not held.fingers.is_holding
    held.world.wait(0.6)
    assert held.fingers.width == pytest.approx(CUBE[1], abs=2e-4)
    assert held.world.held == ITEM and held.fingers.is_holding
    width = held.world.tool_state.width
    assert width is not None and width == pytest.approx(CUBE[1], abs=2e-4)


def test_a_command_takes_effect_after_what_its_lead_is_longer_than_the_way(panda: Cell) -> None:
    slow = replace(panda, devices={n: replace(d, lead=1.0) for n, d in panda.devices.items()})
    world = Hand(slow, Shape(ShapeKind.BOX, CUBE), 0.3).world
    try:
        world.act("gripper", "closed")
        world.wait(0.19)
        assert world.tool_state == OPEN
        world.wait(0.11)
        assert world.fingers is not None and world.fingers.width == pytest.approx(0.07, abs=1.5e-3)
    finally:
        world.close()


def test_fingers_that_close_on_nothing_meet_without_a_collision_and_hold_nothing(hand: Any) -> None:
    empty = hand(shift=(0.06, 0.0, 0.0)).closed(1.0)
    assert empty.world.tool_state == CLOSED
    assert not empty.fingers.is_holding and empty.world.held is None
    assert empty.world.contacts.collisions == ()


@pytest.mark.parametrize("aside", [0.006, -0.012])
def test_an_item_beside_the_middle_is_drawn_there(hand: Any, aside: float) -> None:
    held = hand(shift=(0.0, aside, 0.0)).closed()
    assert held.world.held == ITEM
    assert abs(held.item[1]) < 3e-4
    assert held.world.contacts.collisions == ()


SHAPES = {
    "box": (Shape(ShapeKind.BOX, CUBE), np.eye(3)),
    "cylinder that lies": (Shape(ShapeKind.CYLINDER, (0.025, 0.12)), pose(rpy=(0.0, np.pi / 2, 0.0))[:3, :3]),
    "cylinder that stands": (Shape(ShapeKind.CYLINDER, (0.03, 0.05)), np.eye(3)),
    "ball": (Shape(ShapeKind.SPHERE, (0.025,)), np.eye(3)),
}


@pytest.mark.parametrize("name", SHAPES)
def test_what_is_held_at_rest_loads_the_pads_with_its_weight_and_stays(hand: Any, name: str) -> None:
    shape, turn = SHAPES[name]
    held = hand(shape, turn=turn).closed().lifted()
    held.world.wait(0.5)
    before = held.item
    held.world.wait(1.0)
    np.testing.assert_allclose(held.item, before, atol=2e-5)
    assert held.fingers.slip < 2e-4
    assert held.fingers.load[2] == pytest.approx(-0.3 * GRAVITY, rel=0.01)  # z of the tool points down
    assert held.world.contacts.collisions == ()


def test_a_lever_twists_the_pads(hand: Any) -> None:
    held = hand(Shape(ShapeKind.BOX, (0.2, 0.03, 0.03)), shift=(0.04, 0.0, 0.0)).closed().lifted()
    held.world.wait(0.5)
    assert abs(held.fingers.load[4]) == pytest.approx(0.3 * GRAVITY * 0.04, rel=0.02)


def test_what_weighs_less_than_friction_bears_stays_and_what_weighs_more_slides_away(hand: Any) -> None:
    light = hand(mass=0.75 * MOST_SHEAR / GRAVITY).closed().lifted()
    light.world.wait(1.0)
    assert light.world.held == ITEM and light.fingers.slip < 1e-3
    assert light.fingers.ratio == pytest.approx(0.75, rel=0.02)
    heavy = hand(mass=1.25 * MOST_SHEAR / GRAVITY).closed().lifted()
    heavy.world.wait(1.0)
    (release,) = heavy.world.grip.releases
    assert release.item == ITEM and not release.is_wanted
    assert heavy.world.held is None and not heavy.fingers.is_holding
    assert heavy.world.tool_state == CLOSED


def test_pads_go_on_pulling_at_what_slides(hand: Any) -> None:
    mass = 1.25 * MOST_SHEAR / GRAVITY
    heavy = hand(mass=mass).closed().lifted()
    depths, step = [], 0.02
    for _ in range(4):
        heavy.world.wait(step)
        depths.append(heavy.item[2])
    assert heavy.world.held == ITEM
    acceleration = np.diff(depths, n=2) / step**2
    np.testing.assert_allclose(acceleration[1:], GRAVITY - MOST_SHEAR / mass, rtol=0.05)


def test_a_part_of_the_pads_bears_less_twist(hand: Any) -> None:
    """The middle of the pads bears 0.5 Nm; the strip of 3.5 mm that is on the item here 0.33 Nm."""
    whole = hand(mass=2.0, shift=(0.02, 0.0, 0.0)).closed().lifted()
    part = hand(mass=2.0, shift=(0.035, 0.0, 0.0)).closed().lifted()
    for one in (whole, part):
        one.world.wait(0.3)
    assert whole.fingers.slip < 1.5e-3 < part.fingers.slip or part.world.held is None


def test_fingers_that_open_let_go(hand: Any) -> None:
    held = hand().closed()
    held.world.act("gripper", "open")
    held.world.wait(0.8)
    (release,) = held.world.grip.releases
    assert release.is_wanted and held.world.held is None
    assert held.world.tool_state == OPEN
    assert abs(held.item[2]) < 1e-3  # it stands where it stood
    assert held.world.contacts.collisions == ()


def test_pads_may_touch_what_they_are_to_grasp_and_nothing_else(hand: Any) -> None:
    other = hand()
    other.world.planned = replace(other.world.planned, met=frozenset({"another"}))
    other.closed()
    assert {c.b for c in other.world.contacts.collisions} == {ITEM}
    assert {c.a for c in other.world.contacts.collisions} <= {"panda_leftfinger", "panda_rightfinger"}
