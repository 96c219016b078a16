"""A motion validator for tests: a fake decides configurations and edges, everything else follows."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import NDArray

from pickcli.errors import Reason
from pickcli.geometry import Array
from pickcli.kernel import Checker


class FakeValidator(ABC):
    """A motion validator without a kernel."""

    margin = 0.0

    @property
    def kernel(self) -> Checker:
        raise NotImplementedError("a fake has no kernel")

    @abstractmethod
    def is_valid(self, q: Array) -> bool: ...

    def are_valid(self, Q: Array) -> NDArray[np.bool_]:
        return np.array([self.is_valid(q) for q in Q], dtype=bool)

    @abstractmethod
    def first_blocked_edge(self, Q: Array, slack: Array | None = None) -> int: ...

    def is_valid_edge(self, q0: Array, q1: Array) -> bool:
        return self.is_valid_path(np.stack([q0, q1]))

    def is_valid_path(self, Q: Array, slack: Array | None = None) -> bool:
        return self.first_blocked_edge(Q, slack) < 0

    def explain(self, q: Array) -> Reason:
        return Reason("collision", detail="in a fake")

    def explain_path(self, Q: Array, slack: Array | None = None) -> Reason:
        return Reason("collision", detail="in a fake")
