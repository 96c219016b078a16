"""Arrays that are kept: bit by bit as derived, in files that say what of; damaged ones are derived again."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from pickcli.files.derived_cache import derived_arrays

INPUTS = {"item": "soap", "seed": 3}


class Derivation:
    """Derives the same arrays, and counts how often."""

    def __init__(self) -> None:
        self.n = 0

    def __call__(self) -> Mapping[str, NDArray[Any]]:
        self.n += 1
        return {"points": np.random.default_rng(1).normal(size=(5, 3)), "views": np.arange(4)}


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "apc" / "things"


def test_arrays_are_kept_bit_by_bit(cache: Path) -> None:
    derive = Derivation()
    first, again = (derived_arrays("things", "soap", INPUTS, derive) for _ in range(2))
    assert derive.n == 1
    for name, array in Derivation()().items():
        for each in (first[name], again[name]):
            assert each.dtype == array.dtype and each.tobytes() == array.tobytes()


def test_a_file_says_what_it_was_made_from(cache: Path) -> None:
    derived_arrays("things", "soap", INPUTS, Derivation())
    path = cache / "soap.json"
    assert json.loads(path.read_bytes().partition(b"\n")[2])["made_from"] == INPUTS


def test_what_was_made_from_something_else_is_replaced(cache: Path) -> None:
    derive = Derivation()
    for inputs in (INPUTS, {"seed": 3, "item": "soap"}, {**INPUTS, "seed": 4}, INPUTS):
        derived_arrays("things", "soap", inputs, derive)
    assert derive.n == 3 and len(list(cache.iterdir())) == 1


@pytest.mark.parametrize("damage", [lambda data: data[:-9], lambda data: data.replace(b"soap", b"soup")])
def test_what_is_damaged_is_derived_again(cache: Path, damage: Any) -> None:
    derive = Derivation()
    derived_arrays("things", "soap", INPUTS, derive)
    (path,) = cache.iterdir()
    whole = path.read_bytes()
    path.write_bytes(damage(whole))
    derived_arrays("things", "soap", INPUTS, derive)
    assert derive.n == 2 and path.read_bytes() == whole


def test_without_a_cache_arrays_are_derived_each_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    derive = Derivation()
    for _ in range(2):
        assert set(derived_arrays("things", "soap", INPUTS, derive)) == {"points", "views"}
    assert derive.n == 2
