"""Log of unplanned contacts of the robot and of the held item."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from pickcli.simulation.engine import ContactPoint
from pickcli.simulation.planned_contacts import PlannedContacts

FORGET_TIME = 0.1  # s without contact after which a pair is logged again
HELD_PRESS = 30.0  # N at one point, largest planned force on a body of a held item of up to 3 kg on a corner


@dataclass(frozen=True)
class Collision:
    """One unplanned contact, from beginning to end.

    Attributes:
        a: Link of the robot, or the held item.
        b: The touched body or item.
        t_start: s, simulated.
        t_end: s, simulated.
        depth: m, deepest overlap.
        position: m in the world, of the deepest point.
        force: N, largest at one point.
    """

    a: str
    b: str
    t_start: float
    t_end: float
    depth: float
    position: tuple[float, float, float]
    force: float


class ContactLog:
    """Collects unplanned contacts step by step.

    Args:
        robot: Name of the robot's body.
        links: The contact links, cup or fingers, which may touch what the current segment allows.
        exempt: Pairs (link, body or other link) that are never counted.
        max_press: N, largest force of the bellows or fingers. A larger force on a planned contact counts as
            unplanned, and so does one of the held item above ``HELD_PRESS``, or above its weight if that is
            more: it may stand on one corner.
        earlier: Collisions logged before.
    """

    def __init__(
        self,
        robot: str,
        links: tuple[str, ...],
        exempt: frozenset[tuple[str, str]],
        max_press: float,
        earlier: Iterable[Collision] = (),
    ) -> None:
        self._robot, self._links, self._exempt, self._max_press = robot, links, exempt, max_press
        self._open: dict[tuple[str, str], Collision] = {}
        self._closed = list(earlier)

    @property
    def collisions(self) -> tuple[Collision, ...]:
        """All collisions so far, in the order of their start, including ongoing ones."""
        return tuple(sorted([*self._closed, *self._open.values()], key=lambda c: (c.t_start, c.a, c.b)))

    def since(self, t: float) -> tuple[Collision, ...]:
        """Return the collisions that began or continued after a time.

        Args:
            t: s, simulated.

        Returns:
            The collisions.
        """
        return tuple(c for c in self.collisions if c.t_end > t)

    def update(
        self,
        points: Iterable[ContactPoint],
        planned: PlannedContacts,
        held: str | None,
        t: float,
        held_weight: float = 0.0,
    ) -> None:
        """Check the contact points of robot and held item in one step.

        Args:
            points: Contact points.
            planned: The contacts allowed at present.
            held: Name of the held item, or None.
            t: s, simulated.
            held_weight: N, of the held item.
        """
        for pair in [pair for pair, c in self._open.items() if t - c.t_end > FORGET_TIME]:
            self._closed.append(self._open.pop(pair))
        for point in points:
            a, b = self._pair(point)
            most = self._most(a, b, planned, held, max(HELD_PRESS, held_weight))
            if point.force > most:
                self._record(a, b, point, t)

    def _pair(self, point: ContactPoint) -> tuple[str, str]:
        if point.a == self._robot:
            return point.link_a, point.link_b or point.b
        return point.a, point.link_b or point.b

    def _most(self, a: str, b: str, planned: PlannedContacts, held: str | None, most_held: float) -> float:
        """Largest allowed force of a pair at one point, N; negative if no contact is allowed.

        most_held: N, of the held item on what it is planned to touch
        """
        is_of_hold = a == held and b in self._links
        if (a, b) in self._exempt or held == b or is_of_hold:
            return np.inf  # contacts of the held item are judged from its side
        if a == held and (b in planned.touching or b in planned.held):
            return most_held
        return self._max_press if a in self._links and b in planned.met else -1.0

    def _record(self, a: str, b: str, point: ContactPoint, t: float) -> None:
        known = self._open.get((a, b))
        if known is None:
            self._open[a, b] = Collision(a, b, t, t, point.depth, point.position, point.force)
            return
        deepest = point if point.depth > known.depth else None
        self._open[a, b] = replace(
            known,
            t_end=t,
            depth=deepest.depth if deepest else known.depth,
            position=deepest.position if deepest else known.position,
            force=max(known.force, point.force),
        )
