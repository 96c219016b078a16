"""On what a cup may be pressed: the verifier refuses no press that the planner plans, in piles at rest."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.collision.stage_contacts import PickContacts
from pickcli.geometry import inverse
from pickcli.grasping.cup_press import overtravel
from pickcli.grasping.grasp_target import GraspTarget
from pickcli.grasping.method_choice import grasp_method
from pickcli.grasping.press_check import contact_speed
from pickcli.grasping.search import USUAL
from pickcli.motion.plan import Grasp
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive
from pickcli.verification.tipping_check import Press, beside_support, falls_over
from support.piles import PATTERNS, pile

CELL = load_cell("apc2016_delft")
TOOL = CELL.robot.tool
N_GRASPS = 12  # that are looked at of each item


def takeable(scene: Scene) -> Iterator[tuple[PlacedItem, PickContacts, Grasp]]:
    """Grasps of everything that could tip and that nothing else needs."""
    for placed in scene.items:
        place = CELL.places[placed.location]
        contacts = PickContacts(scene, placed, frozenset(place.support), frozenset(), 0.05)
        if placed.can_roll or not placed.item.suction or contacts.supports.blocking(placed.id):
            continue
        T_entry_item = inverse(scene.T_world_place(place) @ place.T_place_entry) @ placed.T_world_item
        target = GraspTarget(placed.id, placed.item, T_entry_item, place)
        found = grasp_method(TOOL).sample(target, np.random.default_rng(0), USUAL, 1.0).grasps
        yield from ((placed, contacts, grasp) for grasp in found[:: max(1, len(found) // N_GRASPS)])


def is_refused(scene: Scene, placed: PlacedItem, grasp: Grasp, speed: float) -> bool:
    """Whether the verifier says that the planned press tips the item."""
    depth = overtravel(grasp, TOOL, scene.noise)
    tip = placed.T_world_item @ grasp.T_item_tip
    tip[:3, 3] += depth * tip[:3, 2]
    press = Press(tip, depth, TOOL.grip.stiffness, speed)
    if grasp.kind == "top-down":
        return beside_support(scene, placed, press.force, tip[:3, 3]) > 0.0
    return falls_over(scene, placed, press)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_the_verifier_refuses_no_press_that_the_planner_would_plan(pattern: str) -> None:
    scene = next(s for k in range(20) if (s := pile(CELL, pattern, k)) is not None)
    for believed in (scene, perceive(scene, DEFAULT_NOISE, 1, 1)):
        for placed, contacts, grasp in takeable(believed):
            speed = contact_speed(contacts, TOOL, grasp)
            if speed is not None:
                assert not is_refused(believed, placed, grasp, speed), (placed.id, grasp)


def test_a_bridge_may_be_pressed_here_and_not_there() -> None:
    """What plans all presses, or none, would be judged by nothing."""
    scene = pile(CELL, "bridge", 0)
    assert scene is not None
    speeds = [contact_speed(contacts, TOOL, grasp) for _, contacts, grasp in takeable(scene)]
    assert any(speed is None for speed in speeds) and any(speed is not None for speed in speeds)
