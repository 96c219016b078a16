"""Official order files of the Amazon Picking Challenge, in the formats of 2015 and 2016.

2016 pick: ``bin_contents``, ``tote_contents`` (empty) and ``work_order``. 2016 stow: ``bin_contents`` and
``tote_contents``. 2016 output: as stow, the state after a task. 2015: ``bin_contents`` and ``work_order``.
The format is described in docs/formats/order.md.
"""

from __future__ import annotations

import difflib
from collections import Counter
from collections.abc import Callable, Collection
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from reprlib import Repr
from typing import Any

from pickcli.cell.cell import Cell
from pickcli.cell.data_path import data_path
from pickcli.errors import InputError, UnknownNameError
from pickcli.files.file_kind import ORDER
from pickcli.trial.strict_json import Document, Place, parse_json, read_json

_SHORT = Repr()  # of values of any size
_SHORT.maxstring = _SHORT.maxother = 40

BINS = tuple(f"bin_{letter}" for letter in "ABCDEFGHIJKL")
_KEYS = ("bin_contents", "tote_contents", "work_order")
_MOST_PROBLEMS = 8  # how many are named in one message
MAX_CONTENTS = 100  # items in one bin or in the tote
MAX_TARGETS = 500


class OrderKind(StrEnum):
    """What an order asks for."""

    PICK = "pick"  # move the targets of the work order from their bins into the tote
    STOW = "stow"  # move everything from the tote into bins
    OUTPUT = "output"  # not an order but the state after one: no work order and nothing in the tote


@dataclass(frozen=True)
class Target:
    """One line of a work order: one copy of an item, from one bin."""

    bin: str
    item: str


@dataclass(frozen=True)
class Order:
    """What lies where before the task (after it, for OUTPUT), and what is wanted.

    year: 2015 or 2016, by the format of the file; it decides the rules and which figures an item has
    """

    kind: OrderKind
    year: int
    bin_contents: dict[str, tuple[str, ...]]  # by bin, in the order of the bins; duplicates are copies
    tote_contents: tuple[str, ...]
    work_order: tuple[Target, ...]


def read_order(path: Path, cell: Cell) -> Order:
    """Read an order for the bins and items of a cell.

    Args:
        path: A file, or the name of an order under data/tasks.
        cell: Whose bins and items may stand in it.

    Raises:
        InputError: Naming every problem; UnknownNameError for a name that stands for none.
    """
    return _order(read_json(order_file(path), ORDER), {name for name, _ in cell.items}, tuple(cell.pod.bins))


def order_names() -> list[str]:
    """Names of the orders under data/tasks."""
    return sorted(path.stem for path in data_path().glob("tasks/*.json"))


def order_file(name_or_path: Path) -> Path:
    """The file that a path, or the name of an order under data/tasks, means.

    Raises:
        UnknownNameError: There is no such file, and what would be a name is none.
    """
    if name_or_path.exists() or name_or_path.suffix:
        return name_or_path
    is_known = len(name_or_path.parts) == 1 and name_or_path.name in order_names()
    beside = name_or_path.with_name(f"{name_or_path.name}.json")
    if not is_known and beside.is_file():
        raise UnknownNameError(
            "order", str(name_or_path), order_names(), hint=f"did you mean the file {str(beside)!r}?"
        )
    if len(name_or_path.parts) != 1:
        return name_or_path
    if not is_known:
        raise UnknownNameError("order", str(name_or_path), order_names())
    return data_path() / "tasks" / f"{name_or_path}.json"


def parse_order(data: bytes, where: str, items: Collection[str], bins: tuple[str, ...] = BINS) -> Order:
    """Parse the bytes of an order; ``items`` and ``bins`` are the known names. Raises InputError."""
    return _order(parse_json(data, where), items, bins)


def _order(document: Document, items: Collection[str], bins: tuple[str, ...]) -> Order:
    reader = _Reader(document, items, bins)
    order = reader.order()
    if reader.problems:
        shown = list(reader.problems)
        if reader.n_untold:
            shown.append(f"{document.where}: and {reader.n_untold} more")
        raise InputError("\n".join(shown))
    return order


class _Reader:
    """Goes through a document once and collects everything that is wrong with it."""

    def __init__(self, document: Document, items: Collection[str], bins: tuple[str, ...]) -> None:
        self.document, self.items, self.bins = document, items, bins
        self.problems: list[str] = []
        self.n_untold = 0

    def order(self) -> Order:
        """The order; to be used only when there are no problems."""
        root = self._object((), _KEYS, required=("bin_contents",))
        contents = self._object(("bin_contents",), self.bins, required=self.bins) if root else {}
        bin_contents = {b: self._names("bin_contents", b) for b in self.bins if b in contents}
        tote = self._names("tote_contents") if "tote_contents" in root else ()
        work_order = self._work_order(bin_contents) if "work_order" in root else ()
        year = 2016 if "tote_contents" in root else 2015
        if root and len(root) == 1 and "bin_contents" in root:
            self._problem((), lambda: "neither 'work_order' nor 'tote_contents'; an order has at least one")
        without_work_order = OrderKind.STOW if tote else OrderKind.OUTPUT
        kind = OrderKind.PICK if "work_order" in root else without_work_order
        return Order(kind, year, bin_contents, tote, work_order)

    def _work_order(self, bin_contents: dict[str, tuple[str, ...]]) -> tuple[Target, ...]:
        targets: list[Target] = []
        copies = {name: Counter(contents) for name, contents in bin_contents.items()}
        ordered: Counter[Target] = Counter()
        for i in range(len(self._list(("work_order",), MAX_TARGETS))):
            place = ("work_order", i)
            entry = self._object(place, ("bin", "item"), required=("bin", "item"))
            known = [self._name((*place, key), key, names) for key, names in self._target_names(entry)]
            if len(known) == 2 and known[0] and known[1]:
                targets.append(Target(known[0], known[1]))
                ordered[targets[-1]] += 1
                self._check_target(targets[-1], ordered[targets[-1]], copies, (*place, "item"))
        if not targets and not self.problems:
            self._problem(("work_order",), lambda: "the work order is empty; name a target")
        return tuple(targets)

    def _target_names(self, entry: dict[str, Any]) -> list[tuple[str, Collection[str]]]:
        known = (("bin", self.bins), ("item", self.items))
        return [(key, names) for key, names in known if key in entry]

    def _check_target(
        self, target: Target, n_ordered: int, copies: dict[str, Counter[str]], place: Place
    ) -> None:  # fmt: skip
        """A target must lie in its bin, in as many copies as are ordered by now."""
        n_there = copies[target.bin][target.item] if target.bin in copies else 0
        if n_there == 0:
            holders = [b for b, names in copies.items() if target.item in names]
            hint = f"it is in {' and '.join(holders)}" if holders else "it is in no bin"
            what = f"{target.item!r} is ordered from {target.bin} but is not there ({hint})"
            self._problem(place, lambda: f"{what}; correct the bin or the contents")
        elif n_ordered > n_there:
            what = f"{target.item!r} is ordered {n_ordered} times from {target.bin}, which holds {n_there}"
            self._problem(place, lambda: f"{what}; delete one target or add a copy")

    def _names(self, *place: str | int) -> tuple[str, ...]:
        n = len(self._list(place, MAX_CONTENTS))
        found = [self._name((*place, i), "item", self.items) for i in range(n)]
        return tuple(name for name in found if name)

    def _name(self, place: Place, kind: str, known: Collection[str]) -> str:
        """The known name at a place, "" after noting a problem."""
        value = self._value(place)
        if not isinstance(value, str):
            self._expected(place, f"the name of a known {kind}", value)
        elif value not in known:
            self._problem(place, lambda: f"unknown {kind} {value[:60]!r}; {_suggestion(value, known)}")
        else:
            return value
        return ""

    def _object(self, place: Place, known: tuple[str, ...], required: tuple[str, ...]) -> dict[str, Any]:
        value = self._value(place)
        if not isinstance(value, dict):
            self._expected(place, "an object {...}", value)
            return {}
        unknown = [key for key in value if key not in known]
        for key in unknown:
            self._unknown_key(place, key, [k for k in known if k not in value] or known)
        for key in required:
            # A misspelt key has already been named, with its correction.
            if key not in value and not any(_closest(u, [key]) for u in unknown[:_MOST_PROBLEMS]):
                advice = f'add it ("{key}": [] if empty)' if place == ("bin_contents",) else "add it"
                what = f"the key {key!r} is missing; {advice}"
                self._problem(place, lambda what=what: what)  # type: ignore[misc]
        return value

    def _unknown_key(self, place: Place, key: str, known: Collection[str]) -> None:
        self._problem(
            (*place, key), lambda: f"unknown key {key[:60]!r}; {_suggestion(key, known)}", is_key=True
        )

    def _list(self, place: Place, most: int) -> list[Any]:
        value = self._value(place)
        if isinstance(value, list):
            if len(value) > most:
                self._problem(
                    place, lambda: f"{len(value)} entries, at most {most} are taken; leave some out"
                )
            return value[:most]
        self._expected(place, "a list [...]", value)
        return []

    def _value(self, place: Place) -> Any:
        value = self.document.value
        for key in place:
            if isinstance(value, dict) and key not in value:
                return None
            value = value[key]
        return value

    def _expected(self, place: Place, what: str, got: object) -> None:
        name = str(place[-1]) if place and isinstance(place[-1], str) else "here"
        self._problem(place, lambda: f"{name}: expected {what}, got {_SHORT.repr(got)}")

    def _problem(self, place: Place, what: Callable[[], str], is_key: bool = False) -> None:
        """Note a mistake; beyond the first few only their number, for places and hints take time."""
        if len(self.problems) >= _MOST_PROBLEMS:
            self.n_untold += 1
            return
        at = self.document.at_key if is_key else self.document.at
        self.problems.append(f"{at(*place)}: {what()}")


def _closest(name: str, known: Collection[str]) -> str | None:
    close = difflib.get_close_matches(name[:60], sorted(known), n=1)
    return close[0] if close else None


def _suggestion(name: str, known: Collection[str]) -> str:
    if close := _closest(name, known):
        return f"did you mean {close!r}?"
    return f"known: {', '.join(sorted(known)[:12])}{', ...' if len(known) > 12 else ''}"
