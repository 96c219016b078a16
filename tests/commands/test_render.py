"""``apc render``: pictures by the cameras of a cell, or one message why not."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pickcli.cell.cell import Cell
from pickcli.cell.cell_file import load_workcell
from pickcli.cell.data_path import data_path
from pickcli.geometry import Array
from pickcli.perception.camera_pose import camera_pose
from pickcli.perception.depth_picture import measure_depth
from pickcli.perception.rendered_scene import RenderedScene
from pickcli.scene.scene import empty_scene
from pickcli.scene.scene_file import read_scene, write_scene
from support.cell_copies import CellCopy
from support.command_line import ITEM, Made, apc, refused


def depth_in(path: Path) -> Array:
    """Depth of a picture that was written, m; NaN where there is none."""
    steps = np.asarray(Image.open(path)).astype(np.float64)
    return np.where(steps > 0, 1e-4 * steps, np.nan)


def test_pictures_are_written_and_told(made: Made, tmp_path: Path) -> None:
    picture, depth = tmp_path / "picture.png", tmp_path / "depth.png"
    argv = ("render", "--scene", made.scene, "--camera", "hand", "--at", "cam_C", "-o", picture)
    answer = apc(*argv, "--depth", depth, "--json")
    assert answer.code == 0, answer.err
    told = json.loads(answer.out)
    assert told["path"] == str(picture)
    assert told["depth_path"] == str(depth)
    assert told["sensor"] == "ensenso"
    assert told["size"] == [1280, 1024]
    assert set(told["items"]) == {ITEM, "crayola_24_ct"}
    assert 0.2 < told["measured_share"] < 0.95
    shown = Image.open(picture)
    assert (shown.mode, shown.size) == ("RGB", (1280, 1024))
    assert Image.open(depth).size == (1280, 1024)
    assert "2 items in sight of hand (ensenso)" in apc(*argv, "--overwrite").out


def test_cloth_and_bags_are_shown_rumpled_if_asked(cell: Cell, tmp_path: Path) -> None:
    scene, out = tmp_path / "scene.json", tmp_path / "picture.png"
    words = ("make-scene", "--in", "bin_C=scotch_bubble_mailer,dove_beauty_bar", "-o", scene)
    assert apc(*words).code == 0
    argv = (
        "render",
        "--scene",
        scene,
        "--camera",
        "hand",
        "--at",
        "cam_C",
        "-o",
        out,
        "--json",
        "--overwrite",
    )
    pictures, pixels = [], []
    for extra in ((), ("--deformed",), ("--deformed",), ("--deformed", "--textures", 5)):
        told = apc(*argv, *extra)
        assert told.code == 0, told.err
        pixels.append(json.loads(told.out)["items"])
        pictures.append(out.read_bytes())
    assert pictures[1] == pictures[2] and len(set(pictures)) == 3
    mailer, bar = "scotch_bubble_mailer", "dove_beauty_bar"
    assert 0.5 * pixels[0][mailer] < pixels[1][mailer] < pixels[0][mailer]
    assert pixels[1][bar] >= pixels[0][bar]


def test_depth_in_the_file_is_that_of_the_library(made: Made, cell: Cell, tmp_path: Path) -> None:
    """With noise by its seed, in steps of 0.1 mm; without it the true depth."""
    looking, hand = cell.configurations["cam_C"], cell.cameras["hand"]
    rendered = RenderedScene.of(read_scene(made.scene, cell), looking.q, looking.tool_state)
    T = camera_pose(cell.robot, hand, looking.q, looking.tool_state)
    noisy, clean = (
        measure_depth(rendered, hand.model, T, 7).depth,
        rendered.seen_by(hand.model.camera, T).depth,
    )
    path = tmp_path / "depth.png"
    argv = (
        "render",
        "--scene",
        made.scene,
        "--camera",
        "hand",
        "--at",
        "cam_C",
        "--depth",
        path,
        "--overwrite",
    )
    for more, expected in ((("--seed", 7), noisy), (("--no-noise",), clean)):
        assert apc(*argv, *more).code == 0
        within = expected < 6.55
        np.testing.assert_allclose(depth_in(path)[within], expected[within], atol=0.51e-4)
        assert np.isnan(depth_in(path)[~within]).all()


def test_same_seed_same_bytes(made: Made, tmp_path: Path) -> None:
    files = []
    for i, more in enumerate((("--seed", 1), ("--seed", 1), ("--seed", 2), ("--textures", 1))):
        picture, depth = tmp_path / f"picture{i}.png", tmp_path / f"depth{i}.png"
        argv = ("render", "--scene", made.scene, "--camera", "hand", "--at", "cam_C", "-o", picture)
        assert apc(*argv, "--depth", depth, *more).code == 0
        files.append((picture.read_bytes(), depth.read_bytes()))
    assert files[0] == files[1]
    assert files[2][0] == files[0][0]
    assert files[2][1] != files[0][1]
    assert files[3][0] != files[0][0]


def test_a_camera_in_the_world_needs_no_configuration(made: Made, tmp_path: Path) -> None:
    answer = apc("render", "--scene", made.scene, "--camera", "boom", "-o", tmp_path / "tote.png", "--json")
    assert answer.code == 0, answer.err
    np.testing.assert_allclose(
        np.array(json.loads(answer.out)["T_world_camera"])[:3, 3], [-1.045, -0.754, 2.11]
    )


@pytest.mark.parametrize(
    ("argv", "code", "told"),
    [
        (("--camera", "hand"), 2, "nothing to write: name a colour picture with -o"),
        (("-o", "a.png"), 2, "--camera"),
        (("--camera", "hands", "-o", "a.png"), 3, "did you mean 'hand'?"),
        (("--camera", "hand", "--at", "cam_X", "-o", "a.png"), 3, "cam_X"),
        (("--camera", "hand", "-o", "a.jpg"), 3, "is written as .png"),
        (("--camera", "hand", "-o", "a.png", "--depth", "a.png"), 3, "would be written twice"),
        (("--camera", "hand", "-o", "none/a.png"), 3, "does not exist"),
    ],
)
def test_mistakes_are_told_before_any_work(
    made: Made, tmp_path: Path, argv: tuple[str, ...], code: int, told: str
) -> None:
    words = [str(tmp_path / word) if word.endswith((".png", ".jpg")) else word for word in argv]
    answer = apc("render", "--scene", made.scene, *words)
    assert answer.code == code
    assert told in answer.err
    assert not list(tmp_path.glob("*.png"))


def test_depth_of_a_colour_camera_is_refused_unless_it_is_the_true_one(
    made: Made, cell_copy: CellCopy, tmp_path: Path
) -> None:
    cell_copy.yaml.replace("model: ensenso", "model: ids_wrist")
    argv = ("render", "--scene", made.scene, "--cell", cell_copy.folder, "--camera", "hand", "--at", "cam_C")
    refused(
        apc(*argv, "--depth", tmp_path / "a.png"),
        3,
        "camera hand: ids_wrist is a colour camera",
        "--no-noise",
    )
    assert apc(*argv, "--depth", tmp_path / "a.png", "--no-noise").code == 0
    assert apc(*argv, "-o", tmp_path / "b.png").code == 0


def test_a_cell_without_cameras_is_told_how_to_have_one(
    made: Made, cell_copy: CellCopy, tmp_path: Path
) -> None:
    text = cell_copy.yaml.path.read_text()
    cell_copy.yaml.path.write_text(text[: text.index("sensors:\n")])
    argv = ("render", "--scene", made.scene, "--cell", cell_copy.folder, "--camera", "hand")
    refused(apc(*argv, "-o", tmp_path / "a.png"), 3, "has no cameras; add one under sensors")


def test_a_wrong_cell_and_no_camera_are_told_before_arms(made: Made, tmp_path: Path) -> None:
    """Naming an arm would help with neither."""
    out, scene = tmp_path / "a.png", tmp_path / "scene.json"
    argv = ("render", "--camera", "hand", "-o", out, "--scene")
    refused(apc(*argv, made.scene, "--cell", "apc2016_kth"), 4, "made for cell apc2016_delft")
    write_scene(empty_scene(load_workcell("apc2016_kth").preferred), scene)
    refused(apc(*argv, scene), 3, "cell apc2016_kth: has no cameras")
    refused(apc(*argv, scene, "--cell", "apc2016_kth"), 3, "cell apc2016_kth: has no cameras")


def test_of_several_arms_the_one_with_the_configuration_carries_the_camera(tmp_path: Path) -> None:
    """A camera on the left hand moves with the left arm, which need not be named if --at is its own."""
    folder = tmp_path / "kth"
    shutil.copytree(data_path() / "cells" / "apc2016_kth", folder)
    link = load_workcell("apc2016_kth").arms["left"].robot.tool.last_link
    with (folder / "cell.yaml").open("a") as file:
        file.write(
            f"\nsensors:\n  wrist:\n    model: ids_wrist\n    link: {link}\n"
            "    T_parent_camera: {xyz: [0, 0, 0.05], rpy: [0, 0, 0]}\n    error: {position: 0, angle: 0}\n"
        )
    workcell = load_workcell(folder)
    scene = tmp_path / "scene.json"
    write_scene(empty_scene(workcell.preferred), scene)
    left, right = workcell.arms["left"], workcell.arms["right"]
    own = next(name for name in left.configurations if name not in right.configurations)
    common = next(name for name in left.configurations if name in right.configurations)
    argv = ("render", "--scene", scene, "--cell", folder, "--camera", "wrist", "--overwrite", "--json")
    poses = []
    for name, more in ((own, ()), (common, ("--arm", "left"))):
        answer = apc(*argv, "-o", tmp_path / "a.png", "--at", name, *more)
        assert answer.code == 0, answer.err
        at = left.configurations[name]
        expected = camera_pose(left.robot, left.cameras["wrist"], at.q, at.tool_state)
        np.testing.assert_allclose(json.loads(answer.out)["T_world_camera"], expected, atol=1e-12)
        poses.append(expected)
    assert np.abs(poses[0] - poses[1]).max() > 1e-3
