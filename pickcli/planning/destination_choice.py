"""Choice of the destination of an item: the first of several with a plan, e.g. of the bins for a stow."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from pickcli.errors import NoExtractionError, NoPlanError

T = TypeVar("T")


def plan_into_first(query: str, destinations: Sequence[str], plan_into: Callable[[str], T]) -> T:
    """Plan into one destination after the other, until one has a plan.

    Args:
        query: The query, for the message.
        destinations: Names of the places, in the order in which they are tried; at least one.
        plan_into: Plans into a place, or raises NoPlanError.

    Returns:
        The first result.

    Raises:
        NoExtractionError: The item cannot leave the place that it is in; no other destination is tried.
        NoPlanError: No destination has a plan; with the reasons of each by its name, if there are several.
    """
    failed: list[tuple[str, NoPlanError]] = []
    for name in destinations:
        try:
            return plan_into(name)
        except NoPlanError as error:
            failed.append((name, error))
            if isinstance(error, NoExtractionError):
                break
    if len(failed) == 1:
        raise failed[0][1]
    raise NoPlanError.of_alternatives(query, failed)
