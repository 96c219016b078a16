"""Unplanned contacts of the robot or the item it holds, each logged once."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from pickcli.simulation.engine import ContactPoint
from pickcli.simulation.planned_contacts import PlannedContacts

FORGET_TIME = 0.1  # s without contact after which the same pair counts again
HELD_PRESS = (
    30.0  # N at one point by which a held item may press on what it is planned to touch: 3 kg on a corner
)


@dataclass(frozen=True)
class Collision:
    """One contact that no plan allows, from its first to its last moment.

    Attributes:
        a: Link of the robot, or the held item.
        b: Body or item that it touched.
        t_start: s, simulated.
        t_end: s, simulated.
        depth: m, deepest overlap.
        position: m in the world, where it was deepest.
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
    """Collects collisions step by step.

    Args:
        robot: Name of the robot's body.
        links: The cup, or the fingers: those links that may touch what the present segment allows.
        exempt: Pairs (link, body or other link) that are never counted.
        max_press: N, what the bellows push with at most, or fingers. A contact of theirs above that is not a
            planned one, nor is one of the held item above ``HELD_PRESS``.
        earlier: Collisions of before, which are kept.
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
        """All collisions so far, in the order of their start, each with what it has come to by now."""
        return tuple(sorted([*self._closed, *self._open.values()], key=lambda c: (c.t_start, c.a, c.b)))

    def since(self, t: float) -> tuple[Collision, ...]:
        """Collisions that began or went on after a time.

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
    ) -> None:
        """Judge the contact points of one step of the robot and of the held item.

        Args:
            points: Contact points.
            planned: What may be touched now.
            held: Name of the held item, or None.
            t: s, simulated.
        """
        for pair in [pair for pair, c in self._open.items() if t - c.t_end > FORGET_TIME]:
            self._closed.append(self._open.pop(pair))
        for point in points:
            a, b = self._pair(point)
            most = self._most(a, b, planned, held)
            if point.force > most:
                self._record(a, b, point, t)

    def _pair(self, point: ContactPoint) -> tuple[str, str]:
        if point.a == self._robot:
            return point.link_a, point.link_b or point.b
        return point.a, point.link_b or point.b

    def _most(self, a: str, b: str, planned: PlannedContacts, held: str | None) -> float:
        """N with which a pair may press at one point; negative where it may not touch at all."""
        is_of_hold = a == held and b in self._links
        if (a, b) in self._exempt or held == b or is_of_hold:
            return np.inf  # the held item's own contacts are judged from its side
        if a == held and (b in planned.touching or b in planned.held):
            return HELD_PRESS
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
