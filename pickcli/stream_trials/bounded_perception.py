"""What a robot knows of a stream whose items are perceived within bounds of error: at each look anew."""

from __future__ import annotations

from dataclasses import replace

from pickcli.geometry import inverse, pose
from pickcli.scene.item_stream import ItemStream, RidingItem
from pickcli.seeds import derived_rng
from pickcli.stream_trials.stream_trial_request import StreamTrialRequest
from pickcli.trial.pose_noise import perceive


def perceive_stream(
    request: StreamTrialRequest, true: ItemStream, look: int, t: float, charge: float
) -> ItemStream:
    """Perceive what was on the belt when a query had to begin, with errors of poses and speed.

    From then on the encoder tells how far it has gone. The speed is an upper bound, so that plans wait for
    the belt, and not the belt for plans; its stated error holds the true one.

    Args:
        request: The bounds of the errors.
        true: The true stream.
        look: Number of the look, which the errors depend on.
        t: s, at which a plan of the query starts.
        charge: s that the query takes.

    Returns:
        The stream as it is known at that time.
    """
    seen = perceive(true.scene_at(t - charge), request.noise, request.seed, look, request.reality)
    T_now_world = pose((true.speed * charge, 0.0, 0.0)) @ inverse(true.carrier.T_world_carrier)
    items = tuple(
        RidingItem(placed.id, placed.item, t, T_now_world @ placed.T_world_item) for placed in seen.items
    )
    known = replace(true, items=items, noise=request.noise)
    if true.speed == 0.0:
        return known
    off = derived_rng("belt speed", request.seed, look).uniform(-1.0, 1.0) * request.speed_error
    most = min(true.speed + off + request.speed_error, true.belt.max_speed)
    return replace(known, speed=most, speed_error=2.0 * request.speed_error)
