"""The print of one small box, as models know it."""

from __future__ import annotations

import pytest

from pickcli.cell.cell import Cell
from pickcli.cell.item import Item
from pickcli.perception.textures.print_model import PrintModel, print_model

PRINTS = 21


@pytest.fixture(scope="session")
def soap(cell: Cell) -> Item:
    return cell.item("dove_beauty_bar", 2016)


@pytest.fixture(scope="session")
def soap_model(soap: Item) -> PrintModel:
    return print_model(soap, PRINTS)
