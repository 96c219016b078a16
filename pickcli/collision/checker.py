"""Checker of the robot in a scene: one per scene, tool state, held item and set of allowed contacts."""

from __future__ import annotations

import numpy as np

from pickcli.cell.tool import MOVING, ToolState
from pickcli.collision.allowed_contacts import NO_CONTACTS, AllowedContacts
from pickcli.collision.attached_item import AttachedItem, swept_cover
from pickcli.collision.collision_world import KERNEL_KINDS, CollisionWorld, build_world
from pickcli.collision.hand_sphere import HandSphere, HandSphereChecker
from pickcli.collision.kernel_validator import KernelValidator, KernelWorld
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array
from pickcli.kernel import Checker
from pickcli.scene.scene import Scene


class SceneChecker(KernelValidator):
    """The robot in one scene, in one tool state. Cheap to make: covers and boxes are shared.

    Args:
        model: The robot of the scene's cell.
        scene: The planning scene.
        tool_state: State of the tool.
        held: The attached item, None if there is none.
        contacts: Solids that cup and held item may touch, and how deep; all other links keep clear of them.
        margin: m, clearance kept from everything else; the cell's by default.

    Attributes:
        held: The attached item, None if there is none.

    Raises:
        UnknownNameError: If a name in ``contacts`` is not in the scene.
        StaleError: If the scene belongs to another cell than the model.
    """

    def __init__(
        self,
        model: CollisionModel,
        scene: Scene,
        tool_state: ToolState,
        held: AttachedItem | None = None,
        contacts: AllowedContacts = NO_CONTACTS,
        margin: float | None = None,
    ) -> None:
        """Create the kernel's checkers for the scene."""
        self.held, self._model, self._tool_state = held, model, tool_state
        world = build_world(model, scene)
        contacts = contacts.of_present
        parts = (*model.frame_names, held.name if held is not None else "")
        margin = model.cell.clearance if margin is None else margin
        clear = self._clear_of(world, contacts)
        limited = contacts if held is not None else contacts.of_empty_tool
        touch = self._touching(world, limited) if limited.is_limited else None
        super().__init__(world, parts, margin, model.cell.clearance, clear, touch)

    @property
    def tool_state(self) -> ToolState:
        """State of the tool."""
        return self._tool_state

    def hand_sphere(self) -> HandSphereChecker | None:
        """Return a checker of the largest sphere that is rigid with the flange, moved without the arm.

        Where it is not free, no configuration of the robot is valid that has the sphere there.

        Returns:
            The checker, None if nothing rigid with the flange has spheres.
        """
        sphere = HandSphere.of(self._model.state(self._tool_state), self._model.bodies)
        if sphere is None:
            return None
        kept = self._clear.kept
        kept = kept[(self._ignored[kept] & np.uint64(1 << sphere.frame)) == 0]
        return HandSphereChecker(sphere, self.world, kept, self.margin)

    @property
    def _cup(self) -> int:
        """Frame of the cup; the next one is that of the held item."""
        return self._model.n_frames - 1

    def _clear_of(self, world: CollisionWorld, contacts: AllowedContacts) -> KernelWorld:
        """Return the whole robot with all solids except those that it may touch."""
        item = self._cup + 1
        ignored_frames = world.ignored_frames | contacts.ignored_frames(
            world, self._model.tool_frames, item, is_empty=self.held is None
        )
        for part, name in contacts.opening_pairs:
            frame = item if part.startswith("held ") else self._model.frame_names.index(part)
            ignored_frames[world.indices([name])] |= np.uint64(1 << frame)
        self._ignored = ignored_frames
        kernel = self._model.state(self._tool_state).checker()
        kept = np.flatnonzero(world.is_kept(contacts.absent, contacts.entered))
        world.enter(kernel, kept, ignored_frames)
        if self.held is not None:
            self._attach(kernel, self.held)
        return KernelWorld(kernel, kept)

    def _touching(self, world: CollisionWorld, contacts: AllowedContacts) -> KernelWorld:
        """Return cup and held item, not enlarged, with the solids that they may touch to a limited depth."""
        kernel, cup = self._model.state(self._tool_state).cup.checker(), self._cup
        kept = contacts.enter(kernel, world, cup, cup + 1)
        if self.held is not None:
            shape, no_frames = self.held.item.shape, np.zeros(0, np.int32)
            kind = KERNEL_KINDS[shape.kind]
            kernel.set_held_solid(self._T_last_item(self.held), shape.extents / 2, no_frames, kind, 0.0)
        return KernelWorld(kernel, kept)

    def _attach(self, kernel: Checker, held: AttachedItem) -> None:
        tested = self._model.held_tested_frames
        if self._tool_state == MOVING:
            cover = swept_cover(self._model, held)
            kernel.set_held(cover.centers, cover.radii, tested)
        else:
            shape = held.item.shape
            kind = KERNEL_KINDS[shape.kind]
            kernel.set_held_solid(self._T_last_item(held), shape.extents / 2, tested, kind, held.inflate)

    def _T_last_item(self, held: AttachedItem) -> Array:
        return np.asarray(self._model.robot.tool.T_last_tip @ held.T_tip_item)
