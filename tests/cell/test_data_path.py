"""The data folder is found in a checkout and in an installed package."""

from __future__ import annotations

from pathlib import Path

import pytest

import pickcli
from pickcli.cell.data_path import data_path


@pytest.mark.parametrize(("data", "expected"), [("data", "data"), ("pickcli/data", "pickcli/data")])
def test_beside_the_package_else_inside(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, data: str, expected: str
) -> None:
    (tmp_path / data / "cells").mkdir(parents=True)
    (tmp_path / "pickcli").mkdir(exist_ok=True)
    monkeypatch.setattr(pickcli, "__file__", str(tmp_path / "pickcli" / "__init__.py"))
    assert data_path() == tmp_path.resolve() / expected


def test_this_checkout_has_the_default_cell_items_and_orders() -> None:
    folder = data_path()
    assert (folder / "cells" / "apc2016_delft" / "cell.yaml").is_file()
    assert len(list((folder / "items").glob("*.yaml"))) == 2
    assert len(list((folder / "tasks").glob("*pick*.json"))) == 5
