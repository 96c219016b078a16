"""``apc perceive``: items of bins in one look, or one message why not."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pickcli.cell.cell import Cell
from pickcli.commands.output.perceived_lines import perceived_lines
from pickcli.geometry import rotation_angle
from pickcli.perception.items.item_observation import (
    FoundBy,
    ItemObservation,
    PlaceObservation,
    UnexplainedPart,
)
from pickcli.perception.items.perceived_file import read_perceived
from pickcli.perception.items.routing import ItemRoute
from pickcli.perception.textures.opencv import VERSION
from pickcli.perception.textures.sift_views import SiftViews
from pickcli.perception.viewpoints import viewpoints_of
from pickcli.scene.scene import PoseNoise
from pickcli.scene.scene_file import read_scene
from support.command_line import ITEM, Made, apc, refused


def test_answers_are_written_and_told(made: Made, cell: Cell, tmp_path: Path) -> None:
    path = tmp_path / "perceived.json"
    argv = ("perceive", "--scene", made.scene, "--camera", "hand", "--at", "cam_C", "-o", path)
    answer = apc(*argv)
    assert answer.code == 0, answer.err
    assert "bin_C: 2 of 2 listed items found, 8" in answer.out
    assert "something" not in answer.out
    scene = read_scene(made.scene, cell)
    (place,) = read_perceived(path, cell).places
    assert {item.id for item in place.items} == {ITEM, "crayola_24_ct"}
    for item in place.items:
        assert item.T_world_item is not None
        assert np.linalg.norm(item.T_world_item[:3, 3] - scene.find(item.id).T_world_item[:3, 3]) < 0.005
    told = json.loads(apc(*argv, "--overwrite", "--json").out)
    assert told.pop("path") == str(path)
    assert told.pop("seed") == 0
    content = json.loads(path.read_text())
    assert {key: told[key] for key in content} == content


def test_answers_are_drawn_over_the_picture(made: Made, tmp_path: Path) -> None:
    picture, path = tmp_path / "drawn.png", tmp_path / "perceived.json"
    argv = ("perceive", "--scene", made.scene, "--camera", "hand", "--at", "cam_C", "-o", path)
    told = apc(*argv, "--picture", picture, "--json")
    assert told.code == 0 and json.loads(told.out)["picture"] == str(picture)
    with Image.open(picture) as drawn:
        assert drawn.size[0] == 1280 and drawn.size[1] > 1024
    refused(apc(*argv, "--overwrite", "--picture", tmp_path / "drawn.jpg"), 3, "drawn.jpg", ".png")
    refused(apc(*argv[:-1], tmp_path / "b.json", "--picture", picture), 3, "drawn.png", "--overwrite")
    assert not (tmp_path / "b.json").exists()


@pytest.mark.parametrize("views", ["auto", "all-views", "each-view"])
def test_prints_tell_which_side_is_in_front(made: Made, cell: Cell, tmp_path: Path, views: str) -> None:
    path = tmp_path / "perceived.json"
    argv = (
        "perceive",
        "--scene",
        made.scene,
        "--camera",
        "hand",
        "--at",
        "cam_C",
        "--textures",
        4,
        "-o",
        path,
    )
    answer = apc(*argv, "--sift", views)
    assert answer.code == 0, answer.err
    scene = read_scene(made.scene, cell)
    assert json.loads(path.read_text())["made_from"]["versions"]["opencv"] == VERSION
    (place,) = read_perceived(path, cell).places
    by_print = [item for item in place.items if item.found_by is FoundBy.PRINT]
    assert by_print and all(item.item.is_printed for item in by_print)
    for item in by_print:
        assert item.T_world_item is not None
        R, R_true = item.T_world_item[:3, :3], scene.find(item.id).T_world_item[:3, :3]
        assert rotation_angle(R.T @ R_true) < np.radians(10.0), item.id
        assert re.search(rf"{item.id} +print", answer.out)
    assert "by print (" in answer.out and " and shape: " in answer.out
    answer = apc(*argv, "--overwrite", "--sift", "none")
    assert answer.code == 0 and "by shape: prints are left out: " in answer.out
    versions = json.loads(path.read_text())["made_from"]["versions"]
    assert set(versions) == {"apc-pick", "python", "numpy", "scipy"}, "it needs no OpenCV"
    (place,) = read_perceived(path, cell).places
    assert {item.found_by for item in place.items} == {FoundBy.SHAPE}
    assert {item.route for item in place.items} == {ItemRoute(None, "prints are left out")}


def test_the_route_of_each_item_is_in_the_file_and_older_files_have_none(
    made: Made, cell: Cell, tmp_path: Path
) -> None:
    path = tmp_path / "perceived.json"
    argv = ("perceive", "--scene", made.scene, "--camera", "hand", "--at", "cam_C", "-o", path)
    assert apc(*argv).code == 0
    content = json.loads(path.read_text())
    (first, _) = content["places"][0]["items"]
    assert first["route"] == {"views": "all-views", "why": "", "twins": []}
    (place,) = read_perceived(path, cell).places
    assert all(item.route == ItemRoute(SiftViews.ALL) for item in place.items)
    del first["route"]
    path.write_text(json.dumps(content))
    (place,) = read_perceived(path, cell).places
    assert place.items[0].route is None
    first["route"] = {"views": "some-views", "why": "", "twins": []}
    path.write_text(json.dumps(content))
    refused(apc("check", path), 3, "places[0].items[0].route.views", "all-views")


def test_a_way_to_compare_views_that_does_not_exist_is_told(made: Made, tmp_path: Path) -> None:
    argv = ("perceive", "--scene", made.scene, "--camera", "hand", "--at", "cam_C", "-o", tmp_path / "a.json")
    answer = apc(*argv, "--sift", "some-views")
    assert (
        answer.code == 2
        and "'some-views' is not one of 'auto', 'none', 'all-views', 'each-view'" in answer.err
    )


def test_what_was_perceived_is_inspected_and_checked(made: Made, tmp_path: Path) -> None:
    path = tmp_path / "perceived.json"
    argv = ("perceive", "--scene", made.scene, "--camera", "hand", "--at", "cam_C", "-o", path)
    assert apc(*argv).code == 0
    told = apc("inspect", path)
    assert told.code == 0
    assert f"{ITEM}: at " in told.out and "of its room is seen" in told.out
    summary = json.loads(apc("inspect", path, "--json").out)
    content = json.loads(path.read_text())
    assert {key: summary[key] for key in ("format", "cell", "camera", "sensor")} == {
        key: content[key] for key in ("format", "cell", "camera", "sensor")
    }
    assert summary["places"][0]["items"][0]["confidence"] == content["places"][0]["items"][0]["confidence"]
    assert "without mistakes; 2 of 2 listed items found in bin_C" in apc("check", path).out
    content["places"][0]["items"][0]["confidence"] = 2
    path.write_text(json.dumps(content))
    for command in ("inspect", "check"):
        refused(apc(command, path), 3, "places[0].items[0].confidence")
    content["cell"] = "apc2016_delf"
    content["places"][0]["items"][0]["confidence"] = 1
    path.write_text(json.dumps(content))
    refused(apc("check", path), 3, "apc2016_delf")
    assert apc("check", path, "--cell", "apc2016_delft").code == 0


def test_same_seed_same_bytes(made: Made, tmp_path: Path) -> None:
    files = []
    for i, seed in enumerate((1, 1, 2)):
        path = tmp_path / f"{i}.json"
        argv = ("perceive", "--scene", made.scene, "--camera", "hand", "--at", "cam_C", "--bin", "bin_C")
        assert apc(*argv, "-o", path, "--seed", seed).code == 0
        files.append(path.read_bytes())
    assert files[0] == files[1]
    assert files[0] != files[2]


def test_lines_tell_bounds_doubts_and_what_is_left(cell: Cell) -> None:
    """A confidence never reads higher than it is, and what is left is told beside a refusal, too."""
    left = UnexplainedPart(200, np.zeros(3), np.array([0.1, 0.05, 0.02]))
    item = cell.item(ITEM, 2016)
    sure = ItemObservation(ITEM, item, np.eye(4), 0.9996, "", PoseNoise(0.0042, np.radians(3.4)), None)
    unsure = ItemObservation(
        f"{ITEM}#2", item, np.eye(4), 0.49996, "confidence 0.499 is below 0.5", None, None
    )
    one, two = (
        "\n".join(perceived_lines(PlaceObservation("bin_A", np.eye(4), items, (left,), 0.876)))
        for items in ((sure,), (sure, unsure))
    )
    assert "bin_A: 1 of 1 listed items found, 88% of its room is seen" in one
    assert "0.999  4.2 mm  3.4 deg" in one
    assert "something of 100 x 50 x 20 mm is there that is not listed" in one
    assert "0.499" in two and "0.50 " not in two
    assert "something of 100 x 50 x 20 mm is there that is refused above or not listed" in two
    (empty,) = perceived_lines(PlaceObservation("bin_A", np.eye(4), (), (), 0.9))
    assert empty == "bin_A: no items are listed to be there, 90% of its room is seen"


@pytest.mark.parametrize(
    ("argv", "code", "told"),
    [
        (("--camera", "hand"), 2, "-o"),
        (("--camera", "hands", "-o", "a.json"), 3, "did you mean 'hand'?"),
        (("--camera", "hand", "--at", "cam_X", "-o", "a.json"), 3, "cam_X"),
        (("--camera", "hand", "-o", "a.png"), 3, "is written as .json"),
        (
            ("--camera", "hand", "-o", "a.json"),
            3,
            "camera hand at home: shows less than 50% of the room of every place with items",
        ),
        (("--camera", "hand", "--at", "cam_C", "--bin", "bin_Z", "-o", "a.json"), 3, "bin_Z"),
        (("--camera", "hand", "--at", "cam_C", "--bin", "bin_L", "-o", "a.json"), 3, "is not in the picture"),
        (("--camera", "hand", "--at", "cam_C", "--bin", "bin_B", "-o", "a.json"), 3, "% of its room is seen"),
        (
            ("--camera", "boom", "--at", "tote_11h", "--bin", "tote", "-o", "a.json"),
            3,
            "71% is hidden by the robot",
        ),
        (
            ("--camera", "hand", "--at", "drop_12_down", "-o", "a.json"),
            3,
            "camera hand at drop_12_down: nothing is measured in any pixel; ensenso measures from",
        ),
        (
            ("--camera", "hand", "--at", "drop_12_down", "-o", "a.json"),
            3,
            "look from before a place (--camera and --at say from where it is taken)",
        ),
    ],
)
def test_mistakes_are_told(made: Made, tmp_path: Path, argv: tuple[str, ...], code: int, told: str) -> None:
    words = [str(tmp_path / word) if word.endswith((".png", ".json")) else word for word in argv]
    answer = apc("perceive", "--scene", made.scene, *words)
    assert answer.code == code
    assert told in answer.err
    assert not list(tmp_path.iterdir())


def _recorded(made: Made, at: str, folder: Path) -> Path:
    """A recording of what the camera on the gripper sees in a configuration."""
    path = folder / f"{at}.json"
    written = apc(
        "render", "--scene", made.scene, "--camera", "hand", "--at", at, "--textures", 1,
        "-o", folder / f"{at}.png", "--depth", folder / f"{at}_depth.png", "--recording", path,
    )  # fmt: skip
    assert written.code == 0 and f"recording: {path}" in written.out, written.err
    return path


def test_a_recording_gives_the_answers_of_the_look_that_it_recorded(
    made: Made, cell: Cell, tmp_path: Path
) -> None:
    """Within what rounding of the depth to 0.1 mm changes; the list may be an order's."""
    recorded, path, own = _recorded(made, "cam_C", tmp_path), tmp_path / "a.json", tmp_path / "b.json"
    argv = ("perceive", "--recorded", recorded, "--bin", "bin_C")
    answer = apc(*argv, "--order", made.order, "--cell", "apc2016_delft", "-o", path)
    assert answer.code == 0, answer.err
    assert apc(*argv, "--scene", made.scene, "-o", own).code == 0
    looked = tmp_path / "c.json"
    at = ("--camera", "hand", "--at", "cam_C", "--bin", "bin_C")
    assert apc("perceive", "--scene", made.scene, *at, "-o", looked).code == 0
    (one,), (two,), (three,) = (read_perceived(each, cell).places for each in (path, own, looked))
    assert {item.id for item in one.items} == {item.id for item in two.items}
    for item in three.items:
        (same,) = (each for each in one.items if each.id == item.id)
        assert item.T_world_item is not None and same.T_world_item is not None
        assert np.linalg.norm(item.T_world_item[:3, 3] - same.T_world_item[:3, 3]) < 0.0015


def test_recordings_from_several_places_are_looks_that_may_agree(
    made: Made, cell: Cell, tmp_path: Path
) -> None:
    side = viewpoints_of(cell.places["bin_C"], cell)[1].at
    aside = ",".join(repr(float(value)) for value in side.q)
    first, path = _recorded(made, "cam_C", tmp_path), tmp_path / "p.json"
    second = tmp_path / "aside.json"
    written = apc(
        "render", "--scene", made.scene, "--camera", "hand", f"--at={aside}", "--textures", 1, "--seed", 5,
        "-o", tmp_path / "aside.png", "--depth", tmp_path / "aside_depth.png", "--recording", second,
    )  # fmt: skip
    assert written.code == 0, written.err
    both = ("--recorded", first, "--recorded", second)
    by_shape = ("--bin", "bin_C", "--sift", "none")  # prints of both looks would be solved for together
    assert apc("perceive", "--scene", made.scene, *both, *by_shape, "-o", path).code == 0
    perceived = read_perceived(path, cell)
    (T_other,) = perceived.also_from
    np.testing.assert_allclose(T_other, json.loads(second.read_text())["T_world_camera"], atol=1e-9)
    # What two looks agree on is bound otherwise than what each of them says by itself.
    places = [perceived.places[0]]
    for each in (first, second):
        alone = tmp_path / "q.json"
        argv = ("perceive", "--scene", made.scene, "--recorded", each, *by_shape, "--overwrite")
        assert apc(*argv, "-o", alone).code == 0
        places.append(read_perceived(alone, cell).places[0])
    for item, *singles in zip(*(place.items for place in places), strict=True):
        assert item.bound is not None and item.bound not in [single.bound for single in singles]
        poses = [single.T_world_item for single in singles if single.T_world_item is not None]
        assert len(poses) == 2 and item.T_world_item is not None
        assert min(np.abs(item.T_world_item - T).max() for T in poses) < 1e-6


def test_looks_from_both_sides_give_bounds_by_what_they_agree_on(
    made: Made, cell: Cell, tmp_path: Path
) -> None:
    path, argv = tmp_path / "a.json", ("perceive", "--scene", made.scene, "--camera")
    at = ("--at", "cam_C", "--bin", "bin_C", "-o", path)
    answer = apc(*argv, "hand", *at, "--aslant")
    assert answer.code == 0, answer.err
    perceived, place = read_perceived(path, cell), cell.places["bin_C"]
    aside = [each.T_world_camera for each in viewpoints_of(place, cell)[1:]]
    np.testing.assert_allclose(perceived.also_from, aside, atol=1e-7)
    scene = read_scene(made.scene, cell)
    for item in perceived.places[0].items:
        assert item.T_world_item is not None and item.bound is not None
        off = item.T_world_item[:3, 3] - scene.find(item.id).T_world_item[:3, 3]
        assert np.linalg.norm(off) <= item.bound.position < 0.004
    first = path.read_bytes()
    assert apc(*argv, "hand", *at, "--aslant", "--overwrite").code == 0 and path.read_bytes() == first
    fixed = apc(*argv, "boom", "--bin", "tote", "-o", tmp_path / "b.json", "--aslant")
    assert fixed.code == 3 and "camera boom: no arm moves it" in fixed.err


def test_mistakes_with_recordings_are_told(made: Made, tmp_path: Path) -> None:
    recorded, out = _recorded(made, "cam_C", tmp_path), tmp_path / "p.json"
    argv = ("perceive", "--scene", made.scene, "-o", out)
    cases: list[tuple[tuple[object, ...], int, str]] = [
        (("--recorded", recorded, "--camera", "hand"), 2, "leave --camera out"),
        (("--recorded", recorded, "--at", "cam_C"), 2, "leave --at out"),
        (("--recorded", recorded, "--aslant"), 2, "leave --aslant out"),
        ((), 2, "name a camera with --camera, or recordings with --recorded"),
        (("--recorded", tmp_path / "none.json"), 3, "none.json"),
    ]
    for words, code, told in cases:
        answer = apc(*argv, *words)
        assert answer.code == code and told in answer.err
    nothing = apc("perceive", "--camera", "hand", "--cell", "apc2016_delft", "-o", out)
    assert nothing.code == 2 and "--recorded" in nothing.err
    content = json.loads(recorded.read_text())
    recorded.write_text(json.dumps(content | {"at": "cam_X"}))
    refused(apc(*argv, "--recorded", recorded), 3, "cam_X")
    recorded.write_text(json.dumps(content | {"at": "cam_F"}))
    refused(apc(*argv, "--recorded", recorded), 3, "cam_C.json: T_world_camera is", "the arm at cam_F")
    recorded.write_text(json.dumps(content))
    before = (tmp_path / "cam_C_depth.png").read_bytes()
    drawn = ("--picture", tmp_path / "cam_C_depth.png", "--overwrite")
    refused(apc(*argv, "--recorded", recorded, *drawn), 3, "cam_C_depth.png: is an input of this command")
    assert (tmp_path / "cam_C_depth.png").read_bytes() == before
    recorded.write_text(json.dumps(content | {"depth": "cam_C.png"}))
    refused(apc(*argv, "--recorded", recorded), 3, "cam_C.png: expected a grey PNG of 16 bits")
    recorded.write_text(json.dumps(content | {"at": "cam_L", "camera": "boom", "sensor": "kinect_v2"}))
    assert apc(*argv, "--recorded", recorded).code == 3
    only = ("render", "--scene", made.scene, "--camera", "hand", "-o", tmp_path / "x.png")
    half = apc(*only, "--recording", tmp_path / "x.json")
    assert half.code == 2 and "--depth" in half.err
    assert not out.exists() and not (tmp_path / "x.json").exists()
