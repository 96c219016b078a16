"""Levels are switched one by one, by files that ``--reality`` reads."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path

import pytest

from bench.reality import switches, written
from pickcli.simulation.reality import DEFAULT, IDEAL, Reality, read_reality


@pytest.mark.parametrize("name", switches())
def test_each_switch_sets_its_levels_to_their_ideal_and_no_other(name: str, tmp_path: Path) -> None:
    levels = switches()[name]
    assert read_reality(written(name, levels, tmp_path)) == replace(DEFAULT, **levels)
    assert {level: getattr(IDEAL, level) for level in levels} == levels


def test_all_switches_together_make_the_ideal() -> None:
    levels = switches()
    assert replace(DEFAULT, **levels["all"]) == IDEAL
    differing = {f.name for f in fields(Reality) if getattr(DEFAULT, f.name) != getattr(IDEAL, f.name)}
    assert {name for key, some in levels.items() if key != "all" for name in some} == differing
