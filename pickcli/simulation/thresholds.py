"""Thresholds of protective stops; their sources are in docs/supervision.md."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Thresholds:
    """Thresholds beyond which a motion is stopped.

    Attributes:
        lag: s by which a joint or the tool may trail its command, at any speed.
        joint: rad or m of additional error of a joint.
        tool: m of additional error of the tool.
        torque: Unexplained torque as a share of a motor's largest torque.
        planned_force: N at the tool of additional unexplained force during planned contacts.
        vacuum: Share of the vacuum at sealing below which the seal is lost.
        width: m, allowed difference between the width of the fingers and that of the item; at most half of
            the item's width.
        touch: N along the tool's axis from which the cup counts as touching, if above the noise.
        mass: kg by which what is held may be lighter or heavier than the item can be.
        bellows: Largest allowed compression of the cup in a contact, as a share of its stroke.
    """

    lag: float = 0.06
    joint: float = 0.01
    tool: float = 0.01
    torque: float = 0.06
    planned_force: float = 60.0
    vacuum: float = 0.5
    width: float = 0.005
    touch: float = 2.0
    mass: float = 0.03
    bellows: float = 0.95
