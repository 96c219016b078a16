"""Packed arrays: as exact as stated, and as short as their steps allow."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from pickcli.files.packed_array import deflated, inflated, packed, unpacked


@given(
    st.lists(st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=3), min_size=1, max_size=30),
    st.sampled_from([1e-5, 1e-3, 0.25]),
)
def test_every_element_is_off_by_half_of_the_resolution_at_most(
    rows: list[list[float]], resolution: float
) -> None:
    values = np.array(rows)
    assert np.abs(unpacked(packed(values, resolution)) - values).max() <= 0.5 * resolution * (1 + 1e-6)


@pytest.mark.parametrize(("most", "kind"), [(127.0, "i1"), (128.0, "i2"), (32767.0, "i2"), (32768.0, "i4")])
def test_the_widest_step_decides_on_the_type(most: float, kind: str) -> None:
    told = packed(np.array([0.0, most, 0.0]), 1.0)
    assert told["type"] == kind and told["shape"] == [3]
    assert unpacked(told).tolist() == [0.0, most, 0.0]


def test_nothing_is_nothing() -> None:
    assert unpacked(packed(np.zeros((0, 7)), 1.0)).shape == (0, 7)


@given(
    hnp.arrays(
        st.sampled_from([np.float64, np.float32, np.int64, np.uint8]),
        hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=6),
    )
)
def test_what_is_deflated_is_the_same_bit_by_bit(values: np.ndarray) -> None:
    again = inflated(json.loads(json.dumps(deflated(values))))
    assert again.dtype == values.dtype and again.shape == values.shape
    assert again.tobytes() == values.tobytes()
