"""What is known of a stream: within its bounds, told in time, and by nothing but camera and encoder."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.geometry import inverse, rotation_angle
from pickcli.random_scenes.make_stream import StreamRequest, make_stream
from pickcli.scene.item_stream import ItemStream
from pickcli.stream_trials.belt_camera import BeltCamera, encoder_travel
from pickcli.stream_trials.belt_perception import BeltPerception
from support.belt_picks import cell

CHARGE = 0.3


def stream(speed: float, seed: int) -> ItemStream:
    return make_stream(cell(), StreamRequest(12, speed, (0.05, 0.3)), seed)


@pytest.mark.parametrize("speed", [0.1, 0.33, 0.5])
@pytest.mark.parametrize("seed", [61, 62])
def test_bounds_hold_and_every_item_is_known_before_the_window(speed: float, seed: int) -> None:
    true = stream(speed, seed)
    perception, n, n_held = BeltPerception(true, BeltCamera(), seed), 0, 0
    known_at = dict[str, float]()
    last = true.items[-1]
    for t in np.arange(0.5, last.stamp + true.belt.length / speed, 0.4).tolist():
        known = perception.known(true, t, CHARGE)
        assert known.speed - known.speed_error <= true.speed <= known.speed + 1e-12
        for item in known.items:
            riding = true.find(item.id)
            known_at.setdefault(item.id, true.travel_at(riding, t))
            T = riding.T_belt_item.copy()
            T[0, 3] = true.travel_at(riding, t)
            error = inverse(T) @ item.T_belt_item
            assert item.noise is not None and item.item == riding.item
            is_within = np.linalg.norm(error[:3, 3]) <= item.noise.position
            is_within &= rotation_angle(error[:3, :3]) <= item.noise.angle
            n, n_held = n + 1, n_held + bool(is_within)
    assert n_held >= 0.99 * n
    assert set(known_at) == {riding.id for riding in true.items}
    assert max(known_at.values()) < true.belt.window[0]


def test_nothing_is_known_before_three_pictures_are_worked_in() -> None:
    true, camera = stream(0.33, 63), BeltCamera(missed=0.0)
    first = min(riding.stamp for riding in true.items)
    perception = BeltPerception(true, camera, 1)
    early = first + 2.0 / camera.rate
    assert perception.known(true, early + camera.latency + CHARGE, CHARGE).items == ()
    assert perception.known(true, early + 0.3 + camera.latency + CHARGE, CHARGE).items != ()


def test_an_item_that_was_moved_is_not_known_by_pictures_from_before() -> None:
    true, camera = stream(0.33, 63), BeltCamera(missed=0.0)
    perception, t = BeltPerception(true, camera, 1), 3.0
    name = perception.known(true, t, CHARGE).items[0].id
    gone = replace(true, items=tuple(each for each in true.items if each.id != name))
    perception.take(true, t + 0.5)
    perception.forget(name)
    for later in (t + 0.5, t + 0.8, t + 1.1):
        assert name not in {each.id for each in perception.known(gone, later, CHARGE).items}


def test_the_same_seed_sees_the_same() -> None:
    true, camera = stream(0.33, 64), BeltCamera()
    once, twice, other = (camera.sighting(true, 2.0, seed) for seed in (1, 1, 2))
    poses = [[each.T_belt_item for each in sighting.detections] for sighting in (once, twice, other)]
    assert np.array_equal(poses[0], poses[1]) and not np.array_equal(poses[0][:1], poses[2][:1])


def test_the_encoder_reads_whole_counts() -> None:
    true = stream(0.33, 65)
    count = true.belt.encoder_resolution
    for t in (0.0, 0.017, 1.234):
        assert encoder_travel(true, t) / count == pytest.approx(round(encoder_travel(true, t) / count))
        assert 0.0 <= true.speed * t - encoder_travel(true, t) < count * 1.001
