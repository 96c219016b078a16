"""Scene files: what is written comes back, and every mistake is told with its place."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pickcli.cell.load import load_cell
from pickcli.cell.model import Cell
from pickcli.cell.scene import TOTE, PlacedItem, PoseNoise, Scene
from pickcli.cell.scene_file import read_scene, scene_hash, write_scene
from pickcli.errors import InputError, StaleError
from pickcli.geometry import from_quaternion, pose

Refused = Callable[[Callable[[], object]], str]

CELL = load_cell("apc2016_delft")


def make_scene(cell: Cell) -> Scene:
    """One box on the floor of every bin and a sphere in the tote."""
    item, ball = cell.item("crayola_24_ct"), cell.item("rawlings_baseball")
    placed = [
        PlacedItem(
            id=f"crayola_24_ct#{i}",
            item=item,
            location=name,
            T_world_item=b.T_pod_bin @ pose((0.33, 0.0, b.floor_back + 0.0125), rpy=(0, 0, 0.1 * i)),
        )
        for i, (name, b) in enumerate(cell.pod.bins.items())
    ]
    in_tote = PlacedItem("rawlings_baseball", ball, TOTE, cell.tote.T_world_tote @ pose((0, 0, 0.034)))
    return Scene(cell, cell.T_world_pod, (*placed, in_tote), PoseNoise(0.002, 0.0175), seed=3)


@pytest.fixture
def written(tmp_path: Path, cell: Cell) -> Path:
    path = tmp_path / "scene.json"
    write_scene(make_scene(cell), path)
    return path


def edit(path: Path, change: Callable[[dict[str, Any]], None]) -> None:
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content, indent=1))


def test_a_scene_comes_back_as_it_was_written(cell: Cell, written: Path) -> None:
    scene, back = make_scene(cell), read_scene(written)
    assert scene_hash(back) == scene_hash(scene)
    assert (back.noise.position, back.noise.angle) == (scene.noise.position, scene.noise.angle)
    assert (back.seed, back.cell.fingerprint) == (3, cell.fingerprint)
    for a, b in zip(scene.items, back.items, strict=True):
        assert (a.id, a.item.name, a.location) == (b.id, b.item.name, b.location)
        np.testing.assert_allclose(a.T_world_item, b.T_world_item, atol=1e-15)


def test_the_hash_survives_generations_of_files(cell: Cell, written: Path) -> None:
    scene = read_scene(written)
    for generation in range(5):
        write_scene(scene, written.with_name(f"{generation}.json"))
        scene = read_scene(written.with_name(f"{generation}.json"))
    assert scene_hash(scene) == scene_hash(make_scene(cell))


quaternions = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)
half_turns = st.sampled_from(
    [(1, 0, 0, 0), (0, 1, 0, 0), (0.6, 0.8, 0, 0), (0, 0.6, -0.8, 0), (0, 0, 1, 1e-17)]
)


@given(q=st.one_of(quaternions, half_turns), x=st.floats(0.1, 0.3))
def test_the_hash_survives_the_file_for_any_pose(
    tmp_path_factory: pytest.TempPathFactory, q: tuple[float, float, float, float], x: float
) -> None:
    T = CELL.pod.bins["bin_E"].T_pod_bin @ pose((x, 0.01, 0.1), R=from_quaternion(q))
    placed = PlacedItem("one", CELL.item("crayola_24_ct"), "bin_E", T)
    scene = Scene(CELL, CELL.T_world_pod, (placed,), PoseNoise(), seed=0)
    path = tmp_path_factory.getbasetemp() / "any.json"
    write_scene(scene, path)
    assert scene_hash(read_scene(path, CELL)) == scene_hash(scene)


def test_the_hash_sees_poses_and_noise_but_not_order_or_seed(cell: Cell) -> None:
    scene = make_scene(cell)
    first, *rest = scene.items
    nudged = replace(first, T_world_item=pose((1e-6, 0, 0)) @ first.T_world_item)
    elsewhere = replace(first, location=TOTE)
    changed = [
        scene.moved(nudged),
        scene.moved(elsewhere),
        scene.without(first.id),
        replace(scene, noise=PoseNoise(0.003, 0.0175)),
        replace(scene, T_world_pod=pose((0.01, 0, 0))),
        replace(scene, cell=replace(cell, fingerprint="0" * 64)),
    ]
    hashes = {scene_hash(scene), *(scene_hash(other) for other in changed)}
    assert len(hashes) == 1 + len(changed)
    assert scene_hash(replace(scene, items=(*rest, first), seed=9)) == scene_hash(scene)


def _set(*path: Any, value: Any) -> Callable[[dict[str, Any]], None]:
    def change(content: dict[str, Any]) -> None:
        target = content
        for part in path[:-1]:
            target = target[part]
        if value is None:
            del target[path[-1]]
        else:
            target[path[-1]] = value

    return change


MISTAKES = {
    "noise in mm": (_set("noise", "position", value=2.0), "got 2.0; lengths are in m, not mm"),
    "a pod far away": (_set("T_world_pod", "position", value=[1e308, 0, 0]), "got 1e+308; lengths are in m"),
    "a cell by its path": (
        _set("cell", "name", value="../../elsewhere"),
        "cell.name: expected the cell's name",
    ),
    "a cell of a long name": (_set("cell", "name", value="x" * 300), "cell.name: expected the cell's name"),
    "control characters": (_set("items", 0, "id", value="\x1b[2J"), "items[0].id: expected"),
    "unknown item": (
        _set("items", 2, "name", value="crayola_24"),
        "items[2].name: unknown item 'crayola_24' of 2016; did you mean 'crayola_24_ct'?",
    ),
    "unknown year": (
        _set("items", 2, "year", value=2014),
        "items[2].name: unknown item 'crayola_24_ct' of 2014",
    ),
    "unknown bin": (_set("items", 0, "location", value="bin_M"), "items[0].location: unknown place 'bin_M'"),
    "same id twice": (
        _set("items", 1, "id", value="crayola_24_ct#0"),
        "items[1].id: 'crayola_24_ct#0' stands twice",
    ),
    "not a number": (
        _set("items", 0, "position", value=[float("nan"), 0, 0]),
        "items[0].position[0]: expected",
    ),
    "infinite": (_set("items", 0, "position", value=[0, float("inf"), 0]), "items[0].position[1]: expected"),
    "two numbers": (
        _set("items", 0, "position", value=[0, 1]),
        "items[0].position: expected a position [x, y, z] in m",
    ),
    "not a unit quaternion": (
        _set("items", 3, "quaternion", value=[0, 0, 0, 2]),
        "items[3].quaternion: expected a length of 1, got 2",
    ),
    "zero quaternion": (
        _set("T_world_pod", "quaternion", value=[0, 0, 0, 0]),
        "T_world_pod.quaternion: expected a length of 1, got 0",
    ),
    "missing key": (
        _set("noise", value=None),
        "noise: expected bounds of the error of the item poses, got nothing; add it",
    ),
    "unknown key": (_set("items", 0, "weight", value=1), "items[0].weight: unknown key"),
    "another format": (_set("format", value="apc cell"), "format: expected 'apc scene'"),
    "negative noise": (_set("noise", "position", value=-1.0), "noise.position: expected"),
    "another frame": (
        _set("items", 0, "position", value=[0.3, 0.0, 0.1]),
        "crayola_24_ct#0 is 1.43 m away from bin_A",
    ),
}


@pytest.mark.parametrize("name", MISTAKES)
def test_a_mistake_is_told_with_file_line_and_key(written: Path, refused: Refused, name: str) -> None:
    change, expected = MISTAKES[name]
    edit(written, change)
    message = refused(lambda: read_scene(written))
    assert expected in message
    assert all(line.startswith(f"{written}:") for line in message.splitlines())


def test_the_line_is_the_line(written: Path, refused: Refused) -> None:
    text = written.read_text()
    line = text[: text.index('"crayola_24_ct#4"')].count("\n") + 1
    written.write_text(text.replace('"bin_E"', '"bin_e"'))
    assert f"scene.json:{line}:" in refused(lambda: read_scene(written))


def test_overlapping_items_are_both_named_with_the_depth(written: Path, refused: Refused) -> None:
    def change(content: dict[str, Any]) -> None:
        x, y, z = content["items"][0]["position"]
        content["items"][1].update(location="bin_A", position=[x, y, z + 0.015], quaternion=[0, 0, 0, 1])

    edit(written, change)
    message = refused(lambda: read_scene(written))
    assert "crayola_24_ct#0 and crayola_24_ct#1 overlap by 10.0 mm" in message


def test_stacked_items_that_touch_are_accepted(cell: Cell, tmp_path: Path) -> None:
    scene = make_scene(cell)
    below = scene.items[0]
    above = replace(below, id="above", T_world_item=pose((0, 0, 0.0245)) @ below.T_world_item)
    write_scene(replace(scene, items=(*scene.items, above)), tmp_path / "s.json")
    assert len(read_scene(tmp_path / "s.json").items) == len(scene.items) + 1


def test_an_overlap_within_the_stated_noise_is_no_contradiction(written: Path, refused: Refused) -> None:
    def lower(content: dict[str, Any], noise: float) -> None:
        x, y, z = content["items"][0]["position"]
        content["items"][1].update(location="bin_A", position=[x, y, z + 0.0205], quaternion=[0, 0, 0, 1])
        content["noise"] = {"position": noise, "angle": 0.0}

    edit(written, lambda content: lower(content, 0.002))
    assert len(read_scene(written).items) == 13
    edit(written, lambda content: lower(content, 0.001))
    assert "overlap by 4.5 mm" in refused(lambda: read_scene(written))


def test_a_scene_of_another_cell_is_stale_and_names_both(cell: Cell, written: Path) -> None:
    edit(written, _set("cell", "fingerprint", value="ab" * 32))
    with pytest.raises(StaleError) as caught:
        read_scene(written)
    assert "ab" * 32 in str(caught.value)
    assert cell.fingerprint in str(caught.value)
    assert caught.value.exit_code == 4


@given(cut=st.floats(0.0, 0.999))
def test_a_truncated_file_is_refused(tmp_path_factory: pytest.TempPathFactory, cut: float) -> None:
    path = tmp_path_factory.getbasetemp() / "cut.json"
    write_scene(make_scene(CELL), path)
    text = path.read_text().rstrip()
    path.write_text(text[: int(cut * len(text))])
    with pytest.raises(InputError, match=r"cut\.json:\d+"):
        read_scene(path, CELL)


def test_an_item_sunk_into_its_floor_is_told_as_such(cell: Cell, written: Path, refused: Refused) -> None:
    scene = make_scene(cell)
    first = scene.items[0]
    write_scene(scene.moved(replace(first, T_world_item=pose((0, 0, -0.03)) @ first.T_world_item)), written)
    message = refused(lambda: read_scene(written))
    assert f"items[0].position: {first.id} reaches 30.0 mm under the floor of bin_A" in message


def test_an_item_in_the_shelf_is_told_as_such(cell: Cell, written: Path, refused: Refused) -> None:
    scene = make_scene(cell)
    first = scene.items[0]
    write_scene(scene.moved(replace(first, T_world_item=pose((0, -0.12, 0)) @ first.T_world_item)), written)
    message = refused(lambda: read_scene(written))
    assert f"items[0].position: {first.id} stands " in message and "mm deep in " in message


def test_mistakes_beyond_the_first_twenty_are_counted(cell: Cell, written: Path, refused: Refused) -> None:
    """And cost nothing: thousands of items in one place once took minutes."""
    item = json.loads(written.read_text())["items"][0]
    edit(written, lambda content: content.update(items=[{**item, "id": str(i)} for i in range(300)]))
    began = process_time()
    lines = refused(lambda: read_scene(written)).splitlines()
    assert len(lines) == 21 and "more" in lines[-1]
    assert process_time() - began < 5.0
    edit(written, lambda content: content.update(items=[{**item, "id": str(i)} for i in range(301)]))
    assert "at most 300" in refused(lambda: read_scene(written))


def test_characters_beyond_16_bits_are_read_as_json_writes_them(written: Path) -> None:
    edit(written, lambda content: content["items"][0].update(id="\U0001f4e6 one"))
    assert "\\ud83d\\udce6" in written.read_text()
    assert read_scene(written).items[0].id == "\U0001f4e6 one"


@pytest.mark.parametrize(("x", "is_refused"), [(-0.14, False), (-0.16, True)])
def test_an_item_may_lie_so_far_out_of_its_bin_and_no_farther(
    cell: Cell, written: Path, x: float, is_refused: bool
) -> None:
    first = make_scene(cell).items[0]
    T = first.T_world_item.copy()
    T[0, 3] = x
    write_scene(make_scene(cell).moved(replace(first, T_world_item=T)), written)
    if is_refused:
        with pytest.raises(InputError, match=r"is 0\.16 m away from bin_A"):
            read_scene(written)
    else:
        assert read_scene(written).items
