"""A suction cup as data: its size, how its bellows give way, how fast it may go, and what its seal bears."""

from __future__ import annotations

from dataclasses import dataclass

from pickcli.cell.cup_limits import CupLimits


@dataclass(frozen=True, eq=False)
class SuctionCup:
    """The figures of a suction cup.

    Attributes:
        radius: m.
        stroke: m, how far the bellows compress.
        stiffness: N/m along the axis while relaxed.
        tilt: rad, how far from square on a face the lip still seals.
        limits: What the seal bears.
        contact_speed: m/s, fastest final approach.
        take_up: m of a lift in which the sealed cup gives way until it bears the item's weight.
        take_up_speed: m/s, fastest in that stretch where the weight bends the cup.
        seal_time: s at rest on the item before it is moved, for the vacuum to build up under the cup.
    """

    radius: float
    stroke: float
    stiffness: float
    tilt: float
    limits: CupLimits
    contact_speed: float
    take_up: float
    take_up_speed: float
    seal_time: float
