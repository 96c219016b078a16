"""``apc plan-stow``: into each row of bins, verified; and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from pickcli.cell.cell import Cell
from pickcli.motion.plan_file import read_plan
from pickcli.scene.scene_file import write_scene
from support.command_line import apc, refused
from support.heaps import BOOK, BOX, bridge

BAR, BRUSH = "dove_beauty_bar", "dr_browns_bottle_brush"


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A bar and a card box in the tote, a bar in bin_A."""
    path = tmp_path_factory.mktemp("stow") / "scene.json"
    contents = (
        "--in",
        f"tote={BAR},staples_index_cards",
        "--in",
        f"bin_A={BAR}",
        "--in",
        "bin_B=crayola_24_ct",
    )
    assert apc("make-scene", *contents, "--seed", "2", "-o", path).code == 0
    return path


@pytest.mark.slow
@pytest.mark.parametrize("into", ["bin_C", "bin_E", "bin_G", "bin_L"])
def test_one_bin_of_each_row_takes_it_and_the_verifier_agrees(scene: Path, into: str, tmp_path: Path) -> None:
    out = tmp_path / "plan.json"
    answer = apc("plan-stow", "--scene", scene, "--item", f"{BAR}#2", "--into", into, "-o", out)
    assert answer.code == 0, answer.err
    plan = read_plan(out)
    assert plan.certificate is not None and plan.query == f"pick {BAR}#2 from tote into {into}"
    again = tmp_path / "again.json"
    apc("plan-stow", "--scene", scene, "--item", f"{BAR}#2", "--into", into, "-o", again)
    first, second = (json.loads(path.read_text()) for path in (out, again))
    assert {k: v for k, v in first.items() if k != "statistics"} == {
        k: v for k, v in second.items() if k != "statistics"
    }


@pytest.mark.parametrize(
    ("item", "more", "told"),
    [
        ("dove_beauty_bra", (), f"did you mean '{BAR}#2'"),
        ("crayola_24_ct", (), "is in bin_B, not in the tote; apc plan-pick picks it"),
        (f"{BAR}#2", ("--into", "bin_c"), "--into: unknown bin 'bin_c'; did you mean 'bin_C'?"),
        (f"{BAR}#2", ("--into", "tote"), "--into: unknown bin 'tote'"),
    ],
)
def test_unknown_names_are_refused(
    scene: Path, item: str, more: tuple[str, ...], told: str, tmp_path: Path
) -> None:
    out = tmp_path / "plan.json"
    refused(apc("plan-stow", "--scene", scene, "--item", item, *more, "-o", out), 3, told)
    assert not out.exists()


def test_execute_takes_what_is_elsewhere_by_a_query(scene: Path) -> None:
    answer = apc("execute", "--scene", scene, "--stow", "crayola_24_ct:bin_C")
    refused(answer, 3, "not in the tote; --pick bin_B:crayola_24_ct picks it from there")


def test_a_stow_needs_a_tote() -> None:
    answer = apc("execute", "--cell", "ur5e_crates", "--stow", "crayola_24_ct:crate_left")
    refused(answer, 3, "states no pod and no tote; a stow needs pod, tote and tool (docs/formats/cell.md)")
    assert "execute do not" not in answer.err


def test_a_bin_that_is_full_takes_nothing_and_says_why(tmp_path: Path) -> None:
    full, out = tmp_path / "full.json", tmp_path / "plan.json"
    contents = (
        "--in",
        f"tote={BAR}",
        "--in",
        "bin_E=kleenex_tissue_box,kleenex_tissue_box,kleenex_tissue_box",
    )
    assert apc("make-scene", *contents, "--seed", "1", "-o", full).code == 0
    answer = apc("plan-stow", "--scene", full, "--item", BAR, "--into", "bin_E", "-o", out)
    if answer.code != 5:
        pytest.fail(f"exit code {answer.code}: {answer.err}")
    assert "bin_E" in answer.err and not out.exists()


def test_a_stow_is_explained_before_anything_moves() -> None:
    answer = apc("explain-stow", "delft_stow_1", "--json")
    told = json.loads(answer.out)
    assert answer.code == 0 and len(told["items"]) == 12
    assert all(item["bins"] and item["reason"] for item in told["items"])
    assert told["points"] == sum(item["points"] for item in told["items"])
    assert apc("explain-stow", "delft_stow_1", "--json").out == answer.out
    by_size = json.loads(apc("explain-stow", "delft_stow_1", "--stow-rule", "size", "--json").out)
    assert by_size["points"] < told["points"]


def test_what_lies_partly_on_an_item_is_pushed_aside_if_that_is_allowed(cell: Cell, tmp_path: Path) -> None:
    scene, out = tmp_path / "heap.json", tmp_path / "plan.json"
    write_scene(bridge(cell), scene)
    stow = ("plan-stow", "--scene", scene, "--item", BOX, "--into", "bin_E", "-o", out)
    refused(apc(*stow), 5, f"without {BOOK} there is a plan")
    answer = apc(*stow, "--neighbours", "push")
    assert answer.code == 0, answer.err
    assert any(BOOK in segment.pushing for segment in read_plan(out).segments)
    write_scene(bridge(cell, book=-0.015), scene)
    refused(apc(*stow, "--neighbours", "push", "--overwrite"), 5, f"{BOOK} would be carried along")
