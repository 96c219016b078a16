"""What is damaged by force, as a referee would grade it.

No team published what its items or the pod bear. The limits are ours, round, and stated here: a cardboard box
of that size is dented by the weight of a few kilograms on a corner, a sheet-metal shelf by that of a person.
Only contacts that no plan allowed are judged; what the cup presses on in a planned contact is bounded by its
bellows.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pickcli.scene.scene import Scene
from pickcli.trial.score import Damage

if TYPE_CHECKING:
    from pickcli.simulation.contacts import Collision

SHELF = "shelf"


@dataclass(frozen=True)
class ForceLimits:
    """Forces at one point of contact from which on damage is done.

    Attributes:
        minor: N, above which damage is minor.
        major: N, above which it is major.
    """

    minor: float
    major: float

    def grade(self, force: float) -> Damage | None:
        """Grade the damage that a force does.

        Args:
            force: N at one point of contact.

        Returns:
            The damage, None if there is none.
        """
        if force > self.major:
            return Damage.MAJOR
        return Damage.MINOR if force > self.minor else None


ITEM_LIMITS = ForceLimits(150.0, 500.0)
SHELF_LIMITS = ForceLimits(500.0, 2000.0)
FRAGILE_LIMITS = ForceLimits(50.0, 150.0)
FRAGILE = ("oreo_mega_stuf", "soft_white_lightbulb")


def damages(scene: Scene, collisions: Iterable[Collision]) -> tuple[tuple[str, Damage], ...]:
    """Grade every item, and the shelf, that was hit too hard.

    Args:
        scene: A scene with every item of the trial.
        collisions: All that were counted.

    Returns:
        Id of the item or name of the shelf, each once, with the worst damage; sorted.
    """
    limits = {p.id: FRAGILE_LIMITS if p.item.name in FRAGILE else ITEM_LIMITS for p in scene.items}
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
