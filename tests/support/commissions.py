"""Commissions for the truck of apple_booth, smaller than the one that ships."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from pickcli.cell.cell_file import load_workcell
from pickcli.cell.data_path import data_path
from pickcli.commission.commission_file import read_commission
from pickcli.commission.commission_station import CommissionStation
from pickcli.commission.commission_trial import CommissionRequest, PlayedCommission, play_commission
from pickcli.planning.planning_context import PlanningContext

SHIPPED = data_path() / "tasks" / "apple_commission.json"
Change = Callable[[dict[str, Any]], None]


def shipped() -> dict[str, Any]:
    """The commission that ships, as JSON values."""
    found: dict[str, Any] = json.loads(SHIPPED.read_text())
    return found


def few(data: dict[str, Any], *names: str) -> None:
    """Leave only items of some products on the load, one of each."""
    firsts = {each["product"]: each for each in reversed(data["items"])}
    data["items"] = [firsts[name] for name in names]


def written(folder: Path, change: Change) -> Path:
    """A file of the commission that ships, changed."""
    data = shipped()
    change(data)
    path = folder / "commission.json"
    path.write_text(json.dumps(data))
    return path


@cache
def booth() -> Any:
    """The cell apple_booth."""
    return load_workcell("apple_booth").preferred


@cache
def belts_booth() -> Any:
    """The cell apple_booth_belts, whose arm has a bare flange for the hand with belts."""
    return load_workcell("apple_booth_belts").preferred


def station_of(path: Path) -> CommissionStation:
    """A commission in its cell."""
    return CommissionStation.of(booth(), read_commission(path))


def play(path: Path, **conditions: Any) -> PlayedCommission:
    """Play a commission to its end."""
    station = station_of(path)
    return play_commission(CommissionRequest(**conditions), station, PlanningContext(station.cell))
