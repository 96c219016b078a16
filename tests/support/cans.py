"""Cans on the mat of `panda_table`, which its open fingers can reach into from the side or from above."""

from __future__ import annotations

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.tools.gripper import ParallelGripper
from pickcli.collision.allowed_contacts import AllowedContacts
from pickcli.collision.checker import SceneChecker
from pickcli.collision.free_flyer import FreeToolChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import pose
from pickcli.grasping.envelope import Envelope
from pickcli.grasping.finger_envelopes import FingerReach, finger_envelopes
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene

ABOVE_MAT = 0.3  # m: cans hang in the air, so that a level hand has room below


def can(cell: Cell, name: str, x: float, y: float, radius: float = 0.025) -> PlacedItem:
    """Return a can with its axis upright, in the world's x and y."""
    shape = Shape(ShapeKind.CYLINDER, (radius, 0.12))
    item = Item(
        name, 2016, shape, 0.3, 0, dict.fromkeys(shape.face_names, 0.0), "", "printed", 0.0, 1.0, "", ""
    )
    mat = cell.T_world_place(cell.places["mat_front"])[2, 3]
    return PlacedItem(name, item, "mat_front", pose((x, y, mat + ABOVE_MAT)))


class CanScene:
    """A can, `target`, with others around it, and what checks the hand and the arm there."""

    def __init__(self, cell: Cell, others: tuple[PlacedItem, ...] = ()) -> None:
        self.model, self.state = CollisionModel(cell), cell.robot.tool.default_state
        self.target = can(cell, "target", 0.46, 0.0)
        scene = Scene(cell, cell.T_world_pod, (self.target, *others), PoseNoise())
        contacts = AllowedContacts.at_any_depth(["target"])
        self.tool = FreeToolChecker(self.model, scene, self.state, np.eye(3), contacts)
        self.arm = SceneChecker(self.model, scene, self.state, contacts=contacts)
        grip = cell.robot.tool.grip
        assert isinstance(grip, ParallelGripper)
        self.fingers = FingerReach.of(cell.robot.tool, grip, self.tool.depth)

    @property
    def envelopes(self) -> tuple[Envelope, ...]:
        """The envelopes of the target."""
        return finger_envelopes(self.target.item.shape, self.fingers)
