"""``apc make-stream``, and ``apc inspect`` of what it wrote."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from support.command_line import apc, misused, refused


def test_a_stream_is_written_and_inspected(tmp_path: Path) -> None:
    path = tmp_path / "stream.json"
    made = apc("make-stream", "--items", "5", "--gap", "0.3,0.4", "--seed", "2", "-o", path, "--json")
    assert made.code == 0 and json.loads(made.out)["speed"] == 0.33  # nominal
    told = json.loads(apc("inspect", path, "--json").out)
    assert (told["n_items"], told["conveyor"], told["speed_m_s"]) == (5, "belt", 0.33)
    first = told["within_window"][json.loads(made.out)["items"][0]]
    enters, leaves = (float(part) for part in first.removesuffix(" s").split(" to "))
    assert leaves - enters == pytest.approx((2.85 - 1.20) / 0.33, abs=0.02)


@pytest.mark.parametrize("gap", ["0.5", "0.5,0.2", "-0.1,0.2", "nan,nan", "a,b"])
def test_gaps_that_are_none_are_wrong_usage(gap: str, tmp_path: Path) -> None:
    misused(apc("make-stream", "--gap", gap, "-o", tmp_path / "s.json"), "expected LO,HI in m")


@pytest.mark.parametrize("speed", ["-0.1", "nan", "inf"])
def test_speeds_that_are_none_are_wrong_usage(speed: str, tmp_path: Path) -> None:
    misused(apc("make-stream", "--speed", speed, "-o", tmp_path / "s.json"), "--speed")


def test_a_speed_beyond_the_belts_is_refused(tmp_path: Path) -> None:
    refused(apc("make-stream", "--speed", "0.6", "-o", tmp_path / "s.json"), 3, "runs at 0.5 m/s at most")


def test_a_stream_is_no_scene(tmp_path: Path) -> None:
    path = tmp_path / "stream.json"
    assert apc("make-stream", "--items", "2", "-o", path).code == 0
    planned = apc("plan-pick", "--scene", path, "--bin", "belt", "--item", "x", "-o", tmp_path / "p.json")
    refused(planned, 3, "is a stream of items, but a scene is expected here")
