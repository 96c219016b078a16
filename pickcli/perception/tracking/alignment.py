"""Decide which of the tracked items a picture shows, by their order along the belt.

S. Needleman, C. Wunsch, A general method applicable to the search for similarities in the amino acid sequence
of two proteins, 1970; Cowley et al. (2013, III-E) aligned clusters along a conveyor by it. Items do not
overtake each other, so the pairs of the best alignment are in order, and one item that is missed or new
shifts none of the others.
"""

from __future__ import annotations

import numpy as np

from pickcli.geometry import Array


def aligned(gains: Array) -> list[tuple[int, int]]:
    """Find the pairs of two sequences in order whose gains sum up to the most.

    Args:
        gains: (N, M) gain of pairing element i of one sequence with j of the other; what is not positive
            never pairs. An element without a partner gains nothing.

    Returns:
        Pairs (i, j), both increasing.
    """
    n, m = gains.shape
    best = np.zeros((n + 1, m + 1))  # of the first i and the first j elements
    for i in range(n):
        for j in range(m):
            alone = max(best[i, j + 1], best[i + 1, j])
            best[i + 1, j + 1] = max(alone, best[i, j] + gains[i, j])
    pairs, i, j = [], n, m
    while i > 0 and j > 0:
        if best[i, j] == best[i - 1, j]:
            i -= 1
        elif best[i, j] == best[i, j - 1]:
            j -= 1
        else:
            i, j = i - 1, j - 1
            pairs.append((i, j))
    return pairs[::-1]
