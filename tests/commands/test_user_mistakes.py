"""What users do wrong, and what they read: no certificate, no traceback, but what, where and a remedy."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from support.command_line import apc
from support.user_mistakes.call_mistakes import CALL_MISTAKES
from support.user_mistakes.cell_mistakes import CELL_MISTAKES
from support.user_mistakes.item_mistakes import ITEM_MISTAKES
from support.user_mistakes.mistake import Files, Mistake
from support.user_mistakes.scene_mistakes import ORDER_MISTAKES, SCENE_MISTAKES
from support.user_mistakes.urdf_mistakes import URDF_MISTAKES

GROUPS = {
    "cell": CELL_MISTAKES,
    "urdf": URDF_MISTAKES,
    "items": ITEM_MISTAKES,
    "scene": SCENE_MISTAKES,
    "order": ORDER_MISTAKES,
    "call": CALL_MISTAKES,
}
EVERY = [pytest.param(each, id=f"{group}: {each.name}") for group, rows in GROUPS.items() for each in rows]
LINES = 8  # that a message has at most: of many mistakes of one kind the first is told


@pytest.fixture(scope="module")
def right(empty_cache: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with an order, its scene, a pick and a move, in which nothing is wrong."""
    folder = tmp_path_factory.mktemp("right")
    scene, item = folder / "scene.json", "dove_beauty_bar"
    bins: dict[str, list[str]] = {f"bin_{letter}": [] for letter in "ABCDEFGHIJKL"}
    bins["bin_A"], bins["bin_C"] = ["kleenex_tissue_box", "staples_index_cards"], [item, "crayola_24_ct"]
    order = {"bin_contents": bins, "tote_contents": [], "work_order": [{"bin": "bin_C", "item": item}]}
    (folder / "order.json").write_text(json.dumps(order))
    for argv in (
        ("make-scene", folder / "order.json", "-o", scene, "--seed", 3),
        ("plan-pick", "--scene", scene, "--bin", "bin_C", "--item", item, "-o", folder / "plan.json"),
        ("plan-move", "--scene", scene, "--from", "home", "--to", "bin_C", "-o", folder / "move.json"),
        ("check", scene, "--strict"),
        ("check", folder / "order.json", "--strict"),
    ):
        answer = apc(*argv)
        assert answer.code == 0, answer.err
    return folder


@pytest.mark.parametrize("mistake", EVERY)
def test_a_mistake_is_told_with_its_place_and_what_to_do(
    mistake: Mistake, right: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    files = Files(right, tmp_path)
    answer = apc(*files.arguments(mistake))
    assert answer.code == mistake.code, answer.err
    assert not (tmp_path / "out.json").exists()
    assert len(re.findall(r"\berror:", answer.err, re.IGNORECASE)) == 1 and "Traceback" not in answer.err
    told = ".*".join(re.escape(part.strip()) for part in mistake.told.split("…"))
    assert re.search(told, answer.err), answer.err
    if mistake.changes_a_file and mistake.code == 3:
        assert re.search(r"\.(yaml|urdf|json):(\d+| held| is a)", answer.err), answer.err


def test_every_mistake_has_a_name_of_its_own() -> None:
    ids = [each.id for each in EVERY]
    assert len(set(ids)) == len(ids) >= 184
