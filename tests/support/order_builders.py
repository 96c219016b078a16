"""Small orders and names that the tests of this package share."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from pickcli.files.yaml_reader import parse_yaml
from pickcli.trial.order import Order, OrderKind, Target
from pickcli.trial.order_file import BINS, order_of

ITEMS = ("crayola_24_ct", "dove_beauty_bar", "scotch_duct_tape", "dasani_water_bottle", "jane_eyre_dvd")


def pick_data(**bins: list[Any]) -> dict[str, Any]:
    """A valid 2016 pick order as JSON data: a crayola per bin unless said otherwise, one target."""
    contents = {name: ["crayola_24_ct"] for name in BINS} | bins
    return {
        "bin_contents": contents,
        "tote_contents": [],
        "work_order": [{"bin": "bin_A", "item": contents["bin_A"][0]}],
    }


def pick_order(contents: Mapping[str, tuple[str, ...]], *targets: tuple[str, str], year: int = 2016) -> Order:
    """A pick order; bins that are not named are empty."""
    bin_contents = {name: contents.get(name, ()) for name in BINS}
    return Order(OrderKind.PICK, year, bin_contents, (), tuple(Target(b, i) for b, i in targets))


def parsed_order(text: str, path: Path, items: Collection[str]) -> Order:
    """The order of a text, for all bins; ``path`` is the file whose content it would be."""
    return order_of(parse_yaml(text, path), items, BINS)
