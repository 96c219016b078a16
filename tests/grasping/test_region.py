"""Laws of task space regions."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from pickcli.geometry import is_pose, pose
from pickcli.grasping.region import TaskSpaceRegion

angles = st.floats(-1.4, 1.4)
lengths = st.floats(-1.0, 1.0)


def region_of(numbers: list[float]) -> TaskSpaceRegion:
    xyz, rpy, half = numbers[:3], numbers[3:6], np.abs(numbers[6:12])
    bounds = np.column_stack([-half, half])
    bounds[4] = np.clip(bounds[4], -1.4, 1.4)  # pitch stays off the singularity
    return TaskSpaceRegion(pose(xyz, rpy=rpy), pose([0.1, 0.0, 0.2], rpy=[0.3, -0.2, 0.1]), bounds)


numbers = st.lists(st.one_of(lengths, angles), min_size=12, max_size=12)


@given(numbers, st.integers(0, 2**31))
def test_what_is_sampled_is_contained(values: list[float], seed: int) -> None:
    region = region_of(values)
    sampled = region.sample(np.random.default_rng(seed), 5)
    assert len(sampled) == 5
    for T in sampled:
        assert is_pose(T)
        assert region.contains(T, 1e-7)


@given(numbers, st.floats(0.05, 1.0))
def test_distance_grows_by_what_is_outside(values: list[float], beyond: float) -> None:
    region = region_of(values)
    displacement = region.bounds.mean(axis=1)
    displacement[0] = region.bounds[0, 1] + beyond
    assert abs(region.distance(region.poses_at(displacement[None])[0]) - beyond) < 1e-7


@given(numbers)
def test_displacement_inverts_poses_at(values: list[float]) -> None:
    region = region_of(values)
    d = region.bounds[:, 0] * 0.5
    assert np.allclose(region.displacement(region.poses_at(d[None])[0]), d, atol=1e-7)
