"""The only module that imports pybullet, which prints from C when it is imported and when it loads files."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from pickcli.errors import not_installed


@contextmanager
def quiet() -> Iterator[None]:
    """Silence pybullet, which prints from C to stdout and stderr."""
    sys.stdout.flush()
    sys.stderr.flush()
    saved = [os.dup(1), os.dup(2)]
    null = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(null, 1)
        os.dup2(null, 2)
        yield
    finally:
        for stream, copy in enumerate(saved, start=1):
            os.dup2(copy, stream)
            os.close(copy)
        os.close(null)


try:
    with quiet():
        import pybullet as pybullet  # the one place that imports it
except ImportError:
    raise not_installed("pybullet", "sim", "simulation, also where items are put to rest,") from None
