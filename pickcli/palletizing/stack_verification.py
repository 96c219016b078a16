"""Second opinion on a stack: judges its file with algorithms of its own, and trusts nothing that it states.

That a carton stands is proven by the polygon that the file states for it (Z. Gao et al., arXiv 2507.09123):
it must be in the convex hull of the contacts with the polygons of what bears it, which a linear program
decides without building hull or contacts (E. Balas, "Disjunctive programming and a hierarchy of relaxations",
SIAM J. Alg. Disc. Meth. 6(3), 1985), and the centre of mass must be in it wherever it may be. By induction
from the deck, forces then exist that hold all cartons at once, at any time while the stack is put up.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.palletizing.pallet_order import CENTRE_ERROR, LEVEL, PalletOrder, least_contact
from pickcli.palletizing.pallet_stack import Placement
from pickcli.palletizing.pallet_stack_file import StackedPallet

TOLERANCE = 5e-6  # m, of figures that a file rounds
MASS_TOLERANCE = 2e-3  # kg, likewise


@dataclass(frozen=True)
class StackVerdict:
    """Result of the verification of a stack.

    Attributes:
        reasons: Against the stack; none if it is accepted.
        clearance: m, least between a carton that comes down and those beside it; infinite if there is none.
        margin: m, by which centres of mass, wherever they may be, are inside their polygons at least.
        load_share: Most that stands on a carton, as a share of what it bears.
    """

    reasons: tuple[Reason, ...]
    clearance: float
    margin: float
    load_share: float


def verify_stack(stack: StackedPallet, order: PalletOrder | None = None) -> StackVerdict:
    """Judge a stack.

    Args:
        stack: What its file says.
        order: Order that it must be a stack of, if any.

    Returns:
        The verdict, with every fault.
    """
    views = [_View(stack, k) for k in range(len(stack.placements))]
    reasons = [reason for view in views for reason in view.faults()]
    loads = _loads(stack)
    reasons += _overloads(stack, loads)
    if order is not None:
        reasons += _strays(stack, order)
    shares = (loads[p.carton.id] / p.carton.bears for p in stack.placements if p.carton.bears > 0.0)
    return StackVerdict(
        tuple(reasons),
        min((view.clearance for view in views), default=np.inf),
        min((view.margin for view in views), default=np.inf),
        max(shares, default=0.0),
    )


class _View:
    """One carton as it comes to its place, among those before it.

    Args:
        stack: The stack.
        k: Index of the carton.
    """

    def __init__(self, stack: StackedPallet, k: int) -> None:
        self._stack, self._it = stack, stack.placements[k]
        self._earlier = stack.placements[:k]
        low = np.array([p.low for p in self._earlier]).reshape(-1, 3)
        self._tops = np.array([p.high[2] for p in self._earlier])
        high = low + np.array([p.size for p in self._earlier]).reshape(-1, 3)
        self._gaps = np.maximum(
            low - self._it.high, self._it.low - high
        )  # (k, 3) m, negative where they overlap
        self._aside = self._gaps[:, :2].max(axis=1)  # (k,) m between them, seen from above

    @property
    def clearance(self) -> float:
        """Distance (m) between its way down and what is beside that."""
        return float(self._aside[self._tops > self._it.low[2] + LEVEL + TOLERANCE].min(initial=np.inf))

    @property
    def margin(self) -> float:
        """Length (m) by which its centre of mass, wherever it may be, is in its polygon; negative outside."""
        return self._inside(self._centres)

    @property
    def rise(self) -> float:
        """Rise (m) of its middle if it turns about the nearest edge of its polygon; 0 outside."""
        half = float(self._it.size[2]) / 2
        return float(np.hypot(max(self._inside(self._it.centre[None, :2]), 0.0), half)) - half

    def _inside(self, points: Array) -> float:
        """Return m by which points (N, 2) are in its polygon at least; negative outside."""
        from scipy.spatial import ConvexHull, QhullError

        try:
            equations = ConvexHull(self._it.bears_within).equations
        except (QhullError, ValueError):  # fewer than three corners, or on a line
            return -np.inf
        return -float((points @ equations[:, :2].T + equations[:, 2]).max())

    @property
    def _centres(self) -> Array:
        """(4, 2) m, the farthest places of the centre of mass."""
        off = CENTRE_ERROR * self._it.size[:2]
        return np.array([self._it.centre[:2] + off * sign for sign in ((-1, -1), (-1, 1), (1, -1), (1, 1))])

    def faults(self) -> Iterator[Reason]:
        """Yield what is wrong with it."""
        for what, detail in (*self._room(), *self._way_down(), *self._support()):
            yield Reason(what, self._it.carton.id, detail)

    def _room(self) -> Iterator[tuple[str, str]]:
        pallet = self._stack.pallet
        low, high = pallet.room(self._stack.clearance)
        over = max((low - self._it.low[:2]).max(), (self._it.high[:2] - high).max())
        if over > TOLERANCE:
            yield "over the edge of the pallet", f"by {_mm(over)}"
        over = float(self._it.high[2]) + pallet.deck - pallet.height
        if over > TOLERANCE:
            yield "too high", f"by {_mm(over)}"
        for other, gap in zip(self._earlier, self._gaps.max(axis=1).tolist(), strict=True):
            if gap < -TOLERANCE:
                yield "overlaps", f"{other.carton.id}, by {_mm(-gap)}"

    def _way_down(self) -> Iterator[tuple[str, str]]:
        top = float(self._tops.max(initial=0.0))
        if self._it.from_above <= top - TOLERANCE:
            yield "its way down begins too low", f"{_mm(top - self._it.from_above)} below the highest carton"
        is_in_the_way = self._tops > self._it.low[2] + LEVEL + TOLERANCE
        is_in_the_way &= self._aside < self._stack.clearance - TOLERANCE
        for k in np.flatnonzero(is_in_the_way).tolist():
            gap = f"{_mm(self._aside[k])} beside it, {_mm(self._stack.clearance)} are to be kept"
            yield "meets another on its way down", f"{self._earlier[k].carton.id}, {gap}"

    def _support(self) -> Iterator[tuple[str, str]]:
        base = float(self._it.low[2])
        bearers = [p for p in self._earlier if p.carton.id in self._it.rests_on]
        is_level = np.abs(self._tops - base) <= LEVEL + TOLERANCE
        for k, other in enumerate(self._earlier):
            is_stated = other in bearers
            if is_stated and not (is_level[k] and self._aside[k] < TOLERANCE):
                yield "does not rest on what is stated", other.carton.id
            if not is_stated and base > TOLERANCE and is_level[k] and self._aside[k] < -TOLERANCE:
                yield "rests on what is not stated", other.carton.id
        highest = max((float(p.high[2]) for p in bearers), default=0.0)
        if abs(base - highest) > TOLERANCE or (bearers and base <= TOLERANCE):
            yield (
                "hangs in the air" if base > highest else "is sunk in what bears it",
                f"by {_mm(abs(base - highest))}",
            )
        for corner in self._it.bears_within:
            off = _outside(corner, self._it, bearers, least_contact(self._stack.clearance))
            if off > TOLERANCE:
                where = f"a corner is {_mm(off)} outside" if np.isfinite(off) else "nothing bears a corner"
                yield "is not borne within its polygon", where
                break
        if bearers and self.rise < self._stack.fall - TOLERANCE:
            over = f"its middle rises by {_mm(self.rise)} over the nearest edge of what bears it"
            yield "would tip as it lands", f"{over}, it may fall by {_mm(self._stack.fall)}"
        if self.margin < -TOLERANCE:
            why = f"its centre of mass may be {_mm(-self.margin)} outside of what bears it"
            yield "would tip", why if np.isfinite(self.margin) else "its polygon of what bears it has no area"


def _outside(corner: Array, it: Placement, bearers: Sequence[Placement], width: float) -> float:
    """Return m by which a point (2,) is outside of the hull of where a carton is borne.

    It is a mean of points, at most one in the contact with each bearer, that are means of corners of that
    one's polygon; contacts narrower than a width bear nothing. Unknowns are the weights of all these corners,
    and the slack.
    """
    from scipy.optimize import linprog

    if not bearers:
        return float(np.maximum(it.low[:2] - corner, corner - it.high[:2]).max())
    polygons, above = [], []
    for p in bearers:
        low, high = np.maximum(p.low, it.low)[:2], np.minimum(p.high, it.high)[:2]
        if (high - low).min() >= width - TOLERANCE and len(p.bears_within):
            polygons.append(p.bears_within)
            above.append(
                np.vstack([(low - p.bears_within).T, (p.bears_within - high).T])
            )  # (4, corners) <= 0
    if not polygons:
        return np.inf
    n = sum(map(len, polygons))
    inside, at = np.zeros((4 * len(above), n + 4)), 0
    for k, block in enumerate(above):
        inside[4 * k : 4 * k + 4, at : at + block.shape[1]] = block
        at += block.shape[1]
    mean = np.zeros((3, n + 4))
    mean[:2, :n], mean[2, :n] = np.concatenate(polygons).T, 1.0
    mean[:2, n:] = np.hstack([np.eye(2), -np.eye(2)])
    found = linprog(
        np.append(np.zeros(n), np.ones(4)), A_ub=inside, b_ub=np.full(len(inside), TOLERANCE / 2), A_eq=mean,
        b_eq=np.append(corner, 1.0), bounds=(0.0, None), method="highs-ds",
    )  # fmt: skip
    return float(found.fun) if found.status == 0 else np.inf


def _loads(stack: StackedPallet) -> dict[str, float]:
    """Return kg that stand on each carton, directly or through others, each counted whole."""
    loads = {p.carton.id: 0.0 for p in stack.placements}
    below: dict[str, set[str]] = {}
    for p in stack.placements:
        below[p.carton.id] = set(p.rests_on).union(*(below[name] for name in p.rests_on))
        for name in sorted(below[p.carton.id]):
            loads[name] += p.carton.mass
    return loads


def _overloads(stack: StackedPallet, loads: dict[str, float]) -> Iterator[Reason]:
    for p in stack.placements:
        load, name = loads[p.carton.id], p.carton.id
        if load > p.carton.bears + MASS_TOLERANCE:
            yield Reason("overloaded", name, f"{load:g} kg stand on it, it bears {p.carton.bears:g} kg")
        if abs(load - stack.loads[name]) > MASS_TOLERANCE:
            yield Reason(
                "another load is stated", name, f"{load:g} kg stand on it, not {stack.loads[name]:g}"
            )
    mass = sum(p.carton.mass for p in stack.placements)
    if mass > stack.pallet.bears + MASS_TOLERANCE:
        yield Reason(
            "overloaded", "the pallet", f"{mass:g} kg stand on it, it bears {stack.pallet.bears:g} kg"
        )


def _strays(stack: StackedPallet, order: PalletOrder) -> Iterator[Reason]:
    """Yield where a stack is not that of an order."""
    if (stack.pallet, stack.clearance, stack.fall) != (order.pallet, order.clearance, order.fall):
        yield Reason("is for another pallet, clearance or fall", "the order")
    ordered = {carton.id: carton for carton in order.cartons}
    for p in stack.placements:
        if ordered.get(p.carton.id) != p.carton:
            known = "it has another size, mass or load there" if p.carton.id in ordered else ""
            yield Reason("is not in the order", p.carton.id, known)
    placed = {p.carton.id for p in stack.placements}
    for name in ordered:
        if (name in placed) == (name in stack.left):
            yield Reason("is both stacked and left" if name in placed else "is missing", name)


def _mm(length: float) -> str:
    return f"{1e3 * length:.3g} mm"
