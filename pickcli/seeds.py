"""Seeds derived from one seed and names: they do not depend on what ran before.

So a build gives the same bytes in any order and on any number of workers, and a query does not depend on
those before it.
"""

from __future__ import annotations

import hashlib

import numpy as np


def derived_seed(*parts: object) -> int:
    """A seed from names and numbers, independent of everything but their text.

    Args:
        *parts: What the seed depends on.

    Returns:
        In [1, 2**31); never 0, which OMPL takes for none.
    """
    text = "\x1f".join(str(part) for part in parts)
    return max(1, int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "little") >> 1)


def derived_rng(*parts: object) -> np.random.Generator:
    """A random generator seeded by ``derived_seed``.

    Args:
        *parts: What the seed depends on.

    Returns:
        The generator.
    """
    return np.random.default_rng(derived_seed(*parts))
