"""Highest speeds at which the tool may meet the target of a pick, one for all grasps with the same press."""

from __future__ import annotations

from collections.abc import Hashable

import numpy as np

from pickcli.collision.stage_contacts import PickContacts
from pickcli.grasping.grasp_method import GraspMethod
from pickcli.motion.plan import Grasp

SAME_PRESS = 1e-9  # m, and share of a unit vector: grasps that press on the same point in the same direction


class ContactSpeeds:
    """Highest speeds at which the tool may meet a target, each computed once.

    Args:
        method: How the tool grasps.
        contacts: The scene, the target in it, and its support.
    """

    def __init__(self, method: GraspMethod, contacts: PickContacts) -> None:
        self._method, self._contacts = method, contacts
        self._known: dict[Hashable, float | None] = {}

    def of(self, grasp: Grasp) -> float | None:
        """Return the highest speed for a grasp; turns about the tool's axis do not change it.

        Args:
            grasp: Grasp of the target.

        Returns:
            m/s; None if the tool tips the target at any useful speed.
        """
        at = np.rint(grasp.T_item_tip[:3, 2:] / SAME_PRESS).astype(np.int64).tobytes()
        press = (grasp.kind, grasp.face, grasp.tool_state, at)
        if press not in self._known:
            self._known[press] = self._method.contact_speed(self._contacts, grasp)
        return self._known[press]
