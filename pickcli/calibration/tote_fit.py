"""Where a tote stands, by points of its faces that were touched: least squares, with bounds of the error.

KTH (paper 000, section III-A) put the tips of both arms on known points of the tote and took the pose from
forward kinematics. Here each touch says only how far the tote is along the normal of one face, so that the
lip need not meet a point, and more touches than unknowns tell whether they fit.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.calibration.touch_points import TouchPoint
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse, pose, rotation_from_vector

FACTOR = 3.5  # standard deviations in a bound, besides what errors that do not vary add
MISFIT = 4.5  # standard deviations of a residual, besides those, from which on it does not fit
CLEARLY = 2.0  # times the misfit without one touch, over which that without another one is clearly worse
STEPS = 8  # of Gauss and Newton; each is right to the square of the one before
LEAST_INFORMATION = 1e-6  # of the largest singular value, relative: with less a direction is not fixed
UPRIGHT = ("x", "y", "z", "yaw")
TILTED = (*UPRIGHT, "roll", "pitch")
_COLUMNS = {"x": 0, "y": 1, "z": 2, "roll": 3, "pitch": 4, "yaw": 5}


@dataclass(frozen=True, eq=False)
class TouchedPoint:
    """Where a face was touched.

    Attributes:
        aim: What was to be touched.
        point: (3,) m in the world, middle of the lip as it met the face.
        deviation: m, standard deviation of the point along the face's normal.
        bias: m, bound of an error along it that is the same however often it is touched.
    """

    aim: TouchPoint
    point: Array
    deviation: float
    bias: float


@dataclass(frozen=True, eq=False)
class ToteEstimate:
    """The pose of a tote.

    Attributes:
        T_world_tote: (4, 4) estimate: the middle of the inner floor.
        names: The k quantities estimated, of x, y, z (m, in the tote's frame), yaw, roll and pitch (rad).
        covariance: (k, k) of their errors, without biases, m and rad.
        bounds: (k,) of their errors: 99 of 100 poses should be within all of them.
        residuals: (N,) m by which each touched point is outside of its face.
    """

    T_world_tote: Array
    names: tuple[str, ...]
    covariance: Array
    bounds: Array
    residuals: Array

    def bound(self, name: str) -> float:
        """Return the bound of one quantity.

        Args:
            name: One of ``names``.

        Returns:
            m or rad.
        """
        return float(self.bounds[self.names.index(name)])


def fit_tote(
    touched: Sequence[TouchedPoint], T_world_guess: Array, names: tuple[str, ...] = UPRIGHT
) -> ToteEstimate:
    """Estimate the pose of a tote from touched points, without a judgement of their fit.

    Args:
        touched: The N touched points.
        T_world_guess: (4, 4) pose near which it is.
        names: What is estimated; all else is that of the guess.

    Returns:
        The estimate.

    Raises:
        InputError: The points do not fix all that is to be estimated.
    """
    T = np.array(T_world_guess)
    columns = [_COLUMNS[name] for name in names]
    deviations = np.array([each.deviation for each in touched])
    for _ in range(STEPS):
        residuals, jacobian = _residuals(touched, T)
        weighted = jacobian[:, columns] / deviations[:, None]
        _refuse_open(weighted, names)
        step = np.zeros(6)
        step[columns] = -np.linalg.lstsq(weighted, residuals / deviations, rcond=None)[0]
        T = T @ pose(step[:3], R=rotation_from_vector(step[3:]))
    residuals, jacobian = _residuals(touched, T)
    weighted = jacobian[:, columns] / deviations[:, None]
    gain = np.linalg.pinv(weighted) / deviations  # (k, N) of the estimate by each point
    covariance = np.linalg.inv(weighted.T @ weighted)
    biases = np.abs(gain) @ np.array([each.bias for each in touched])
    bounds = FACTOR * np.sqrt(np.diag(covariance)) + biases
    return ToteEstimate(T, names, covariance, bounds, residuals)


def _residuals(touched: Sequence[TouchedPoint], T_world_tote: Array) -> tuple[Array, Array]:
    """Distances (N,) in m of points outside of their faces, and their derivatives (N, 6).

    The derivatives are by a shift along the tote's axes, and a turn about them.
    """
    normals = np.array([each.aim.face.normal for each in touched])
    T_tote_world = inverse(T_world_tote)
    points = np.array([(T_tote_world @ [*each.point, 1.0])[:3] for each in touched])
    offsets = points - np.array([each.aim.point for each in touched])
    return np.einsum("ij,ij->i", normals, offsets), np.hstack([-normals, -np.cross(points, normals)])


def _refuse_open(weighted: Array, names: tuple[str, ...]) -> None:
    """Refuse touches that leave a direction open. weighted: (N, k), of m and rad alike."""
    scaled = weighted / np.maximum(np.linalg.norm(weighted, axis=0), 1e-300)
    _, singular, directions = np.linalg.svd(scaled, full_matrices=True)
    if len(weighted) < len(names) or singular[-1] < LEAST_INFORMATION:
        open_left = names[int(np.argmax(np.abs(directions[-1])))]
        raise InputError(
            f"tote not located: {len(weighted)} touches do not fix its {open_left}; touch faces of other "
            "directions, or farther apart"
        )


def refuse_misfit(touched: Sequence[TouchedPoint], T_world_guess: Array, fit: ToteEstimate) -> None:
    """Refuse touched points that do not fit one pose of the tote, and name the one that does not.

    Args:
        touched: The touched points.
        T_world_guess: (4, 4) pose near which the tote is.
        fit: Their fit.

    Raises:
        InputError: A point is off its face by more than the errors of the touches explain.
    """
    if (np.abs(fit.residuals) <= _allowed(touched)).all():
        return
    suspects = _suspects(touched, T_world_guess, fit.names)
    if suspects and (len(suspects) == 1 or suspects[1].misfit > CLEARLY * suspects[0].misfit):
        raise InputError(
            f"tote not located: touch {suspects[0].name} is {1e3 * abs(suspects[0].off):.1f} mm "
            f"{'before' if suspects[0].off > 0.0 else 'behind'} that face by all others: it met something "
            "else; look what lies there, and locate it again"
        )
    worst = int(np.argmax(np.abs(fit.residuals) / _allowed(touched)))
    which = " or ".join(each.name for each in suspects)
    raise InputError(
        f"tote not located: the touches do not fit its shape (touch {touched[worst].aim.name} is off by "
        f"{1e3 * abs(fit.residuals[worst]):.1f} mm): {which or 'more than one'} met something else, or it is "
        "another tote"
    )


@dataclass(frozen=True)
class _Suspect:
    """A touch without which all others fit.

    Attributes:
        name: Of the touch.
        misfit: Largest residual of the others, as a share of the allowed one.
        off: m by which it is outside of its face by their fit.
    """

    name: str
    misfit: float
    off: float


def _suspects(
    touched: Sequence[TouchedPoint], T_world_guess: Array, names: tuple[str, ...]
) -> list[_Suspect]:
    """Find the touches without which all others fit, the one without which they fit best first."""
    found = []
    for i, each in enumerate(touched):
        others = [*touched[:i], *touched[i + 1 :]]
        try:
            fit = fit_tote(others, T_world_guess, names)
        except InputError:  # without it a direction is open
            continue
        misfit = float((np.abs(fit.residuals) / _allowed(others)).max())
        if misfit <= 1.0:
            off = float(_residuals([each], fit.T_world_tote)[0][0])
            found.append(_Suspect(each.aim.name, misfit, off))
    return sorted(found, key=lambda suspect: suspect.misfit)


def _allowed(touched: Sequence[TouchedPoint]) -> Array:
    """Largest residual (N,) of each point, m, that its own error and those of the others explain."""
    own = np.array([MISFIT * each.deviation + each.bias for each in touched])
    return np.asarray(own + np.median(own))
