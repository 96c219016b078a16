"""Hierarchical quadratic programs: rows with bounds, in levels of strict priority.

Level p minimizes the norm of w_p subject to lower_p - w_p <= A_p x <= upper_p + w_p, while the violations w_i
of the levels before it, i < p, stay as they are (Kanoun, Lamiraux and Wieber, IEEE T-RO 27(4), 2011; Krug et
al., RA-L 2016, section III-B). The kernel finds the active set of one level after the other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.errors import NoPlanError, Reason
from pickcli.geometry import Array
from pickcli.kernel import PriorityLevel, solve_hierarchy

UNBOUNDED = 1e300  # a bound of this size is none


@dataclass(frozen=True, eq=False)
class BoundedRows:
    """Rows lower <= A x <= upper of one priority.

    Attributes:
        rows: (m, n) A.
        lower: (m,) lower bounds, -inf for none.
        upper: (m,) upper bounds, inf for none; a row with two equal bounds is an equality.
    """

    rows: Array
    lower: Array
    upper: Array

    @classmethod
    def equal(cls, rows: Array, values: Array) -> BoundedRows:
        """Describe equalities A x = b.

        Args:
            rows: (m, n) A.
            values: (m,) b.

        Returns:
            The rows.
        """
        return cls(rows, values, values)

    @classmethod
    def at_most(cls, rows: Array, upper: Array) -> BoundedRows:
        """Describe inequalities A x <= b.

        Args:
            rows: (m, n) A.
            upper: (m,) b.

        Returns:
            The rows.
        """
        return cls(rows, np.full(len(upper), -np.inf), upper)


@dataclass(frozen=True, eq=False)
class Hierarchy:
    """What a hierarchy of levels has in common.

    Attributes:
        x: (n,) the solution.
        violations: Of each level (m,), how far rows are above their upper bounds, or, negative, below the
            lower ones.
    """

    x: Array
    violations: tuple[Array, ...]


def solve(levels: Sequence[BoundedRows], start: Array) -> Hierarchy:
    """Minimize lexicographically the norms of the levels' violations.

    Args:
        levels: The levels, the most important one first.
        start: (n,) where the search begins. Where the least norms do not determine x, it is reached from
            there by steps of least norm.

    Returns:
        The solution.

    Raises:
        ValueError: Shapes do not fit, a value is not finite, or a lower bound is above its upper one.
        NoPlanError: A level has no optimum within 1000 changes of its active set, or later levels moved
            it by over 1e-7, which rounding may do if rows depend on each other but for the last digits.
    """
    found = solve_hierarchy([_level(each) for each in levels], start)
    if found.failure:
        raise NoPlanError("hierarchical QP", [Reason("not solved", "hierarchy", found.failure)])
    return Hierarchy(found.x, tuple(found.violations))


def _level(level: BoundedRows) -> PriorityLevel:
    bounds = (np.clip(each, -UNBOUNDED, UNBOUNDED) for each in (level.lower, level.upper))
    return PriorityLevel(level.rows, *bounds)
