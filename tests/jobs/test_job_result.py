"""Records travel as bytes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as st_numpy

from pickcli.errors import Reason
from pickcli.jobs.job_result import JobResult

ARRAYS = st.dictionaries(
    st.text(max_size=5), st_numpy.arrays("<f8", st_numpy.array_shapes(min_side=0)), max_size=3
)


@given(arrays=ARRAYS, text=st.text(), number=st.floats(allow_nan=False, allow_infinity=False))
def test_a_record_comes_back_to_the_bit(arrays: dict[str, np.ndarray], text: str, number: float) -> None:
    record = JobResult({"text": text, "number": number}, arrays, Reason(text, "where", text))
    again = JobResult.of_bytes(record.to_bytes())
    assert again.values == record.values and again.reason == record.reason
    assert {name: (a.shape, a.tobytes()) for name, a in again.arrays.items()} == {
        name: (a.shape, a.tobytes()) for name, a in arrays.items()
    }
    assert again.to_bytes() == record.to_bytes()


@pytest.mark.parametrize(
    "content",
    [b"", b"{}\n", b"[]\n", b'{"values": {}, "arrays": [["x", [2]]], "reason": null}\n12345678',
     b'{"values": {}, "arrays": [], "reason": null}\n1',
     b'{"values": {}, "arrays": [["x", [-1]]], "reason": null}\n',
     b'{"values": [], "arrays": [], "reason": null}\n',
     b'{"values": {}, "arrays": [], "reason": ["a", "b", 1]}\n',
     b'{"values": {}, "arrays": [], "reason": ["a"]}\n',
     b'{"values": {}, "arrays": [["x", [1000000000000000000000000]]], "reason": null}\n',
     b"[" * 100_000],
)  # fmt: skip
def test_bytes_that_are_no_record_are_refused(content: bytes) -> None:
    with pytest.raises(ValueError, match="no record of a task"):
        JobResult.of_bytes(content)
