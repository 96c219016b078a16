"""Files from outside that are wrong: one message that names it, the right exit code, nothing half-written."""

from __future__ import annotations

import builtins
import io
import json
import os
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.store import write_roadmap
from support.command_line import ITEM, Made, apc, pick, refused

TASKS = Path(__file__).parents[2] / "data" / "tasks"
INVALID = sorted((Path(__file__).parents[1] / "trial" / "invalid_orders").glob("*.json"))
NOTHING: dict[str, Callable[[Path], object]] = {
    "missing": lambda path: None,
    "a folder": lambda path: path.mkdir(),
    "empty": lambda path: path.write_bytes(b""),
    "garbage": lambda path: path.write_bytes(bytes(range(256)) * 40),
}


# Orders ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("path", INVALID, ids=lambda path: path.stem)
def test_orders_that_are_not_json(path: Path, out: Path) -> None:
    refused(apc("make-scene", path, "-o", out), 3, f"{path}:", "not JSON")
    refused(apc("run-trial", path, "-o", out), 3, f"{path}:", "not JSON")
    assert not out.exists()


def _order(order: dict[str, Any], bin_name: str, item: str) -> None:
    order["work_order"].append({"bin": bin_name, "item": item})


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda o: o["bin_contents"]["bin_A"].append("dove_beauty_bra"), f"did you mean '{ITEM}'"),
        (lambda o: _order(o, "bin_Z", ITEM), "unknown bin 'bin_Z'"),
        (lambda o: o["bin_contents"].pop("bin_B"), "'bin_B' is missing; add it"),
        (lambda o: o.pop("bin_contents"), "bin_contents: expected an object"),
        (lambda o: o.update(work_orders=[]), "did you mean"),
        (lambda o: _order(o, "bin_A", ITEM), "it is in bin_C"),
        (lambda o: _order(o, "bin_C", ITEM), "ordered 2 times"),
        (lambda o: o["work_order"].append("all"), "expected an object"),
    ],
)
@pytest.mark.parametrize("command", ["make-scene", "run-trial"])
def test_orders_that_make_no_sense(
    command: str, change: Callable[[Any], None], told: str, made: Made, tmp_path: Path, out: Path
) -> None:
    path = made.changed("order", tmp_path, change)
    refused(apc(command, path, "-o", out), 3, f"{path}:1:", told)
    assert not out.exists()


def test_only_a_stow_order_is_explained() -> None:
    path = TASKS / "jsk_pick_sample.json"
    refused(apc("explain-stow", path), 3, path, "this is a pick order; name a stow order")


def test_an_order_without_anything_to_stow_is_told_so(tmp_path: Path) -> None:
    path = tmp_path / "empty.json"
    bins = {f"bin_{letter}": list[str]() for letter in "ABCDEFGHIJKL"}
    path.write_text(json.dumps({"bin_contents": bins, "tote_contents": []}))
    refused(apc("explain-stow", path), 3, f"{path}: nothing is in tote_contents; name a stow order")


# Files -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", NOTHING)
def test_files_that_are_none(kind: str, made: Made, tmp_path: Path, out: Path) -> None:
    bad = tmp_path / "bad"
    NOTHING[kind](bad)
    move = ("plan-move", "--scene", made.scene, "--from", "home", "--to", "bin_C", "-o", out)
    for argv in (
        ("make-scene", bad, "-o", out),
        ("make-scene", made.order, "--cell", bad, "-o", out),
        ("run-trial", bad, "-o", out),
        ("plan-pick", "--scene", bad, "--bin", "bin_C", "--item", ITEM, "-o", out),
        ("verify", made.plan, "--scene", bad),
        ("verify", bad, "--scene", made.scene),
        ("execute", made.plan, "--scene", bad),
        ("execute", bad, "--scene", made.scene),
        ("inspect", bad),
        (*move, "--roadmap", bad),
        (*move, "--trajectories", bad),
        ("run-trial", made.order, "--roadmap", bad, "-o", out),
    ):
        refused(apc(*argv), 3, bad)
        assert not out.exists()


def test_files_that_are_cut_off(made: Made, tmp_path: Path, out: Path) -> None:
    cut = tmp_path / "cut.json"
    cut.write_bytes(made.plan.read_bytes()[:3000])
    refused(apc("verify", cut, "--scene", made.scene), 3, f"{cut}:", "cut off")
    refused(apc("inspect", cut), 3, f"{cut}:", "cut off")
    cut.write_bytes(made.scene.read_bytes()[:300])
    refused(pick(cut, out), 3, f"{cut}:", "cut off")
    refused(apc("inspect", cut), 3, f"{cut}:")
    both = "is a scene, cut off at its end, but a plan is expected here"
    refused(apc("verify", cut, "--scene", made.scene), 3, f"{cut}: {both}")
    refused(apc("verify", made.scene, "--scene", made.scene), 3, f"{made.scene}: is a scene, but a plan is")
    cut.write_bytes(made.order.read_bytes()[:100])
    refused(apc("make-scene", cut, "-o", out), 3, f"{cut}:", "cut off")
    assert not out.exists()


# Roadmaps and databases --------------------------------------------------------------------------------


def _roadmap(path: Path, fingerprint: str) -> Path:
    cell = load_cell("apc2016_delft")
    home = cell.configurations["home"].q
    roadmap = Roadmap.empty(cell.robot.joint_names)
    assert len(home) == len(roadmap.joint_names)
    write_roadmap(path, roadmap, fingerprint, {"by": {}, "settings": {}, "result": {}})
    return path


def _flipped(content: bytes) -> bytes:
    changed = np.frombuffer(content, dtype=np.uint8).copy()
    changed[len(changed) // 4 :: 97] ^= 0xFF
    return changed.tobytes()


def test_a_roadmap_of_another_cell_is_stale(made: Made, tmp_path: Path, out: Path) -> None:
    path = _roadmap(tmp_path / "roadmap.h5", "0" * 64)
    other, mine = "0" * 16, load_cell("apc2016_delft").fingerprint[:16]
    refused(pick(made.scene, out, "--roadmap", path), 4, path, other, mine, "build")
    refused(apc("run-trial", made.order, "--roadmap", path, "-o", out), 4, path, other, mine)
    assert not out.exists()


@pytest.mark.parametrize("damage", [lambda c: c[: len(c) // 2], _flipped], ids=["truncated", "flipped"])
def test_a_damaged_roadmap_is_refused(
    damage: Callable[[bytes], bytes], made: Made, tmp_path: Path, out: Path
) -> None:
    path = _roadmap(tmp_path / "roadmap.h5", load_cell("apc2016_delft").fingerprint)
    path.write_bytes(damage(path.read_bytes()))
    refused(pick(made.scene, out, "--roadmap", path), 4, path, "damaged", "build it again")
    refused(apc("inspect", path), 4, path, "damaged")
    assert not out.exists()


def test_a_roadmap_is_no_database(made: Made, tmp_path: Path, out: Path) -> None:
    path = _roadmap(tmp_path / "roadmap.h5", load_cell("apc2016_delft").fingerprint)
    refused(
        pick(made.scene, out, "--trajectories", path),
        3,
        path,
        "expected a trajectory database, found roadmap",
    )


# Cells and scenes --------------------------------------------------------------------------------------


def test_a_cell_without_an_acceleration_limit(made: Made, tmp_path: Path, out: Path) -> None:
    folder = tmp_path / "cell"
    shutil.copytree(load_cell("apc2016_delft").path, folder)
    text = (folder / "cell.yaml").read_text()
    (folder / "cell.yaml").write_text(re.sub(r"max_acceleration: [^,}\n]+,? ?", "", text, count=1))
    for argv in (
        ("make-scene", made.order, "--cell", folder, "-o", out),
        ("build-roadmap", "--cell", folder, "-o", out),
        ("run-trial", made.order, "--cell", folder, "-o", out),
        ("inspect", folder),
    ):
        refused(apc(*argv), 3, f"{folder}/cell.yaml:", "max_acceleration", "state what")
    assert not out.exists()


def test_an_unknown_cell(made: Made, out: Path) -> None:
    for argv in (("make-scene", made.order), ("run-trial", made.order), ("build-trajectories",)):
        refused(apc(*argv, "--cell", "apc2016_delf", "-o", out), 3, "did you mean 'apc2016_delft'")


def test_overlapping_items(made: Made, tmp_path: Path, out: Path) -> None:
    def put_together(scene: dict[str, Any]) -> None:
        scene["items"][1]["position"] = scene["items"][0]["position"]

    scene = made.changed("scene", tmp_path, put_together)
    refused(pick(scene, out), 3, f"{scene}:1:", "overlap by", "correct one of the poses")


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda s: s["items"][0].update(name="dove"), "unknown item 'dove'"),
        (lambda s: s["items"][0].update(location="bin_Z"), "bin_Z"),
        (lambda s: s["items"][0].pop("position"), "position"),
        (lambda s: s["items"][0].update(quaternion=[0, 0, 0, 0.5]), "expected a length of 1"),
        (lambda s: s.pop("cell"), "cell"),
        (lambda s: s.update(version=99), "version"),
    ],
)
def test_scenes_with_mistakes(
    change: Callable[[Any], None], told: str, made: Made, tmp_path: Path, out: Path
) -> None:
    scene = made.changed("scene", tmp_path, change)
    refused(pick(scene, out), 3, f"{scene}:", told)
    refused(apc("inspect", scene), 3, f"{scene}:", told)


def test_a_scene_of_another_cell_is_stale(made: Made, tmp_path: Path, out: Path) -> None:
    scene = made.changed("scene", tmp_path, lambda s: s["cell"].update(fingerprint="0" * 64))
    refused(pick(scene, out), 4, scene, "0" * 64, load_cell("apc2016_delft").fingerprint)


def test_files_that_may_not_be_read_are_bad_input(
    made: Made, tmp_path: Path, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As files that are missing, and not wrong usage, whoever runs the tests."""
    path, is_allowed, opened = tmp_path / "secret.json", os.access, io.open
    path.write_text("{}")

    def access(name: object, mode: int, **options: Any) -> bool:
        return str(name) != str(path) and is_allowed(str(name), mode, **options)

    def refuse(name: object, *arguments: Any, **options: Any) -> Any:
        if str(name) == str(path):
            raise PermissionError(13, "Permission denied", str(path))
        return opened(name, *arguments, **options)  # type: ignore[call-overload]

    monkeypatch.setattr(os, "access", access)
    monkeypatch.setattr(io, "open", refuse)
    monkeypatch.setattr(builtins, "open", refuse)
    for argv in (
        ("make-scene", path, "-o", out), ("check", path), ("inspect", path),
        ("plan-move", "--scene", path, "--from", "home", "--to", "bin_C", "-o", out),
    ):  # fmt: skip
        refused(apc(*argv), 3, f"{path}: cannot be read")
    assert not out.exists()


def test_pipes_are_not_waited_for(made: Made, tmp_path: Path, out: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    move = ("plan-move", "--from", "home", "--to", "bin_C", "-o", out, "--scene")
    for argv in (
        ("inspect", pipe),
        ("verify", pipe, "--scene", made.scene),
        ("verify", made.plan, "--scene", pipe),
        ("execute", pipe, "--scene", made.scene),
        ("make-scene", pipe, "-o", out),
        (*move, pipe),
        (*move, made.scene, "--roadmap", pipe),
        ("check", pipe),
        ("refresh", pipe),
    ):
        refused(apc(*argv), 3, pipe, "is a pipe, not a regular file")
