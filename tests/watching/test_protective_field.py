"""Fields hold all that the truck sweeps, and no more where that is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.driving.tricycle import Tricycle
from pickcli.watching.foreseen_contact import stopping_poses
from pickcli.watching.protective_field import FieldSet, ProtectiveField
from pickcli.watching.stopping_distance import stopping_distance
from support.watched import narrow_watch

WATCH, TRUCK = narrow_watch(), Tricycle()
FIELDS = FieldSet(TRUCK, WATCH.scanner, WATCH.fields)


def reach_towards(field: ProtectiveField, degrees: float) -> float:
    return float(field.reach[np.abs(field.angles - np.radians(degrees)).argmin()])


def test_field_for_a_straight_drive_ends_at_the_stopping_distance() -> None:
    field = FIELDS.field_for(0.9, 0.0)
    delay = 2 * WATCH.scanner.period + WATCH.scanner.delay + WATCH.fields.reaction
    assert field.stopping == pytest.approx(stopping_distance(0.9, delay, TRUCK.acceleration))
    straight = replace(WATCH.fields, ahead=0.0)
    longer = FieldSet(TRUCK, WATCH.scanner, straight).field_for(0.9, 0.0)
    ahead = reach_towards(field, 0.0) - reach_towards(longer, 0.0)
    assert ahead == pytest.approx(WATCH.fields.ahead)
    # Fields are for some steering either way, too, whose outlines end nearer along the middle.
    assert reach_towards(longer, 0.0) == pytest.approx(field.stopping, abs=0.02)


def test_field_at_rest_is_the_widened_outline() -> None:
    field = FIELDS.field_for(0.0, 0.0)
    assert field.stopping == 0.0
    assert reach_towards(field, 0.0) == pytest.approx(WATCH.fields.ahead)
    side = TRUCK.width / 2 + WATCH.fields.side
    assert reach_towards(field, 90.0) == pytest.approx(side, rel=1e-3)


@settings(max_examples=40, deadline=None)
@given(st.floats(0.05, 1.0), st.floats(-1.2, 1.2))
def test_field_holds_all_corners_until_the_rest(speed: float, steering: float) -> None:
    """Beams beside a corner reach beyond it; corners behind the truck's front side have beams, too."""
    field = FIELDS.field_for(speed, steering)
    _, poses = stopping_poses(TRUCK, np.zeros(3), (speed, steering), FIELDS.delay)
    c, s = np.cos(poses[:, 2, None]), np.sin(poses[:, 2, None])
    x, y = TRUCK.corners[1:3].T  # of the front
    corners = np.stack([poses[:, :1] + c * x - s * y, poses[:, 1:2] + s * x + c * y], -1).reshape(-1, 2)
    off = corners - [field.forward, 0.0]
    beams = np.abs(np.arctan2(off[:, 1], off[:, 0])[:, None] - field.angles).argmin(axis=1)
    assert (field.reach[beams] > np.hypot(*off.T)).all()


def test_fields_grow_with_the_speed_and_bend_with_the_steering() -> None:
    reaches = [FIELDS.field_for(speed, 0.3).reach for speed in (0.2, 0.5, 1.0)]
    # Outlines are centimetres apart, and their corners leave millimetres between them.
    assert (reaches[0] <= reaches[1] + 0.02).all() and (reaches[1] <= reaches[2] + 0.02).all()
    assert reaches[0].sum() < reaches[2].sum()
    left, right = FIELDS.field_for(0.8, 0.8), FIELDS.field_for(0.8, -0.8)
    np.testing.assert_allclose(left.reach, right.reach[::-1], atol=1e-9)
    assert reach_towards(left, 45.0) > reach_towards(left, -45.0)


def test_field_for_people_who_walk_is_wider_by_their_way() -> None:
    """At rest by nothing more than the way in the delay; at a speed by that until the truck rests."""
    walked = FieldSet(TRUCK, WATCH.scanner, replace(WATCH.fields, approach=1.6))
    at_rest = walked.field_for(0.0, 0.0)
    more = reach_towards(at_rest, 0.0) - reach_towards(FIELDS.field_for(0.0, 0.0), 0.0)
    assert more == pytest.approx(1.6 * walked.delay)
    moving, narrow = walked.field_for(1.0, 0.0), FIELDS.field_for(1.0, 0.0)
    until_rest = walked.delay + 1.0 / TRUCK.acceleration
    assert reach_towards(moving, 0.0) - reach_towards(narrow, 0.0) == pytest.approx(
        1.6 * until_rest, abs=0.01
    )


def test_the_outline_ends_at_the_scanner() -> None:
    field = FIELDS.field_for(0.4, 0.0)
    assert field.outline.shape == (len(field.angles) + 1, 2)
    np.testing.assert_allclose(field.outline[-1], [WATCH.scanner.forward, 0.0])
    assert field.outline[:-1, 0].max() == pytest.approx(
        WATCH.scanner.forward + reach_towards(field, 0.0), abs=0.02
    )


def test_the_field_of_a_rear_scanner_is_behind_the_truck() -> None:
    rear = replace(WATCH.scanner, forward=-TRUCK.back, looks_back=True)
    front, back = (
        FieldSet(TRUCK, scanner, WATCH.fields).field_for(0.8, 0.0) for scanner in (WATCH.scanner, rear)
    )
    ahead = front.outline[:, 0].max() - TRUCK.front
    behind = -back.outline[:, 0].min() - TRUCK.back
    assert behind == pytest.approx(ahead, abs=0.02) and behind > back.stopping
    assert back.outline[:, 0].max() < TRUCK.front + 1.0 and front.outline[:, 0].min() > -TRUCK.back - 1.0
