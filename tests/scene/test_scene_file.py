"""Scene files: what is written comes back, and every mistake is told with its place."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_cell
from pickcli.cell.pod_tolerance import Displacement
from pickcli.errors import InputError, StaleError
from pickcli.geometry import from_quaternion, pose
from pickcli.scene.scene import TOTE, HeldItem, PlacedItem, PoseNoise, Scene
from pickcli.scene.scene_file import read_scene, scene_hash, write_scene
from support.bare_robot import write_bare_robot
from support.cell_copies import CellCopy
from support.scene_files import edit, make_scene, put_at

Refused = Callable[[Callable[[], object]], str]

CELL = load_cell("apc2016_delft")


def test_a_scene_comes_back_as_it_was_written(cell: Cell, written: Path) -> None:
    scene, back = make_scene(cell), read_scene(written)
    assert scene.items and scene_hash(back) == scene_hash(scene)
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


def test_an_item_in_the_bin_beside_its_own_is_told(cell: Cell, written: Path) -> None:
    """It is within 0.15 m of the bin that it is said to be in."""
    items = json.loads(written.read_text())["items"]
    k = next(i for i, item in enumerate(items) if item["location"] == "bin_E")
    bin_e, (x, _, z) = cell.pod.bins["bin_E"], items[k]["position"]
    left = bin_e.T_carrier_place[1, 3] + bin_e.room.high[1] - 0.1
    edit(written, put_at("items", k, "position", value=[x, left, z]))
    assert read_scene(written).items
    edit(written, put_at("items", k, "location", value="bin_D"))
    with pytest.raises(InputError, match="lies in bin_E, not in bin_D; correct its location"):
        read_scene(written)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("flow: 600,", "flow: 60,", "other devices (e.g. a pump of another flow) than"),
        ("pump: {kind: pump, lead: 2.0,", "pump: {kind: pump, lead: 1.0,", "other devices"),
        ("max_pull: 42.0", "max_pull: 41.0", "other load limits of the tool than"),
    ],
)
def test_a_copied_cell_of_the_same_name_is_another_one(
    cell_copy: CellCopy, tmp_path: Path, old: str, new: str, told: str
) -> None:
    """Stored motions are for both cells, but what a pump holds is not."""
    cell_copy.yaml.replace(old, new)
    other, path = cell_copy.load(), tmp_path / "scene.json"
    assert other.fingerprint == CELL.fingerprint
    write_scene(make_scene(other), path)
    assert read_scene(path, other).items
    with pytest.raises(StaleError) as error:
        read_scene(path)
    assert told in str(error.value) and "--cell" in str(error.value)
    text = json.loads(path.read_text())
    for key in ("devices", "tool"):
        del text["cell"][key]
    path.write_text(json.dumps(text))
    assert read_scene(path).items


@pytest.mark.parametrize("noise", [PoseNoise(), PoseNoise(0.002, 0.0175)])
def test_the_noise_of_the_scene_stated_by_an_item_is_the_same_scene(cell: Cell, noise: PoseNoise) -> None:
    scene = replace(make_scene(cell), noise=noise)
    first, *others = scene.items
    stated = replace(scene, items=(replace(first, noise=PoseNoise(noise.position, noise.angle)), *others))
    assert scene_hash(stated) == scene_hash(scene)
    for own in (PoseNoise(noise.position + 0.001, noise.angle), replace(noise, displacement=0.003)):
        assert scene_hash(replace(scene, items=(replace(first, noise=own), *others))) != scene_hash(scene)


def test_the_displacement_of_an_item_comes_back_and_bounds_all_of_its_points(
    cell: Cell, tmp_path: Path
) -> None:
    scene = make_scene(cell)
    first, *others = scene.items
    own = PoseNoise(0.003, 0.1, 0.004)
    write_scene(replace(scene, items=(replace(first, noise=own), *others)), tmp_path / "scene.json")
    back = read_scene(tmp_path / "scene.json")
    assert back.instance(first.id).noise == own
    assert back.bound(back.instance(first.id)) == 0.004
    assert PoseNoise(0.003, 0.001, 0.1).bound(first.item) < 0.004


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
    edit(written, put_at("held", value=held))
    assert "held.name: unknown item 'elephant' of 2016" in refused(lambda: read_scene(written))
    edit(written, put_at("held", value={**held, "name": "dasani_water_bottle", "id": "crayola_24_ct#0"}))
    assert "held.id: 'crayola_24_ct#0' is a crayola_24_ct of 2016" in refused(lambda: read_scene(written))


quaternions = st.tuples(*[st.floats(-1, 1)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1)
half_turns = st.sampled_from(
    [(1, 0, 0, 0), (0, 1, 0, 0), (0.6, 0.8, 0, 0), (0, 0.6, -0.8, 0), (0, 0, 1, 1e-17)]
)


@given(q=st.one_of(quaternions, half_turns), x=st.floats(0.1, 0.3))
def test_the_hash_survives_the_file_for_any_pose(
    tmp_path_factory: pytest.TempPathFactory, q: tuple[float, float, float, float], x: float
) -> None:
    T = CELL.places[TOTE].T_carrier_place @ pose((x - 0.2, 0.01, 0.5), R=from_quaternion(q))
    placed = PlacedItem("one", CELL.item("crayola_24_ct"), TOTE, T)  # where it may be in the air
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


MISTAKES = {
    "noise in mm": (put_at("noise", "position", value=2.0), "got 2.0; lengths are in m, not mm"),
    "a pod far away": (
        put_at("T_world_pod", "position", value=[1e308, 0, 0]),
        "got 1e+308; lengths are in m",
    ),
    "a cell by its path": (
        put_at("cell", "name", value="../../elsewhere"),
        "cell.name: expected the cell's name",
    ),
    "a cell of a long name": (put_at("cell", "name", value="x" * 300), "cell.name: expected the cell's name"),
    "control characters": (put_at("items", 0, "id", value="\x1b[2J"), "items[0].id: expected"),
    "unknown item": (
        put_at("items", 2, "name", value="crayola_24"),
        "items[2].name: unknown item 'crayola_24' of 2016; did you mean 'crayola_24_ct'?",
    ),
    "unknown year": (
        put_at("items", 2, "year", value=2014),
        "items[2].name: unknown item 'crayola_24_ct' of 2014",
    ),
    "unknown bin": (
        put_at("items", 0, "location", value="bin_M"),
        "items[0].location: unknown place 'bin_M'",
    ),
    "same id twice": (
        put_at("items", 1, "id", value="crayola_24_ct#0"),
        "items[1].id: 'crayola_24_ct#0' stands twice",
    ),
    "not a number": (
        put_at("items", 0, "position", value=[float("nan"), 0, 0]),
        "NaN is not JSON; write a finite number",
    ),
    "infinite": (
        put_at("items", 0, "position", value=[0, float("inf"), 0]),
        "Infinity is not JSON; write a finite number",
    ),
    "two numbers": (
        put_at("items", 0, "position", value=[0, 1]),
        "items[0].position: expected a position [x, y, z] in m",
    ),
    "not a unit quaternion": (
        put_at("items", 3, "quaternion", value=[0, 0, 0, 2]),
        "items[3].quaternion: expected a length of 1, got 2",
    ),
    "zero quaternion": (
        put_at("T_world_pod", "quaternion", value=[0, 0, 0, 0]),
        "T_world_pod.quaternion: expected a length of 1, got 0",
    ),
    "missing key": (
        put_at("noise", value=None),
        "noise: expected bounds of the error of poses of items without bounds of their own, got nothing",
    ),
    "unknown key": (put_at("items", 0, "weight", value=1), "items[0].weight: unknown key"),
    "another format": (put_at("format", value="apc scenes"), "format: expected 'apc scene'"),
    "negative noise": (put_at("noise", "position", value=-1.0), "noise.position: expected"),
    "another frame": (
        put_at("items", 0, "position", value=[0.3, 0.0, 0.1]),
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


def test_a_mistake_in_what_may_be_left_out_is_told_as_any_other(written: Path, refused: Refused) -> None:
    held = {"id": "x", "name": "rawlings_baseball", "year": 2016, "position": [0, 0, 0.04], "quternion": 1}
    edit(written, put_at("held", value=held))
    message = refused(lambda: read_scene(written))
    assert "held.quternion: unknown key; did you mean 'quaternion'?" in message
    assert "held.quaternion: expected a unit quaternion [x, y, z, w], got nothing; add it" in message


def test_the_line_is_the_line(written: Path, refused: Refused) -> None:
    text = written.read_text()
    line = text[: text.index('"crayola_24_ct#4"')].count("\n") + 1
    written.write_text(text.replace('"bin_E"', '"bin_e"'))
    assert f"scene.json:{line}:" in refused(lambda: read_scene(written))


def test_a_scene_of_another_cell_is_stale_and_names_both(cell: Cell, written: Path) -> None:
    edit(written, put_at("cell", "fingerprint", value="ab" * 32))
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


def test_mistakes_beyond_the_first_twenty_are_counted(cell: Cell, written: Path, refused: Refused) -> None:
    """And cost nothing: thousands of items in one place once took minutes."""
    item = json.loads(written.read_text())["items"][0]
    edit(written, lambda content: content.update(items=[{**item, "id": str(i)} for i in range(300)]))
    began = process_time()
    lines = refused(lambda: read_scene(written)).splitlines()
    assert len(lines) == 1 and "20 more are like it" in lines[0]
    assert process_time() - began < 5.0
    unknown = [{**item, "id": str(i), "name": f"nothing_{i}"} for i in range(300)]
    edit(written, lambda content: content.update(items=unknown))
    lines = refused(lambda: read_scene(written)).splitlines()
    assert len(lines) == 21 and "more" in lines[-1]
    edit(written, lambda content: content.update(items=[{**item, "id": str(i)} for i in range(301)]))
    assert "at most 300" in refused(lambda: read_scene(written))


def test_characters_beyond_16_bits_are_read_as_json_writes_them(written: Path) -> None:
    edit(written, lambda content: content["items"][0].update(id="\U0001f4e6 one"))
    assert "\\ud83d\\udce6" in written.read_text()
    assert read_scene(written).items[0].id == "\U0001f4e6 one"


@pytest.mark.parametrize("length", [1.0009, 0.9991, 1.0011, 0.9989])
def test_a_quaternion_is_a_unit_within_a_thousandth_and_is_normalised(written: Path, length: float) -> None:
    before = read_scene(written)
    q = np.array(json.loads(written.read_text())["items"][0]["quaternion"]) * length
    edit(written, put_at("items", 0, "quaternion", value=q.tolist()))
    if abs(length - 1.0) > 1e-3:
        with pytest.raises(InputError, match=r"items\[0\]\.quaternion: expected a length of 1"):
            read_scene(written)
    else:
        T = read_scene(written).items[0].T_world_item
        np.testing.assert_allclose(T, before.items[0].T_world_item, atol=1e-12)


lengths = st.floats(0.0, 0.1)


@given(lengths, st.floats(0.0, 3.2), lengths, lengths, st.floats(0.0, 0.05), st.integers(0, 2**63 - 1))
@example(0.1, 3.2, 0.1, 0.1, 0.05, 2**63 - 1)
@example(0.0, 0.0, 0.0, 0.0, 0.0, 0)
def test_every_bound_comes_back_up_to_its_limit(
    tmp_path_factory: pytest.TempPathFactory, position: float, angle: float, x: float, y: float, yaw: float,
    seed: int,
) -> None:  # fmt: skip
    scene = Scene(
        CELL, CELL.T_world_pod, (), PoseNoise(position, angle), seed, pod_error=Displacement(x, y, yaw)
    )
    path = tmp_path_factory.getbasetemp() / "bounds.json"
    write_scene(scene, path)
    back = read_scene(path, CELL)
    assert (back.noise.position, back.noise.angle, back.seed) == (position, angle, seed)
    assert (back.pod_error, back.items, back.held) == (scene.pod_error, (), None)
    assert scene_hash(back) == scene_hash(scene)


def test_the_hash_sees_every_figure_that_a_plan_depends_on(cell: Cell) -> None:
    scene = make_scene(cell)
    first = scene.items[0]
    tool = cell.robot.tool
    cups = [
        replace(tool.cup, limits=replace(limits, **{field.name: 1.01 * getattr(limits, field.name)}))
        for limits in (tool.cup.limits,)
        for field in fields(limits)
    ]
    figures: dict[str, Any] = {
        "mass": 0.3,
        "mass_error": 0.01,
        "seal_inset": 0.001,
        "speed_scale": 0.5,
        "year": 2015,
    }
    others = [replace(first.item, **{name: value}) for name, value in figures.items()]
    others.append(replace(first.item, shape=replace(first.item.shape, size=(0.095, 0.07, 0.026))))
    others.append(replace(first.item, seals={**first.item.seals, "+x": 0.123}))
    changed = [
        *(replace(scene, pod_error=Displacement(*bounds)) for bounds in 0.01 * np.eye(3)),
        *(
            replace(scene, cell=replace(cell, robot=replace(cell.robot, tool=replace(tool, grip=each))))
            for each in cups
        ),
        *(scene.moved(replace(first, item=item)) for item in others),
        replace(scene, noise=PoseNoise(0.002, 0.0176)),
    ]
    hashes = {scene_hash(scene), *(scene_hash(other) for other in changed)}
    assert len(hashes) == 1 + len(changed)


def test_the_sign_of_zero_is_no_other_pose(cell: Cell) -> None:
    item, hashes = cell.item("crayola_24_ct"), set()
    for zero in (0.0, -0.0, 1e-9, -1e-9):
        T = pose((0.1, 0.0, 0.0))
        T[T == 0.0] = zero
        hashes.add(scene_hash(Scene(cell, np.eye(4), (PlacedItem("one", item, TOTE, T),), PoseNoise())))
    assert len(hashes) == 1


def test_a_pose_counts_to_a_ten_millionth(cell: Cell) -> None:
    """Beyond that two scenes are the same: so much is lost by turning a pose into a quaternion and back."""
    item = cell.item("crayola_24_ct")
    hashes = [
        scene_hash(Scene(cell, np.eye(4), (PlacedItem("one", item, TOTE, pose((x, 0.0, 0.0))),), PoseNoise()))
        for x in (0.1, 0.1 + 4e-8, 0.1 - 4e-8, 0.1 + 1e-7, -0.1)
    ]
    assert hashes[0] == hashes[1] == hashes[2] and len(set(hashes)) == 3


def test_a_cell_without_places_has_scenes_without_a_pod(tmp_path: Path) -> None:
    bare, path = load_cell(write_bare_robot(tmp_path)), tmp_path / "scene.json"
    write_scene(Scene(bare, bare.T_world_pod, (), PoseNoise()), path)
    assert "T_world_pod" not in json.loads(path.read_text())
    np.testing.assert_array_equal(read_scene(path, bare).T_world_pod, bare.T_world_pod)


def test_a_scene_of_another_cell_is_made_again_or_where_nothing_makes_it_looked_at(
    cell: Cell, written: Path, tmp_path: Path
) -> None:
    bare, path = load_cell(write_bare_robot(tmp_path)), tmp_path / "bare.json"
    write_scene(Scene(bare, bare.T_world_pod, (), PoseNoise()), path)
    advice = "if its poses are still right, write that fingerprint into it"
    for file, its, told in ((written, cell, "make the scene again"), (path, bare, advice)):
        edit(file, put_at("cell", "fingerprint", value="0" * 64))
        with pytest.raises(StaleError, match=rf"but this is {its.name} {its.scene_fingerprint}; {told}$"):
            read_scene(file, its)


def test_an_unknown_cell_is_told_where_it_stands_with_what_may_be_meant(
    written: Path, refused: Refused
) -> None:
    edit(written, put_at("cell", "name", value="ur5e_crate"))
    message = refused(lambda: read_scene(written))
    assert f"{written}:" in message and "cell.name: unknown cell 'ur5e_crate'; did you mean " in message
    assert message.endswith("'ur5e_crates'? (for a cell elsewhere: --cell)")
