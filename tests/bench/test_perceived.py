"""The figures of perceived items are what they say."""

from __future__ import annotations

import numpy as np
import pytest

from bench.perceived import Row, calibrated, calibrated_bounds, numbers_in, reliability, summary


def row(**changes: object) -> Row:
    usual: dict[str, object] = {
        "sensor": "carmine", "seed": 1, "bin": "bin_A", "id": "a", "n_items": 2, "visible": 1.0,
        "is_answer": True, "confidence": 0.9, "mm": 1.0, "deg": 1.0, "surface_mm": 2.0, "ms": 50.0,
        "features": (1.0, 1.0), "bound_features": (1.0,), "bound_mm": 4.0, "bound_deg": 5.0,
        "bound_surface_mm": 5.0, "is_bound_kept": True,
    }  # fmt: skip
    return Row(**(usual | changes))  # type: ignore[arg-type]


ROWS = [
    row(),
    row(mm=3.0),
    row(mm=9.0, deg=11.0, is_bound_kept=False),
    row(mm=50.0, visible=0.5, is_bound_kept=False),
    row(mm=1.0, is_answer=False, confidence=0.2),
    row(mm=None, deg=None, is_answer=False, confidence=0.0, features=None, visible=0.1),
]


def test_figures_count_answers_well_seen_and_wrong_ones() -> None:
    found = summary(ROWS)
    assert found["items"] == 6
    assert found["answered"] == pytest.approx(4 / 6)
    assert found["good"] == pytest.approx(2 / 6)
    assert found["good_of_well_seen"] == pytest.approx(2 / 4)
    assert found["wrong_of_answers"] == pytest.approx(1 / 4)
    assert found["bound_kept"] == pytest.approx(2 / 4)
    assert found["mm_median"] == pytest.approx(2.0)


def test_refused_poses_count_for_the_calibration_too() -> None:
    assert reliability(ROWS) == [("0.1 to 0.5", 1, 0.2, 1.0), ("0.8 to 0.95", 4, pytest.approx(0.9), 0.5)]


def test_a_calibrated_model_is_right_in_the_mean() -> None:
    rng = np.random.default_rng(1)
    x = rng.normal(size=4000)
    is_near = rng.random(4000) < 1.0 / (1.0 + np.exp(-(0.5 + 2.0 * x)))
    rows = [
        row(mm=1.0 if near else 50.0, features=(1.0, value)) for near, value in zip(is_near, x, strict=True)
    ]
    np.testing.assert_allclose(calibrated(rows), [0.5, 2.0], atol=0.2)


def test_calibrated_bounds_keep_all_errors_of_nearly_all_and_follow_the_features() -> None:
    rng = np.random.default_rng(2)
    x = rng.normal(size=2000)
    slopes = np.array([0.7, 0.2, -0.4])
    errors = np.abs(rng.normal(size=(2000, 3))) * np.exp(x[:, None] * slopes)
    features = np.stack([np.ones(2000), x], axis=1)
    model = calibrated_bounds(features, errors, [k // 400 for k in range(2000)])
    assert (errors <= model.bounds(features)).all(axis=1).mean() > 0.99
    np.testing.assert_allclose(model.weights[:, 1], slopes, atol=0.1)


def test_large_errors_widen_the_bounds_of_their_own_class_alone() -> None:
    rng = np.random.default_rng(4)
    features = np.stack([np.ones(4000), rng.normal(size=4000)], axis=1)
    errors = np.abs(rng.normal(size=(4000, 3))) * np.exp(features[:, 1:])
    scenes = [k % 5 for k in range(4000)]
    before = calibrated_bounds(features, errors, scenes)
    is_rare = (features[:, 1] > 1.0) & (rng.random(4000) < 0.1)
    errors[is_rare] *= 30.0
    after = calibrated_bounds(features, errors, scenes)
    assert abs(after.factors[0] - before.factors[0]) < 0.5
    assert after.factors[1] > before.factors[1] + 2.0


def test_a_scene_that_is_unlike_the_others_widens_their_bounds() -> None:
    rng = np.random.default_rng(3)
    errors, scenes = np.abs(rng.normal(size=(1000, 3))), [k // 250 for k in range(1000)]
    features = np.stack([np.ones(1000), rng.normal(size=1000)], axis=1)
    alike = calibrated_bounds(features, errors, scenes).bounds(features)
    errors[750:] *= 3.0
    assert np.median(calibrated_bounds(features, errors, scenes).bounds(features) / alike) > 2.0


def test_seeds_are_a_range_or_a_list() -> None:
    assert numbers_in("1000-1002") == [1000, 1001, 1002]
    assert numbers_in("3,5") == [3, 5]
