"""A scene in the physics engine, with an arm that carries a hand. It carries out plans as any driver."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.robot import Robot
from pickcli.cell.tool import ToolState
from pickcli.geometry import Array, inverse
from pickcli.hand.belt_hand import BeltHand
from pickcli.hand.grasp_world import TIME_STEP
from pickcli.hand.hand_arm import HAND_LINKS, ROBOT, TIPS, HandArm
from pickcli.hand.hand_urdf import PALM
from pickcli.hand.simulated_hand import SimulatedHand
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.simulation.contacts import Collision, ContactLog
from pickcli.simulation.driver import device_for
from pickcli.simulation.engine import Engine
from pickcli.simulation.places import location_of
from pickcli.simulation.planned_contacts import PlannedContacts
from pickcli.simulation.scene_bodies import add_items, add_statics, standing_links
from pickcli.simulation.simulated_tool import BareTool, SimulatedTool

MOST_PRESS = (
    80.0  # N at one point, with which the hand may press on what it grasps; its pads bear half of that
)


class ArmWorld:
    """A world, which advances by steps of ``TIME_STEP``.

    Attributes:
        scene: The scene, with items where they were at the start.
        engine: The engine.
        tool: The bare flange.
        hand: The hand.
        arm: The arm that carries it.
        reached_for: Names of the items that the hand may touch at present.
        observer: Called after every step.

    Args:
        scene: The true scene; its cell's arm has a bare flange.
        hand: Figures of the hand.
        q: (n,) rad of the arm at the start.
        masses: kg of the items by id.
        friction: Factor on the friction of belts.
    """

    def __init__(
        self, scene: Scene, hand: BeltHand, q: Array, masses: Mapping[str, float], friction: float = 1.0
    ) -> None:
        self.scene = scene
        self.engine = Engine(TIME_STEP)
        add_statics(self.engine, scene)
        add_items(self.engine, scene, masses)
        self.arm = HandArm(self.engine, scene.cell, hand, q)
        self.hand = SimulatedHand(self.engine, hand, self.arm, hand.belts.friction * friction)
        self.reached_for: frozenset[str] = frozenset()
        self.observer: Callable[[ArmWorld], None] | None = None
        standing = (body.name for body, _ in scene.standing)
        never = {*product(standing_links(scene.cell.robot), standing), TIPS, TIPS[::-1]}
        self._log = ContactLog(ROBOT, HAND_LINKS, frozenset(never), MOST_PRESS)
        self.tool: SimulatedTool = BareTool(scene.cell.robot.tool)
        self._n_steps = 0

    # A driver ----------------------------------------------------------------------------------------

    @property
    def cell(self) -> Cell:
        """The cell, without the hand."""
        return self.scene.cell

    @property
    def time_step(self) -> float:
        """S of a step."""
        return TIME_STEP

    @property
    def t(self) -> float:
        """S since the start."""
        return self._n_steps * TIME_STEP

    @property
    def time(self) -> float:
        """S since the start."""
        return self.t

    @property
    def q(self) -> Array:
        """(n,) rad of the arm, as measured."""
        return self.arm.q

    @property
    def robot(self) -> Robot:
        """The arm, without the hand."""
        return self.cell.robot

    @property
    def joints(self) -> Array:
        """(n,) rad of the joints that are recorded."""
        return self.arm.q

    @property
    def held(self) -> str | None:
        """None, as what is between the fingers is held by contacts alone."""
        return None

    @property
    def tool_state(self) -> ToolState:
        """The only state of a bare flange."""
        return self.cell.robot.tool.default_state

    def command(self, q: Array) -> None:
        """Set the set point of the end of the next step.

        Args:
            q: (n,) rad.
        """
        self.arm.command = q.copy()

    def act(self, device: str, action: str) -> bool | None:
        """Refuse, as there is nothing to switch.

        Args:
            device: Name of a device.
            action: An action.

        Raises:
            UnknownNameError: There is no such device or action.
        """
        device_for(self.cell, device, action)
        return None

    def step(self) -> None:
        """Advance by a step."""
        self.hand.exert()
        self.engine.step()
        self._n_steps += 1
        planned = PlannedContacts(met=self.reached_for)
        self._log.update(self.engine.contact_points(ROBOT), planned, None, self.t)
        if self.observer is not None:
            self.observer(self)

    def wait(self, duration: float) -> None:
        """Let time pass while the arm rests.

        Args:
            duration: s.
        """
        for _ in range(round(duration / TIME_STEP)):
            self.step()

    def reset(self, q: Array, taken: Sequence[str]) -> None:
        """Bring the arm elsewhere by hand, with the open hand, and take items out of the world.

        Args:
            q: (n,) rad.
            taken: Ids of these items.
        """
        self.reach_for(frozenset())
        self.arm.reset(q)
        self.hand.reset()
        for name in taken:
            self.engine.remove(name)
        self.scene = replace(self.scene, items=tuple(p for p in self.scene.items if p.id not in taken))

    def close(self) -> None:
        """Free the engine."""
        self.engine.close()

    # What is seen ------------------------------------------------------------------------------------

    @property
    def collisions(self) -> tuple[Collision, ...]:
        """Contacts of arm and hand so far that were not wanted."""
        return self._log.collisions

    def reach_for(self, names: frozenset[str]) -> None:
        """Let the hand touch some items, and no others, from now on.

        Args:
            names: Their ids.
        """
        for name in sorted(self.reached_for ^ names):
            self.engine.keep_awake(name, name in names)
        self.reached_for = names

    def pose(self, name: str) -> Array:
        """Return where an item is.

        Args:
            name: Its id.

        Returns:
            (4, 4) T_world_item.
        """
        return self.engine.pose(name)

    def pose_in_hand(self, name: str) -> Array:
        """Return where an item is in the hand.

        Args:
            name: Its id.

        Returns:
            (4, 4) T_hand_item.
        """
        return inverse(self.engine.pose(ROBOT, PALM)) @ self.engine.pose(name)

    def middle_in_hand(self, name: str) -> Array:
        """Return where the middle of an item is.

        Args:
            name: Its id.

        Returns:
            (3,) m in the frame of the hand.
        """
        return np.asarray(self.pose_in_hand(name)[:3, 3])

    def contacts(self, name: str) -> dict[str, list[Array]]:
        """Return where an item is touched.

        Args:
            name: Its id.

        Returns:
            Contact points (3,) in m in the frame of the hand, by link of the hand or name of another body.
        """
        T_hand_world = inverse(self.engine.pose(ROBOT, PALM))
        found: dict[str, list[Array]] = {}
        for point in self.engine.contact_points(name):
            at = T_hand_world[:3, :3] @ np.array(point.position) + T_hand_world[:3, 3]
            found.setdefault(point.link_b if point.b == ROBOT else point.b, []).append(at)
        return found

    def placed(self, item_id: str) -> PlacedItem:
        """Return an item as it is now.

        Args:
            item_id: Its id.

        Returns:
            The item, in the place where it is.
        """
        before = self.scene.find(item_id)
        T = self.engine.pose(item_id)
        return replace(before, T_world_item=T, location=location_of(self.scene, before.item, T))

    def now(self) -> Scene:
        """Return the scene as it is, with all items."""
        return replace(self.scene, items=tuple(self.placed(each.id) for each in self.scene.items))
