"""What a robot knows of a stream: tracks of a camera over the conveyor, and the encoder."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

import numpy as np

from pickcli.perception.tracking.belt_tracker import WITHIN, BeltTracker
from pickcli.perception.tracking.sighting import Detection, Sighting
from pickcli.scene.item_stream import ItemStream, RidingItem
from pickcli.stream_trials.belt_camera import BeltCamera, encoder_travel


class BeltPerception:
    """Follows a stream with a camera and the encoder.

    Args:
        true: The true stream at time 0.
        camera: The camera.
        seed: Seed of the errors.
    """

    def __init__(self, true: ItemStream, camera: BeltCamera, seed: int) -> None:
        self._camera, self._seed = camera, seed
        self._t_read = self._t_taken = 0.0
        self._taken: deque[Sighting] = deque()  # pictures whose detections are not known yet
        self._hidden: list[tuple[float, float]] = []  # s between which the arm is over the window
        self._tracker = BeltTracker(true.belt, camera.noise, 0.0, encoder_travel(true, 0.0))

    def known(self, true: ItemStream, t: float, charge: float) -> ItemStream:
        """Return what is known at a time, to a query that began before.

        The speed is the upper bound of the belt's, so that plans wait for the belt, and not the belt for
        plans.

        Args:
            true: The true stream.
            t: s, at which a plan of the query starts.
            charge: s that the query takes: pictures whose detections come later do not count for it.

        Returns:
            The tracked items at that time.
        """
        self.take(true, t)
        for read in (*self._camera.stamps(self._t_read, t), t):
            self._tracker.read_encoder(read, encoder_travel(true, read))
        self._t_read = t
        last = t - charge - self._camera.latency
        while self._taken and self._taken[0].stamp <= last:
            self._tracker.see(self._taken.popleft())
        speed, deviation = self._tracker.speed(t)
        error = WITHIN * deviation
        items = tuple(
            RidingItem(track.id, track.item, t, track.T_belt_item, track.noise)
            for track in self._tracker.tracks(t)
        )
        if true.speed == 0.0:
            return replace(true, items=items)
        most = min(max(speed, 0.0) + error, true.belt.max_speed)
        return replace(true, items=items, speed=most, speed_error=2.0 * error)

    def take(self, true: ItemStream, t: float) -> None:
        """Take the pictures until a time, of the stream as it is now; their detections are known later.

        Args:
            true: The true stream.
            t: s.
        """
        for stamp in self._camera.stamps(self._t_taken, t):
            is_hidden = any(start <= stamp <= end for start, end in self._hidden)
            until = true.belt.window[0] if is_hidden else np.inf
            self._taken.append(self._camera.sighting(true, stamp, self._seed, until))
        self._t_taken = max(self._t_taken, t)

    def hide(self, t_start: float, t_end: float) -> None:
        """Note when the arm is over the window, and hides what is there.

        Args:
            t_start: s.
            t_end: s.
        """
        self._hidden.append((t_start, t_end))

    def forget(self, item_id: str) -> None:
        """Forget an item that was taken off the belt, or moved on it.

        Args:
            item_id: Its id.
        """
        self._tracker.forget(item_id)
        self._taken = deque(replace(each, detections=_without(each, item_id)) for each in self._taken)


def _without(sighting: Sighting, label: str) -> tuple[Detection, ...]:
    """Return what a picture shows besides an item."""
    return tuple(each for each in sighting.detections if each.label != label)
