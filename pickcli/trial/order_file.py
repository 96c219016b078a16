"""Reads order files: official ones of the Amazon Picking Challenge of 2015 and 2016, and moves.

2016 pick: ``bin_contents``, ``tote_contents`` (empty) and ``work_order``. 2016 stow: ``bin_contents`` and
``tote_contents``. 2016 output: as stow, the state after a task. 2015: ``bin_contents`` and ``work_order``.
For cells with other places: ``contents`` and ``moves``. See docs/formats/order.md.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Annotated

from annotated_types import Len
from pydantic import Field

from pickcli.cell.cell import Cell
from pickcli.cell.data_path import data_path, task_names
from pickcli.cell.item import item_suggestion
from pickcli.errors import InputError, UnknownNameError
from pickcli.files.bounded_reading import read_kind
from pickcli.files.file_kind import COMMISSION, ORDER, STREAM
from pickcli.files.schema import FEW_MISSING, FileModel, validate
from pickcli.files.source import Key, Source
from pickcli.files.yaml_reader import read_yaml
from pickcli.name_suggestion import shortened, suggestion
from pickcli.trial.order import Order, OrderKind, Target

BINS = tuple(f"bin_{letter}" for letter in "ABCDEFGHIJKL")
MAX_CONTENTS = 100  # items in one bin or in the tote
MAX_TARGETS = 500
NEWEST = 2016  # year of the items' figures in orders of moves
FORMATS = ("apc commission", "apc pallet", "apc stacked", "apc stream")  # of tasks that are no orders
OTHERS = (STREAM, COMMISSION)  # kinds of files under data/tasks that are no orders


def read_order(path: Path, cell: Cell) -> Order:
    """Read an order for the bins and items of a cell.

    Args:
        path: A file, or the name of an order under data/tasks.
        cell: The cell, for names of bins, other places and items.

    Returns:
        The order.

    Raises:
        InputError: The file has mistakes: with every problem; or it is an official order and the cell has no
            pod or tote.
        UnknownNameError: There is no such file and no order of that name.
    """
    source, items = read_yaml(order_file(path, cell), ORDER), {name for name, _ in cell.items}
    _refuse_format(source)
    has_bins = cell.pod.bins and cell.tote is not None
    if isinstance(source.data, dict) and _is_of_moves(source.data.keys(), not has_bins):
        return moves_of(source, items, tuple(cell.places))
    if not has_bins:
        _refuse_official(source, cell)
    cell.require_pod_and_tote()
    return order_of(source, items, tuple(cell.pod.bins))


def refuse_unknown_task(name_or_path: Path, cell: Cell | None = None) -> None:
    """Refuse, before any work, a name that is none of a task: of an order, a stream or a commission.

    Args:
        name_or_path: As written by the user.
        cell: Cell in whose folder to look besides data/tasks, if any.

    Raises:
        UnknownNameError: There is no such file and no task of that name.
    """
    if name_or_path.exists() or name_or_path.suffix or len(name_or_path.parts) != 1:
        return
    names = sorted({*task_names(), *order_names(cell)})
    if name_or_path.name not in names and not name_or_path.with_name(f"{name_or_path.name}.json").is_file():
        raise UnknownNameError("order", str(name_or_path), names, hint=_of_another_cell(name_or_path.name))


def order_names(cell: Cell | None = None) -> list[str]:
    """List the names of known orders: under data/tasks, and in a cell's own folder.

    Args:
        cell: The cell; None for only those under data/tasks.

    Returns:
        Their names, sorted.
    """
    tasks = (path for path in data_path().glob("tasks/*.json") if read_kind(path) not in OTHERS)
    return sorted({path.stem for path in (*tasks, *_own_orders(cell))})


def order_file(name_or_path: Path, cell: Cell | None = None) -> Path:
    """Find the file of a path or the name of an order.

    Args:
        name_or_path: As written by the user.
        cell: Cell in whose folder to look besides data/tasks, if any.

    Returns:
        Path of the file, which need not exist if a path was given.

    Raises:
        UnknownNameError: There is no such file and no order of that name.
    """
    if name_or_path.exists() or name_or_path.suffix:
        return name_or_path
    names = order_names(cell)
    is_known = len(name_or_path.parts) == 1 and name_or_path.name in names
    beside = name_or_path.with_name(f"{name_or_path.name}.json")
    if not is_known and beside.is_file():
        raise UnknownNameError(
            "order", str(name_or_path), names, hint=f"did you mean the file {str(beside)!r}?"
        )
    if len(name_or_path.parts) != 1:
        return name_or_path
    if not is_known:
        raise UnknownNameError("order", str(name_or_path), names, hint=_of_another_cell(name_or_path.name))
    own = (path for path in _own_orders(cell) if path.stem == name_or_path.name)
    return next(own, data_path() / "tasks" / f"{name_or_path}.json")


def _refuse_format(source: Source) -> None:
    """Raise InputError for a file that states a format: no order does, and those of other tasks are known."""
    stated = source.data.get("format") if isinstance(source.data, dict) else None
    if isinstance(stated, str):
        raise InputError(
            f"{source.path}: format: {shortened(stated)!r} is no format of a task; "
            f"{suggestion(stated, FORMATS)} Orders state none (docs/formats/order.md)"
        )


def _own_orders(cell: Cell | None) -> list[Path]:
    """Orders of moves in the folder of a cell, recognised by their file names."""
    return [] if cell is None else sorted(cell.path.glob("moves_*.json"))


def _of_another_cell(name: str) -> str:
    """A hint at a cell under data/cells whose own order has a name; empty if none has."""
    cells = [
        path.parent.name for path in sorted(data_path().glob("cells/*/moves_*.json")) if path.stem == name
    ]
    return f"it is one of the cell {cells[0]}; add --cell {cells[0]}" if cells else ""


def _is_of_moves(keys: Collection[str], is_likely: bool) -> bool:
    """Whether a file with these keys is meant as an order of moves, possibly with a misspelt key."""
    if {"moves", "contents"} & set(keys):
        return True
    return is_likely and not {"bin_contents", "tote_contents", "work_order"} & set(keys)


def _refuse_official(source: Source, cell: Cell) -> None:
    """Raise InputError for an official order in a cell without pod or tote, with alternatives."""
    own = [path.stem for path in _own_orders(cell)]
    lacking = " and no ".join(
        key for key, has in (("pod", cell.pod.bins), ("tote", cell.tote is not None)) if not has
    )
    expected = f"e.g. {', '.join(own)}" if own else "with the keys contents and moves (docs/formats/order.md)"
    raise InputError(
        f"{source.path}: is an official order, of bins and a tote, and cell {cell.name} has no {lacking}; "
        f"name an order of moves, {expected}, or place items with apc make-scene --in PLACE=ITEM"
    )


class _TargetModel(FileModel):
    bin: str = Field(description="the name of a bin")
    item: str = Field(description="the name of an item")


_Contents = Annotated[tuple[str, ...], Len(0, MAX_CONTENTS)]


class _OrderModel(FileModel):
    bin_contents: dict[str, _Contents] = Field(description="an object with a list of items for every bin")
    tote_contents: _Contents = Field(default=(), description="a list of items")
    work_order: Annotated[tuple[_TargetModel, ...], Len(0, MAX_TARGETS)] = Field(
        default=(), description="a list of targets, each with its bin and item"
    )


class _MoveModel(FileModel):
    source: str = Field(alias="from", description="the name of a place")
    item: str = Field(description="the name of an item")
    to: str = Field(description="the name of another place")


class _MovesModel(FileModel):
    contents: dict[str, _Contents] = Field(description="an object with a list of items by place")
    moves: Annotated[tuple[_MoveModel, ...], Len(1, MAX_TARGETS)] = Field(
        description="a list of moves, each with from, item and to"
    )


def moves_of(source: Source, items: Collection[str], places: tuple[str, ...]) -> Order:
    """Build an order of moves from a file's values, with its names checked.

    Args:
        source: The values of the file, with their positions.
        items: Known names of items.
        places: Known names of places.

    Returns:
        The order, of the kind MOVE.

    Raises:
        InputError: The file has mistakes: with every problem.
    """
    model = validate(source, _MovesModel)
    for name, names in model.contents.items():
        _check_name(source, ("contents", name), "place", name, places)
        for i, item in enumerate(names):
            _check_name(source, ("contents", name, i), "item", item, items)
    copies = {name: Counter(names) for name, names in model.contents.items()}
    targets = tuple(Target(move.source, move.item, move.to) for move in model.moves)
    ordered: Counter[Target] = Counter()
    for i, target in enumerate(targets):
        key: Key = ("moves", i)
        known = _check_name(source, (*key, "from"), "place", target.bin, places)
        if _check_name(source, (*key, "to"), "place", target.into, places) and target.into == target.bin:
            source.add((*key, "to"), f"{target.item!r} is in {target.bin} already; name another place")
        if _check_name(source, (*key, "item"), "item", target.item, items) and known:
            taken = Target(target.bin, target.item)
            ordered[taken] += 1
            if fault := _fault(taken, ordered[taken], copies):
                source.add((*key, "item"), fault)
    source.check()
    return Order(OrderKind.MOVE, NEWEST, dict(model.contents), (), targets)


def order_of(source: Source, items: Collection[str], bins: tuple[str, ...]) -> Order:
    """Build an official order from a file's values, with its names checked.

    Args:
        source: The values of the file, with their positions.
        items: Known names of items.
        bins: Known names of bins.

    Returns:
        The order.

    Raises:
        InputError: The file has mistakes: with every problem.
    """
    model = validate(source, _OrderModel)
    _check_bins(source, model, bins)
    _check_items(source, model, items)
    _check_work_order(source, model, items, bins)
    has_targets, has_tote = (key in model.model_fields_set for key in ("work_order", "tote_contents"))
    if not has_targets and not has_tote:
        source.add((), "neither 'work_order' nor 'tote_contents'; an order has at least one")
    source.check()
    without_targets = OrderKind.STOW if model.tote_contents else OrderKind.OUTPUT
    return Order(
        kind=OrderKind.PICK if has_targets else without_targets,
        year=2016 if has_tote else 2015,
        bin_contents={name: model.bin_contents[name] for name in bins},
        tote_contents=model.tote_contents,
        work_order=tuple(Target(target.bin, target.item) for target in model.work_order),
    )


def _check_bins(source: Source, model: _OrderModel, bins: tuple[str, ...]) -> None:
    """Check that the contents list exactly the bins of the cell."""
    missing = [name for name in bins if name not in model.bin_contents]
    meant = ""
    for name in model.bin_contents:
        if name not in bins:
            hint = "" if source.is_full else f"; {suggestion(name, missing or bins)}"
            source.add(("bin_contents", name), f"unknown bin{hint}")
            meant += hint
    # Bins suggested for a misspelt key are not reported again.
    unexplained = [name for name in missing if repr(name) not in meant]
    if len(unexplained) > FEW_MISSING:
        fault = f'the bins {", ".join(unexplained)} are missing; add them ("{unexplained[0]}": [] if empty)'
        source.add(("bin_contents",), fault)
        return
    for name in unexplained:
        source.add(("bin_contents",), f'the bin {name!r} is missing; add it ("{name}": [] if empty)')


def _check_items(source: Source, model: _OrderModel, items: Collection[str]) -> None:
    """Check that all names of items are known."""
    lists: dict[Key, tuple[str, ...]] = {("tote_contents",): model.tote_contents}
    lists |= {("bin_contents", name): names for name, names in model.bin_contents.items()}
    for place, names in lists.items():
        for i, name in enumerate(names):
            _check_name(source, (*place, i), "item", name, items)


def _check_name(source: Source, key: Key, kind: str, name: str, known: Collection[str]) -> bool:
    """Whether a name is known; an unknown one is reported, with suggestions unless the list is full."""
    if name not in known:
        suggest = item_suggestion if kind == "item" else suggestion
        hint = "" if source.is_full else f"; {suggest(name, known)}"
        source.add(key, f"unknown {kind} {shortened(name)!r}{hint}")
    return name in known


def _check_work_order(
    source: Source, model: _OrderModel, items: Collection[str], bins: tuple[str, ...]
) -> None:  # fmt: skip
    """Check that every target is in its bin, in enough copies."""
    if "work_order" in model.model_fields_set and not model.work_order:
        source.add(("work_order",), "the work order is empty; name a target")
    copies = {name: Counter(names) for name, names in model.bin_contents.items()}
    ordered: Counter[Target] = Counter()
    for i, entry in enumerate(model.work_order):
        key: Key = ("work_order", i)
        known = _check_name(source, (*key, "bin"), "bin", entry.bin, bins)
        if _check_name(source, (*key, "item"), "item", entry.item, items) and known:
            target = Target(entry.bin, entry.item)
            ordered[target] += 1
            if fault := _fault(target, ordered[target], copies):
                source.add((*key, "item"), fault)


def _fault(target: Target, n_ordered: int, copies: Mapping[str, Counter[str]]) -> str:
    """Why a target, ordered for the n-th time, is not available, "" if it is."""
    n_there = copies[target.bin][target.item] if target.bin in copies else 0
    if n_there == 0:
        holders = [name for name, names in copies.items() if target.item in names]
        hint = f"it is in {' and '.join(holders)}" if holders else "it is in no bin"
        what = f"{target.item!r} is ordered from {target.bin} but is not there ({hint})"
        return f"{what}; correct the bin or the contents"
    if n_ordered > n_there:
        what = f"{target.item!r} is ordered {n_ordered} times from {target.bin}, which holds {n_there}"
        return f"{what}; delete one target or add a copy"
    return ""
