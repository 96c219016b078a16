"""How far spheres reach out of the shapes that they cover."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.inertial import assumed_inertial
from pickcli.cell.robot import Link
from pickcli.cell.shapes import Body, Shape, ShapeKind
from pickcli.collision.robot_model import CollisionModel
from pickcli.collision.sphere_cover import Cover
from pickcli.robot_setup.sphere_excess import mean_excess, mean_of, sphere_excess
from support.bare_robot import write_bare_robot


def test_every_link_with_shapes_is_measured(tmp_path: Path) -> None:
    cell = load_cell(write_bare_robot(tmp_path))
    model = CollisionModel(cell)
    measured = sphere_excess(cell, model)
    assert [each.link for each in measured] == ["upper", "camera", "lower", "hand", "left", "right"]
    for each in measured:
        assert each.n_spheres == len(model.covers[each.link].radii)
        assert 0.0 <= each.mean_excess <= each.max_excess + 1e-6
    assert min(each.mean_excess for each in measured) <= mean_of(measured) <= measured[0].max_excess + 0.02
    assert mean_of([]) == 0.0


@pytest.mark.parametrize("out", [0.0, 0.01])
def test_a_larger_sphere_around_a_ball_reaches_out_by_the_difference(out: float) -> None:
    link = Link("ball", (Body("ball", Shape(ShapeKind.SPHERE, (0.05,)), np.eye(4)),), assumed_inertial(()))
    inner = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.001]])  # the second one is inside of the first
    cover = Cover(inner, np.array([0.05 + out, 0.04]), out)
    assert mean_excess(link, cover) == pytest.approx(out, abs=1e-5)
