"""The first of several alternatives that has a plan, e.g. of the bins into which an item may be stowed."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

from pickcli.errors import NoPlanError

T = TypeVar("T")


def first_plan(query: str, alternatives: Iterable[tuple[str, Callable[[], T]]]) -> T:
    """Plan one alternative after the other, until one has a plan.

    Args:
        query: The query, for the message.
        alternatives: Name and planning function of each, in their order; at least one.

    Returns:
        The result of the first function that returns.

    Raises:
        NoPlanError: No alternative has a plan; with the reasons of each by its name, if there are several.
    """
    failed: list[tuple[str, NoPlanError]] = []
    for name, plan in alternatives:
        try:
            return plan()
        except NoPlanError as error:
            failed.append((name, error))
    if len(failed) == 1:
        raise failed[0][1]
    raise NoPlanError.of_alternatives(query, failed)
