"""Where the pod stands, from one depth picture: it is rendered, and fitted to what was measured.

Team KTH (paper 000, section III-A) finds the two front legs in a slice of the cloud of a camera at the waist.
Where both are seen, and nothing else may be one, the fit begins there; else with all of its boxes. Either way
all of the pod is fitted, which says more than two of its edges: items in it are outliers of a robust fit.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import Displacement, displaced, pod_stand
from pickcli.cell.sensors.mounted_camera import MountError
from pickcli.cell.sensors.sensor_model import DepthModel
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse
from pickcli.perception.depth_picture import DepthPicture
from pickcli.perception.pod_bound import front_bound, pod_bound
from pickcli.perception.pod_fit import PodFit, PodFitter, ThinnedPicture
from pickcli.perception.pod_legs import FrontLegs
from pickcli.perception.pod_start import PodBoxes

SCANNED, COARSE, FINE = 2_500, 10_000, 40_000  # pixels of the scan, of the first fits, and of the last one
SCAN_STEP = 0.01  # m in y: dividers are thin and alike, and the nearest one may be another
NEAR_STEP, NEAR = 0.002, 0.012  # m of a second scan, and how far aside: few pixels show where a divider is
N_CANDIDATES = 3  # of the first scan, that are fitted
WIDE, NARROW = 0.02, 0.003  # m, scales of the cost of the first fits, and of the last ones
LEAST_POINTS = 400
LEAST_TELLING = 100.0  # pixels that tell where it is along x, and along y: fewer may be edges of something
LEAST_EXPLAINED = 0.35  # share of the pixels that must show the pod where it is said to be
MOST_THROUGH = 0.05  # share of them that may see through it
RIVAL = 1.1  # times the cost of the best place, below which another one may be it as well
APART = 0.01  # m and rad, from which on places are different
LARGEST = Displacement(0.005, 0.005, float(np.radians(0.5)))  # with wider bounds too little of it is seen
WIDEST = Displacement(0.1, 0.1, 0.05)  # bounds that a scene may state (m, m and rad)
MOST_ASIDE = 0.1  # m of tolerance in y: with more the pod may be a bin beside, and look alike
OUT_OF_RANGE = 2.0  # times the sensor's range, from which on depths are in another unit
MEDIAN_STEP = 64  # pixels of which one counts for the median
LEGS_OFF = np.array([0.01, 0.01, np.radians(1.0)])  # m, m and rad, by which legs and the whole pod may differ
EXACT = MountError(0.0, 0.0)


class PodStart(StrEnum):
    """By what the fit of a pod began."""

    LEGS = "legs"
    BOXES = "boxes"


@dataclass(frozen=True, eq=False)
class PodEstimate:
    """The pod as seen in one picture.

    Attributes:
        T_world_pod: (4, 4) its pose. It stands upright on the floor, so only x, y and yaw are estimated.
        error: Bounds of the true pod's pose in the frame of this one, the camera's error included, in which
            99 of 100 should be.
        front_error: m, bound of how far any point of its front is off.
        explained: Share of the pixels that should show it that is within 10 mm of it; others show items.
        n_pixels: Number of these pixels, of a thinned out picture.
        start: By what its fit began; None where that is not known.
    """

    T_world_pod: Array
    error: Displacement
    front_error: float
    explained: float
    n_pixels: int
    start: PodStart | None = None


def locate_pod(
    picture: DepthPicture, cell: Cell, noise: DepthModel, mount: MountError = EXACT,
    T_world_guess: Array | None = None,
) -> PodEstimate:  # fmt: skip
    """Estimate the pose of the pod from a depth picture.

    Args:
        picture: The picture, with the stated pose of its camera.
        cell: A cell with a pod.
        noise: How the sensor measures depth.
        mount: Bounds of the error of the camera's stated pose.
        T_world_guess: (4, 4) where the pod may stand, within its tolerance; None for its place in the cell.

    Returns:
        The estimate. The same picture gives the same bytes.

    Raises:
        InputError: The cell has no pod, the picture is not usable, it shows too little of the pod, what it
            shows does not look like it, the pod stands beyond its tolerance or has too much of it, or the
            camera's error leaves too wide bounds.
    """
    if not cell.pod.bins:
        raise InputError(f"cell {cell.name}: has no pod to be located")
    if cell.pod.displacement.y > MOST_ASIDE:
        aside = f"may stand {cell.pod.displacement.y:g} m aside in cell {cell.name}, {MOST_ASIDE:g} m at most"
        raise InputError(f"pod not located: it {aside}: bins beside look alike; narrow pod.displacement.y")
    check_picture(picture, noise)
    T_guess = cell.T_world_pod if T_world_guess is None else T_world_guess
    fit, start = fit_pod(picture, cell, noise, T_guess)
    refuse_doubtful(fit)
    T_world_pod = displaced(T_guess, *fit.offset)
    error = pod_bound(fit, mount)
    if (_numbers(error) > _numbers(WIDEST)).any():
        off = f"{1e3 * mount.position:.1f} mm and {np.degrees(mount.angle):.2f} degrees"
        raise InputError(
            f"pod not located: the camera's own pose may be off by {off}, which leaves bounds wider than a "
            "scene may state; calibrate its mount"
        )
    beyond = np.abs(fit.offset) - _numbers(cell.pod.displacement) - _numbers(error)
    if (beyond > 0.0).any():
        where = pod_stand(inverse(T_guess) @ T_world_pod)
        raise InputError(f"pod not located: it fits best {where}, which is beyond its tolerance")
    front = front_bound(fit, mount, front_of(cell))
    return PodEstimate(T_world_pod, error, front, fit.explained, fit.n_pixels, start)


def front_of(cell: Cell) -> Array:
    """Return the ends of the front of a cell's pod.

    Args:
        cell: The cell.

    Returns:
        (2, 2) x and y, m in the frame of the pod.
    """
    bodies = cell.pod.bodies
    low = min(float(body.T_parent_shape[0, 3] - body.shape.extents[0] / 2) for body in bodies)
    half = max(float(abs(body.T_parent_shape[1, 3]) + body.shape.extents[1] / 2) for body in bodies)
    return np.array([[low, -half], [low, half]])


def check_picture(picture: DepthPicture, noise: DepthModel) -> None:
    """Refuse a picture that cannot be what the sensor measured.

    Args:
        picture: The picture.
        noise: How the sensor measures depth.

    Raises:
        InputError: It has another size than the camera, nothing was measured, depths are in another unit or
            not above 0, or the camera has no pose.
    """
    picture.check()
    measured = picture.depth[np.isfinite(picture.depth)]
    middle = float(np.median(measured[::MEDIAN_STEP]))
    if not noise.least / OUT_OF_RANGE <= middle <= noise.greatest * OUT_OF_RANGE:
        range_ = f"the sensor measures from {noise.least:g} to {noise.greatest:g} m"
        raise InputError(f"depth: {middle:.4g} m at the median, but {range_}; is it in another unit, as mm?")


def fit_pod(
    picture: DepthPicture, cell: Cell, noise: DepthModel, T_world_guess: Array
) -> tuple[PodFit, PodStart]:
    """Fit the pod, from where its legs are, or from the best places of its boxes.

    Args:
        picture: The picture.
        cell: The cell.
        noise: How the sensor measures depth.
        T_world_guess: (4, 4) where the pod may stand.

    Returns:
        The fit, and by what it began.

    Raises:
        InputError: Too little is measured around the pod, or two places explain the picture as well.
    """
    by_legs = _fitted_from_legs(picture, cell, noise, T_world_guess)
    if by_legs is not None:
        return by_legs, PodStart.LEGS
    return _fitted_from_boxes(picture, cell, noise, T_world_guess), PodStart.BOXES


def _fitted_from_legs(
    picture: DepthPicture, cell: Cell, noise: DepthModel, T_world_guess: Array
) -> PodFit | None:
    """The pod fitted from where its legs are; None if they are not seen, or the picture does not agree."""
    legs = FrontLegs.of(cell)
    by_legs = None if legs is None else legs.located(picture, T_world_guess)
    if by_legs is None:
        return None
    fitter = PodFitter.of(cell, T_world_guess)
    start = np.clip(by_legs, -fitter.tolerance, fitter.tolerance)
    scanned, coarse = (ThinnedPicture.of(picture, noise, most) for most in (SCANNED, COARSE))
    near = _nearer(fitter, scanned, coarse, start)
    fit = fitter.fitted(ThinnedPicture.of(picture, noise, FINE), near.offset, NARROW, 6)
    agrees = (np.abs(fit.offset - by_legs) <= LEGS_OFF).all()
    return fit if agrees and _doubt(fit) is None else None


def _fitted_from_boxes(picture: DepthPicture, cell: Cell, noise: DepthModel, T_world_guess: Array) -> PodFit:
    """The pod drawn to points, scanned in y, and of the best places the best one fitted to more pixels."""
    boxes, fitter = PodBoxes.of(cell), PodFitter.of(cell, T_world_guess)
    coarse = ThinnedPicture.of(picture, noise, COARSE)
    points = boxes.around(coarse.points, T_world_guess)
    if len(points) < LEAST_POINTS:
        few = f"only {len(points)} points are measured around it, at least {LEAST_POINTS} are needed"
        raise InputError(f"pod not located: {few}; look at it from where the sensor measures")
    scanned = ThinnedPicture.of(picture, noise, SCANNED)
    drawn = boxes.drawn(points, T_world_guess)
    aside = cell.pod.displacement.y
    drawn[1] = 0.0
    starts = _scanned(fitter, scanned, _beside(drawn, aside, SCAN_STEP), WIDE)[:N_CANDIDATES]
    rough = sorted((fitter.fitted(coarse, start, WIDE, 3) for start in starts), key=lambda fit: fit.cost)
    rivals = [fit for fit in rough[1:] if _are_apart(fit, rough[0]) and fit.cost < RIVAL * rough[0].cost]
    fits = [_nearer(fitter, scanned, coarse, fit.offset) for fit in (rough[0], *rivals)]
    best = min(fits, key=lambda fit: fit.cost)
    for other in fits:
        if _are_apart(other, best) and other.cost < RIVAL * best.cost:
            alike = f"two places, {1e3 * np.hypot(*(other.offset - best.offset)[:2]):.0f} mm apart"
            raise InputError(f"pod not located: {alike}, explain the picture as well; show more of the pod")
    return fitter.fitted(ThinnedPicture.of(picture, noise, FINE), best.offset, NARROW, 6)


def _nearer(fitter: PodFitter, scanned: ThinnedPicture, coarse: ThinnedPicture, offset: Array) -> PodFit:
    """The fit of a narrow cost that begins at the best place beside an offset."""
    start = _scanned(fitter, scanned, _beside(offset, NEAR, NEAR_STEP), NARROW)[0]
    return fitter.fitted(coarse, start, NARROW, 6)


def _are_apart(one: PodFit, other: PodFit) -> bool:
    return bool(np.abs(one.offset - other.offset).max() > APART)


def _beside(offset: Array, aside: float, step: float) -> list[Array]:
    """Offsets (3,) that are up to so many m beside one in y."""
    n = int(np.ceil(aside / step))  # to each side
    return [offset + np.array([0.0, y, 0.0]) for y in np.linspace(-aside, aside, 1 + 2 * n)]


def _scanned(fitter: PodFitter, picture: ThinnedPicture, offsets: list[Array], scale: float) -> list[Array]:
    """Offsets by the cost there, the least first."""
    return sorted(offsets, key=lambda offset: fitter.cost(picture, offset, scale))


def refuse_doubtful(fit: PodFit) -> None:
    """Refuse a fit that does not show the pod, or too little of it.

    Args:
        fit: The fit.

    Raises:
        InputError: It does not.
    """
    if (doubt := _doubt(fit)) is not None:
        raise InputError(f"pod not located: {doubt}")


def _doubt(fit: PodFit) -> str | None:
    """What is to be doubted of a fit, and what to do about it; None if nothing is."""
    if fit.explained < LEAST_EXPLAINED:
        found = f"only {100 * fit.explained:.0f} % of the points in its place lie on it where it fits best"
        return f"{found}; does it stand within its tolerance, and is this it?"
    if fit.through > MOST_THROUGH:
        found = f"{100 * fit.through:.0f} % of the points in its place are behind it where it fits best"
        return f"{found}; does it stand within its tolerance, and is this it?"
    if (fit.n_telling < LEAST_TELLING).any():
        few = " and ".join(
            f"{n:.0f} pixels along {axis}" for n, axis in zip(fit.n_telling, "xy", strict=True)
        )
        least = f"at least {LEAST_TELLING:.0f} are needed"
        return f"only {few} tell where it is, {least}; show more of its sides"
    error = pod_bound(fit, EXACT)
    if (np.abs(fit.step) > _numbers(error)).any():
        return "the fit does not settle; show more of the pod"
    if (_numbers(error) > _numbers(LARGEST)).any():
        off = f"{1e3 * error.x:.1f} mm in x, {1e3 * error.y:.1f} mm in y and {np.degrees(error.yaw):.2f}"
        return f"what is seen leaves {off} degrees open; show more of its sides"
    return None


def _numbers(bounds: Displacement) -> Array:
    return np.array([bounds.x, bounds.y, bounds.yaw])
