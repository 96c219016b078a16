"""Targets of fresh pick orders that several cells can pick: which tool takes most out of the same scenes.

    python -m bench.lances CELL [CELL ...] [--orders 6] [--seed 0] [--json FILE]

Scenes are those of ``bench.fresh``, at rest in the shelf of the first cell. Counted for each cell are the
targets that a tool holds, that have a plan once their bin is cleared (``bench.deliverable``), and that have
one as everything lies, with true poses and the bounds of error that a trial states. No stored motions are
used. Targets that not all cells can pick as they lie are listed.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from bench.deliverable import as_known, cleared, is_holdable, is_plannable
from pickcli.cell.cell_file import load_workcell
from pickcli.errors import InputError
from pickcli.planning.planning_context import PlanningContext
from pickcli.random_scenes.make_scene import make_scene
from pickcli.scene.scene import PlacedItem, Scene
from pickcli.trial.make_order import make_order
from pickcli.trial.order import OrderKind

JUDGED = ("held", "planned when cleared", "planned as it lies")


def judged(copies: Sequence[PlacedItem], scene: Scene, warm: Sequence[PlanningContext]) -> tuple[bool, ...]:
    """Which of ``JUDGED`` a cell can do with any of the copies of a target."""
    tools = [context.cell.robot.tool for context in warm]
    known = as_known(scene)
    return (
        any(is_holdable(copy.item, tools) for copy in copies),
        any(is_plannable(copy, cleared(known, copy, tools), warm) for copy in copies),
        any(is_plannable(copy, known, warm) for copy in copies),
    )


def measure(cells: Sequence[str], seeds: Sequence[int]) -> dict[str, Any]:
    """Counts by cell, and the targets on which cells differ."""
    warm = {name: [PlanningContext(cell) for cell in load_workcell(name).arms.values()] for name in cells}
    base = warm[cells[0]][0].cell
    counts = {name: dict.fromkeys(JUDGED, 0) for name in cells}
    differing: list[dict[str, Any]] = []
    targets = 0
    for seed in seeds:
        order = make_order(OrderKind.PICK, 2016, seed)
        try:
            scene = make_scene(order.bin_contents, base, seed, order.year)
        except InputError as error:
            print(f"seed {seed}: {error}", file=sys.stderr)
            continue
        for target in order.work_order:
            targets += 1
            copies = [p for p in scene.in_location(target.bin) if p.item.name == target.item]
            found = {
                name: judged(copies, replace(scene, cell=warm[name][0].cell), warm[name]) for name in cells
            }
            for name, can in found.items():
                for what, is_so in zip(JUDGED, can, strict=True):
                    counts[name][what] += is_so
            if len(set(found.values())) > 1 or not all(all(can) for can in found.values()):
                line = {"seed": seed, "bin": target.bin, "item": target.item}
                differing.append(line | {name: [*map(int, can)] for name, can in found.items()})
                print(differing[-1], file=sys.stderr, flush=True)
        print(f"seed {seed}: {counts} of {targets}", file=sys.stderr, flush=True)
    return {"targets": targets, "counts": counts, "not all": differing}


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cells", nargs="+")
    parser.add_argument("--orders", type=int, default=6)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    figures = measure(given.cells, range(given.seed, given.seed + given.orders))
    text = json.dumps(figures, indent=2)
    print(text)
    if given.json is not None:
        given.json.write_text(text + "\n")


if __name__ == "__main__":
    main()
