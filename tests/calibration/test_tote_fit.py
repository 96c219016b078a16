"""The pose of the tote by touched points: against known poses, with noise, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from pickcli.calibration.tote_fit import TILTED, UPRIGHT, TouchedPoint, fit_tote, refuse_misfit
from pickcli.calibration.tote_location import tote_offset
from pickcli.calibration.tote_shape import ToteShape, tote_shape
from pickcli.calibration.touch_points import touch_points
from pickcli.cell.cell_file import load_cell
from pickcli.errors import InputError
from pickcli.geometry import Array, pose

DEVIATION, BIAS = 1.2e-4, 3e-4
LIP = 0.015


@cache
def shape() -> ToteShape:
    return tote_shape(load_cell("apc2016_delft"))


def moved(x: float = 0.012, y: float = -0.02, z: float = 0.001, **angles: float) -> Array:
    """The tote off its place, m and rad."""
    rpy = [angles.get(name, 0.0) for name in ("roll", "pitch", "yaw")]
    return np.asarray(shape().T_world_tote @ pose((x, y, z), rpy=tuple(rpy)))


def touches(T: Array, n: int = 8, errors: Array | None = None) -> list[TouchedPoint]:
    """Points of the faces of a tote at T, off by errors (n,) along the normals, and 3 mm along the faces."""
    errors = np.zeros(n) if errors is None else errors
    found = []
    for aim, error in zip(touch_points(shape(), n, LIP), errors, strict=True):
        face = aim.face
        p = aim.point + error * face.normal + 0.003 * face.along
        found.append(TouchedPoint(aim, (T @ [*p, 1.0])[:3], DEVIATION, BIAS))
    return found


def guess() -> Array:
    return shape().T_world_tote


@pytest.mark.parametrize("yaw", [-0.05, 0.0, 0.03])
@pytest.mark.parametrize("n", [6, 8, 10])
def test_exact_points_give_the_exact_pose(n: int, yaw: float) -> None:
    T = moved(0.03, -0.03, yaw=yaw)
    fit = fit_tote(touches(T, n), guess())
    np.testing.assert_allclose(fit.T_world_tote, T, atol=1e-9)
    np.testing.assert_allclose(fit.residuals, 0.0, atol=1e-9)
    refuse_misfit(touches(T, n), guess(), fit)


def test_a_tilt_is_found_if_it_is_looked_for() -> None:
    T = moved(yaw=0.02, roll=0.004, pitch=-0.006)
    np.testing.assert_allclose(fit_tote(touches(T), guess(), TILTED).T_world_tote, T, atol=1e-9)
    upright = fit_tote(touches(T), guess())
    assert np.abs(upright.residuals).max() > 3e-4
    with pytest.raises(InputError, match="tote not located"):
        refuse_misfit(touches(moved(roll=0.02)), guess(), fit_tote(touches(moved(roll=0.02)), guess()))


@pytest.mark.parametrize("names", [UPRIGHT, TILTED])
def test_covariance_is_that_of_many_draws_and_bounds_hold(names: tuple[str, ...]) -> None:
    """With errors as stated: normal ones of each touch, and a bias of each anywhere within its bound."""
    rng, T = np.random.default_rng(5), moved(yaw=0.02)
    normal, kept = [], 0
    for _ in range(400):
        noise, bias = rng.normal(0.0, DEVIATION, 8), rng.uniform(-BIAS, BIAS, 8)
        fit = fit_tote(touches(T, 8, noise), guess(), names)
        normal.append([*tote_offset(fit.T_world_tote, T, names).values()])
        biased = fit_tote(touches(T, 8, noise + bias), guess(), names)
        off = np.array([*tote_offset(biased.T_world_tote, T, names).values()])
        kept += bool((np.abs(off) <= biased.bounds).all())
    drawn = np.cov(np.array(normal).T)
    np.testing.assert_allclose(np.sqrt(np.diag(drawn)), np.sqrt(np.diag(fit.covariance)), rtol=0.12)
    assert kept >= 0.99 * 400


def test_a_bias_of_all_touches_alike_is_within_the_bounds() -> None:
    """As of bellows that are stiffer than stated: walls cancel out or shift the tote, rims raise it."""
    fit = fit_tote(touches(moved(), 8, np.full(8, BIAS)), guess())
    off = np.array([*tote_offset(fit.T_world_tote, moved()).values()])
    assert np.abs(off).max() > 0.5 * BIAS and (np.abs(off) <= fit.bounds).all()


@pytest.mark.parametrize(
    ("left", "open_left"),
    [(("wall left", "wall right", "rim near"), "x"), (("wall near", "wall far", "rim near"), "y|yaw"),
     (("wall left", "wall near", "wall far", "wall right"), "z")],
)  # fmt: skip
def test_touches_that_leave_a_direction_open_are_refused(left: tuple[str, ...], open_left: str) -> None:
    some = [each for each in touches(moved()) if each.aim.face.name in left]
    told = f"tote not located: {len(some)} touches do not fix its ({open_left});"
    with pytest.raises(InputError, match=told):
        fit_tote(some, guess())


def test_fewer_touches_than_unknowns_are_refused() -> None:
    with pytest.raises(InputError, match="5 touches do not fix its "):
        fit_tote(touches(moved())[:5], guess(), TILTED)


@pytest.mark.parametrize(("i", "off"), [(0, 0.005), (1, -0.004), (6, 0.006)])
def test_what_met_something_else_is_named(i: int, off: float) -> None:
    errors = np.zeros(10)
    errors[i] = off
    wrong = touches(moved(), 10, errors)
    name, side = wrong[i].aim.name, "before" if off > 0.0 else "behind"
    with pytest.raises(InputError, match=f"touch {name} is {1e3 * abs(off):.1f} mm {side} that face"):
        refuse_misfit(wrong, guess(), fit_tote(wrong, guess()))


def test_two_that_contradict_each_other_are_both_named() -> None:
    """Of two walls that face each other, nothing else tells which one was not met."""
    errors = np.zeros(8)
    errors[2] = 0.01
    wrong = touches(moved(), 8, errors)
    with pytest.raises(InputError, match="3 wall near or 5 wall far met something else"):
        refuse_misfit(wrong, guess(), fit_tote(wrong, guess()))


def test_another_tote_is_refused() -> None:
    wrong = touches(moved(), 10, np.array([0.01, 0.01, 0.01, 0.01, 0.01, 0.0, 0.0, 0.0, 0.0, 0.004]))
    with pytest.raises(InputError, match="or it is another tote"):
        refuse_misfit(wrong, guess(), fit_tote(wrong, guess()))


def test_worse_touches_have_wider_bounds() -> None:
    good, bad = touches(moved()), [replace(each, deviation=4 * DEVIATION) for each in touches(moved())]
    assert (fit_tote(bad, guess()).bounds > fit_tote(good, guess()).bounds).all()
