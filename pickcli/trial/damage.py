"""Damage by contact forces, graded as a referee would.

No team published load limits of its items or the pod. The limits here are round assumptions: a cardboard box
of this size is dented by a few kilograms on a corner, a sheet-metal shelf by the weight of a person. Only
unplanned contacts are judged; forces in planned contacts of the cup are limited by its bellows.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

from pickcli.scene.scene import Scene

if TYPE_CHECKING:
    from pickcli.simulation.contacts import Collision

SHELF = "shelf"


class Damage(StrEnum):
    """Damage to an item or the shelf, as a referee would grade it."""

    MINOR = "minor"
    MAJOR = "major"


@dataclass(frozen=True)
class ForceLimits:
    """Forces at one contact point from which damage occurs.

    Attributes:
        minor: N, above which damage is minor.
        major: N, above which it is major.
    """

    minor: float
    major: float

    def grade(self, force: float) -> Damage | None:
        """Grade the damage caused by a force.

        Args:
            force: N at one point of contact.

        Returns:
            The damage, or None.
        """
        if force > self.major:
            return Damage.MAJOR
        return Damage.MINOR if force > self.minor else None


ITEM_LIMITS = ForceLimits(150.0, 500.0)
SHELF_LIMITS = ForceLimits(500.0, 2000.0)
FRAGILE_LIMITS = ForceLimits(50.0, 150.0)


def damages(scene: Scene, collisions: Iterable[Collision]) -> tuple[tuple[str, Damage], ...]:
    """Grade the damage to all items and the shelf.

    Args:
        scene: A scene with every item of the trial.
        collisions: All unplanned contacts.

    Returns:
        Ids of damaged items, or the name of the shelf, each once with the worst grade; sorted.
    """
    limits = {p.id: FRAGILE_LIMITS if p.item.is_fragile else ITEM_LIMITS for p in scene.items}
    pod = {body.name for body in scene.cell.pod.bodies}
    worst: dict[str, Damage] = {}
    for collision in collisions:
        for name in (collision.a, collision.b):
            what = SHELF if name in pod else name
            bears = SHELF_LIMITS if what == SHELF else limits.get(name)
            grade = None if bears is None else bears.grade(collision.force)
            if grade is not None and worst.get(what) is not Damage.MAJOR:
                worst[what] = grade
    return tuple(sorted(worst.items()))
