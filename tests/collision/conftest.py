"""The default cell, its model, and scenes of it with boxes where a test wants them."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.cell.tool import ToolState
from pickcli.collision.checker import SceneChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array
from pickcli.kinematics.arm import Arm
from pickcli.scene.scene import PlacedItem, PoseNoise, Scene
from support.solid_helpers import MakeChecker, MakeScene
from support.tool_states import STRAIGHT


@pytest.fixture(scope="session")
def model(cell: Cell) -> CollisionModel:
    return CollisionModel(cell)


@pytest.fixture(scope="session")
def home(cell: Cell) -> Array:
    return cell.configurations["home"].q


@pytest.fixture(scope="session")
def arm(cell: Cell) -> Arm:
    return Arm(cell.robot)


@pytest.fixture(scope="session")
def T_home_tip(arm: Arm, home: Array) -> Array:
    return arm.tip(home, STRAIGHT)


@pytest.fixture(scope="session")
def make_scene(cell: Cell) -> MakeScene:
    """make_scene((item, T_world_item), ...): ids are item0, item1, ..."""

    def make(
        *placed: tuple[Item, Array], noise: PoseNoise | None = None, T_world_pod: Array | None = None
    ) -> Scene:
        items = tuple(PlacedItem(f"item{i}", item, "bin_E", T) for i, (item, T) in enumerate(placed))
        return Scene(cell, np.eye(4) if T_world_pod is None else T_world_pod, items, noise or PoseNoise())

    return make


@pytest.fixture(scope="session")
def make_checker(model: CollisionModel, make_scene: MakeScene) -> MakeChecker:
    """make_checker(scene=..., tool_state=..., **options): empty and with a straight cup by default."""

    def make(scene: Scene | None = None, tool_state: ToolState = STRAIGHT, **options: object) -> SceneChecker:
        return SceneChecker(model, scene or make_scene(), tool_state, **options)  # type: ignore[arg-type]

    return make
