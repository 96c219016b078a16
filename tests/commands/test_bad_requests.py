"""Requests that cannot be met, files that do not belong together, places that cannot be written to."""

from __future__ import annotations

import json
import os
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from pickcli.cell.cell_file import load_cell
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.commands.options.stated_pick import refuse_impossible
from pickcli.commands.options.trial_options import parse_noise
from pickcli.errors import InputError
from pickcli.planning.pick_problem import PickQuery
from pickcli.scene.scene_file import read_scene
from support.command_line import ITEM, Made, apc, misused, pick, refused

# Queries -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--bin", "bin_Z", "--item", ITEM), "--bin: unknown place 'bin_Z'; known: bin_A, bin_B"),
        (("--bin", "bin_c", "--item", ITEM), "--bin: unknown place 'bin_c'; did you mean 'bin_C'?"),
        (("--bin", "C", "--item", ITEM), "--bin: unknown place 'C'; did you mean 'bin_C'?"),
        (("--bin", "bin_C", "--item", "Dove"), f"did you mean '{ITEM}'"),
        (("--bin", "bin_C", "--item", ITEM, "--into", "Tote"), "unknown place 'Tote'; did you mean 'tote'?"),
        (("--bin", "bin_C", "--item", ITEM, "--into", "d"), "unknown place 'd'; did you mean 'bin_D'?"),
        (("--pick", f"bin_c:{ITEM}"), "--pick: unknown place 'bin_c'; did you mean 'bin_C'?"),
        (("--bin", "bin_C", "--item", ITEM, "--into", "bin_C"), "is in bin_C already; name another place"),
        (("--bin", "bin_C", "--item", "dove_beauty_bra"), f"did you mean '{ITEM}'"),
        (("--bin", "bin_A", "--item", ITEM), "is not in bin_A but in bin_C"),
        (("--bin", "tote", "--item", ITEM), "is not in tote but in bin_C"),
        (("--bin", "bin_A", "--item", "crayola"), "known: none"),
    ],
)
def test_unknown_names(options: tuple[str, ...], told: str, made: Made, out: Path) -> None:
    refused(apc("plan-pick", "--scene", made.scene, "-o", out, *options), 3, told)
    assert not out.exists()


@pytest.mark.parametrize(
    ("q", "told"),
    [
        ("0.2,0,0", "got 3 of 8 numbers; write 8 numbers with commas (rail,joint_s,"),
        ("9,0,0,0,0,0,0,0", "rail is 9 m, its limits are 0.05 to 1.15 m; correct it"),
        ("0.2,nan,0,0,0,0,0,0", "joint_s is nan"),
        ("0.2,0,0,0,0,0,0,inf", "joint_t is inf"),
        ("0.2,0,0,0,0,0,0,x", "'x'"),
        ("0.2,0,0,0,0,0,0,90", "joint_t is 90 rad, its limits are -3.1415 to 3.1415 rad; angles are in rad"),
        ("200,0,0,0,0,0,0,9", "rail is 200 m, its limits are 0.05 to 1.15 m; joint_t is 9 rad"),
        ("200,0,0,0,0,0,0,0", "lengths are in m, not mm"),
        ("hom", "did you mean 'home'"),
        ("", "unknown configuration ''; apc inspect apc2016_delft lists the names; or write 8 numbers"),
        ("nope", "apc inspect apc2016_delft lists the names"),
        ("0.2", "got 1 of 8 numbers"),
        ("0.2 0 0 0 0 0 0 0", "is not a number; write 8 numbers with commas"),
        ("[0.2,0,0,0,0,0,0,0]", "'[0.2' is not a number"),
    ],
)
def test_configurations_that_are_none(q: str, told: str, made: Made, out: Path) -> None:
    refused(pick(made.scene, out, "--from", q), 3, told)
    refused(apc("plan-move", "--scene", made.scene, "--from", "home", "--to", q, "-o", out), 3, told)
    refused(apc("execute", made.plan, "--scene", made.scene, "--from", q), 3, told)
    assert not out.exists()


def test_what_nothing_reaches_has_no_plan(made: Made, tmp_path: Path, out: Path) -> None:
    def put_far(scene: dict[str, Any]) -> None:
        for placed in (scene["T_world_pod"], *scene["items"]):
            placed["position"][0] += 3.0

    scene = made.changed("scene", tmp_path, put_far)
    refused(pick(scene, out), 5, f"no plan for pick {ITEM} from bin_C", "no inverse-kinematics solution")
    assert not out.exists()


def test_a_bin_that_is_too_small_is_refused_at_once(made: Made, out: Path) -> None:
    scene = read_scene(made.scene)
    placed = scene.find(ITEM)
    large = replace(placed, item=replace(placed.item, shape=Shape(ShapeKind.BOX, (0.3, 0.3, 0.3))))
    scene = replace(scene, items=(large,))
    options = {"out_of_option": "--bin", "into_option": "--into"}
    with pytest.raises(InputError, match=r"does not fit into bin_A: it has 300 x 300 x 300 mm, the place"):
        refuse_impossible(scene, PickQuery("bin_C", ITEM, "bin_A"), **options)
    refuse_impossible(scene, PickQuery("bin_C", ITEM, "tote"), **options)


def test_a_goal_in_collision_has_no_plan(made: Made, out: Path) -> None:
    in_the_wall = "tote_10h"  # one of Delft's poses, in our tote
    answer = apc("plan-move", "--scene", made.scene, "--from", "home", "--to", in_the_wall, "-o", out)
    refused(answer, 5, "goal: collision", "mm deep")
    assert not out.exists()


# Plans -------------------------------------------------------------------------------------------------


def test_a_plan_of_another_scene_is_stale(made: Made, tmp_path: Path) -> None:
    scene = made.changed("scene", tmp_path, lambda s: s["items"].pop())
    refused(apc("verify", made.plan, "--scene", scene), 4, made.plan, scene, "plan it again")
    refused(apc("execute", made.plan, "--scene", scene), 4, made.plan, "plan it again", "--planned-in")
    out = tmp_path / "out.csv"
    answer = apc("export", made.plan, "--scene", scene, "--format", "csv", "-o", out)
    refused(answer, 4, f"{scene} is", "plan it again, or name the scene it was made in with --scene")
    answer = apc("execute", made.plan, "--scene", made.scene, "--planned-in", scene)
    refused(answer, 4, f"made in {made.scene}", f"not in {scene}; swap --scene and --planned-in")
    gone = made.changed("scene", tmp_path, lambda s: s.update(items=[]))
    answer = apc("execute", made.plan, "--scene", gone, "--planned-in", made.scene)
    refused(answer, 3, f"{gone}: does not contain {ITEM}, which {made.plan} picks")


def test_a_plan_of_the_cell_alone_names_no_scene(made: Made, tmp_path: Path) -> None:
    move = tmp_path / "move.json"
    words = ("--cell", "apc2016_delft", "--from", "home", "--to", "bin_C", "-o", move)
    assert apc("plan-move", *words).code == 0
    refused(apc("execute", move, "--scene", made.scene), 4, "plan it again, or name only --cell")


def _bend(plan: dict[str, Any]) -> None:
    plan["trajectory"]["points"][5]["positions"][1] += 0.2


def test_an_edited_plan_is_refused(made: Made, tmp_path: Path) -> None:
    plan = made.changed("plan", tmp_path, _bend)
    for argv in (("verify", plan, "--scene", made.scene), ("execute", plan, "--scene", made.scene)):
        refused(apc(*argv), 4, plan, "edited after it was certified")
    refused(apc("inspect", plan), 4, plan, "edited")


def test_an_edited_plan_is_rejected_without_its_certificate_too(made: Made, tmp_path: Path) -> None:
    def edit(plan: dict[str, Any]) -> None:
        _bend(plan)
        plan["certificate"] = None

    plan = made.changed("plan", tmp_path, edit)
    before = plan.read_bytes()
    refused(apc("verify", plan, "--scene", made.scene, "--write"), 4, plan, "rejected", "velocity limit")
    answer = apc("execute", plan, "--scene", made.scene)
    refused(answer, 4, f"{plan}: pick {ITEM} from bin_C: rejected, plan it again", "\n  velocity limit")
    assert max(len(line) for line in answer.err.splitlines()[1:]) < 120
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


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize(("path", "told"), [("", "the path is empty"), ("-", "nor written to stdout")])
def test_outputs_that_are_no_paths(
    name: str, path: str, told: str, made: Made, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    misused(apc(*_writers(made)[name], path), told, "name a file")
    assert not list(tmp_path.iterdir())


def test_pictures_are_written_in_the_format_of_their_name(made: Made, tmp_path: Path, out: Path) -> None:
    picture = tmp_path / "p.txt"
    refused(apc("make-scene", made.order, "-o", out, "--picture", picture), 3, picture, "is written as .png")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("seed", ["-1", "x", "1.5", str(2**31)])
def test_impossible_seeds(seed: str, made: Made, out: Path) -> None:
    for command in ("make-scene", "run-trial"):
        misused(apc(command, made.order, "-o", out, f"--seed={seed}"), "--seed")


@pytest.mark.parametrize("share", ["-0.1", "1.5", "nan", "some"])
def test_impossible_shares_of_leaning_items(share: str, made: Made, out: Path) -> None:
    misused(apc("make-scene", made.order, "-o", out, f"--leaning={share}"), "--leaning")


@pytest.mark.parametrize("noise", ["2", "a,b", "-1,1", "nan,1", "1,1,1", "2,90", ""])
def test_impossible_noise(noise: str, made: Made, out: Path) -> None:
    misused(apc("run-trial", made.order, "-o", out, f"--pose-noise={noise}"), "--pose-noise", "expected")


def test_noise_is_of_what_is_perceived(made: Made, out: Path, tmp_path: Path) -> None:
    words = ("make-scene", made.order, "-o", out)
    misused(apc(*words, "--pose-noise", "5,2"), "--pose-noise applies only to --perceived; add that")
    answer = apc(*words, "--perceived", tmp_path / "seen.json", "--pose-noise", "0.005,0.02")
    assert answer.code == 0 and "0.005 mm and 0.02 degrees are a tiny error; the units are mm" in answer.err


@pytest.mark.parametrize(
    ("noise", "is_told"), [("0.002,1", True), ("2,0.017", True), ("2,1", False), ("0,1", False)]
)
def test_noise_in_m_or_rad_is_told(noise: str, is_told: bool, capsys: pytest.CaptureFixture[str]) -> None:
    parse_noise(None, None, noise)
    assert ("are a tiny error; the units are mm and degrees" in capsys.readouterr().err) == is_told


@pytest.mark.parametrize("command", ["run-trial", "run-trials"])
def test_a_stow_rule_is_for_stows(command: str, out: Path) -> None:
    words = (command, "jsk_pick_sample", "--stow-rule", "size", "-o", out)
    misused(apc(*words), "--stow-rule is for stow orders, this is a pick order")


@pytest.mark.parametrize("command", ["run-trial", "run-trials"])
@pytest.mark.parametrize(
    ("kind", "told"), [("truth", "there are no errors"), ("camera", "pictures have errors of their own")]
)
def test_only_bounded_errors_have_bounds(command: str, kind: str, told: str, out: Path) -> None:
    words = (command, "jsk_pick_sample", "--perception", kind, "--pose-noise", "2,1", "-o", out)
    misused(apc(*words), f"--pose-noise: {told} with --perception {kind}")
    assert not out.exists()


@pytest.mark.parametrize("command", ["run-trial", "run-trials"])
def test_only_cameras_look_for_prints(command: str, out: Path) -> None:
    words = (command, "jsk_pick_sample", "-o", out, "--perception", "noise", "--sift")
    misused(apc(*words, "all-views"), "--sift: prints are looked for by cameras; add --perception camera")
    misused(apc(*words, "some"), "--sift")
    kth = (command, "jsk_pick_sample", "--cell", "apc2016_kth", "-o", out, "--sift", "all-views")
    misused(
        apc(*kth), "--sift: prints are looked for by cameras; those of cell apc2016_kth do not see all its"
    )
    assert not out.exists()


@pytest.mark.parametrize("command", ["run-trial", "run-trials"])
def test_cameras_that_do_not_see_the_bins_are_advised_against(command: str, out: Path) -> None:
    words = (command, "jsk_pick_sample", "--cell", "apc2016_kth", "-o", out, "--perception", "camera")
    refused(apc(*words), 3, "state one (docs/formats/cell.md), or play with --perception noise")
    assert not out.exists()


@pytest.mark.parametrize("shift", ["random", "5,0,0"])
def test_a_pod_that_is_not_there_cannot_be_shifted(shift: str, out: Path) -> None:
    words = ("make-scene", "--cell", "panda_table", "--in", "tray=dove_beauty_bar", "-o", out)
    refused(apc(*words, "--pod-shift", shift), 3, "--pod-shift: the cell panda_table has no pod")
    assert apc(*words, "--pod-shift", "none").code == 0


@pytest.mark.parametrize(
    "argv",
    [("verify",), ("plan-pick",), ("inspect", "a", "b"), ("inspect", "--nosuch", "a"),
     ("build-roadmap", "-o", "x.h5", "--planner", "PRM")],
)  # fmt: skip
def test_wrong_usage(argv: tuple[str, ...]) -> None:
    misused(apc(*argv), "--help")


@pytest.mark.parametrize(
    ("argv", "told"),
    [
        (("plan-pik",), "unknown command 'plan-pik'; did you mean 'plan-pick'?"),
        (("plan_pick", "--help"), "did you mean 'plan-pick'?"),
        (("order",), "did you mean 'make-order' or 'make-pallet-order'?"),
        (("zzz",), "known: believe, build-roadmap"),
        (("plan-pick", "-o", "x.json"), "name a scene with --scene, or items on a conveyor with --stream"),
        (("verify",), "Missing argument 'PLAN'. Example: apc verify plan.json --scene scene.json"),
        (("check",), "Missing argument 'FILE'. Example: apc check trajectories.h5"),
        (("make-scene", "-o", "x.json"), "name an order, e.g. jsk_pick_sample, or items"),
        (("make-order", "-o", "x", "--seed", "1", "--seed", "2"), "--seed is given 2 times; keep one"),
        (("make-order", "-o", "x", "--output", "y"), "-o and --output mean the same; keep one"),
        (("make-order", "-o", "x.json", "--seed", "1.5"), "'1.5' is not a valid whole number"),
    ],
)
def test_usage_is_told_with_what_was_meant(argv: tuple[str, ...], told: str) -> None:
    misused(apc(*argv), told)


def test_a_switch_may_be_said_twice(out: Path) -> None:
    assert apc("make-order", "-o", out, "--json", "--json").code == 0


def test_a_start_that_is_away_is_told_with_its_unit(made: Made) -> None:
    answer = apc("execute", made.move, "--scene", made.scene, "--from", "tote")
    refused(answer, 3, "rad from the plan's first point (at most 0.01 rad)")


def test_what_does_not_fit_names_the_order(tmp_path: Path, out: Path) -> None:
    bins: dict[str, list[str]] = {f"bin_{letter}": [] for letter in "ABCDEFGHIJKL"}
    bins |= {"bin_H": ["kleenex_paper_towels"] * 2, "bin_I": [ITEM]}
    order, work = tmp_path / "order.json", [{"bin": "bin_I", "item": ITEM}]
    order.write_text(json.dumps({"bin_contents": bins, "tote_contents": [], "work_order": work}))
    refused(apc("make-scene", order, "-o", out), 3, f"{order}: bin_H: its 2 items do not fit at rest")


def test_choices_may_be_written_in_any_case(out: Path) -> None:
    assert apc("make-order", "--task", "PICK", "-o", out).code == 0


def test_a_plan_that_is_no_way_back_has_none_that_stopped(made: Made) -> None:
    answer = apc("verify", made.plan, "--scene", made.scene, "--stopped", made.move)
    refused(answer, 3, made.plan, "is no way back after a stop")


def test_films_are_gifs(made: Made, tmp_path: Path) -> None:
    film = tmp_path / "film.mp4"
    refused(apc("execute", made.plan, "--scene", made.scene, "--video", film), 3, film, ".gif")


@pytest.mark.parametrize("name", [name for name in WRITERS if name != "run-trial"])
def test_outputs_that_are_no_regular_files_are_refused(name: str, made: Made, tmp_path: Path) -> None:
    pipe, link = tmp_path / "pipe.gif", tmp_path / "link.gif"
    os.mkfifo(pipe)
    link.symlink_to(pipe)
    for path in (pipe, link):
        refused(apc(*_writers(made)[name], path, "--overwrite"), 3, path, "is a pipe, not a regular file")
    assert pipe.is_fifo() and link.is_symlink()


@pytest.mark.parametrize("name", [name for name in WRITERS if name != "run-trial"])
def test_outputs_with_names_that_are_too_long_are_refused(name: str, made: Made, tmp_path: Path) -> None:
    refused(apc(*_writers(made)[name], tmp_path / ("x" * 300 + ".gif")), 3, "name too long")


def test_no_input_is_replaced(made: Made, tmp_path: Path) -> None:
    copies = {name: made.changed(name, tmp_path, lambda data: None) for name in ("order", "scene", "plan")}
    cell = tmp_path / "cell"
    shutil.copytree(load_cell("apc2016_delft").path, cell)
    film = tmp_path / "film.gif"
    film.symlink_to(copies["scene"])
    move = ("plan-move", "--from", "home", "--to", "bin_C", "--scene")
    calls: list[tuple[tuple[object, ...], Path]] = [
        (("make-scene", copies["order"], "-o"), copies["order"]),
        (("make-scene", copies["order"], "-o", tmp_path / "new.json", "--picture"), copies["order"]),
        (("make-scene", copies["order"], "--cell", cell, "-o"), cell / "cell.yaml"),
        ((*move, copies["scene"], "-o"), copies["scene"]),
        (("plan-pick", "--bin", "bin_C", "--item", ITEM, "--scene", copies["scene"], "-o"), copies["scene"]),
        (("execute", copies["plan"], "--scene", copies["scene"], "--video"), film),
        (("build-roadmap", "--cell", cell, "-o"), cell / "cell.yaml"),
        (("suggest-configurations", "--cell", cell, "--bin", "bin_C", "-o"), cell / "robot.urdf"),
    ]
    for argv, path in calls:
        before = path.read_bytes()
        refused(apc(*argv, path, "--overwrite"), 3, path, "is an input of this command")
        assert path.read_bytes() == before


def test_a_move_says_in_which_state_the_tool_is(made: Made, tmp_path: Path) -> None:
    move = ("plan-move", "--scene", made.scene, "--from", "home", "-o", tmp_path / "move.json")
    told = apc(*move, "--to", "tote_02v")  # a node of no roadmap: not free in every state of the tool
    assert told.code == 0 and "\n  tool straight\n" in told.out
    refused(apc(*move, "--overwrite", "--to", "tote_10h"), 5, "with the tool straight: goal: collision")


@pytest.mark.parametrize(("text", "is_told"), [("0.3,0.1,0.05", True), ("0,0,0", False), ("300,0,4", False)])
def test_a_place_in_metres_is_told(text: str, is_told: bool, capsys: pytest.CaptureFixture[str]) -> None:
    from pickcli.commands.plan_pick import _stated

    _stated(text)
    assert ("it is in mm" in capsys.readouterr().err) == is_told
