"""What leans stays only on what reaches up to its centre: physics, verifier and planner agree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.shapes import ShapeKind
from pickcli.errors import Failures, Reason
from pickcli.geometry import inverse
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.floor_placements import floor_placements
from pickcli.scene.scene import PoseNoise, Scene
from pickcli.simulation.settle import settle
from pickcli.verification.landing_statics import keeps_standing, leans_too_low
from support.bin_piles import BIN, EXACT, at, shaped

TALL, THICK, PITCH = 0.2, 0.01, np.radians(6.5)
NOISE = PoseNoise(0.004)
GAP = 0.006  # m before what it leans on, where it is let go within the errors of both poses
LOW, HIGH = 0.05, 0.18


def pack_before(cell: Cell, height: float, leaning: bool = True) -> Scene:
    """A pack on its edge, which leans back on a heavy block of a height, m."""
    pitch = PITCH if leaning else 0.0
    pack = shaped(cell, (THICK, 0.09, TALL))
    z = (TALL * np.cos(pitch) + THICK * np.sin(pitch)) / 2
    met = min(height, TALL * np.cos(pitch))  # m over the floor, where they meet
    behind = 0.25 + THICK / 2 / np.cos(pitch) + (met - z) * np.tan(pitch) + GAP
    block = shaped(cell, (0.12, 0.12, height), mass=3.0)
    items = (
        at(cell, "block", block, behind + 0.06, 0.0, height / 2),
        at(cell, "pack", pack, 0.25, 0.0, z + 0.001, rpy=(0.0, pitch, 0.0)),
    )
    return Scene(cell, cell.T_world_pod, items, NOISE)


@pytest.mark.parametrize(("height", "falls"), [(LOW, True), (HIGH, False)])
def test_it_falls_over_what_is_lower_than_its_centre(cell: Cell, height: float, falls: bool) -> None:
    scene = pack_before(cell, height)
    assert keeps_standing(scene, "pack"), "forces that hold it exist in both cases"
    assert leans_too_low(scene, "pack") is falls
    rested = settle(scene, scene.items)
    assert not isinstance(rested, Reason)
    turned = (inverse(scene.find("pack").T_world_item) @ rested[1].T_world_item)[:3, :3]
    turn = np.degrees(np.arccos(np.clip((np.trace(turned) - 1.0) / 2.0, -1.0, 1.0)))
    assert turn > 45.0 if falls else turn < 10.0


def test_what_stands_beside_it_does_not_hold_it(cell: Cell) -> None:
    scene = pack_before(cell, LOW)
    tall = at(cell, "tall", shaped(cell, (0.06, 0.04, HIGH), mass=3.0), 0.25, 0.067, HIGH / 2)
    assert leans_too_low(replace(scene, items=(*scene.items, tall)), "pack")


@pytest.mark.parametrize("tilt", [0.3, 0.36, 0.4])
def test_it_falls_over_what_is_low_however_far_it_leans(cell: Cell, tilt: float) -> None:
    thick = 0.06
    z = (TALL * np.cos(tilt) + thick * np.sin(tilt)) / 2
    pack = at(cell, "pack", shaped(cell, (thick, 0.09, TALL)), 0.25, 0.0, z + 0.001, rpy=(0.0, tilt, 0.0))
    behind = 0.25 + thick / 2 / np.cos(tilt) + (0.03 - z) * np.tan(tilt) + 0.001
    block = at(cell, "block", shaped(cell, (0.12, 0.12, 0.03), mass=3.0), behind + 0.06, 0.0, 0.015)
    assert leans_too_low(Scene(cell, cell.T_world_pod, (block, pack), NOISE), "pack")


def test_what_stands_by_itself_or_rolls_leans_on_nothing(cell: Cell) -> None:
    upright = pack_before(cell, LOW, leaning=False)
    thick = replace(upright.items[1], item=shaped(cell, (0.08, 0.09, TALL)))
    assert not leans_too_low(replace(upright, items=(upright.items[0], thick)), "pack")
    ball = at(cell, "ball", shaped(cell, (0.04,), ShapeKind.SPHERE), 0.2, 0.0, 0.04)
    chock = at(cell, "chock", shaped(cell, (0.05, 0.1, 0.02)), 0.262, 0.0, 0.01)
    assert not leans_too_low(Scene(cell, cell.T_world_pod, (ball, chock), EXACT), "ball")


@pytest.mark.parametrize(("height", "is_leant_on"), [(LOW, False), (HIGH, True)])
def test_it_is_set_down_before_what_is_high_enough(cell: Cell, height: float, is_leant_on: bool) -> None:
    scene, place = pack_before(cell, height), cell.pod.bins[BIN]
    pack = scene.items[1]
    R = np.eye(3)
    spots = floor_placements(PlanningContext(cell), scene, pack, R, place, n_most=50)
    found = () if isinstance(spots, Failures) else spots
    in_place = [inverse(cell.T_world_place(place)) @ spot.T_world_item for spot in found]
    before = [T for T in in_place if T[0, 3] < 0.25 and abs(T[1, 3]) < 0.05]
    assert bool(before) is is_leant_on
