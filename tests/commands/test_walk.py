"""From an order to an item in the tote, command by command."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

from pickcli.cell.cell_file import load_cell
from pickcli.motion.plan_file import read_plan
from support.command_line import ITEM, Made, apc


def test_a_plan_is_certified_unless_unwanted(made: Made, tmp_path: Path) -> None:
    out = tmp_path / "plan.json"
    assert read_plan(made.plan).certificate is not None
    assert read_plan(made.move).certificate is not None
    argv = ("plan-pick", "--scene", made.scene, "--bin", "bin_C", "--item", ITEM, "-o", out, "--no-verify")
    answer = apc(*argv, "--json")
    told = json.loads(answer.out)
    assert answer.code == 0 and not told["certified"] and told["min_clearance_m"] is None
    assert read_plan(out).certificate is None
    assert [segment["kind"] for segment in told["segments"]][-1] == "depart"


def test_the_same_seed_gives_the_same_motion(made: Made, tmp_path: Path) -> None:
    out = tmp_path / "plan.json"
    assert apc("plan-pick", "--scene", made.scene, "--bin", "bin_C", "--item", ITEM, "-o", out).code == 0
    first, second = (json.loads(path.read_text()) for path in (made.plan, out))
    del first["statistics"], second["statistics"]
    assert first == second


def test_the_item_ends_in_the_tote(made: Made) -> None:
    answer = apc("execute", made.plan, "--scene", made.scene, "--json")
    told = json.loads(answer.out)
    assert answer.code == 0 and told["in_tote"] and told["item"] == ITEM
    assert told["execution"]["sensor_reads_held"] and told["bridge"] is None
    assert {event["device"] for event in told["execution"]["events"]} >= {"pump", "valve", "vacuum_sensor"}
    assert all(event["distance_m"] < 2e-3 for event in told["execution"]["events"])


def test_it_starts_elsewhere_only_over_a_bridge(made: Made) -> None:
    argv = ("execute", made.plan, "--scene", made.scene, "--from", "cam_A")
    refusal = apc(*argv)
    assert refusal.code == 3 and refusal.out == ""
    assert "from the plan's first point" in refusal.err and "--bridge" in refusal.err
    answer = apc(*argv, "--bridge", "--json")
    told = json.loads(answer.out)
    assert answer.code == 0, answer.err
    assert told["in_tote"] and told["bridge"]["simulated_s"] > 0.5
    assert told["collisions"] == 0 and told["limit_violations"] == 0


def test_no_bridge_is_planned_where_none_is_needed(made: Made) -> None:
    home = load_cell("apc2016_delft").configurations["home"].q.copy()
    home[1] += 0.009
    q = ",".join(map(str, home))
    argv = ("execute", made.move, "--scene", made.scene, "--from", q, "--bridge", "--json")
    answer = apc(*argv)
    assert answer.code == 0, answer.err
    assert json.loads(answer.out)["bridge"] is None


def test_an_uncertified_plan_is_verified_first(made: Made, tmp_path: Path) -> None:
    plan = made.changed("move", tmp_path, lambda p: p.update(certificate=None))
    answer = apc("execute", plan, "--scene", made.scene)
    assert answer.code == 0
    assert f"{plan} has no certificate; it was verified now and accepted" in answer.err


def test_the_truth_may_differ_from_what_was_planned_in(made: Made, tmp_path: Path) -> None:
    def shift(scene: dict[str, list[dict[str, list[float]]]]) -> None:
        scene["items"][0]["position"][1] -= 0.001

    truth = made.changed("scene", tmp_path, shift)
    answer = apc("execute", made.plan, "--scene", truth, "--planned-in", made.scene, "--json")
    assert answer.code == 0, answer.err
    assert json.loads(answer.out)["in_tote"]


def test_what_is_not_there_is_missed_and_no_error(made: Made, tmp_path: Path) -> None:
    def swap_away(scene: dict[str, list[dict[str, list[float]]]]) -> None:
        scene["items"][0]["position"][0] += 0.15

    truth = made.changed("scene", tmp_path, swap_away)
    answer = apc("execute", made.plan, "--scene", truth, "--planned-in", made.scene, "--json")
    told = json.loads(answer.out)
    assert not told["in_tote"] and told["item_is_in"] == "bin_C"
    assert told["execution"]["sensor_reads_held"] is False
    assert answer.code == (6 if told["collisions"] else 0)


def test_a_scene_of_a_cell_elsewhere(made: Made, tmp_path: Path) -> None:
    folder, scene, out = tmp_path / "cell", tmp_path / "scene.json", tmp_path / "move.json"
    shutil.copytree(load_cell("apc2016_delft").path, folder)
    text = (folder / "cell.yaml").read_text()
    (folder / "cell.yaml").write_text(text.replace("speed_scale: 1.0", "speed_scale: 0.5"))
    assert apc("make-scene", made.order, "--cell", folder, "-o", scene).code == 0
    move = ("plan-move", "--scene", scene, "--from", "home", "--to", "bin_C", "-o", out)
    assert apc(*move).code == 4  # the cell of that name under data/cells is another one
    assert apc(*move, "--cell", folder).code == 0
    assert apc("execute", out, "--scene", scene, "--cell", folder).code == 0
    slow, full = (read_plan(path).trajectory.duration for path in (out, made.move))
    assert slow > 1.3 * full  # jerk limits stay as they are


def test_inspect_says_where_the_arm_of_a_cell_cannot_stand(tmp_path: Path) -> None:
    """Else it is told late, by whatever is planned from there."""
    told = json.loads(apc("inspect", "apc2016_delft", "--json").out)["not_free"]
    assert set(told) == {"tote_10h", "tote_11h", "tote_12h"}  # Delft's, whose tool was another
    folder = tmp_path / "cell"
    shutil.copytree(load_cell("apc2016_delft").path, folder)
    text = (folder / "cell.yaml").read_text()
    home = "name: home, kind: home, tool_state: straight, q: [0.1580, 0.0000, "
    assert f"{home}-0.3000" in text
    (folder / "cell.yaml").write_text(text.replace(f"{home}-0.3000", f"{home}1.5000"))
    assert "not_free: home: tool straight: collision: " in apc("inspect", folder).out


def test_inspect_lists_the_items_by_bin(made: Made) -> None:
    told = json.loads(apc("inspect", made.scene, "--json").out)
    assert set(told["items"]["bin_C"]) == {ITEM, "crayola_24_ct"}
    assert f"bin_C: {ITEM}" in apc("inspect", made.scene).out


def test_without_artifacts_a_note_says_so(made: Made, tmp_path: Path) -> None:
    answer = apc("plan-move", "--scene", made.scene, "--from", "home", "--to", "bin_A",
                 "-o", tmp_path / "move.json")  # fmt: skip
    assert answer.code == 0 and answer.err.startswith("note: neither roadmap nor trajectory database")
