"""``apc make-scene`` and ``apc execute``: what they write, print and refuse."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import displaced
from pickcli.commands.execute import command as execute_command
from pickcli.commands.inspect import command as inspect_command
from pickcli.commands.make_scene import command as make_scene_command
from pickcli.commands.options.plan_options import PlanOptions
from pickcli.errors import InputError, RejectedError, TrialAbortedError
from pickcli.geometry import pose
from pickcli.motion.plan import Plan
from pickcli.motion.plan_file import motion_hash, read_plan, write_plan
from pickcli.motion.segment import Segment, SegmentKind
from pickcli.motion.trajectory import Trajectory
from pickcli.scene.scene import HeldItem, PlacedItem, PoseNoise, Scene
from pickcli.scene.scene_file import read_scene, scene_hash, write_scene
from pickcli.simulation.reality import DEFAULT
from pickcli.trial.pose_noise import perceive
from pickcli.verification.verify import certify
from support.command_line import apc, pick, refused
from support.tool_states import STRAIGHT


@pytest.fixture
def order(tmp_path: Path) -> Path:
    bins: dict[str, list[str]] = {f"bin_{letter}": [] for letter in "ABCDEFGHIJKL"}
    contents = {**bins, "bin_C": ["dove_beauty_bar", "crayola_24_ct"]}
    work_order = [{"bin": "bin_C", "item": "dove_beauty_bar"}]
    path = tmp_path / "order.json"
    path.write_text(json.dumps({"bin_contents": contents, "tote_contents": [], "work_order": work_order}))
    return path


def rail_move(cell: Cell, distance: float = 0.1) -> Plan:
    home = cell.configurations["home"].q
    positions = np.array([home, home + distance * (np.arange(8) == 0)])
    still = np.zeros_like(positions)
    trajectory = Trajectory(cell.robot.joint_names, np.array([0.0, 0.8]), positions, still, still)
    segment = Segment(SegmentKind.TRANSIT, 0.0, 0.8, STRAIGHT, None)
    return Plan("move", cell.fingerprint, "", 0, (segment,), trajectory, ())


@pytest.fixture
def files(cell: Cell, tmp_path: Path) -> tuple[Path, Path]:
    """A plan and its scene."""
    plan, scene = tmp_path / "plan.json", tmp_path / "scene.json"
    write_plan(rail_move(cell), plan)
    write_scene(Scene(cell, cell.T_world_pod, (), PoseNoise()), scene)
    return plan, scene


def test_make_scene_writes_a_scene_and_a_picture(order: Path, tmp_path: Path) -> None:
    out, picture = tmp_path / "scene.json", tmp_path / "scene.png"
    arguments = [str(order), "-o", str(out), "--seed", "3", "--picture", str(picture), "--json"]
    result = CliRunner().invoke(make_scene_command, arguments, catch_exceptions=False)
    told = json.loads(result.stdout)
    assert told["picture"] == str(picture) and told["perceived"] is None
    assert sorted(told["bins"]["bin_C"]) == ["crayola_24_ct", "dove_beauty_bar"]
    assert len(read_scene(out).items) == 2
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_make_scene_lets_items_lean_and_tells_which(order: Path, tmp_path: Path) -> None:
    words = [str(order), "-o", str(tmp_path / "scene.json"), "--seed", "3", "--leaning", "1"]
    told = json.loads(CliRunner().invoke(make_scene_command, [*words, "--json"]).stdout)
    assert list(told["leaning"]) == ["crayola_24_ct"] and 3.0 < told["leaning"]["crayola_24_ct"] <= 20.0
    shown = CliRunner().invoke(make_scene_command, [*words, "--overwrite"]).stdout
    assert shown.startswith("2 items at rest in 12 bins, 1 of them leaning, seed 3: ")


def test_make_scene_writes_what_a_trial_sees_too(order: Path, tmp_path: Path) -> None:
    out, seen = tmp_path / "scene.json", tmp_path / "seen.json"
    words = [str(order), "-o", str(out), "--seed", "3", "--perceived", str(seen), "--pose-noise", "4,2"]
    result = CliRunner().invoke(make_scene_command, words, catch_exceptions=False)
    assert result.exit_code == 0 and f"perceived scene: {seen}\n" in result.stdout
    true, believed = read_scene(out), read_scene(seen)
    assert true.noise.position == 0.0 and believed.noise.position == pytest.approx(0.004)
    assert believed.noise.angle == pytest.approx(np.radians(2.0))
    assert scene_hash(believed) == scene_hash(perceive(true, believed.noise, 3, 1, DEFAULT))
    off = [
        np.linalg.norm(a.T_world_item[:3, 3] - b.T_world_item[:3, 3])
        for a, b in zip(true.items, believed.items, strict=True)
    ]
    assert all(d > 1e-5 for d in off) and believed.pod_error != true.pod_error
    same = CliRunner().invoke(make_scene_command, [*words[:6], str(out), "--overwrite"])
    assert isinstance(same.exception, InputError) and "would be written twice" in str(same.exception)


def test_inspect_shows_what_rests_on_what(cell: Cell, tmp_path: Path) -> None:
    T = cell.T_world_place(cell.pod.bins["bin_C"])
    floor, items, z = cell.pod.bins["bin_C"].room.floor_back, [], 0.0005
    for name in ("kleenex_tissue_box", "i_am_a_bunny_book"):
        height = float(cell.item(name).shape.extents[2])
        items.append(
            PlacedItem(name, cell.item(name), "bin_C", T @ pose([0.25, 0.0, floor + z + height / 2]))
        )
        z += height + 0.0005
    path = tmp_path / "scene.json"
    write_scene(Scene(cell, cell.T_world_pod, tuple(items), PoseNoise()), path)
    told = json.loads(CliRunner().invoke(inspect_command, [str(path), "--json"]).stdout)["supports"]
    assert told["i_am_a_bunny_book"]["rests_on"] == ["kleenex_tissue_box"]
    assert told["kleenex_tissue_box"]["carries"] == ["i_am_a_bunny_book"]
    assert told["kleenex_tissue_box"]["without_it_fall"] == ["i_am_a_bunny_book"]
    text = CliRunner().invoke(inspect_command, [str(path)]).stdout
    assert "kleenex_tissue_box: without it fall i_am_a_bunny_book" in text


def test_inspect_shows_the_bounds_of_each_pose(cell: Cell, tmp_path: Path) -> None:
    own, path = PoseNoise(0.001, 0.02, 0.004), tmp_path / "scene.json"
    item, place = cell.item("dove_beauty_bar"), cell.pod.bins["bin_C"]
    up = place.room.floor_back + float(item.shape.extents[2]) / 2
    T = cell.T_world_place(place) @ pose([0.25, 0.0, up])
    placed = PlacedItem("dove_beauty_bar", item, "bin_C", T, own)
    write_scene(Scene(cell, cell.T_world_pod, (placed,), PoseNoise(0.002, 0.01)), path)
    told = json.loads(CliRunner().invoke(inspect_command, [str(path), "--json"]).stdout)
    assert told["noise"] == {"position_m": 0.002, "angle_rad": 0.01}
    bounds = {"position_m": 0.001, "angle_rad": 0.02, "displacement_m": 0.004}
    assert told["noise_of_items"] == {"dove_beauty_bar": bounds}


def test_make_scene_does_not_replace_files_unasked(order: Path, tmp_path: Path) -> None:
    out = tmp_path / "scene.json"
    out.write_text("mine")
    with pytest.raises(InputError, match="--overwrite"):
        CliRunner().invoke(
            make_scene_command, [str(order), "-o", str(out)], catch_exceptions=False, standalone_mode=False
        )
    assert out.read_text() == "mine"


def run_execute(plan: Path, scene: Path, *options: str) -> dict[str, object]:
    arguments = [str(plan), "--scene", str(scene), "--json", *options]
    result = CliRunner().invoke(execute_command, arguments, catch_exceptions=False, standalone_mode=False)
    record = json.loads(result.stdout)
    assert isinstance(record, dict)
    return record


def test_execute_runs_the_plan_and_films_it(files: tuple[Path, Path], tmp_path: Path) -> None:
    film = tmp_path / "film.gif"
    record = run_execute(*files, "--no-verify", "--video", str(film))
    assert record["collisions"] == 0 and record["limit_violations"] == 0 and record["bridge"] is None
    assert film.read_bytes().startswith(b"GIF8")


def test_a_stop_after_the_end_is_told(files: tuple[Path, Path]) -> None:
    plan, scene = files
    words = ("execute", plan, "--scene", scene, "--no-verify", "--operator-stop")
    late, early = apc(*words, "100:101"), apc(*words, "0.2:0.4")
    assert late.code == 0 and "the motion ended before --operator-stop" in late.err
    assert early.code == 0 and "--operator-stop" not in early.err


def test_what_the_verifier_rejects_is_not_executed(files: tuple[Path, Path], cell: Cell) -> None:
    plan = replace(rail_move(cell, distance=0.6), scene_hash=scene_hash(read_scene(files[1])))
    write_plan(plan, files[0])
    with pytest.raises(RejectedError, match="velocity"):
        run_execute(*files)


def test_a_simulation_begins_with_an_empty_cup(files: tuple[Path, Path], cell: Cell) -> None:
    plan, scene = files
    held = HeldItem("bar", cell.item("dove_beauty_bar"), pose((0.0, 0.0, 0.02)))
    write_scene(replace(read_scene(scene), held=held), scene)
    result = CliRunner().invoke(execute_command, [str(plan), "--scene", str(scene)])
    assert isinstance(result.exception, InputError)
    assert f"{scene}: held: bar is in the cup" in str(result.exception)


def test_a_scene_with_a_full_cup_is_shown_and_nothing_is_planned_in_it(
    files: tuple[Path, Path], cell: Cell, tmp_path: Path
) -> None:
    _, scene = files
    held = HeldItem("bar", cell.item("dove_beauty_bar"), pose((0.0, 0.0, 0.02)))
    write_scene(replace(read_scene(scene), held=held), scene)
    told = json.loads(CliRunner().invoke(inspect_command, [str(scene), "--json"]).stdout)["held"]
    assert (told["id"], told["name"], told["position"]) == ("bar", "dove_beauty_bar", [0.0, 0.0, 0.02])
    assert "dove_beauty_bar" in CliRunner().invoke(inspect_command, [str(scene)]).stdout
    out = tmp_path / "out.json"
    why = f"{scene}: held: bar is in the cup"
    refused(apc("plan-move", "--scene", scene, "--from", "home", "--to", "bin_C", "-o", out), 3, why)
    refused(pick(scene, out), 3, why)


def test_a_plan_that_the_speed_limit_makes_too_long_is_refused_with_that_advice(
    cell: Cell, tmp_path: Path
) -> None:
    slow = replace(cell, max_tool_speed=0.01)
    scene = Scene(slow, slow.T_world_pod, (), PoseNoise())
    plan = replace(rail_move(slow), scene_hash=scene_hash(scene))
    long = replace(plan, trajectory=replace(plan.trajectory, times=np.array([0.0, 301.0])))
    options = PlanOptions(
        scene_path=None, cell_name=None, items_path=None, start="home", arm=None, standing=(),
        no_verify=False, roadmap=None, trajectories=None, learn=False, seed=0, as_json=False,
        output=tmp_path / "out.json", overwrite=False,
    )  # fmt: skip
    with pytest.raises(RejectedError, match=r"max_tool_speed of 0\.01 m/s makes it too long; raise that"):
        options.deliver(long, scene)


def test_a_plan_that_was_sealed_again_is_not_executed(files: tuple[Path, Path], cell: Cell) -> None:
    believed = read_scene(files[1])
    honest = certify(replace(rail_move(cell, distance=0.1), scene_hash=scene_hash(believed)), believed)
    forged = replace(rail_move(cell, distance=0.6), scene_hash=scene_hash(believed))
    assert honest.certificate is not None
    seal = replace(honest.certificate, motion_hash=motion_hash(forged))
    write_plan(replace(forged, certificate=seal), files[0])
    assert read_plan(files[0]).certificate == seal  # nothing about the file is wrong
    with pytest.raises(RejectedError, match="velocity"):
        run_execute(*files)


def test_an_unverified_run_says_so(files: tuple[Path, Path]) -> None:
    arguments = [str(files[0]), "--scene", str(files[1]), "--no-verify"]
    assert "was not verified" in CliRunner().invoke(execute_command, arguments).stderr


def test_broken_limits_are_told_and_abort(files: tuple[Path, Path], cell: Cell) -> None:
    write_plan(rail_move(cell, distance=0.6), files[0])
    with pytest.raises(TrialAbortedError, match="limit violations"):
        run_execute(*files, "--no-verify")


def test_a_pod_beyond_its_bounds_is_noted(cell: Cell, tmp_path: Path) -> None:
    inside, beyond, raised = (tmp_path / f"{name}.json" for name in ("inside", "beyond", "raised"))
    write_scene(Scene(cell, displaced(cell.T_world_pod, 0.05, -0.05, 0.052), (), PoseNoise()), inside)
    write_scene(Scene(cell, displaced(cell.T_world_pod, 0.06, 0.0, 0.0), (), PoseNoise()), beyond)
    write_scene(Scene(cell, pose((0.0, 0.0, 0.01)), (), PoseNoise()), raised)
    assert "note" not in CliRunner().invoke(inspect_command, [str(inside)]).stderr
    told = CliRunner().invoke(inspect_command, [str(beyond)])
    assert "the pod stands +60.0 mm in x, +0.0 mm in y, +0.00 degrees off its place" in told.stderr
    assert "the cell allows for 50.0 mm, 50.0 mm and 3.00 degrees" in told.stderr
    assert "+60.0 mm in x" in told.stdout
    assert "raised by 10.0 mm and tilted by 0.00" in CliRunner().invoke(inspect_command, [str(raised)]).stderr
