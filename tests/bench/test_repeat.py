"""The same seed gives the same trial, whatever else the process and the machine do."""

from __future__ import annotations

import pytest

from bench.repeat import is_repeated


@pytest.mark.slow
def test_a_trial_is_the_same_bytes_with_and_without_pictures_in_two_busy_processes() -> None:
    assert is_repeated(seed=1, time_limit=12.0, is_bare=True)
