"""Seeds that depend on names, not on order."""

from __future__ import annotations

import hashlib


def derive_seed(seed: int, *labels: str) -> int:
    """A seed in [1, 2**31) for one task of a larger run.

    The same labels give the same seed whatever ran before, so that a build gives the same bytes in any
    order and on any number of workers.
    """
    text = "\x00".join((str(seed), *labels)).encode()
    return 1 + int.from_bytes(hashlib.sha256(text).digest()[:8], "big") % (2**31 - 1)
