"""A conveyor: a carrier whose running surface travels along +x, and the items on it with it."""

from __future__ import annotations

from dataclasses import dataclass

UPSTREAM = 2.0  # lengths of a conveyor before its infeed, from which on items are known


@dataclass(frozen=True)
class Conveyor:
    """The figures of a conveyor's belt.

    Frame of the belt: that of its carrier, with the origin in the middle of the infeed edge on the running
    surface, +x in the running direction, +z up.

    Attributes:
        length: m from infeed to outfeed.
        width: m.
        nominal_speed: m/s at which it usually runs.
        max_speed: m/s that it never exceeds.
        max_acceleration: m/s^2 at which its speed changes at most, either way.
        window: m from the infeed, between which items may be picked.
        encoder_resolution: m of travel per count of the encoder.
        encoder_latency: s by which a reading of the encoder is old.
    """

    length: float
    width: float
    nominal_speed: float
    max_speed: float
    max_acceleration: float
    window: tuple[float, float]
    encoder_resolution: float
    encoder_latency: float

    @property
    def upstream(self) -> float:
        """How far before the infeed the items are known, m: nothing else comes onto the belt before them."""
        return UPSTREAM * self.length

    @property
    def farthest(self) -> float:
        """How far the belt carries what is known, m: from the first of it to the outfeed."""
        return self.upstream + self.length
