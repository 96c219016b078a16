"""The file of a page: whole, without a network, the same again, and made of what the repository states."""

from __future__ import annotations

import hashlib
import json
import re
from collections import Counter
from importlib import resources

import pytest

from pickcli.cell.cell_file import cell_names, load_workcell
from pickcli.page.html_page import MODULES, app_script, page_bytes
from pickcli.page.page_document import PageDocument, document_values
from pickcli.page.scene_page import cell_page
from support.page_files import document_of

PAGE = resources.files("pickcli.page")
DECLARED = re.compile(
    r"^(?:export )?(?:async )?(?:function|class|const|let) (?:(\w+)|[{\[]([^}\]]*)[}\]])", re.MULTILINE
)
IMPORTED = re.compile(r'^import .*? from "(.*?)";$', re.MULTILINE | re.DOTALL)


def module(name: str) -> str:
    return (PAGE / "app" / name).read_text()


def test_three_js_is_the_pinned_one_with_its_licence() -> None:
    vendor = PAGE / "vendor"
    pinned = json.loads((vendor / "three.json").read_text())
    locked = json.loads((vendor / "package-lock.json").read_text())["packages"]["node_modules/three"]
    content = (vendor / "three.min.js").read_bytes()
    assert hashlib.sha256(content).hexdigest() == pinned["sha256"]
    assert {key: locked[key] for key in ("version", "integrity", "license")} == {
        key: pinned[key] for key in ("version", "integrity", "license")
    }
    assert "MIT License" in (vendor / "LICENSE").read_text()
    assert b"</script" not in content and len(content) < 650_000


def test_the_app_is_all_its_modules_in_the_order_of_their_imports() -> None:
    files = {path.name for path in (PAGE / "app").iterdir() if path.name.endswith(".js")}
    assert files == set(MODULES)
    for k, name in enumerate(MODULES):
        own = [source for source in IMPORTED.findall(module(name)) if source != "three"]
        assert {source.removeprefix("./") for source in own} <= set(MODULES[:k])
    assert not re.search(r"^(import|export)\b", app_script(), re.MULTILINE)


def test_no_two_modules_declare_the_same_name() -> None:
    names = [name for each in MODULES for name, _ in DECLARED.findall(module(each)) if name]
    assert len(names) > 60
    assert [name for name, n in Counter(names).items() if n > 1] == []


def test_a_page_holds_its_document_and_asks_for_nothing() -> None:
    document = PageDocument("cell", "<b>&", "two words")
    page = page_bytes(document)
    assert page == page_bytes(document)
    assert document_of(page) == {
        "format": "apc page", "version": 1, "kind": "cell", "title": "<b>&", "subtitle": "two words",
    }  # fmt: skip
    text = page.decode()
    assert "<title>&lt;b&gt;&amp;</title>" in text
    assert not re.search(r"""(?:src|href)=["'](?!data:)""", text)
    assert not re.search(r"\bimport\(|@import|url\(", app_script() + module("style.css"))


@pytest.mark.parametrize("name", cell_names())
def test_every_cell_has_a_page(name: str) -> None:
    for cell in load_workcell(name).arms.values():
        shown = document_values(cell_page(cell))
        assert [link["name"] for link in shown["robot"]["links"]] == [link.name for link in cell.robot.links]
        assert {node["name"] for node in shown["nodes"]} == set(cell.configurations)
        assert {place["name"] for place in shown.get("places", [])} == set(cell.places)
        assert len(page_bytes(cell_page(cell))) < 2_000_000
