"""How far the cup is pressed on: onto the face wherever it is, and not beyond its bellows."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.cell import Cell
from pickcli.geometry import pose
from pickcli.grasping.cup_press import LEAST_OF_STROKE, MOST_OF_STROKE, PRESS, overtravel
from pickcli.motion.plan import Grasp
from pickcli.scene.scene import PoseNoise
from support.tool_states import DOWN

DEGREE = float(np.radians(1.0))


def at(x: float) -> Grasp:
    """A grasp on top of an item, x m from its middle."""
    T = pose([x, 0.0, 0.01], R=np.diag([1.0, -1.0, -1.0]))
    return Grasp("item", "top-down", "+z", DOWN, T, *[0.0] * 6)


@pytest.mark.parametrize(
    ("noise", "x"),
    [(PoseNoise(), 0.0), (PoseNoise(0.002, DEGREE), 0.0), (PoseNoise(0.002, DEGREE), 0.08)],
)
def test_the_cup_meets_the_face_and_its_bellows_keep_their_stroke(
    cell: Cell, noise: PoseNoise, x: float
) -> None:
    tool = cell.robot.tool
    off = noise.position + noise.angle * x
    pressed = overtravel(at(x), tool, noise)
    assert pressed + off <= tool.cup.stroke + 1e-12
    assert pressed >= off  # it meets the face, wherever that is
    if x == 0.0:
        assert pressed == pytest.approx(off + PRESS)


def test_what_is_hardly_known_is_pressed_on_by_a_share_of_the_stroke(cell: Cell) -> None:
    tool = cell.robot.tool
    for position in (0.006, 0.02):
        pressed = overtravel(at(0.0), tool, PoseNoise(position, DEGREE))
        assert pressed == pytest.approx(LEAST_OF_STROKE * tool.cup.stroke)
        assert pressed < MOST_OF_STROKE * tool.cup.stroke
