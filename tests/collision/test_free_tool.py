"""The tool by itself says what the arm's checker says of lance and cup."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.tool import ToolState
from pickcli.collision.allowed_contacts import AllowedContacts
from pickcli.collision.free_flyer import FreeToolChecker
from pickcli.collision.robot_model import CollisionModel
from pickcli.geometry import Array, pose
from pickcli.kinematics.arm import Arm
from support.solid_helpers import MakeChecker, MakeScene
from support.tool_states import DOWN, STRAIGHT

TOOL = ("lance", "cup")


@pytest.fixture(scope="module")
def arm(cell: Cell) -> Arm:
    return Arm(cell.robot)


@pytest.mark.parametrize("tool_state", [STRAIGHT, DOWN])
def test_its_clearance_is_that_of_the_arms_lance_and_cup(
    cell: Cell, model: CollisionModel, arm: Arm, make_scene: MakeScene, make_checker: MakeChecker,
    tool_state: ToolState,
) -> None:  # fmt: skip
    scene = make_scene()
    checker, tool = make_checker(scene, tool_state), FreeToolChecker(model, scene, tool_state, np.eye(3))
    rng = np.random.default_rng(0)
    compared = 0
    fronts = np.array([c.q for c in cell.configurations.values() if c.kind == "bin"])
    for q in np.repeat(fronts, 60, axis=0) + 0.15 * rng.standard_normal((60 * len(fronts), arm.n)):
        theirs = checker.clearance(q)
        ours = tool.clearance(tool.displacements(arm.tip(q, tool_state)[None])[0])
        assert ours.distance >= theirs.distance - 1e-9  # the arm is more than its tool
        if theirs.a in TOOL and theirs.kind != "robot":
            compared += 1
            assert ours.distance == pytest.approx(theirs.distance, abs=1e-9)
            assert (ours.a, ours.b, ours.kind) == (theirs.a, theirs.b, theirs.kind)
    assert compared > 10


def in_front_of(cell: Cell, bin_name: str, x: float, R: Array) -> Array:
    cell_bin = cell.pod.bins[bin_name]
    return np.asarray(cell.T_world_place(cell_bin) @ pose([x, 0.0, cell_bin.access.height / 2], R=R))


FRONTAL = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])  # tool z into the bin, x down


def test_a_push_into_the_bin_is_free_and_one_through_its_back_is_not(
    cell: Cell, model: CollisionModel, make_scene: MakeScene
) -> None:
    tool = FreeToolChecker(model, make_scene(), STRAIGHT, np.eye(3))
    places = [in_front_of(cell, "bin_E", x, FRONTAL) for x in (-0.1, 0.2, 0.6)]
    assert tool.is_valid_path(tool.displacements(np.stack(places[:2])))
    assert tool.first_blocked_edge(tool.displacements(np.stack(places))) == 1
    assert tool.are_valid(tool.displacements(np.stack(places))).tolist() == [True, True, False]
    assert tool.clearance(tool.displacements(np.stack(places))[2]).b == "back"


@pytest.mark.parametrize("roll", np.radians([0.0, 90.0, -90.0, 179.9, -179.9]))
def test_it_does_not_spin_on_a_straight_line_however_it_is_rolled(
    cell: Cell, model: CollisionModel, make_scene: MakeScene, roll: float
) -> None:
    """A turned cup that swung round on its way would meet the bin's boards."""
    tool = FreeToolChecker(model, make_scene(), DOWN, np.eye(3))
    level = np.diag([-1.0, 1.0, -1.0])  # lance towards the mouth, cup down
    turn = pose(rpy=[roll, 0.0, 0.0])[:3, :3]
    a, b = (in_front_of(cell, "bin_B", x, turn @ level) for x in (0.0, 0.25))
    a[:3, :3] = pose(rpy=[1e-3, 0.0, 0.0])[:3, :3] @ a[:3, :3]
    assert tool.are_valid(tool.displacements(np.stack([a, b]))).all()
    assert tool.is_valid_path(tool.displacements(np.stack([a, b])))


def test_only_the_cup_may_touch_what_it_is_allowed_to(
    cell: Cell, model: CollisionModel, make_scene: MakeScene
) -> None:
    item = cell.item("crayola_24_ct")
    T = in_front_of(cell, "bin_E", 0.2, np.eye(3))
    scene = make_scene((item, T))
    touching = FreeToolChecker(model, scene, STRAIGHT, np.eye(3), AllowedContacts.at_any_depth({"item0"}))
    short, deep = (
        in_front_of(cell, "bin_E", 0.2 - item.shape.size[0] / 2 + d, FRONTAL) for d in (0.005, 0.05)
    )
    Q = touching.displacements(np.stack([short, deep]))
    assert touching.are_valid(Q).tolist() == [True, False]
    assert touching.clearance(Q[1]).a == "lance"
    gone = FreeToolChecker(model, scene, STRAIGHT, np.eye(3), AllowedContacts(absent=frozenset({"item0"})))
    assert gone.is_valid(Q[1])
