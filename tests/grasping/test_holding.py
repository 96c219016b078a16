"""The load model against cases worked by hand."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.geometry import rotation_rpy
from pickcli.grasping.holding import GRAVITY, load, static_load

DOWN = np.diag([1.0, -1.0, -1.0])
FORWARD = rotation_rpy(0.0, np.pi / 2, 0.0)  # tool z along world x


def test_item_hanging_below_the_cup_only_pulls() -> None:
    worst = static_load(0.5, DOWN, np.array([0.0, 0.0, 0.05]))
    assert worst.pull == pytest.approx(0.5 * GRAVITY)
    assert worst.shear == pytest.approx(0.0, abs=1e-12)
    assert worst.moment == pytest.approx(0.0, abs=1e-12)


def test_frontal_bottle_of_the_facts() -> None:
    """Dasani lying along the tool: 0.52 kg at 97.5 mm gives the 0.5 Nm that the facts name."""
    worst = static_load(0.52, FORWARD, np.array([0.0, 0.0, 0.0975]))
    assert worst.moment == pytest.approx(0.497, abs=1e-3)
    assert worst.shear == pytest.approx(0.52 * GRAVITY)
    assert worst.pull == pytest.approx(0.0, abs=1e-9)


def test_free_fall_loads_nothing() -> None:
    falling = np.array([[0.0, 0.0, -GRAVITY]])
    worst = load(1.0, DOWN[None], np.array([0.02, 0.0, 0.05]), falling)
    assert max(worst.pull, worst.shear, worst.moment) < 1e-12


def test_pushing_onto_the_item_is_no_pull() -> None:
    up = np.eye(3)  # the cup under the item
    assert static_load(1.0, up, np.array([0.0, 0.0, 0.05])).pull == 0.0
