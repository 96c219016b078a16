"""Puts a stack up in the physics engine, carton by carton: the second opinion on whether it stands.

As in BED-BPP (F. Kagerer et al., "BED-BPP: Benchmarking dataset for robotic bin packing problems", IJRR
42(14), 2023), a stack is stable if no carton moves by more than 10 mm in height. Boxes are shrunk, so that
the engine does not push apart what stands side by side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.item import Item
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, pose
from pickcli.palletizing.pallet_bodies import deck_body, wall_bodies
from pickcli.palletizing.pallet_order import Pallet
from pickcli.palletizing.pallet_stack import PalletStack, Placement
from pickcli.simulation.engine import Engine

MOST_SINKING = 0.010  # m in height, of BED-BPP
MOST_SHIFT = 0.020  # m sideways, beyond which a carton is not where others are put up beside it
TIME_STEP = 2e-3  # s
DROPPED = 1e-3  # m over its place, from which each carton falls
SHRUNK = 1e-3  # m of each side
LEAST, MOST = 0.05, 1.0  # s after each carton, until all are at rest
RESTING = (5e-3, 0.02)  # m/s and rad/s, below which a carton is at rest
N_BETWEEN = 5  # time steps from one look at the speeds to the next
AFTERWARDS = 2.0  # s after all
THICK = 0.1  # m, of the deck
GREY, BROWN = (0.6, 0.6, 0.6, 1.0), (0.7, 0.5, 0.3, 1.0)


@dataclass(frozen=True)
class DropTest:
    """What became of a stack in the engine.

    Attributes:
        sinking: m, of the carton whose height changed most.
        shift: m, of the carton that went farthest sideways.
        reasons: Against the stack: one for each carton that moved by more than is allowed.
    """

    sinking: float
    shift: float
    reasons: tuple[Reason, ...]

    @property
    def is_stable(self) -> bool:
        """Whether nothing moved by more than is allowed."""
        return not self.reasons


def drop_test(pallet: Pallet, placements: Sequence[Placement]) -> DropTest:
    """Put up a stack carton by carton, and let it stand.

    Args:
        pallet: The pallet.
        placements: The cartons in the sequence in which they are put up.

    Returns:
        How far the cartons ended from where they were put down.
    """
    engine, there = Engine(TIME_STEP), list[str]()
    try:
        for body in (deck_body(pallet, THICK), *wall_bodies(pallet)):
            engine.add_static(body, np.eye(4), GREY)
        for placement in placements:
            T = pose(placement.centre + np.array([0.0, 0.0, DROPPED]))
            engine.add_item(placement.carton.id, _solid(placement), T, BROWN)
            for each in placement.rests_on:
                engine.wake(each)
            there.append(placement.carton.id)
            _settle(engine, there)
        for placement in placements:
            engine.wake(placement.carton.id)
        _run(engine, AFTERWARDS)
        ends = {p.carton.id: engine.pose(p.carton.id)[:3, 3] for p in placements}
    finally:
        engine.close()
    return _judged(placements, ends)


def what_stands(stack: PalletStack) -> tuple[PalletStack, DropTest]:
    """Put up as much of a stack as stands in the engine: what makes it move, and all later ones, are left.

    Args:
        stack: The stack.

    Returns:
        What of it stands, found by bisection, with reasons against the rest; and its drop test.
    """

    def tested_first(n: int) -> DropTest:
        return drop_test(stack.order.pallet, stack.placements[:n])

    stands, moves = 0, len(stack.placements)
    tested = tested_first(moves)
    if tested.is_stable:
        return stack, tested
    while moves - stands > 1:
        middle = (stands + moves) // 2
        is_stable = tested_first(middle).is_stable
        stands, moves = (middle, moves) if is_stable else (stands, middle)
    names = [placement.carton.id for placement in stack.placements]
    against = {names[stands]: Failures(tested_first(moves).reasons)}
    after = Failures((Reason("comes after what moves in the engine", names[stands]),))
    left = stack.left | against | dict.fromkeys(names[moves:], after)
    return replace(stack, placements=stack.placements[:stands], left=left), tested_first(stands)


def _judged(placements: Sequence[Placement], ends: dict[str, Array]) -> DropTest:
    sinking, shift, reasons = 0.0, 0.0, []
    for placement in placements:
        off = ends[placement.carton.id] - placement.centre
        down, aside = abs(float(off[2])), float(np.linalg.norm(off[:2]))
        sinking, shift = max(sinking, down), max(shift, aside)
        if down > MOST_SINKING or aside > MOST_SHIFT:
            detail = f"by {1e3 * down:.1f} mm in height, {1e3 * aside:.1f} mm sideways"
            reasons.append(Reason("moves in the engine", placement.carton.id, detail))
    return DropTest(sinking, shift, tuple(reasons))


def _solid(placement: Placement) -> Item:
    """The carton as the engine has it, along the axes of the pallet; its height is kept."""
    x, y, z = placement.size.tolist()
    shape = Shape(ShapeKind.BOX, (x - SHRUNK, y - SHRUNK, z))
    return Item(
        name=placement.carton.id,
        year=0,
        shape=shape,
        mass=placement.carton.mass,
        bonus=0,
        seals={},
        seal_source="",
        why_not="",
        seal_inset=0.0,
        speed_scale=1.0,
        folded="",
        source="",
    )


def _settle(engine: Engine, names: Sequence[str]) -> None:
    """Run until cartons are at rest: the next one comes down on nothing that moves."""
    _run(engine, LEAST)
    for _ in range(round((MOST - LEAST) / TIME_STEP / N_BETWEEN)):
        if (np.array([engine.speed(name) for name in names]) <= RESTING).all():
            return
        _run(engine, N_BETWEEN * TIME_STEP)


def _run(engine: Engine, duration: float) -> None:
    for _ in range(round(duration / TIME_STEP)):
        engine.step()
