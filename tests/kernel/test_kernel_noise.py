"""Depth with noise: statistics of many pixels against the coefficients that they were drawn with."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

from pickcli.geometry import Array, pose
from pickcli.kernel import DepthNoise, philox4x32, set_simd, simd
from support.ray_reference import Solids, rays, seen

INTRINSICS = np.array([400.0, 400.0, 159.5, 119.5])
SIZE = np.array([320, 240], np.int32)
RANGE: dict[str, Any] = {"least": 0.1, "greatest": 9.0, "incidence_from": 1.54, "incidence_to": 1.57}


def wall(z: float, turn: float = 0.0) -> Solids:
    """A large wall whose face is at depth z in the middle of the picture, turned about the vertical."""
    solids = Solids()
    T = pose((0.0, 0.0, z), rpy=(0.0, turn, 0.0)) @ pose((0.0, 0.0, 0.5))
    solids.add(T, np.array([50.0, 50.0, 0.5]))
    return solids


def measured(solids: Solids, seed: int = 1, no_return: float = 0.0, **coefficients: Any) -> Array:
    noise = DepthNoise(**{**RANGE, **coefficients})
    shares = np.full(len(solids.T), no_return)
    depth = solids.scene.measured_depth(INTRINSICS, SIZE, np.eye(4), noise, shares, seed)
    return np.asarray(depth, dtype=np.float64)


def true(solids: Solids) -> Array:
    return seen(solids, INTRINSICS, (320, 240), np.eye(4))[0]


def angle(solids: Solids, turn: float) -> Array:
    """(H, W) angles at which rays meet the wall."""
    d, normal = rays(INTRINSICS, (320, 240)), np.array([-np.sin(turn), 0.0, -np.cos(turn)])
    return np.asarray(np.arccos(np.abs(d @ normal) / np.linalg.norm(d, axis=-1)))


@pytest.mark.parametrize(
    ("counter", "key", "expected"),
    [
        ([0] * 4, [0] * 2, [0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8]),
        ([0xFFFFFFFF] * 4, [0xFFFFFFFF] * 2, [0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD]),
        (
            [0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344],
            [0xA4093822, 0x299F31D0],
            [0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1],
        ),
    ],
)
def test_random_words_are_those_of_the_reference(
    counter: list[int], key: list[int], expected: list[int]
) -> None:
    """The known answers of the authors' library, Random123."""
    words = philox4x32(np.array(counter, np.uint64), np.array(key, np.uint64))
    assert words.tolist() == expected


@pytest.mark.parametrize("z", [0.5, 1.0, 2.5])
@pytest.mark.parametrize("correlation", [0.0, 1.0])
def test_axial_noise_of_structured_light_has_its_deviation(z: float, correlation: float) -> None:
    error = measured(wall(z), constant=0.0012, quadratic=0.0019, from_depth=0.4, correlation=correlation) - z
    sigma = 0.0012 + 0.0019 * (z - 0.4) ** 2
    tolerance = 0.01 if correlation == 0.0 else 0.03  # correlated errors are fewer independent ones
    assert error.std() == pytest.approx(sigma, rel=tolerance)
    assert abs(error.mean()) < 4 * sigma * (4 if correlation else 1) / np.sqrt(error.size)
    standard = np.abs(error / sigma)
    for bound, share in ((1.0, 0.6827), (2.0, 0.9545), (3.0, 0.9973)):
        assert (standard < bound).mean() == pytest.approx(share, abs=0.015)


@pytest.mark.parametrize("z", [0.4, 0.9, 1.6])
def test_stereo_noise_grows_with_the_square_of_depth(z: float) -> None:
    error = measured(wall(z), baseline=0.1, disparity_error=0.08)[:, 5:-5] - z
    assert error.std() == pytest.approx(0.08 * z * z / (400.0 * 0.1), rel=0.01)


@pytest.mark.parametrize("turn", [0.4, 1.15, 1.3])
def test_oblique_surfaces_are_noisier_from_their_angle_on(turn: float) -> None:
    solids = wall(1.0, turn)
    z, t = true(solids), angle(solids, turn)
    depth = measured(solids, constant=0.001, oblique=1e-4, oblique_from=np.pi / 3)
    sigma = 0.001 + np.where(t > np.pi / 3, 1e-4 / np.sqrt(z) * t**2 / (np.pi / 2 - t) ** 2, 0.0)
    fits = np.isfinite(depth) & (t < 1.45)
    assert fits.sum() > 20_000
    standard = ((depth - z) / sigma)[fits]
    assert standard.std() == pytest.approx(1.0, rel=0.015)
    assert abs(standard.mean()) < 0.03


def test_neighbours_err_alike_where_they_are_correlated() -> None:
    """By the autocorrelation of a Gaussian filter of 1 px over two neighbours on each side."""
    weights = np.exp(-0.5 * np.arange(-2, 3) ** 2)
    for correlation, expected in ((0.0, 0.0), (1.0, (weights[1:] @ weights[:-1]) / (weights @ weights))):
        error = measured(wall(1.0), constant=0.001, correlation=correlation) - 1.0
        for a, b in ((error[:, 1:], error[:, :-1]), (error[1:], error[:-1])):
            assert (a * b).mean() / error.var() == pytest.approx(expected, abs=0.02)


def test_disparities_are_whole_steps() -> None:
    depth = measured(wall(1.3), baseline=0.075, disparity_error=0.1, disparity_step=0.125, constant=0.001)
    steps = 400.0 * 0.075 / depth[np.isfinite(depth)] / 0.125
    assert np.abs(steps - steps.round()).max() < 1e-4
    assert len(np.unique(steps.round())) > 3


@pytest.mark.parametrize("turn", [1.0, 1.15, 1.25, 1.35])
def test_returns_end_linearly_with_the_angle(turn: float) -> None:
    solids = wall(1.0, turn)
    t = angle(solids, turn)
    share = np.clip((t - 1.1) / 0.3, 0.0, 1.0)
    is_lost = np.isnan(measured(solids, incidence_from=1.1, incidence_to=1.4))
    within = np.isfinite(true(solids)) & (true(solids) < 9.0)
    assert within.sum() > 20_000
    assert is_lost[within].mean() == pytest.approx(share[within].mean(), abs=0.01)
    assert not is_lost[within & (share == 0.0)].any()
    assert is_lost[within & (share == 1.0)].all()


@pytest.mark.parametrize("share", [0.2, 0.85])
def test_materials_are_lost_in_whole_blots(share: float) -> None:
    blots = np.isnan(measured(wall(1.0), no_return=share)).reshape(60, 4, 80, 4).mean(axis=(1, 3))
    assert set(np.unique(blots)) == {0.0, 1.0}
    assert blots.mean() == pytest.approx(share, abs=4 * np.sqrt(share * (1 - share) / blots.size))


@pytest.mark.parametrize("baseline", [0.05, 0.1])
def test_what_the_second_eye_does_not_see_has_no_depth(baseline: float) -> None:
    """The shadow of a plate at 0.6 m on a wall at 1 m, at its left as the second eye is at the right."""
    solids = wall(1.0)
    solids.add(pose((0.0, 0.0, 0.605)), np.array([0.06, 0.06, 0.005]))
    is_lost, plate = np.isnan(measured(solids, baseline=baseline)), true(solids) < 0.9
    middle = is_lost[120]
    expected = 400.0 * baseline * (1 / 0.6 - 1 / 1.0)
    assert middle.sum() == pytest.approx(expected, abs=1.5)
    left = np.nonzero(plate[120])[0][0]
    assert set(np.nonzero(middle)[0]) <= set(range(round(left - expected) - 2, left + 1))
    assert not is_lost[10].any()  # over the plate
    assert not np.isnan(measured(solids)).any()


def test_edges_are_off_by_the_lateral_noise_and_faces_are_not() -> None:
    """A pixel at a distance from an edge shows the other side as often as a normal error carries it over."""
    solids = wall(1.0, 0.5)
    solids.add(pose((-1.0, 0.0, 0.5)), np.array([1.0, 50.0, 0.01]))  # its edge is at x = 0, column 159.5
    z = true(solids)
    depths = np.array([measured(solids, seed, lateral=1.5) for seed in range(10)])
    is_near, is_far = np.abs(depths - 0.49) < 1e-5, depths > 0.6
    assert (is_near | is_far).mean() > 0.999  # nothing lies between
    shares = is_near.mean(axis=(0, 1))
    columns = np.arange(150, 170)
    # Moves are rounded to whole pixels.
    expected = norm.cdf((159.5 - columns) / 1.5)
    np.testing.assert_allclose(shares[150:170], expected, atol=0.03)
    untouched = np.isfinite(depths[:, :, 175:])
    error = (depths - z)[:, :, 175:][untouched]
    assert untouched.mean() > 0.999
    assert np.abs(error).max() < 1e-5


def test_time_of_flight_mixes_both_sides_of_an_edge() -> None:
    solids = wall(1.0)
    solids.add(pose((-1.0, 0.0, 0.5)), np.array([1.0, 50.0, 0.01]))
    depth = measured(solids, lateral=1.0, mixes_edges=True)
    is_between = (depth > 0.5) & (depth < 0.99)
    rows, columns = np.nonzero(is_between)
    crossing = 2 * norm.cdf(-np.arange(0.5, 5.0)).sum()  # pixels of a row, of both sides
    assert len(rows) == pytest.approx(crossing * 240 * 0.98, rel=0.2)
    assert np.abs(columns - 159.5).max() < 6.0
    shares = (depth[is_between] - 0.49) / 0.51
    assert shares.mean() == pytest.approx(0.5, abs=0.05)


def test_depth_out_of_range_is_none() -> None:
    assert np.isnan(measured(wall(0.09))).all()
    assert np.isnan(measured(wall(9.1))).all()
    assert np.isfinite(measured(wall(8.9))).all()


def test_without_noise_depth_is_exact() -> None:
    solids = wall(1.0, 0.7)
    np.testing.assert_allclose(measured(solids), true(solids), rtol=3e-6)


def test_equal_seeds_give_equal_bytes_in_both_builds_and_others_do_not() -> None:
    solids = wall(1.0, 0.6)
    solids.add(pose((0.0, 0.0, 0.6)), np.array([0.05, 0.05, 0.05]))
    figures = {
        "constant": 0.001, "oblique": 1e-4, "baseline": 0.075, "disparity_error": 0.1,
        "disparity_step": 0.125, "correlation": 1.0, "lateral": 0.8, "lateral_oblique": 0.035,
    }  # fmt: skip
    fastest, pictures = simd(), []
    for build in ("baseline", fastest, fastest):
        set_simd(build)
        pictures.append(measured(solids, 2**63 + 5, 0.3, **figures).tobytes())
    assert pictures[0] == pictures[1] == pictures[2]
    assert len({measured(solids, seed, 0.3, **figures).tobytes() for seed in range(5)}) == 5


@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({"constant": -0.1}, "at least 0"),
        ({"constant": np.nan}, "finite"),
        ({"least": 0.0}, "least"),
        ({"greatest": 0.05}, "least"),
        ({"incidence_to": 1.0}, "incidence_from"),
        ({"incidence_to": 1.6}, "incidence_from"),
        ({"correlation": 0.2}, "correlation"),
        ({"disparity_step": 0.1}, "baseline"),
    ],
)
def test_coefficients_of_no_sensor_are_refused(changed: dict[str, Any], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        DepthNoise(**{**RANGE, **changed})


def test_shares_beyond_all_are_refused() -> None:
    with pytest.raises(ValueError, match="shares from 0 to 1"):
        measured(wall(1.0), no_return=1.5)
