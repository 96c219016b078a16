"""Where rays enter solids and leave them, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.geometry import rotation_rpy
from pickcli.verification.ray_casting import cast_rays
from support.solid_oracles import is_inside

BOX = Shape(ShapeKind.BOX, (0.2, 0.4, 0.6))
CAN = Shape(ShapeKind.CYLINDER, (0.1, 0.5))
BALL = Shape(ShapeKind.SPHERE, (0.15,))
DIAGONAL = (0.6, 0.8, 0.0)


@pytest.mark.parametrize(
    ("shape", "start", "along", "ends"),
    [
        (BOX, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (-0.1, 0.1)),
        (BOX, (0.05, -0.1, 0.7), (0.0, 0.0, -1.0), (0.4, 1.0)),
        (BOX, (0.0, -0.2, 0.1), DIAGONAL, (0.0, 1 / 6)),
        (BOX, (0.11, 0.0, 0.0), (0.0, 1.0, 0.0), None),
        (BOX, (0.0, 0.21, 0.0), (0.0, 0.0, 1.0), None),
        (BOX, (-0.4, 0.0, 0.0), DIAGONAL, None),
        (CAN, (0.0, 0.0, 0.1), (0.0, 0.0, 1.0), (-0.35, 0.15)),
        (CAN, (0.06, 0.0, 0.0), (0.0, 1.0, 0.0), (-0.08, 0.08)),
        (CAN, (0.0, -0.5, 0.3), (0.0, 0.8, -0.6), (0.5, 0.75)),
        (CAN, (0.11, 0.0, 0.0), (0.0, 0.0, 1.0), None),
        (CAN, (0.0, 0.0, 0.26), (1.0, 0.0, 0.0), None),
        (CAN, (0.0, 0.11, 0.0), (1.0, 0.0, 0.0), None),
        (BALL, (0.0, 0.09, 0.0), (0.0, 0.0, 1.0), (-0.12, 0.12)),
        (BALL, (1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (-1.15, -0.85)),
        (BALL, (0.0, 0.16, 0.0), (1.0, 0.0, 0.0), None),
    ],
)  # fmt: skip
def test_rays_enter_and_leave_where_they_meet_the_surface(
    shape: Shape,
    start: tuple[float, float, float],
    along: tuple[float, float, float],
    ends: tuple[float, float] | None,
) -> None:
    enters, leaves = cast_rays(shape, np.array([start, start]), np.array(along))
    for found in zip(enters, leaves, strict=True):
        assert found == pytest.approx(ends or (np.nan, np.nan), abs=1e-9, nan_ok=True)


@pytest.mark.parametrize("shape", [BOX, CAN, BALL])
def test_between_its_ends_a_ray_is_inside_and_elsewhere_it_is_not(shape: Shape) -> None:
    rng = np.random.default_rng(2)
    starts = rng.uniform(-0.4, 0.4, (200, 3))
    along = rotation_rpy(0.3, -0.5, 1.1)[:, 0]
    enters, leaves = cast_rays(shape, starts, along)
    is_met = np.isfinite(enters)
    assert 0 < is_met.sum() < len(starts)
    for share, is_in in ((0.001, True), (0.5, True), (0.999, True), (-0.001, False), (1.001, False)):
        at = starts + (enters + share * (leaves - enters))[:, None] * along
        assert (is_inside(shape, at[is_met]) == is_in).all()
    for t in np.linspace(-1.0, 1.0, 101):
        assert not is_inside(shape, (starts + t * along)[~is_met]).any()
