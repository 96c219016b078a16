"""Tracks against known motion: bounds hold, ids stay, whatever pictures miss, swap or show twice."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pickcli.cell.conveyor import Conveyor
from pickcli.errors import InputError
from pickcli.geometry import inverse, pose, rotation_angle, rotation_axis_angle
from pickcli.perception.tracking.belt_tracker import LEAST_SIGHTINGS, BeltTrack, BeltTracker
from pickcli.perception.tracking.sighting import Detection, Sighting, SightingNoise
from pickcli.seeds import derived_rng
from support.belt_picks import cell

SIGMA, TURN, RATE = 0.004, np.radians(2.0), 10.0
NOISE = SightingNoise(SIGMA, float(TURN))
ITEMS = ("dove_beauty_bar", "crayola_24_ct", "expo_dry_erase_board_eraser", "dove_beauty_bar")


def belt() -> Conveyor:
    figures = cell().carriers["belt"].conveyor
    assert figures is not None
    return figures


def truth(seed: int, gap: float) -> dict[str, Detection]:
    """Two pairs of items at travel 0; those of a pair are beside each other, one ahead by a gap."""
    rng, placed = derived_rng("tracked", seed), {}
    for k, name in enumerate(ITEMS):
        where = [0.3 - 0.15 * (k // 2) - gap * (k % 2), 0.08 * (-1) ** k, 0.02]
        T = pose(where, R=rotation_axis_angle((0, 0, 1), rng.uniform(-3, 3)))
        placed[f"piece{k}"] = Detection(cell().item(name), T)
    return placed


def seen(
    true: dict[str, Detection], travel: float, rng: np.random.Generator, missed: float
) -> list[Detection]:
    """What a picture shows of the items."""
    found = []
    for each in true.values():
        turn = rotation_axis_angle((0, 0, 1), rng.normal(0.0, TURN) + (np.pi if rng.random() < 0.05 else 0.0))
        T = each.T_belt_item.copy()
        T[:3, :3] = turn @ T[:3, :3]
        T[:2, 3] += rng.normal((travel, 0.0), SIGMA)
        if rng.random() >= missed and T[0, 3] > 0.0:
            found.append(Detection(each.item, T))
    return found


def speed_at(t: float) -> float:
    """A belt that slows down by a fifth at 0.2 m/s2, and runs up again later."""
    return 0.33 - 0.066 * float(np.clip((t - 1.0) / 0.33, 0.0, 1.0) - np.clip((t - 3.0) / 0.33, 0.0, 1.0))


def is_within(track: BeltTrack, true: Detection, travel: float) -> bool:
    """Whether a track's bounds hold its error."""
    error = inverse(true.T_belt_item) @ inverse(pose((travel, 0.0, 0.0))) @ track.T_belt_item
    off = float(np.linalg.norm(error[:3, 3]))
    return off <= track.noise.position and rotation_angle(error[:3, :3]) <= track.noise.angle


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("gap", [0.0, 0.07])
def test_bounds_hold_and_ids_stay_while_the_belt_changes_its_speed(seed: int, gap: float) -> None:
    true, rng = truth(seed, gap), derived_rng("pictures", seed)
    tracker, travel = BeltTracker(belt(), NOISE, 0.0, 0.0), 0.0
    ids: dict[str, str] = {}
    n_bounds = n_held = 0
    for k in range(1, 60):
        for _ in range(10):
            travel += speed_at(k / RATE) / RATE / 10
        t = k / RATE
        tracker.read_encoder(t, np.floor(travel / 1e-5) * 1e-5)
        tracker.see(Sighting(t, tuple(seen(true, travel, rng, missed=0.1))))
        for track in tracker.tracks(t):
            nearest = min(true, key=lambda name: _apart(track, true[name], travel))
            assert ids.setdefault(track.id, nearest) == nearest
            n_bounds, n_held = n_bounds + 1, n_held + is_within(track, true[nearest], travel)
            assert track.n_sightings >= LEAST_SIGHTINGS
    assert len(ids) == len(set(ids.values())) == len(true)
    assert n_held >= 0.99 * n_bounds


def _apart(track: BeltTrack, true: Detection, travel: float) -> float:
    centre = true.T_belt_item[:3, 3] + (travel, 0.0, 0.0)
    is_other = track.item.name != true.item.name
    return float(np.linalg.norm(track.T_belt_item[:3, 3] - centre)) + (1e3 if is_other else 0.0)


def test_two_beside_each_other_keep_their_tracks_though_pictures_swap_their_order() -> None:
    item = cell().item("dove_beauty_bar")
    true = {k: Detection(item, pose([0.3, y, 0.02])) for k, y in (("left", 0.1), ("right", -0.1))}
    tracker = BeltTracker(belt(), NOISE, 0.0, 0.0)
    for k in range(1, 30):
        t, x = k / RATE, 0.33 * k / RATE
        tracker.read_encoder(t, x)
        swap = 0.002 * (-1) ** k
        pictures = [
            replace(each, T_belt_item=pose([0.3 + x + (swap if y > 0 else -swap), y, 0.02]))
            for each, y in zip(true.values(), (0.1, -0.1), strict=True)
        ]
        tracker.see(Sighting(t, tuple(pictures)))
    tracks = tracker.tracks(t)
    assert sorted(round(float(track.T_belt_item[1, 3]), 3) for track in tracks) == [-0.1, 0.1]
    assert all(track.n_sightings >= 14 for track in tracks)


def test_what_is_seen_twice_in_a_picture_is_one_item() -> None:
    item, tracker = cell().item("dove_beauty_bar"), BeltTracker(belt(), NOISE, 0.0, 0.0)
    for k in range(1, 10):
        tracker.read_encoder(k / RATE, 0.033 * k)
        twice = (Detection(item, pose([0.3 + 0.033 * k, y, 0.02])) for y in (0.0, 0.003))
        tracker.see(Sighting(k / RATE, tuple(twice)))
    assert len(tracker.tracks(0.9)) == 1


def test_what_is_seen_too_rarely_is_never_reported() -> None:
    item, tracker = cell().item("dove_beauty_bar"), BeltTracker(belt(), NOISE, 0.0, 0.0)
    for k in range(1, 20):
        tracker.read_encoder(k / RATE, 0.033 * k)
        ghost = (Detection(item, pose([0.2, 0.0, 0.02])),) if k % 8 == 0 else ()
        tracker.see(Sighting(k / RATE, ghost))
        assert tracker.tracks(k / RATE) == ()


def test_a_reported_item_goes_on_with_the_encoder_out_of_view() -> None:
    item, tracker = cell().item("dove_beauty_bar"), BeltTracker(belt(), NOISE, 0.0, 0.0)
    for k in range(1, 11):
        tracker.read_encoder(k / RATE, 0.033 * k)
        tracker.see(Sighting(k / RATE, (Detection(item, pose([0.1 + 0.033 * k, 0.0, 0.02])),)))
    for k in range(11, 61):  # at a third of the speed from here on
        tracker.read_encoder(k / RATE, 0.33 + 0.011 * (k - 10))
    (track,) = tracker.tracks(6.0)
    assert track.T_belt_item[0, 3] == pytest.approx(0.1 + 0.33 + 0.55, abs=1e-3)
    assert track.noise.position < 2.0 * SIGMA


def test_labels_are_ids_and_one_label_is_one_track() -> None:
    item, tracker = cell().item("dove_beauty_bar"), BeltTracker(belt(), NOISE, 0.0, 0.0)
    for k in range(1, 6):
        tracker.read_encoder(k / RATE, 0.033 * k)
        tracker.see(Sighting(k / RATE, (Detection(item, pose([0.3 + 0.033 * k, 0.0, 0.02]), "A7"),)))
    assert [track.id for track in tracker.tracks(0.5)] == ["A7"]
    tracker.forget("A7")
    assert tracker.tracks(0.5) == ()


def test_what_is_out_of_order_is_refused() -> None:
    tracker = BeltTracker(belt(), NOISE, 0.0, 0.0)
    tracker.read_encoder(0.5, 0.1)
    with pytest.raises(InputError, match=r"reading of 0.400 s after one of 0.500 s"):
        tracker.read_encoder(0.4, 0.1)
    with pytest.raises(InputError, match=r"stamp 0.600 s is out of order \(known are 0.000 to 0.500 s\)"):
        tracker.see(Sighting(0.6, ()))
    tracker.see(Sighting(0.5, ()))
    with pytest.raises(InputError, match=r"stamp 0.300 s is out of order"):
        tracker.see(Sighting(0.3, ()))


@pytest.mark.parametrize("label", ["", "A7"])
@pytest.mark.parametrize("shift", [0.03, 0.12])
def test_an_item_that_was_moved_is_soon_where_it_is_now(label: str, shift: float) -> None:
    item, tracker = cell().item("dove_beauty_bar"), BeltTracker(belt(), NOISE, 0.0, 0.0)
    for k in range(1, 41):
        tracker.read_encoder(k / RATE, 0.033 * k)
        y = 0.0 if k <= 25 else shift
        picture = (Detection(item, pose([0.3 + 0.033 * k, y, 0.02]), label),)
        tracker.see(Sighting(k / RATE, picture))
    (track,) = tracker.tracks(4.0)
    assert track.T_belt_item[1, 3] == pytest.approx(shift, abs=1e-6)


def test_an_item_that_the_arm_hides_is_not_gone() -> None:
    item, tracker = cell().item("dove_beauty_bar"), BeltTracker(belt(), NOISE, 0.0, 0.0)
    for k in range(1, 41):
        tracker.read_encoder(k / RATE, 0.033 * k)
        shown = (Detection(item, pose([0.3 + 0.033 * k, 0.0, 0.02])),) if k <= 25 else ()
        tracker.see(Sighting(k / RATE, shown, (0.0, np.inf if k <= 25 else 1.0)))
    assert len(tracker.tracks(4.0)) == 1
