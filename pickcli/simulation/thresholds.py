"""Beyond which figures a motion is stopped; their sources stand in docs/supervision.md."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Thresholds:
    """Thresholds beyond which a motion is stopped.

    Attributes:
        lag: s by which a joint or the tool may trail its command, whatever its speed.
        joint: rad or m that a joint may be off on top of that.
        tool: m that the tool may be off on top of that.
        torque: Share of a motor's largest torque that the motion need not explain.
        planned_force: N at the tool on top of that, where the plan touches something.
        vacuum: Share of the level at the seal below which the seal is lost.
        width: m by which fingers may stand closer, or farther apart, than the item is wide; at most half of
            that.
        touch: N along the tool's axis from which the cup counts as touching, where that exceeds the noise.
        bellows: Share of the cup's stroke to which a contact may press it in.
    """

    lag: float = 0.06
    joint: float = 0.01
    tool: float = 0.01
    torque: float = 0.06
    planned_force: float = 60.0
    vacuum: float = 0.5
    width: float = 0.005
    touch: float = 2.0
    bellows: float = 0.95
