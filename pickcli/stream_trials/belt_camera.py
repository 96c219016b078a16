"""Simulated camera over the infeed of a conveyor: sightings of what truly rides there, with errors.

The only interface from a true stream to what is perceived of it, besides the encoder.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.geometry import rotation_axis_angle
from pickcli.perception.tracking.sighting import Detection, Sighting, SightingNoise
from pickcli.scene.item_stream import ItemStream
from pickcli.seeds import derived_rng

PR2_LIKE = SightingNoise(position=0.004, angle=float(np.radians(2.0)), mount=0.001)


@dataclass(frozen=True)
class BeltCamera:
    """A camera over a conveyor, which sees what comes before it is counted on.

    Attributes:
        noise: Errors of what it detects.
        rate: Hz, pictures (PR2: 10 to 12).
        latency: s from a picture until its detections are known.
        missed: Share of the items in a picture that are not detected.
        reversed: Share of the detections that are turned by half a turn.
        ahead: m before ``Conveyor.upstream`` from which on it sees: the way in the time until a track is
            reported, and the query that uses it has ended.
    """

    noise: SightingNoise = PR2_LIKE
    rate: float = 10.0
    latency: float = 0.15
    missed: float = 0.05
    reversed: float = 0.02
    ahead: float = 0.7

    def stamps(self, after: float, until: float) -> list[float]:
        """Return when pictures are taken.

        Args:
            after: s.
            until: s.

        Returns:
            The times in (after, until].
        """
        first, last = int(np.floor(after * self.rate + 1e-9)) + 1, int(np.floor(until * self.rate + 1e-9))
        return [min(k / self.rate, until) for k in range(first, last + 1)]  # but for rounding

    def sighting(self, true: ItemStream, stamp: float, seed: int, until: float = np.inf) -> Sighting:
        """Take a picture.

        Args:
            true: The true stream.
            stamp: s.
            seed: Seed of the trial; an item's error depends on it, the item's id and the stamp only.
            until: m along the belt, beyond which the arm may hide what is there.

        Returns:
            What is detected; every label is the id of the true item.
        """
        off = derived_rng("belt camera", seed).normal(size=2)
        mount = self.noise.mount * off / max(1.0, float(np.hypot(*off)))
        view = (-true.belt.upstream - self.ahead, min(until, true.belt.length))
        found = []
        for riding in true.items:
            rng = derived_rng("sighting", seed, riding.id, f"{stamp:.3f}")
            is_missed, is_reversed = rng.random() < self.missed, rng.random() < self.reversed
            x, y = rng.normal(0.0, self.noise.position, 2) + mount
            yaw = rng.normal(0.0, self.noise.angle) + (np.pi if is_reversed else 0.0)
            travel = true.travel_at(riding, stamp)
            if is_missed or not view[0] <= travel <= view[1]:
                continue
            T = riding.T_belt_item.copy()
            T[:3, :3] = rotation_axis_angle((0.0, 0.0, 1.0), yaw) @ T[:3, :3]
            T[:3, 3] = travel + x, T[1, 3] + y, T[2, 3]
            found.append(Detection(riding.item, T, riding.id))
        return Sighting(stamp, tuple(found), view)


def encoder_travel(true: ItemStream, t: float) -> float:
    """Return what the encoder of a belt reads.

    Args:
        true: The stream that rides on it.
        t: s.

    Returns:
        m of travel since time 0, in whole counts.
    """
    count = true.belt.encoder_resolution
    return float(np.floor(true.speed * t / count + 1e-9) * count)
