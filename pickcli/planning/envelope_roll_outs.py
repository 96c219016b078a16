"""Roll-outs of a controller into envelopes of an object: whole ones, else what a scene leaves of them.

The nearest pose of a whole envelope may lie behind what is in the way, where a controller gets stuck that
knows no future (Krug et al., RA-L 2016, section III-B). So envelopes are truncated and divided for it, and of
those that it reaches the one with the shortest way is chosen; and if it reaches none, it goes on from where
it came the nearest.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from pickcli.collision.free_flyer import FreeToolChecker
from pickcli.control.roll_out import STILL, End, RollOut
from pickcli.geometry import Array
from pickcli.grasping.envelope import Envelope
from pickcli.grasping.envelope_truncation import free_sectors

MOST_ROUNDS = 4  # in which all of this is tried, each from where the last one came the nearest


@dataclass(frozen=True, eq=False)
class EnvelopeRollOut:
    """A roll-out into an envelope.

    Attributes:
        envelope: The envelope, or a part of it.
        run: What the controller did.
        left: Error of the stack's goal at its end.
    """

    envelope: Envelope
    run: RollOut
    left: float

    @property
    def is_reached(self) -> bool:
        """Whether the tool is in the envelope."""
        return self.run.end is End.REACHED

    @property
    def travel(self) -> float:
        """Sum of the ways of all joints, rad or m."""
        return float(np.abs(np.diff(self.run.Q, axis=0)).sum())


def roll_out_into(
    run: Callable[[Envelope, Array, Array], RollOut],
    goal: str,
    start: Array,
    envelopes: Sequence[Envelope],
    T_world_object: Array,
    tool: FreeToolChecker,
) -> list[EnvelopeRollOut]:
    """Run into whole envelopes; if none is reached into what is free of them; else into sectors of that.

    If none of these is reached, all is tried again from where the controller came to rest the nearest to one.

    Args:
        run: Lets the controller run into an envelope from a configuration (n,), with joint rates (n,).
        goal: Name of the task that ends a roll-out.
        start: (n,) configuration, free.
        envelopes: The envelopes, none of them empty.
        T_world_object: (4, 4) of their frame.
        tool: Checks the tool without the arm.

    Returns:
        All roll-outs in their order, as many at first as there are envelopes.
    """
    groups: Iterable[list[Envelope]] = _in_turn(envelopes, T_world_object, tool)
    ended: list[EnvelopeRollOut] = []
    before: RollOut | None = None
    for _ in range(MOST_ROUNDS):
        tried = []
        for parts in groups:
            tried.append(parts)
            for each in parts:
                if before is None:
                    found = run(each, start, np.zeros_like(start))
                else:
                    found = before.then(run(each, before.Q[-1], before.rates))
                ended.append(EnvelopeRollOut(each, found, float(found.errors[goal][-1])))
            if any(each.is_reached for each in ended):
                return ended
        rested = [each for each in ended if is_at_rest(each.run)]
        if not rested or best_of(rested).run is before:
            break  # it came to rest no nearer
        before, groups = best_of(rested).run, tried
    return ended


def is_at_rest(run: RollOut) -> bool:
    """Tell whether the joints rest at the end of a roll-out, as far as a controller brings them to rest.

    Args:
        run: The roll-out.

    Returns:
        Whether none is faster than ``STILL``.
    """
    return bool(np.abs(run.rates).max() < STILL)


def best_of(ended: Sequence[EnvelopeRollOut]) -> EnvelopeRollOut:
    """Return the roll-out that reached an envelope on the shortest way, or that came the nearest to one.

    Args:
        ended: Roll-outs, at least one.

    Returns:
        One of them.
    """
    return min(ended, key=lambda each: (not each.is_reached, each.travel if each.is_reached else each.left))


def _in_turn(
    envelopes: Sequence[Envelope], T_world_object: Array, tool: FreeToolChecker
) -> Iterator[list[Envelope]]:
    """Yield envelopes, then what of each is free, then the sectors of that."""
    yield list(envelopes)
    parts = [free_sectors(each, T_world_object, tool) for each in envelopes]
    yield [each[0] for each in parts if each]
    yield [sector for each in parts for sector in each[1:]]
