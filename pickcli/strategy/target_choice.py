"""Choice of the next target or action among the open ones."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from pickcli.strategy.node_types import ActionKind, Criterion
from pickcli.strategy.trial_actions import OpenTarget


def best_action(targets: Iterable[OpenTarget]) -> tuple[OpenTarget, ActionKind] | None:
    """Choose the action with the most points per second; if equal, that of the earlier line, and picks first.

    Args:
        targets: The open targets.

    Returns:
        The target and the kind of action; None if there is none.
    """
    found = ((target, kind, rate) for target in targets for kind, rate in target.rates.items())
    best = max(found, key=lambda f: (f[2], -f[0].index, f[1] is ActionKind.PICK), default=None)
    return None if best is None else best[:2]


def first_target(
    targets: Iterable[OpenTarget],
    by: Sequence[str],
    items: Sequence[str] = (),
    bins: Sequence[str] = (),
    attempts_below: int | None = None,
) -> OpenTarget | None:
    """Choose the first target by criteria; if equal by all of them, that of the earlier line.

    Args:
        targets: The open targets.
        by: Names of criteria, the most important first.
        items: Names of items for ``item_priority``, the first ones first.
        bins: Names of bins for ``bin_priority``, the first ones first.
        attempts_below: Only targets with fewer attempts are considered; None for all.

    Returns:
        The target; None if there is none.
    """
    item_rank, bin_rank = _ranks(items), _ranks(bins)

    def key(target: OpenTarget) -> tuple[float, ...]:
        values = {
            Criterion.POINTS_PER_SECOND: -max(target.rates.values(), default=0.0),
            Criterion.POINTS: -float(target.points),
            Criterion.FEWEST_ITEMS: float(target.n_items),
            Criterion.FEWEST_ATTEMPTS: float(target.n_attempts),
            Criterion.ITEM_PRIORITY: float(item_rank.get(target.item, len(item_rank))),
            Criterion.BIN_PRIORITY: float(bin_rank.get(target.bin, len(bin_rank))),
            Criterion.ORDER: float(target.index),
        }
        return (*(values[Criterion(name)] for name in by), float(target.index))

    found = (t for t in targets if attempts_below is None or t.n_attempts < attempts_below)
    return min(found, key=key, default=None)


def _ranks(names: Sequence[str]) -> Mapping[str, int]:
    """Rank of each name, by its first place in the list."""
    return {name: rank for rank, name in reversed(list(enumerate(names)))}
