"""What a robot knows of a stream: tracks of a camera over the conveyor, and the encoder."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pickcli.perception.tracking.belt_tracker import WITHIN, BeltTracker
from pickcli.scene.item_stream import ItemStream, RidingItem
from pickcli.trial.belt_camera import BeltCamera, encoder_travel


class BeltPerception:
    """Follows a stream with a camera and the encoder.

    Args:
        true: The true stream at time 0.
        camera: The camera.
        seed: Seed of the errors.
    """

    def __init__(self, true: ItemStream, camera: BeltCamera, seed: int) -> None:
        self._camera, self._seed = camera, seed
        self._t_read = self._t_seen = 0.0
        self._hidden = (np.inf, np.inf)  # s between which the arm was over the window
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
        for read in (*self._camera.stamps(self._t_read, t), t):
            self._tracker.read_encoder(read, encoder_travel(true, read))
        for stamp in self._camera.stamps(self._t_seen, t - charge - self._camera.latency):
            is_hidden = self._hidden[0] <= stamp <= self._hidden[1]
            until = true.belt.window[0] if is_hidden else np.inf
            self._tracker.see(self._camera.sighting(true, stamp, self._seed, until))
            self._t_seen = stamp
        self._t_read = t
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

    def hide(self, t_start: float, t_end: float) -> None:
        """Note when the arm was over the window, and hid what is there.

        Args:
            t_start: s.
            t_end: s.
        """
        self._hidden = (t_start, t_end)

    def forget(self, item_id: str) -> None:
        """Forget an item that was taken off the belt, or moved on it.

        Args:
            item_id: Its id.
        """
        self._tracker.forget(item_id)
