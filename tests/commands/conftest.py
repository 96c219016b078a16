"""A small order, its scene and a certified pick, made once by the commands themselves."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.command_line import ITEM, Made, apc


@pytest.fixture(scope="module", autouse=True)
def empty_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A cache of its own: what its user has built before decides nothing here."""
    folder = tmp_path_factory.mktemp("cache")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(folder))
        yield folder


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Made]:
    """Two items in bin_C, a pick of one of them and a move; made with an empty cache, and read-only."""
    folder = tmp_path_factory.mktemp("made")
    files = Made(*(folder / f"{name}.json" for name in ("order", "scene", "plan", "move")))
    bins: dict[str, list[str]] = {f"bin_{letter}": [] for letter in "ABCDEFGHIJKL"}
    order = {
        "bin_contents": {**bins, "bin_C": [ITEM, "crayola_24_ct"]},
        "tote_contents": [],
        "work_order": [{"bin": "bin_C", "item": ITEM}],
    }
    files.order.write_text(json.dumps(order))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(folder / "cache"))
        for argv in (
            ("make-scene", files.order, "-o", files.scene, "--seed", 3),
            ("plan-pick", "--scene", files.scene, "--bin", "bin_C", "--item", ITEM, "-o", files.plan),
            ("plan-move", "--scene", files.scene, "--from", "home", "--to", "bin_C", "-o", files.move),
        ):
            answer = apc(*argv)
            assert answer.code == 0, answer.err
    before = {path: path.read_bytes() for path in vars(files).values()}
    yield files
    assert {path: path.read_bytes() for path in before} == before


@pytest.fixture
def out(tmp_path: Path) -> Path:
    """Where a command is told to write."""
    return tmp_path / "out.json"
