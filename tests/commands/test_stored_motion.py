"""``apc inspect --motion``: one motion of a database, alone."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.roadmap.store import read_database, write_database
from support.command_line import apc
from support.stored_samples import database


@pytest.fixture
def stored(tmp_path: Path) -> Path:
    path = tmp_path / "trajectories.h5"
    write_database(path, database(), load_cell("apc2016_delft").fingerprint, {})
    return path


def test_a_motion_is_shown_with_its_points(stored: Path) -> None:
    motion = next(iter(read_database(stored, points=True)))
    key, timed = motion.key, motion.trajectory
    assert timed is not None
    answer = apc("inspect", stored, "--motion", key.start, key.goal, "--json")
    told = json.loads(answer.out)["motions"][str(key.payload)]
    assert told["waypoints"] == motion.path.waypoints.tolist() and told["duration_s"] == motion.duration
    assert [point["positions"] for point in told["points"]] == timed.positions.tolist()
    assert [point["time_from_start"] for point in told["points"]] == timed.times.tolist()
    words = apc("inspect", stored, "--motion", key.start, key.goal)
    told_in_words = " ".join(words.out.split())  # the lines end where the terminal does
    assert f"{motion.duration:.3f} s" in told_in_words and f"{len(timed.times)} timed points" in told_in_words


def test_the_way_back_is_shown_too(stored: Path) -> None:
    motion = next(iter(read_database(stored)))
    answer = apc("inspect", stored, "--motion", motion.key.goal, motion.key.start, "--json")
    told = json.loads(answer.out)["motions"][str(motion.key.payload)]
    np.testing.assert_array_equal(told["waypoints"], motion.path.waypoints[::-1])


def test_a_motion_that_is_not_stored_is_told(stored: Path) -> None:
    answer = apc("inspect", stored, "--motion", "a", "nowhere")
    assert answer.code == 3 and answer.out == ""
    assert "contains no motion between 'a' and 'nowhere'" in answer.err and "--all lists" in answer.err


def test_one_motion_is_not_drawn(stored: Path) -> None:
    answer = apc("inspect", stored, "--motion", "a", "b", "--picture", stored.with_suffix(".png"))
    assert answer.code == 2 and "leave out --motion" in answer.err
