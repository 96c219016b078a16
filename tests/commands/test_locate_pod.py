"""``apc locate-pod``: where the pod stands, and what becomes of that, or one message why not."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import Displacement
from pickcli.geometry import inverse
from pickcli.perception.items.perceived_file import read_perceived
from pickcli.scene.scene_file import read_scene, write_scene
from support.command_line import ITEM, Made, apc, refused

SHIFT = "20,-10,1.5"  # mm, mm and degrees
AT = ("--camera", "hand", "--at", "cam_C")


@pytest.fixture(scope="module")
def shifted(made: Made, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("locate") / "shifted.json"
    assert apc("make-scene", made.order, "--pod-shift", SHIFT, "-o", path).code == 0
    return path


@pytest.fixture(scope="module")
def pod(shifted: Path) -> Path:
    path = shifted.parent / "pod.json"
    answer = apc("locate-pod", "--scene", shifted, *AT, "-o", path)
    assert answer.code == 0, answer.err
    return path


def test_a_pod_displaced_by_a_known_amount_is_found_and_told(shifted: Path, tmp_path: Path) -> None:
    path = tmp_path / "pod.json"
    answer = apc("locate-pod", "--scene", shifted, *AT, "-o", path)
    assert answer.code == 0, answer.err
    assert "the pod stands +20.0 mm in x, -10.0 mm in y, +1.50 degrees off its place" in answer.out
    assert (
        "  found from all of its boxes, then fitted as a whole" in answer.out
    )  # before a bin no leg is seen
    assert "  within " in answer.out and "no point of its front is off by more than" in answer.out
    told = json.loads(apc("locate-pod", "--scene", shifted, *AT, "-o", path, "--overwrite", "--json").out)
    off = told["displacement"]
    np.testing.assert_allclose([off["x"], off["y"]], [0.02, -0.01], atol=2e-4)
    assert off["yaw"] == pytest.approx(np.radians(1.5), abs=2e-4)
    content = json.loads(path.read_text())
    assert {key: told[key] for key in content} == content
    assert content["places"] == []


def test_the_camera_at_the_waist_of_kth_finds_it(tmp_path: Path) -> None:
    """By another robot, and upside down: their paper, section III-A."""
    scene, path = tmp_path / "scene.json", tmp_path / "pod.json"
    made = ("--cell", "apc2016_kth_picking", "--in", f"bin_H={ITEM}", "--pod-shift", "-30,25,-2")
    assert apc("make-scene", *made, "-o", scene).code == 0
    answer = apc("locate-pod", "--scene", scene, "--camera", "chest", "-o", path, "--json")
    assert answer.code == 0, answer.err
    told = json.loads(answer.out)
    np.testing.assert_allclose([1e3 * told["displacement"][key] for key in "xy"], [-30.0, 25.0], atol=1.0)
    assert np.degrees(told["displacement"]["yaw"]) == pytest.approx(-2.0, abs=0.1)
    assert told["pod"]["error"]["x"] < 0.01
    for command in ("check", "inspect"):  # what a camera saw is the same for both arms
        assert apc(command, path).code == 0


def test_where_both_legs_are_seen_they_are_where_the_fit_begins(tmp_path: Path, cell: Cell) -> None:
    scene, path = tmp_path / "scene.json", tmp_path / "pod.json"
    made = ("--cell", "apc2016_kth_picking", "--in", f"bin_H={ITEM}", "--pod-shift", "45,-30,2")
    assert apc("make-scene", *made, "-o", scene).code == 0
    answer = apc("locate-pod", "--scene", scene, "--camera", "chest", "-o", path)
    assert answer.code == 0, answer.err
    assert "  found from its two front legs, then fitted as a whole" in answer.out
    assert json.loads(path.read_text())["pod"]["start"] == "legs"


def test_a_file_from_before_starts_were_stated_is_read(pod: Path, cell: Cell, tmp_path: Path) -> None:
    content = json.loads(pod.read_text())
    assert content["pod"].pop("start") == "boxes"
    path = tmp_path / "before.json"
    path.write_text(json.dumps(content))
    found = read_perceived(path, cell).pod
    assert found is not None and found.start is None
    assert "found from" not in apc("inspect", path).out and apc("check", path).code == 0


def test_the_file_is_read_back_inspected_and_checked(pod: Path, cell: Cell) -> None:
    found = read_perceived(pod, cell).pod
    assert found is not None
    summary = json.loads(apc("inspect", pod, "--json").out)["pod"]
    content = json.loads(pod.read_text())["pod"]
    assert {**summary, "pose": content["pose"]} == content
    assert "without mistakes; 0 of 0 listed items found, and the pod" in apc("check", pod).out


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda pod: pod["error"].update(x=-1.0), "pod.error.x"),
        (lambda pod: pod["pose"].update(quaternion=[1.0, 0.0, 0.0, 0.0]), "leans, or is not on the floor"),
        (lambda pod: pod["pose"].update(position=[0.0, 0.0, 0.5]), "leans, or is not on the floor"),
        (lambda pod: pod.pop("pixels"), "pixels"),
        (lambda pod: pod.update(pixels=0), "pod.pixels"),
        (lambda pod: pod.update(start="arms"), 'pod.start: expected "legs" or "boxes"'),
    ],
)
def test_mistakes_in_the_file_are_told(pod: Path, tmp_path: Path, change, told: str) -> None:  # type: ignore[no-untyped-def]
    content = json.loads(pod.read_text())
    change(content["pod"])
    path = tmp_path / "changed.json"
    path.write_text(json.dumps(content))
    refused(apc("check", path), 3, told)


def test_a_pod_that_is_known_exactly_is_refused(pod: Path, tmp_path: Path) -> None:
    content = json.loads(pod.read_text())
    content["pod"]["front_error"] = 0.0
    path = tmp_path / "changed.json"
    path.write_text(json.dumps(content))
    answer = apc("check", path)
    assert answer.code == 3 and "pod.front_error: expected m, above 0" in answer.err


def test_a_recorded_picture_says_the_same(shifted: Path, pod: Path, cell: Cell, tmp_path: Path) -> None:
    depth, path = tmp_path / "depth.png", tmp_path / "recorded.json"
    assert apc("render", "--scene", shifted, *AT, "--depth", depth).code == 0
    answer = apc("locate-pod", "--scene", shifted, *AT, "--recorded", depth, "-o", path)
    assert answer.code == 0, answer.err
    one, other = (read_perceived(each, cell).pod for each in (pod, path))
    assert one is not None and other is not None
    np.testing.assert_allclose(other.T_world_pod, one.T_world_pod, atol=1e-4)


def test_the_believed_pod_holds_the_true_one_for_planner_and_verifier(
    pod: Path, shifted: Path, cell: Cell, tmp_path: Path
) -> None:
    """Every corner of it is in the volume that takes its place."""
    path, plan = tmp_path / "believed.json", tmp_path / "plan.json"
    answer = apc("believe", pod, "--empty", "tote", "-o", path)
    assert answer.code == 0, answer.err
    assert "the pod stands +20.0 mm" in answer.out
    true, believed = read_scene(shifted, cell), read_scene(path, cell)
    found = read_perceived(pod, cell).pod
    assert found is not None and believed.pod_error == found.error != Displacement()
    np.testing.assert_allclose(believed.T_world_pod, found.T_world_pod, atol=1e-12)
    T = inverse(believed.T_world_pod) @ true.T_world_pod
    for body in cell.pod.bodies:
        half = body.shape.extents / 2
        swept = believed.pod_error.swept(body)
        for signs in np.stack(np.meshgrid(*[(-1, 1)] * 3), axis=-1).reshape(-1, 3):
            corner = (T @ body.T_parent_shape @ np.append(signs * half, 1.0))[:3]
            local = (inverse(swept.T_parent_shape) @ np.append(corner, 1.0))[:3]
            assert (np.abs(local) <= swept.shape.extents / 2 + 1e-9).all(), body.name
    move = ("plan-move", "--from", "home", "--to", "bin_C", "-o", plan, "--scene", path)
    answer = apc(*move)
    assert answer.code == 0, answer.err
    assert apc("verify", plan, "--scene", path).code == 0
    wide = tmp_path / "wide.json"
    write_scene(replace(believed, pod_error=Displacement(0.05, 0.05, 0.03)), wide)
    assert apc("verify", plan, "--scene", wide).code != 0


def test_items_are_found_where_the_pod_was_located(
    pod: Path, shifted: Path, made: Made, cell: Cell, tmp_path: Path
) -> None:
    """Though the scene has the pod elsewhere, what is believed is where the true items are."""
    perceived, believed = tmp_path / "perceived.json", tmp_path / "believed.json"
    answer = apc("perceive", "--scene", shifted, *AT, "--pod", pod, "-o", perceived)
    assert answer.code == 0, answer.err
    found = read_perceived(pod, cell).pod
    (place,) = read_perceived(perceived, cell).places
    assert found is not None and place.error == found.error
    answer = apc("believe", pod, perceived, "--empty", "tote", "-o", believed)
    assert answer.code == 0, answer.err
    true, scene = read_scene(shifted, cell), read_scene(believed, cell)
    assert scene.pod_error == found.error and ITEM in {placed.id for placed in scene.items}
    for placed in scene.items:
        off = placed.T_world_item[:3, 3] - true.find(placed.id).T_world_item[:3, 3]
        assert np.linalg.norm(off) < scene.noise_of(placed).position


def test_a_pick_planned_in_what_is_believed_is_executed_in_the_true_scene(tmp_path: Path) -> None:
    """Neither planner nor verifier is told where the pod, or the item, truly is."""
    true, pod, seen, believed, plan = (
        tmp_path / f"{name}.json" for name in ["true", "pod", "seen", "believed", "plan"]
    )
    made = ("--in", f"bin_C={ITEM},crayola_24_ct", "--pod-shift", "30,-25,-2", "--seed", "5")
    assert apc("make-scene", *made, "-o", true).code == 0
    assert apc("locate-pod", "--scene", true, *AT, "-o", pod).code == 0
    assert apc("perceive", "--scene", true, *AT, "--pod", pod, "-o", seen).code == 0
    assert apc("believe", pod, seen, "--empty", "tote", "-o", believed).code == 0
    answer = apc("plan-pick", "--scene", believed, "--bin", "bin_C", "--item", ITEM, "-o", plan)
    assert answer.code == 0 and "certified" in answer.out, answer.err
    answer = apc("execute", plan, "--scene", true, "--planned-in", believed)
    assert answer.code == 0, answer.err
    assert f"{ITEM} is in the tote" in answer.out


def test_looks_into_a_pod_that_stands_elsewhere_are_refused(pod: Path, made: Made, tmp_path: Path) -> None:
    perceived = tmp_path / "perceived.json"
    assert apc("perceive", "--scene", made.scene, *AT, "-o", perceived).code == 0
    answer = apc("believe", pod, perceived, "-o", tmp_path / "believed.json")
    refused(answer, 3, "bin_C was looked into with the pod", "look for its items where the pod was located")
    answer = apc("perceive", "--scene", made.scene, *AT, "--pod", perceived, "-o", tmp_path / "other.json")
    refused(answer, 3, "the pod was not located in it; apc locate-pod writes such a file")


@pytest.mark.parametrize(
    ("argv", "code", "told"),
    [
        (("--camera", "hand"), 2, "-o"),
        (("--camera", "hands", "-o", "a.json"), 3, "did you mean 'hand'?"),
        (("--camera", "hand", "-o", "a.png"), 3, "is written as .json"),
        (("--camera", "boom", "-o", "a.json"), 3, "pod not located"),
        (
            ("--camera", "hand", "--at", "drop_12_down", "-o", "a.json"),
            3,
            "nothing was measured in any pixel",
        ),
    ],
)
def test_mistakes_are_told(made: Made, tmp_path: Path, argv: tuple[str, ...], code: int, told: str) -> None:
    words = [str(tmp_path / word) if word.endswith((".png", ".json")) else word for word in argv]
    answer = apc("locate-pod", "--scene", made.scene, *words)
    assert answer.code == code, answer.err
    assert told in answer.err
    assert not list(tmp_path.iterdir())


def test_recorded_pictures_that_are_none_are_refused(made: Made, tmp_path: Path) -> None:
    out, path = tmp_path / "pod.json", tmp_path / "depth.png"

    def told(picture: Image.Image, *text: str, more: tuple[str, ...] = ()) -> None:
        picture.save(path)
        answer = apc("locate-pod", "--scene", made.scene, *AT, "--recorded", path, *more, "-o", out)
        refused(answer, 3, *text)
        assert not out.exists()

    grey = np.full((1024, 1280), 6000, np.uint16)
    told(Image.fromarray(grey[:100]), "depth: 1280 x 100 px, but the camera has 1280 x 1024")
    told(Image.fromarray(np.zeros_like(grey)), "nothing was measured in any pixel")
    told(Image.fromarray(grey), "is it in another unit", more=("--depth-step", "1"))
    told(Image.fromarray((grey / 100).astype(np.uint8)), "expected a grey PNG of 16 bits, got one of mode L")
    Image.fromarray(grey).save(path)
    path.write_bytes(path.read_bytes()[:200])
    answer = apc("locate-pod", "--scene", made.scene, *AT, "--recorded", path, "-o", out)
    refused(answer, 3, "is no whole PNG")


def test_a_recording_states_intrinsics_and_pose_itself(shifted: Path, tmp_path: Path) -> None:
    seen, path = tmp_path / "seen.json", tmp_path / "pod.json"
    pictures = ("-o", tmp_path / "seen.png", "--depth", tmp_path / "depth.png", "--recording", seen)
    assert apc("render", "--scene", shifted, *AT, *pictures).code == 0
    argv = ("locate-pod", "--cell", "apc2016_delft", "--recorded", seen, "-o", path)
    answer = apc(*argv, "--json")
    assert answer.code == 0, answer.err
    off = json.loads(answer.out)["displacement"]
    np.testing.assert_allclose([off["x"], off["y"]], [0.02, -0.01], atol=2e-4)
    stated = apc(*argv, "--camera", "hand", "--overwrite")
    assert stated.code == 2 and "leave --camera out" in stated.err
    nothing = apc("locate-pod", "--cell", "apc2016_delft", "--camera", "hand", "-o", path, "--overwrite")
    assert nothing.code == 2 and "--recorded" in nothing.err
