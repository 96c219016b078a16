"""Whatever is wrong from outside: one message that names it, the right exit code, nothing half-written."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import ITEM, Answer, Made, apc

from pickcli.cell.load import load_cell
from pickcli.roadmap.graph import Roadmap
from pickcli.roadmap.store import write_roadmap

TASKS = Path(__file__).parents[2] / "data" / "tasks"
INVALID = sorted((Path(__file__).parents[1] / "trial" / "invalid_orders").glob("*.json"))
NOTHING = {
    "missing": lambda path: None,
    "a folder": lambda path: path.mkdir(),
    "empty": lambda path: path.write_bytes(b""),
    "garbage": lambda path: path.write_bytes(bytes(range(256)) * 40),
}


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """Where a command is told to write."""
    return tmp_path / "out.json"


def refused(answer: Answer, code: int, *told: str | Path) -> None:
    """One message on stderr that contains all of ``told``, nothing on stdout, and this exit code."""
    assert answer.code == code, answer.err
    assert answer.out == ""
    assert answer.err.count("error:") == 1 and "Traceback" not in answer.err
    assert [str(text) for text in told if str(text) not in answer.err] == [], answer.err


def misused(answer: Answer, *told: str) -> None:
    """Exit code 2 with click's message."""
    assert answer.code == 2 and answer.out == ""
    assert answer.err.count("Error:") == 1 and [text for text in told if text not in answer.err] == []


def pick(scene: Path, out: Path, *more: object) -> Answer:
    return apc("plan-pick", "--scene", scene, "--bin", "bin_C", "--item", ITEM, "-o", out, *more)


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
        (lambda o: o.pop("bin_contents"), "'bin_contents' is missing"),
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


def test_a_stow_order_cannot_be_played(out: Path) -> None:
    path = TASKS / "jsk_stow_sample.json"
    refused(apc("run-trial", path, "-o", out), 3, path, "stow", "pick orders")


# Files -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", NOTHING)
def test_files_that_are_none(kind: str, made: Made, tmp_path: Path, out: Path) -> None:
    bad = tmp_path / "bad"
    NOTHING[kind](bad)
    move = ("plan-move", "--scene", made.scene, "--from", "home", "--to", "bin_C", "-o", out)
    damaged = 4 if bad.is_file() else 3
    for argv, code in (
        (("make-scene", bad, "-o", out), 3),
        (("make-scene", made.order, "--cell", bad, "-o", out), 3),
        (("run-trial", bad, "-o", out), 3),
        (("plan-pick", "--scene", bad, "--bin", "bin_C", "--item", ITEM, "-o", out), 3),
        (("verify", made.plan, "--scene", bad), 3),
        (("verify", bad, "--scene", made.scene), 4 if kind == "empty" else 3),
        (("execute", made.plan, "--scene", bad), 3),
        (("execute", bad, "--scene", made.scene), 4 if kind == "empty" else 3),
        (("inspect", bad), 3),
        ((*move, "--roadmap", bad), damaged),
        ((*move, "--trajectories", bad), damaged),
        (("run-trial", made.order, "--roadmap", bad, "-o", out), damaged),
    ):
        refused(apc(*argv), code, bad)
        assert not out.exists()


def test_files_that_are_cut_off(made: Made, tmp_path: Path, out: Path) -> None:
    cut = tmp_path / "cut.json"
    cut.write_bytes(made.plan.read_bytes()[:3000])
    refused(apc("verify", cut, "--scene", made.scene), 4, f"{cut}:", "cut off", "plan it anew")
    refused(apc("inspect", cut), 4, f"{cut}:")
    cut.write_bytes(made.scene.read_bytes()[:300])
    refused(pick(cut, out), 3, f"{cut}:", "cut off")
    refused(apc("inspect", cut), 3, f"{cut}:")
    cut.write_bytes(made.order.read_bytes()[:100])
    refused(apc("make-scene", cut, "-o", out), 3, f"{cut}:", "truncated")
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
        refused(apc(*argv), 3, f"{folder}/cell.yaml:", "max_acceleration", "add it")
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


# Queries -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--bin", "bin_Z", "--item", ITEM), "unknown bin 'bin_Z'"),
        (("--bin", "bin_C", "--item", "dove_beauty_bra"), f"did you mean '{ITEM}'"),
        (("--bin", "bin_A", "--item", ITEM), "it is in bin_C"),
        (("--bin", "bin_A", "--item", "crayola"), "known: none"),
    ],
)
def test_unknown_names(options: tuple[str, ...], told: str, made: Made, out: Path) -> None:
    refused(apc("plan-pick", "--scene", made.scene, "-o", out, *options), 3, told)
    assert not out.exists()


@pytest.mark.parametrize(
    ("q", "told"),
    [
        ("0.2,0,0", "expected 8 numbers (rail joint_s"),
        ("9,0,0,0,0,0,0,0", "rail is 9, expected 0.05 to"),
        ("0.2,nan,0,0,0,0,0,0", "joint_s is nan"),
        ("0.2,0,0,0,0,0,0,inf", "joint_t is inf"),
        ("0.2,0,0,0,0,0,0,x", "'x'"),
        ("hom", "did you mean 'home'"),
        ("", "unknown configuration"),
    ],
)
def test_configurations_that_are_none(q: str, told: str, made: Made, out: Path) -> None:
    refused(pick(made.scene, out, "--from", q), 3, told)
    refused(apc("plan-move", "--scene", made.scene, "--from", "home", "--to", q, "-o", out), 3, told)
    refused(apc("execute", made.plan, "--scene", made.scene, "--start", q), 3, told)
    assert not out.exists()


def test_what_nothing_reaches_has_no_plan(made: Made, tmp_path: Path, out: Path) -> None:
    def put_far(scene: dict[str, Any]) -> None:
        for placed in (scene["T_world_pod"], *scene["items"]):
            placed["position"][0] += 3.0

    scene = made.changed("scene", tmp_path, put_far)
    refused(pick(scene, out), 5, f"no plan for pick {ITEM} from bin_C", "no inverse-kinematics solution")
    assert not out.exists()


def test_a_goal_in_collision_has_no_plan(made: Made, out: Path) -> None:
    in_the_wall = "tote_10h"  # one of Delft's poses, in our tote
    answer = apc("plan-move", "--scene", made.scene, "--from", "home", "--to", in_the_wall, "-o", out)
    refused(answer, 5, "goal: collision", "mm deep")
    assert not out.exists()


# Plans -------------------------------------------------------------------------------------------------


def test_a_plan_of_another_scene_is_stale(made: Made, tmp_path: Path) -> None:
    scene = made.changed("scene", tmp_path, lambda s: s["items"].pop())
    refused(apc("verify", made.plan, "--scene", scene), 4, made.plan, scene, "plan it anew")
    refused(apc("execute", made.plan, "--scene", scene), 4, made.plan, "plan it anew", "--planned-in")


def _bend(plan: dict[str, Any]) -> None:
    plan["trajectory"]["points"][5]["positions"][1] += 0.2


def test_an_edited_plan_is_refused(made: Made, tmp_path: Path) -> None:
    plan = made.changed("plan", tmp_path, _bend)
    for argv in (("verify", plan, "--scene", made.scene), ("execute", plan, "--scene", made.scene)):
        refused(apc(*argv), 4, plan, "edited after it was certified")
    refused(apc("inspect", plan), 4, plan, "edited")


def test_an_edited_plan_is_rejected_without_its_certificate_too(made: Made, tmp_path: Path) -> None:
    plan = made.changed("plan", tmp_path, lambda p: (_bend(p), p.update(certificate=None)))
    before = plan.read_bytes()
    refused(apc("verify", plan, "--scene", made.scene, "--write"), 4, plan, "rejected", "velocity limit")
    refused(apc("execute", plan, "--scene", made.scene), 4, "rejected", "velocity limit")
    assert plan.read_bytes() == before


# Outputs and options -----------------------------------------------------------------------------------


def _writers(made: Made) -> dict[str, tuple[object, ...]]:
    return {
        "make-scene": ("make-scene", made.order, "-o"),
        "make-scene picture": ("make-scene", made.order, "-o", made.order.parent / "new.json", "--picture"),
        "plan-pick": ("plan-pick", "--scene", made.scene, "--bin", "bin_C", "--item", ITEM, "-o"),
        "plan-move": ("plan-move", "--scene", made.scene, "--from", "home", "--to", "bin_C", "-o"),
        "build-roadmap": ("build-roadmap", "-o"),
        "build-trajectories": ("build-trajectories", "-o"),
        "execute": ("execute", made.plan, "--scene", made.scene, "--video"),
        "run-trial": ("run-trial", made.order, "-o"),
    }


WRITERS = (
    "make-scene", "make-scene picture", "plan-pick", "plan-move", "build-roadmap", "build-trajectories",
    "execute", "run-trial",
)  # fmt: skip


@pytest.mark.parametrize("name", WRITERS)
def test_places_that_cannot_be_written(name: str, made: Made, tmp_path: Path) -> None:
    argv = _writers(made)[name]
    taken = tmp_path / "taken.gif"
    taken.write_bytes(b"mine")
    in_a_file = taken / "out.gif"
    refused(apc(*argv, taken), 3, taken)
    refused(apc(*argv, in_a_file), 3, in_a_file)
    assert taken.read_bytes() == b"mine"
    refused(apc(*argv, "/proc/none/out.gif" if name == "run-trial" else "/proc/out.gif"), 3, "/proc")
    if name != "run-trial":
        refused(apc(*argv, taken), 3, "--overwrite")
        refused(apc(*argv, tmp_path, "--overwrite"), 3, tmp_path, "is a folder")
        refused(apc(*argv, tmp_path / "none" / "out.gif"), 3, "does not exist")
    assert [path.name for path in tmp_path.iterdir()] == ["taken.gif"]


def test_a_used_folder_is_not_written_to(made: Made, tmp_path: Path) -> None:
    (tmp_path / "trial.json").write_text("mine")
    refused(apc("run-trial", made.order, "-o", tmp_path), 3, tmp_path, "--overwrite")
    assert (tmp_path / "trial.json").read_text() == "mine"


def test_overwrite_replaces(made: Made, out: Path) -> None:
    out.write_text("old")
    move = ("plan-move", "--scene", made.scene, "--from", "home", "--to", "cam_A", "-o", out)
    assert apc(*move, "--overwrite").code == 0
    assert json.loads(out.read_text())["format"] == "apc plan"


@pytest.mark.parametrize("seed", ["-1", "x", "1.5", str(2**31)])
def test_impossible_seeds(seed: str, made: Made, out: Path) -> None:
    for command in ("make-scene", "run-trial"):
        misused(apc(command, made.order, "-o", out, f"--seed={seed}"), "--seed")


@pytest.mark.parametrize("noise", ["2", "a,b", "-1,1", "nan,1", "1,1,1", "2,90", ""])
def test_impossible_noise(noise: str, made: Made, out: Path) -> None:
    misused(apc("run-trial", made.order, "-o", out, f"--pose-noise={noise}"), "--pose-noise", "expected")


@pytest.mark.parametrize(
    "argv",
    [("nosuch",), ("verify",), ("plan-pick",), ("inspect", "a", "b"), ("inspect", "--nosuch", "a"),
     ("build-roadmap", "-o", "x.h5", "--planner", "PRM")],
)  # fmt: skip
def test_wrong_usage(argv: tuple[str, ...]) -> None:
    misused(apc(*argv), "--help")


def test_films_are_gifs(made: Made, tmp_path: Path) -> None:
    film = tmp_path / "film.mp4"
    refused(apc("execute", made.plan, "--scene", made.scene, "--video", film), 3, film, ".gif")
