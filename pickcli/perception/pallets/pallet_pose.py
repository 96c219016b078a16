"""Where a pallet stands, from one depth picture of its entry side.

APPLE (Krug et al. 2016, section II-A) tracks a pallet by its signed distance field while the truck drives
in. Ours looks at its front alone, through whose pockets is seen: what stands or lies on the deck does not
matter, and a box of the same size is none.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.cell.pod_tolerance import Displacement
from pickcli.cell.sensors.mounted_camera import MountError
from pickcli.cell.sensors.sensor_model import DepthModel
from pickcli.errors import InputError
from pickcli.geometry import Array
from pickcli.perception.depth_picture import DepthPicture
from pickcli.perception.floor_pose_bound import pose_bound
from pickcli.perception.pallets.front_fit import FIRST, LAST, FrontFit, approached
from pickcli.perception.pallets.front_search import PalletZone, pallet_candidates
from pickcli.perception.pallets.front_shares import FrontShares
from pickcli.perception.pallets.pallet_shape import PalletShape
from pickcli.perception.pod_fit import ThinnedPicture
from pickcli.perception.pod_pose import EXACT, check_picture

SEARCHED = 20_000  # pixels in which places are looked for
N_FITTED = 3  # of them, those of least cost
SAME = np.array([0.03, 0.03, 0.05])  # m, m and rad: less are two fits of one place apart
FACTOR = 2.5  # of standard deviations; ``bench.pallet_pose --pictures 350 --seed 1 --calibrate`` says 2.34
LEAST_SHARE = 0.5  # of each part of the front that has to be seen as it is
LEAST_PARTS = 2  # of three runners, and of three parts of the deck's edge
LEAST_VISIBLE = 0.4  # of the front
MOST_COST = 0.15  # of a fit
LARGEST = Displacement(0.02, 0.02, float(np.radians(1.5)))  # with wider bounds too little of it is seen


@dataclass(frozen=True, eq=False)
class PalletEstimate:
    """A pallet as seen in one picture.

    Attributes:
        shape: The pallet.
        pose: (3,) m, m, rad of its middle, x out of its entry side, in the frame on the floor.
        error: Bounds of the true pose in the frame of this one, the camera's error included, in which 99 of
            100 should be.
        residual: m, root of the mean square of distances of the pixels of its front.
        n_pixels: Number of these pixels, of a thinned out picture.
        visible: Share of its front that nothing hides.
    """

    shape: PalletShape
    pose: Array
    error: Displacement
    residual: float
    n_pixels: int
    visible: float


def detect_pallet(
    picture: DepthPicture, noise: DepthModel, shape: PalletShape, zone: PalletZone, mount: MountError = EXACT
) -> PalletEstimate:
    """Find a pallet and estimate its pose.

    Args:
        picture: The picture, with the stated pose of its camera in a frame on the floor, z up.
        noise: How the sensor measures depth.
        shape: The pallet.
        zone: Where it is expected in that frame.
        mount: Bounds of the error of the camera's stated pose.

    Returns:
        The estimate. The same picture gives the same bytes.

    Raises:
        InputError: The picture is not usable, or there is no pallet in the zone, with the reason.
    """
    check_picture(picture, noise)
    starts = pallet_candidates(ThinnedPicture.of(picture, noise, SEARCHED), shape, zone)
    if not starts:
        raise InputError(
            "no pallet here: nowhere in the zone do runners and pockets of its widths alternate; look at its "
            "entry side from where the sensor measures"
        )
    rough = [approached(picture, noise, shape, start, FIRST) for start in starts]
    likely = _apart(sorted((fit for fit in rough if fit is not None), key=lambda fit: fit.cost))[:N_FITTED]
    fits = [approached(picture, noise, shape, fit.pose, LAST) for fit in likely]
    reasons = []
    for fit in sorted((fit for fit in fits if fit is not None), key=lambda fit: fit.cost):
        shares = FrontShares.of(picture, noise, shape, fit.pose)
        fault = _doubt(fit, shares, zone)
        if fault is None:
            error = pose_bound(fit, mount, FACTOR)
            return PalletEstimate(shape, fit.pose, error, shares.residual, shares.n_pixels, shares.visible)
        reasons.append(fault)
    where = reasons[0] if reasons else "what looks like its front is at the edge of the picture"
    raise InputError(f"no pallet here: {where}")


def _apart(fits: list[FrontFit]) -> list[FrontFit]:
    """Fits without those that ended where an earlier one did."""
    kept: list[FrontFit] = []
    for fit in fits:
        if all((np.abs(fit.pose - other.pose) > SAME).any() for other in kept):
            kept.append(fit)
    return kept


def _doubt(fit: FrontFit, shares: FrontShares, zone: PalletZone) -> str | None:
    """Why a fit is not the pallet; None if it is."""
    parts = (
        ("a runner", shares.runners, LEAST_PARTS), ("the edge of the deck", shares.deck, LEAST_PARTS),
        ("a pocket", shares.pockets, 1), ("an end of its front", shares.beside, 0),
    )  # fmt: skip
    for name, values, least in parts:
        known = values[np.isfinite(values)]
        if len(known) and known.min() < LEAST_SHARE:
            return f"where {name} should be, {known.min():.0%} of the pixels look like it; is it a box?"
        if len(known) < least:
            return f"too little is seen of the place of {name}; show more of its front"
    if shares.visible < LEAST_VISIBLE:
        return f"only {shares.visible:.0%} of its front is visible; remove what stands before it"
    if fit.cost > MOST_COST:
        return f"what is there differs from its front by {fit.cost:.2f}, at most {MOST_COST:g} is a pallet"
    if not zone.holds(fit.pose):
        return "what looks like it stands beyond the zone; widen its tolerance"
    open_left = pose_bound(fit, EXACT, FACTOR)
    bounds = (open_left.x, open_left.y, open_left.yaw)
    if (np.array(bounds) > [LARGEST.x, LARGEST.y, LARGEST.yaw]).any():
        off = f"{1e3 * open_left.x:.0f} mm, {1e3 * open_left.y:.0f} mm and {np.degrees(open_left.yaw):.1f}"
        return f"what is seen leaves {off} degrees open; show more of its front"
    return None
