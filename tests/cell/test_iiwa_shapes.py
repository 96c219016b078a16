"""The arm of apple_booth, written from published figures, against the model of the authors of APPLE."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pybullet_data
import pytest

from pickcli.cell.data_path import data_path
from pickcli.cell.robots.urdf import read_urdf
from pickcli.geometry import rotation_angle
from support.mesh_surface import outside, surface_points
from support.plain_urdf import PlainUrdf

THEIRS = Path(pybullet_data.getDataPath()) / "kuka_iiwa"
OURS = data_path() / "cells" / "apple_booth" / "robot.urdf"
ROUNDING = 1.5e-4  # m by which a point may be out of a shape that was rounded to such figures
N_POINTS = 20_000


@pytest.mark.parametrize("k", range(8))
def test_the_shapes_contain_the_real_link(k: int) -> None:
    points = surface_points(THEIRS / "meshes" / f"link_{k}.stl", N_POINTS, np.random.default_rng(3))
    bodies = read_urdf(OURS, OURS.parent, {}).links[f"iiwa_link_{k}"].bodies
    assert outside(points, bodies).max() < ROUNDING
    assert outside(1.2 * points, bodies).max() > 0.005  # the oracle tells shapes that are too small


def test_every_link_is_where_the_authors_have_it() -> None:
    ours, theirs = PlainUrdf.read(OURS, OURS.parent), PlainUrdf.read(THEIRS / "model.urdf", THEIRS)
    rng = np.random.default_rng(7)
    for _ in range(50):
        q = rng.uniform(-2.0, 2.0, 7).tolist()
        own = {f"iiwa_joint_{k}": value for k, value in enumerate(q, 1)}
        their = {f"lbr_iiwa_joint_{k}": value for k, value in enumerate(q, 1)}
        for k in range(8):
            a, b = ours.pose(f"iiwa_link_{k}", own), theirs.pose(f"lbr_iiwa_link_{k}", their)
            assert np.linalg.norm(a[:3, 3] - b[:3, 3]) < 1e-6
            assert rotation_angle(a[:3, :3].T @ b[:3, :3]) < 1e-4
