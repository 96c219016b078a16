"""OMPL's RRTConnect, states tested by python-fcl with forward kinematics in numpy."""

from __future__ import annotations

from typing import Any

from ompl import util

from bench.peers.fcl_world import FclScene
from bench.peers.ompl_peer import OmplPeer

PACKAGES = ("ompl", "python-fcl")


class Peer(OmplPeer):
    """See ``worker``."""

    def prepare(self, query: dict[str, Any], number: int) -> None:
        """Everything that does not count as planning."""
        util.RNG.setSeed(number + 1)
        self.is_free = FclScene(self.problem, query, self.problem["margin"]).is_free
