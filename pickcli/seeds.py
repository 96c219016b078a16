"""Seeds derived from one seed and names, independent of what ran before.

So a build gives the same bytes in any order and on any number of workers, and a query does not depend on
earlier ones.
"""

from __future__ import annotations

import hashlib

import numpy as np


def derived_seed(*parts: object) -> int:
    """Derive a seed from names and numbers; it depends only on their text.

    Args:
        *parts: Parts that determine the seed.

    Returns:
        In [1, 2**31); never 0, which OMPL treats as unset.
    """
    text = "\x1f".join(str(part) for part in parts)
    return max(1, int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "little") >> 1)


def derived_rng(*parts: object) -> np.random.Generator:
    """Return a random generator seeded by ``derived_seed``.

    Args:
        *parts: Parts that determine the seed.

    Returns:
        The generator.
    """
    return np.random.default_rng(derived_seed(*parts))
