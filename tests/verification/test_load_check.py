"""The verifier's own load model: hand calculations of the wrench, and every way in which a cup lets go."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.item import Item
from pickcli.cell.tools.cup_limits import CupLimits
from pickcli.geometry import Array, pose, rotation_axis_angle, rotation_rpy
from pickcli.scene.scene import Scene
from pickcli.verification.load_check import wrenches
from pickcli.verification.verify import verify
from support.handmade_plans import bound, pick

BOTTLE: Item = replace(load_cell("apc2016_delft").item("dasani_water_bottle", 2016), mass_error=0.0)
WEIGHT = 0.52 * 9.81
STEP = 1e-3


def about(axis: tuple[float, float, float], rate: float, change: float, R: Array) -> Array:
    """Five poses of a tool that turns in the world about an axis through its tip."""
    times = STEP * np.arange(-2, 3)
    angles = rate * times + change * times**2 / 2
    return np.array([pose(R=rotation_axis_angle(axis, float(a)) @ R) for a in angles])


def test_item_at_rest_weighs() -> None:
    level = rotation_rpy(0.0, np.pi / 2, 0.0)  # tool z along world x, x down, y along y
    still = np.tile(pose(R=level), (5, 1, 1))
    wrench = wrenches(still, pose([0.0, 0.03, 0.1]), BOTTLE, STEP)[0]
    np.testing.assert_allclose(wrench[:3], [-WEIGHT, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(wrench[3:], [0.0, -WEIGHT * 0.1, WEIGHT * 0.03], atol=1e-9)


def test_turning_up_takes_the_inertia_about_the_tip() -> None:
    """A bottle held by its end, swung up about the tip: m (3 r^2 + l^2) / 12 + m (l / 2)^2."""
    straight = rotation_rpy(np.pi, 0.0, 0.0)
    hanging = pose([0.0, 0.0, 0.0975])
    swung = wrenches(about((0.0, 1.0, 0.0), 0.0, 8.0, straight), hanging, BOTTLE, STEP)[1]
    inertia = 0.52 * (3 * 0.0335**2 + 0.195**2) / 12 + 0.52 * 0.0975**2
    assert np.hypot(*swung[3:5]) == pytest.approx(8.0 * inertia, rel=1e-4)


def test_turning_steadily_pulls_outwards() -> None:
    straight = rotation_rpy(np.pi, 0.0, 0.0)
    turning = about((0.0, 0.0, 1.0), 3.0, 0.0, straight)
    wrench = wrenches(turning, pose([0.1, 0.0, 0.0]), BOTTLE, STEP)[1]
    assert wrench[0] == pytest.approx(-0.52 * 9.0 * 0.1, rel=1e-5)  # towards the axis
    np.testing.assert_allclose(wrench[2], -WEIGHT, rtol=1e-9)  # the cup holds it up, tool z points down


def changed(scene: Scene, **changes: Any) -> Scene:
    target = scene.items[0]
    return scene.moved(replace(target, item=replace(target.item, **changes)))


def told(scene: Scene) -> list[str]:
    plan, _ = pick()
    return [str(reason) for reason in verify(bound(plan, scene), scene).reasons]


def test_a_face_that_does_not_seal_is_refused() -> None:
    plan, scene = pick()
    assert plan.grasp is not None and plan.grasp.face == "-z"
    seals = scene.items[0].item.seals
    open_face = changed(scene, seals={**seals, "-z": 0.0}, seal_source="perforated")
    assert any("cup not on a face that seals" in t and "perforated" in t for t in told(open_face))
    assert told(changed(scene, seals={face: float(face == "-z") for face in seals})) == []


def test_a_weak_seal_bears_less() -> None:
    _, scene = pick()
    seals = scene.items[0].item.seals
    assert told(scene) == []
    assert any("does not hold" in t for t in told(changed(scene, seals=dict.fromkeys(seals, 0.02))))


@pytest.mark.parametrize(
    ("limits", "expected"),
    [
        (CupLimits(42.0, 21.0, 0.001, 0.21), "pull and moment"),
        (CupLimits(42.0, 0.5, 0.6, 0.21), "shear and twist"),
        (CupLimits(42.0, 21.0, 0.6, 1e-4), "shear and twist"),
    ],
)
def test_each_limit_of_the_cup_counts(limits: CupLimits, expected: str) -> None:
    _, scene = pick()
    robot = scene.cell.robot
    cup = replace(robot.tool.cup, limits=limits)
    weak = replace(robot, tool=replace(robot.tool, grip=cup))
    texts = told(replace(scene, cell=replace(scene.cell, robot=weak)))
    assert any("does not hold" in t and expected in t for t in texts)
    other = "shear and twist" if expected == "pull and moment" else "pull and moment"
    assert not any(other in t for t in texts)


def test_an_item_that_may_be_heavier_than_stated_must_hold_as_such() -> None:
    _, scene = pick()
    assert not any("does not hold" in t for t in told(changed(scene, mass=1.6, mass_error=0.0)))
    assert any("does not hold" in t for t in told(changed(scene, mass=1.6, mass_error=1.0)))


def with_take_up(scene: Scene, speed: float) -> Scene:
    robot = scene.cell.robot
    cup = replace(robot.tool.cup, take_up_speed=speed)
    gentle = replace(robot, tool=replace(robot.tool, grip=cup))
    return replace(scene, cell=replace(scene.cell, robot=gentle))


def test_a_weight_that_turns_the_item_on_the_cup_is_to_be_taken_up_slowly() -> None:
    """The lever of 12.5 mm makes 0.37 of the cup's bending of 1.8 kg, and 0.08 of 0.4 kg."""
    _, scene = pick()
    heavy, light = (changed(scene, mass=mass, mass_error=0.0) for mass in (1.8, 0.4))
    assert any("taken up too fast" in t for t in told(with_take_up(heavy, 0.001)))
    assert not any("taken up too fast" in t for t in told(with_take_up(heavy, 1.0)))
    assert not any("taken up too fast" in t for t in told(with_take_up(light, 0.001)))
