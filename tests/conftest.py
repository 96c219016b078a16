"""What all tests share."""

from __future__ import annotations

import pytest
from hypothesis import settings

from pickcli.cell.load import load_cell
from pickcli.cell.model import Cell

# How long an example takes says how busy the machine is, and nothing about the code.
settings.register_profile("suite", deadline=None)
settings.load_profile("suite")


@pytest.fixture(scope="session")
def cell() -> Cell:
    """The default cell, which nothing changes."""
    return load_cell("apc2016_delft")
