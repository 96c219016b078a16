"""Scripts perceive as the command does, and a second look is warm."""

from __future__ import annotations

from pathlib import Path

import pytest

from pickcli import (
    InputError,
    Planner,
    Scene,
    UnknownNameError,
    make_scene,
    read_perceived,
    write_perceived,
    write_scene,
)
from support.command_line import apc


@pytest.fixture(scope="module")
def planner() -> Planner:
    return Planner.load("apc2016_delft")


@pytest.fixture(scope="module")
def scene(planner: Planner) -> Scene:
    return make_scene({"bin_C": ["dove_beauty_bar", "crayola_24_ct"]}, planner.cell, seed=3)


def test_a_script_writes_the_bytes_of_the_command(planner: Planner, scene: Scene, tmp_path: Path) -> None:
    stored = tmp_path / "scene.json"
    write_scene(scene, stored)
    look = ("--camera", "hand", "--at", "cam_C", "--textures", 4, "--seed", 3)
    for sift, places in (("auto", ()), ("none", ("bin_C",))):
        by_command, by_script = tmp_path / f"{sift}_command.json", tmp_path / f"{sift}_script.json"
        of = [word for name in places for word in ("--bin", name)]
        answer = apc("perceive", "--scene", stored, *look, *of, "--sift", sift, "-o", by_command)
        assert answer.code == 0, answer.err
        perceived = planner.perceive(scene, "hand", "cam_C", places, sift, textures=4, seed=3)
        write_perceived(perceived, by_script)
        assert by_script.read_bytes() == by_command.read_bytes()
        (place,) = read_perceived(by_script, planner.cell).places
        assert all(item.route is not None for item in place.items)


def test_looks_do_not_change_those_after_them(planner: Planner, scene: Scene, tmp_path: Path) -> None:
    path = tmp_path / "p.json"

    def content(sift: str) -> bytes:
        write_perceived(planner.perceive(scene, "hand", "cam_C", sift=sift), path)
        return path.read_bytes()

    first = content("auto")
    assert content("none") != first and content("auto") == first


def test_what_is_not_there_is_named_with_what_is(planner: Planner, scene: Scene) -> None:
    with pytest.raises(UnknownNameError, match="some-views"):
        planner.perceive(scene, "hand", "cam_C", sift="some-views")
    with pytest.raises(UnknownNameError, match="hind"):
        planner.perceive(scene, "hind", "cam_C")
    with pytest.raises(UnknownNameError, match="bin_Z"):
        planner.perceive(scene, "hand", "cam_C", ["bin_Z"])
    with pytest.raises(UnknownNameError, match="cam_Z"):
        planner.perceive(scene, "hand", "cam_Z")
    with pytest.raises(InputError, match="shows less than"):
        planner.perceive(scene, "hand", "cam_L")
