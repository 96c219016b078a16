"""What stored files depend on: cell, configurations, settings and code, as digests."""

from __future__ import annotations

from typing import Any

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.fingerprint import digest
from pickcli.jobs import job


def inputs_digest(cell: Cell, kind: str, settings: Any) -> str:
    """The ``inputs`` of a job of this kind: cell, settings (a dataclass of JSON values) and our code."""
    return digest([kind, cell.fingerprint, configurations_digest(cell), repr(settings), job.code_digest()])


def configurations_digest(cell: Cell) -> str:
    """SHA-256 over the named configurations: bits, tool states and kinds. No fingerprint covers them."""
    named = [
        [c.name, np.asarray(c.q, "<f8").tobytes().hex(), c.tool_state.name, c.kind]
        for c in cell.configurations.values()
    ]
    return digest(named)
