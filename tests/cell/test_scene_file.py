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

from pickcli.cell.displacement import Displacement
from pickcli.cell.load import load_cell
from pickcli.cell.model import Cell
from pickcli.cell.overlap import Solid, overlap_depth
from pickcli.cell.scene import TOTE, HeldItem, PlacedItem, PoseNoise, Scene
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


def test_what_the_cup_holds_comes_back_and_counts(cell: Cell, tmp_path: Path) -> None:
    scene = make_scene(cell)
    bottle = cell.item("dasani_water_bottle")
    middle = (0.01, 0.0, float(bottle.shape.extents[2]) / 2)
    held = HeldItem("bottle", bottle, pose(middle, rpy=(0.1, 0.05, 0.3)))
    holding = replace(scene, held=held)
    write_scene(holding, tmp_path / "scene.json")
    back = read_scene(tmp_path / "scene.json")
    assert back.held is not None and (back.held.id, back.held.item.name) == ("bottle", "dasani_water_bottle")
    np.testing.assert_allclose(back.held.T_tip_item, held.T_tip_item, atol=1e-15)
    turned = replace(holding, held=replace(held, T_tip_item=np.eye(4)))
    assert scene_hash(back) == scene_hash(holding)
    assert len({scene_hash(each) for each in (scene, holding, turned)}) == 3


def test_mistakes_in_what_the_cup_holds_are_told(cell: Cell, written: Path, refused: Refused) -> None:
    held = {"id": "x", "name": "elephant", "year": 2016, "position": [0, 0, 0.04], "quaternion": [0, 0, 0, 1]}
    edit(written, _set("held", value=held))
    assert "held.name: unknown item 'elephant' of 2016" in refused(lambda: read_scene(written))
    edit(written, _set("held", value={**held, "name": "dasani_water_bottle", "id": "crayola_24_ct#0"}))
    assert "held.id: 'crayola_24_ct#0' is a crayola_24_ct of 2016" in refused(lambda: read_scene(written))


@pytest.mark.parametrize(
    ("z", "told"),
    [(40.0, "is 40 m from the tip of the cup"), (0.2, "is 0.2 m from the tip"), (-0.04, "into the tool"),
     (-0.3, "is 0.3 m from the tip"), (0.0, "into the tool"), (0.033, ""), (0.03, ""), (0.04, "")],
)  # fmt: skip
def test_what_the_cup_holds_begins_at_its_tip(written: Path, refused: Refused, z: float, told: str) -> None:
    held = {"id": "ball", "name": "rawlings_baseball", "year": 2016, "quaternion": [0, 0, 0, 1]}
    edit(written, _set("held", value={**held, "position": [0, 0, z]}))
    if told:
        message = refused(lambda: read_scene(written))
        assert "held.position: " in message and told in message and "in the tool frame, in m" in message
    else:
        assert read_scene(written).held is not None


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
    "another format": (_set("format", value="apc scenes"), "format: expected 'apc scene'"),
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


def _read(scene: Scene, path: Path, noise: float = 0.0, pod_error: Displacement | None = None) -> Scene:
    write_scene(replace(scene, noise=PoseNoise(noise, 0.0), pod_error=pod_error or Displacement()), path)
    return read_scene(path)


def _lowered(scene: Scene, item: PlacedItem, *, dz: float = 0.0, dx: float = 0.0, dy: float = 0.0) -> Scene:
    return scene.moved(replace(item, T_world_item=pose((dx, dy, dz)) @ item.T_world_item))


@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_an_item_may_sink_into_its_floor_by_5_mm_and_its_noise(
    cell: Cell, written: Path, noise: float
) -> None:
    scene = make_scene(cell)
    first = replace(
        scene.items[0], T_world_item=cell.pod.bins["bin_A"].T_pod_bin
        @ pose((0.33, 0.0, cell.pod.bins["bin_A"].floor_back + scene.items[0].item.shape.extents[2] / 2))
    )  # fmt: skip
    alone = replace(scene, items=(first,))
    assert _read(_lowered(alone, first, dz=-0.0049 - noise), written, noise)
    with pytest.raises(InputError, match=f"reaches {5.1 + 1000 * noise:.1f} mm under the floor of bin_A"):
        _read(_lowered(alone, first, dz=-0.0051 - noise), written, noise)


def _in_tote(cell: Cell, dz: float) -> PlacedItem:
    """A box on the tote's bottom, or deeper."""
    item = cell.item("crayola_24_ct")
    T = cell.tote.T_world_tote @ pose((0.0, 0.0, float(item.shape.extents[2]) / 2 + dz))
    return PlacedItem("one", item, TOTE, T)


@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_an_item_may_stand_in_the_tote_by_5_mm_and_its_noise(
    cell: Cell, tmp_path: Path, noise: float
) -> None:
    scene, path = make_scene(cell), tmp_path / "tote.json"
    assert _read(replace(scene, items=(_in_tote(cell, -0.0049 - noise),)), path, noise)
    with pytest.raises(InputError, match=r"items\[0\]\.position: one stands .* mm deep in .*tote"):
        _read(replace(scene, items=(_in_tote(cell, -0.0053 - noise),)), path, noise)


def test_where_the_pod_may_stand_elsewhere_an_item_may_stand_deeper(cell: Cell, tmp_path: Path) -> None:
    """By as much as the pod's farthest corner may be off: 3 mm here."""
    scene, path = replace(make_scene(cell), items=(_in_tote(cell, -0.007),)), tmp_path / "tote.json"
    assert _read(scene, path, pod_error=Displacement(0.003, 0.0, 0.0))
    with pytest.raises(InputError, match="mm deep in"):
        _read(scene, path, pod_error=Displacement(0.001, 0.0, 0.0))
    corner = max(float(np.linalg.norm(body.T_parent_shape[:2, 3])) for body in cell.pod.bodies)
    assert _read(scene, path, pod_error=Displacement(0.0, 0.0, 0.0025 / corner))
    with pytest.raises(InputError, match="mm deep in"):
        _read(scene, path, pod_error=Displacement(0.0, 0.0, 0.0015 / corner))


@pytest.mark.parametrize("length", [1.0009, 0.9991, 1.0011, 0.9989])
def test_a_quaternion_is_a_unit_within_a_thousandth_and_is_normalised(written: Path, length: float) -> None:
    before = read_scene(written)
    q = np.array(json.loads(written.read_text())["items"][0]["quaternion"]) * length
    edit(written, _set("items", 0, "quaternion", value=q.tolist()))
    if abs(length - 1.0) > 1e-3:
        with pytest.raises(InputError, match=r"items\[0\]\.quaternion: expected a length of 1"):
            read_scene(written)
    else:
        T = read_scene(written).items[0].T_world_item
        np.testing.assert_allclose(T, before.items[0].T_world_item, atol=1e-12)


def test_an_item_may_lie_anywhere_in_its_bin_and_nowhere_far_beside_it(cell: Cell, tmp_path: Path) -> None:
    """Its middle within 0.15 m of the bin's room, in each direction."""
    bin_, path = cell.pod.bins["bin_E"], tmp_path / "astray.json"
    item = cell.item("crayola_24_ct")
    low = np.array([0.0, bin_.y_range[0], bin_.floor_back])
    high = np.array([bin_.depth, bin_.y_range[1], bin_.ceiling_front])
    middle = (low + high) / 2
    for axis in range(3):
        for edge, outwards in ((low, -1.0), (high, 1.0)):
            for beyond, is_astray in ((0.149, False), (0.151, True)):
                p = middle.copy()
                p[axis] = edge[axis] + outwards * beyond
                placed = PlacedItem("one", item, "bin_E", cell.T_world_pod @ bin_.T_pod_bin @ pose(p))
                scene = Scene(cell, cell.T_world_pod, (placed,), PoseNoise(0.1, 3.0), seed=0)
                write_scene(scene, path)
                try:
                    read_scene(path)
                except InputError as error:
                    assert ("one is 0.15 m away from bin_E" in str(error)) is is_astray
                else:
                    assert not is_astray


def test_the_deepest_of_several_solids_is_named(cell: Cell, tmp_path: Path) -> None:
    scene = make_scene(cell)
    first = scene.items[0]
    sunk = _lowered(replace(scene, items=(first,)), first, dy=-0.1, dz=-0.004)
    message = ""
    try:
        _read(sunk, tmp_path / "s.json")
    except InputError as error:
        message = str(error)
    solids = {
        body.name: overlap_depth(
            Solid(first.item.shape, sunk.items[0].T_world_item),
            Solid(body.shape, sunk.T_world_pod @ body.T_parent_shape), 0.005,
        )
        for body in cell.pod.bodies
    }  # fmt: skip
    deepest = max(solids, key=lambda name: solids[name])
    assert f"{first.id} stands {1000 * solids[deepest]:.1f} mm deep in {deepest}" in message


def test_overlaps_are_allowed_by_the_mean_noise_of_both(cell: Cell, tmp_path: Path) -> None:
    below = make_scene(cell).items[0]
    for sunk, is_refused in ((0.0014, False), (0.0016, True)):
        T = pose((0, 0, float(below.item.shape.extents[2]) - sunk)) @ below.T_world_item
        scene = replace(make_scene(cell), items=(below, replace(below, id="above", T_world_item=T)))
        if is_refused:
            with pytest.raises(InputError, match=r"overlap by 1\.6 mm"):
                _read(scene, tmp_path / "s.json")
        else:
            assert _read(scene, tmp_path / "s.json")


def test_a_pose_counts_to_a_ten_millionth(cell: Cell) -> None:
    """Beyond that two scenes are the same: so much is lost by turning a pose into a quaternion and back."""
    item = cell.item("crayola_24_ct")
    hashes = [
        scene_hash(Scene(cell, np.eye(4), (PlacedItem("one", item, TOTE, pose((x, 0.0, 0.0))),), PoseNoise()))
        for x in (0.1, 0.1 + 4e-8, 0.1 - 4e-8, 0.1 + 1e-7, -0.1)
    ]
    assert hashes[0] == hashes[1] == hashes[2] and len(set(hashes)) == 3


def test_an_item_in_a_corner_of_an_obstacle_is_told_as_such(cell: Cell, tmp_path: Path) -> None:
    """Far from the obstacle's middle, as most of what stands in the way is."""
    boom = next(body for body in cell.obstacles.bodies if body.name == "camera_boom")
    np.testing.assert_allclose(boom.T_parent_shape[:3, 3] + boom.shape.extents / 2, (-0.981, -0.904, 2.163))
    placed = PlacedItem("one", cell.item("crayola_24_ct"), TOTE, pose((-0.981, -0.919, 1.682)))
    with pytest.raises(InputError, match=r"one stands .* mm deep in camera_boom"):
        _read(replace(make_scene(cell), items=(placed,)), tmp_path / "s.json")
