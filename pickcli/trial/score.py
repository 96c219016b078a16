"""Score of a trial by the official rules of 2015 and 2016, itemised. See docs/scoring.md.

Pure functions of an order and the true final state. Sources: the transcription of the 2016 rules in
start-jsk/jsk_apc (doc/apc2016_rules.rst) and the 2015 score calculator of the same team.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from pickcli.cell.cell import Cell
from pickcli.scene.scene import TOTE
from pickcli.simulation.places import OUTSIDE
from pickcli.trial.damage import Damage
from pickcli.trial.final_state import Drop, FinalItem, FinalState
from pickcli.trial.order import Order, OrderKind, Target


@dataclass(frozen=True)
class ScoringRules:
    """The points of one year.

    Attributes:
        fill: Pairs of the least number of items in the bin at the start, and the points for a target of it.
        outside: Points for an item outside of bins and tote.
        wrong_claim: Points for an item claimed at a wrong place.
        protruding: Points for an item that protrudes from its bin by more than ``protrusion_limit``.
        high_drop: Points for a fall of more than ``drop_limit``, released or not.
        lost_target: Points for a target lost by the tool, from any height.
        wrong_item: Points for an item that is not a target and was moved out of its bin.
        damage: Points by grade of damage.
        drop_limit: m.
        protrusion_limit: m.
    """

    fill: tuple[tuple[int, int], ...]
    outside: int = 0
    wrong_claim: int = 0
    protruding: int = 0
    high_drop: int = 0
    lost_target: int = 0
    wrong_item: int = 0
    damage: Mapping[Damage, int] = field(default_factory=dict)
    drop_limit: float = 0.3
    protrusion_limit: float = 0.005

    def fill_points(self, n_items: int) -> int:
        """Return the points for a target by the number of items in its bin.

        Args:
            n_items: Number of items in the bin at the start.

        Returns:
            Points.
        """
        return next((points for n, points in self.fill if n_items >= n), self.fill[-1][1])


RULES = {
    2016: ScoringRules(
        fill=((5, 20), (3, 15), (1, 10)),
        outside=-10, wrong_claim=-10, protruding=-5, high_drop=-5,
        damage={Damage.MINOR: -5, Damage.MAJOR: -20},
    ),
    2015: ScoringRules(
        fill=((3, 20), (2, 15), (1, 10)),
        lost_target=-3, wrong_item=-12,
        damage={Damage.MINOR: -5, Damage.MAJOR: -5},
    ),
}  # fmt: skip


@dataclass(frozen=True)
class ScoreLine:
    """One line of the score. A missed target is a line of 0 points.

    Attributes:
        points: Points, negative for a penalty.
        subject: Id of an item, or a name.
        reason: What the points are for.
    """

    points: int
    subject: str
    reason: str


@dataclass(frozen=True)
class Score:
    """All lines of a score, with the largest possible total.

    Attributes:
        lines: The lines.
        maximum: Points for all targets without penalties.
    """

    lines: tuple[ScoreLine, ...]
    maximum: int

    @property
    def total(self) -> int:
        """Sum of the lines; may be negative."""
        return sum(line.points for line in self.lines)


def item_bonuses(cell: Cell, order: Order) -> dict[str, int]:
    """Return the bonus of every item of an order, by the rules of its year.

    Args:
        cell: The cell, for its items.
        order: The order.

    Returns:
        Points by name of the item.
    """
    names = set(order.tote_contents).union(*order.bin_contents.values())
    return {name: cell.item(name, order.year).bonus for name in sorted(names)}


def target_points(order: Order, bin_name: str, item: str, bonus: Mapping[str, int]) -> int:
    """Return the points for one item moved out of (stow: into) a bin; 1 for each of an order's moves.

    Args:
        order: The order.
        bin_name: Name of the bin.
        item: Name of the item.
        bonus: Points by name of the item, as from ``item_bonuses``.

    Returns:
        Points.
    """
    if order.kind is OrderKind.MOVE:
        return 1
    n_items = len(order.bin_contents.get(bin_name, ()))
    return RULES[order.year].fill_points(n_items) + bonus.get(item, 0)


def maximum_score(order: Order, bonus: Mapping[str, int]) -> int:
    """Return the largest possible score: all targets without penalties.

    Args:
        order: The order.
        bonus: Points by name of the item, as from ``item_bonuses``.

    Returns:
        Points.
    """
    if order.kind is not OrderKind.STOW:
        return sum(target_points(order, t.bin, t.item, bonus) for t in order.work_order)
    bins = order.bin_contents
    return sum(max(target_points(order, b, name, bonus) for b in bins) for name in order.tote_contents)


def score(order: Order, final: FinalState, bonus: Mapping[str, int]) -> Score:
    """Score a final state; for moves the number of items at their destinations. The item order is irrelevant.

    Args:
        order: The order that was played.
        final: The final state.
        bonus: Points by name of the item, as from ``item_bonuses``.

    Returns:
        The score, line by line.
    """
    items = tuple(sorted(final.items, key=lambda item: item.id))
    if order.kind is OrderKind.MOVE:
        return Score(tuple(_moved(order, items)), maximum_score(order, bonus))
    delivered = _delivered(order, items)
    lines = [
        *(_picked if order.kind is OrderKind.PICK else _stowed)(order, items, delivered, bonus),
        *_places(order, items, delivered),
        *_claims(order, items, final.claim),
        *_falls(order, items, final.drops),
        *_damages(order, final.damages),
    ]
    return Score(tuple(lines), maximum_score(order, bonus))


def told_by_copies(score: Score, targets: Sequence[Target], delivered: Mapping[int, str]) -> Score:
    """Give each target the line of the copy that was delivered for it: the rules do not tell copies apart.

    Args:
        score: A score, whose first lines are those of the targets.
        targets: The targets, in the order of these lines.
        delivered: Id of the delivered copy by index of its target.

    Returns:
        The same lines, perhaps exchanged between targets that are alike.
    """
    left, mine = list(range(len(targets))), dict[int, int]()
    for is_sure in (True, False):
        for k, target in enumerate(targets):
            alike = [i for i in left if targets[i] == target]
            own = [i for i in alike if score.lines[i].subject == delivered.get(k)] if is_sure else alike
            if k not in mine and own:
                mine[k] = own[0]
                left.remove(own[0])
    lines = (score.lines[mine[k]] for k in range(len(targets)))
    return replace(score, lines=(*lines, *score.lines[len(targets) :]))


def _delivered(order: Order, items: tuple[FinalItem, ...]) -> dict[str, str]:
    """Instances that fulfil the order, with the bin that counts, by id. Spare copies fulfil nothing."""
    if order.kind is not OrderKind.PICK:
        return {i.id: i.end for i in items if i.start == TOTE and i.end in order.bin_contents}
    wanted = Counter((target.bin, target.item) for target in order.work_order)
    delivered = {}
    for item in items:
        if item.end == TOTE and wanted[item.start, item.name] > 0:
            wanted[item.start, item.name] -= 1
            delivered[item.id] = item.start
    return delivered


def _moved(order: Order, items: tuple[FinalItem, ...]) -> Iterator[ScoreLine]:
    """Yield one point for every move with its own copy at the destination."""
    arrived = [item for item in items if item.end != item.start]
    for move in order.work_order:
        wanted = (move.bin, move.item, move.into)
        copy = next((i for i in arrived if (i.start, i.name, i.end) == wanted), None)
        if copy is None:
            yield ScoreLine(0, move.item, f"from {move.bin} is not in {move.into}")
            continue
        arrived.remove(copy)
        yield ScoreLine(1, copy.id, f"from {move.bin} is in {move.into}")


def _picked(
    order: Order, items: tuple[FinalItem, ...], delivered: Mapping[str, str], bonus: Mapping[str, int]
) -> Iterator[ScoreLine]:
    open_copies = [item for item in items if item.id in delivered]
    for target in order.work_order:
        copy = next((i for i in open_copies if (i.start, i.name) == (target.bin, target.item)), None)
        if copy is None:
            yield ScoreLine(0, target.item, f"target of {target.bin} is not in the tote")
            continue
        open_copies.remove(copy)
        points = target_points(order, target.bin, target.item, bonus)
        yield ScoreLine(points, copy.id, f"target from {_worth(order, target.bin, target.item, bonus)}")


def _stowed(
    order: Order, items: tuple[FinalItem, ...], delivered: Mapping[str, str], bonus: Mapping[str, int]
) -> Iterator[ScoreLine]:
    # Copies in bins count first, as the order does not distinguish copies.
    left = sorted((i for i in items if i.start == TOTE), key=lambda i: i.id not in delivered)
    for name in order.tote_contents:
        item = next(i for i in left if i.name == name)
        left.remove(item)
        if item.id in delivered:
            points = target_points(order, item.end, item.name, bonus)
            yield ScoreLine(points, item.id, f"stowed into {_worth(order, item.end, item.name, bonus)}")
        else:
            yield ScoreLine(0, item.id, "is in no bin")


def _worth(order: Order, bin_name: str, item: str, bonus: Mapping[str, int]) -> str:
    extra = f", item bonus {bonus[item]}" if bonus.get(item) else ""
    return f"{bin_name}, which started with {len(order.bin_contents[bin_name])}{extra}"


def _places(order: Order, items: tuple[FinalItem, ...], delivered: Mapping[str, str]) -> Iterator[ScoreLine]:
    rules = RULES[order.year]
    for item in items:
        if item.end == OUTSIDE and rules.outside:
            yield ScoreLine(rules.outside, item.id, "left outside bins and tote")
        if item.end in order.bin_contents and item.protrusion > rules.protrusion_limit and rules.protruding:
            millimetres = f"{1000 * item.protrusion:.1f} mm"
            yield ScoreLine(rules.protruding, item.id, f"stands {millimetres} out of {item.end}")
        # A moved target is never a wrong item, at any final place.
        is_target = any((t.bin, t.item) == (item.start, item.name) for t in order.work_order)
        is_spare = item.end == TOTE and item.id not in delivered
        if rules.wrong_item and item.end != item.start and (is_spare or not is_target):
            yield ScoreLine(rules.wrong_item, item.id, f"no target, but moved from {item.start}")


def _claims(order: Order, items: tuple[FinalItem, ...], claim: Order | None) -> Iterator[ScoreLine]:
    """Compare claimed and actual names by place, as copies are indistinguishable in the file."""
    points = RULES[order.year].wrong_claim
    if claim is None or not points:
        return
    places = {**claim.bin_contents, TOTE: claim.tote_contents}
    claimed = Counter((name, place) for place, names in places.items() for name in names)
    actual = Counter((item.name, item.end) for item in items if item.end in places)
    for name in sorted({name for name, _ in claimed | actual}):
        false_claims = [p for (n, p), k in (claimed - actual).items() if n == name for _ in range(k)]
        unclaimed = [p for (n, p), k in (actual - claimed).items() if n == name for _ in range(k)]
        for i in range(max(len(false_claims), len(unclaimed))):
            said = false_claims[i] if i < len(false_claims) else "nowhere"
            true = unclaimed[i] if i < len(unclaimed) else "not there"
            yield ScoreLine(points, name, f"output file says {said}, the item is {true}")


def _falls(order: Order, items: tuple[FinalItem, ...], drops: tuple[Drop, ...]) -> Iterator[ScoreLine]:
    rules = RULES[order.year]
    by_id = {item.id: item for item in items}
    targets = {(target.bin, target.item) for target in order.work_order}
    for drop in sorted(drops, key=lambda d: (d.item, d.height)):
        if drop.height > rules.drop_limit and rules.high_drop:
            yield ScoreLine(rules.high_drop, drop.item, f"fell {drop.height:.2f} m")
        item = by_id.get(drop.item)
        is_target = item is not None and (item.start, item.name) in targets
        if rules.lost_target and is_target and not drop.is_release:
            yield ScoreLine(rules.lost_target, drop.item, f"target dropped from {drop.height:.2f} m")


def _damages(order: Order, damages: tuple[tuple[str, Damage], ...]) -> Iterator[ScoreLine]:
    for what, damage in sorted(damages):
        yield ScoreLine(RULES[order.year].damage[damage], what, f"{damage} damage")
