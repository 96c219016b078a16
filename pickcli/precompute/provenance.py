"""Provenance of stored files: digests of cell, configurations, settings and code."""

from __future__ import annotations

from typing import Any

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.fingerprint import digest
from pickcli.jobs import job


def inputs_digest(cell: Cell, kind: str, settings: Any) -> str:
    """Digest all inputs of a job's records besides their keys: cell, settings and this program's code.

    Args:
        cell: The cell.
        kind: Name of the kind of job.
        settings: A dataclass of JSON values.

    Returns:
        SHA-256 in hex.
    """
    return digest([kind, cell.fingerprint, configurations_digest(cell), repr(settings), job.code_digest()])


def configurations_digest(cell: Cell) -> str:
    """Digest the named configurations of a cell: bits, tool states and kinds. No fingerprint covers them.

    Args:
        cell: The cell.

    Returns:
        SHA-256 in hex.
    """
    named = [
        [c.name, np.asarray(c.q, "<f8").tobytes().hex(), c.tool_state.name, c.kind]
        for c in cell.configurations.values()
    ]
    return digest(named)
