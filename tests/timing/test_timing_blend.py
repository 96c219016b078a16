"""Blends: the stated bound, smoothness, and what the proof gets to see."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.errors import NoPlanError
from pickcli.geometry import Array
from pickcli.timing.blend_validation import chord_tube, proven_blend
from pickcli.timing.corner_blending import BlendedPath, blend
from pickcli.timing.path_parts import PathParts
from pickcli.timing.polyline_simplification import POINT_TOLERANCE, arc_lengths, canonical
from support.timing_paths import SEEDS, dense_curve, distance_to_polyline, limits, polylines, random_walk


@given(polylines(), st.floats(1e-4, 0.2))
@settings(max_examples=150, deadline=None)
def test_curve_stays_within_tolerance_of_the_polyline(waypoints: Array, tolerance: float) -> None:
    curve = blend(waypoints, tolerance)
    q = curve.evaluate(np.linspace(0.0, curve.length, 800))
    assert distance_to_polyline(q, waypoints).max() <= tolerance * (1.0 + 1e-9) + POINT_TOLERANCE


@given(polylines(), st.floats(1e-4, 0.2))
@settings(max_examples=150, deadline=None)
def test_every_waypoint_projects_near_itself_and_in_order(waypoints: Array, tolerance: float) -> None:
    curve = blend(waypoints, tolerance)
    at = curve.waypoint_s
    assert np.all(np.diff(at) >= 0.0)
    assert at[0] == 0.0 and at[-1] == pytest.approx(curve.length, abs=2 * POINT_TOLERANCE)
    assert (
        np.linalg.norm(curve.evaluate(at) - waypoints, axis=1).max() <= 1.1 * tolerance + 2 * POINT_TOLERANCE
    )


@given(SEEDS, st.sampled_from(["walk", "dense"]))
@settings(max_examples=30, deadline=None)
def test_derivatives_are_those_of_the_curve(seed: int, kind: str) -> None:
    waypoints = random_walk(seed, 5) if kind == "walk" else dense_curve(seed, 30)
    curve = blend(waypoints, 0.02)
    rng = np.random.default_rng(seed)
    s = rng.uniform(0.0, curve.length, 200)
    # Derivatives of order 2 and 3 scale with the reach of the shortest blend near by.
    short = curve.half_lengths[curve.half_lengths > 0.0].min()
    eps = 1e-4 * short
    inner = s[(s > eps) & (s < curve.length - eps)]
    for d in range(3):
        numeric = (curve.evaluate(inner + eps, d) - curve.evaluate(inner - eps, d)) / (2 * eps)
        assert np.abs(numeric - curve.evaluate(inner, d + 1)).max() < 5e-3 / short**d


def test_third_derivative_has_no_jumps() -> None:
    curve = blend(random_walk(1, 4), 0.05)
    ends = curve.corner_s[1:-1] + curve.half_lengths[1:-1]
    assert np.abs(curve.evaluate(ends - 1e-9, 3)).max() < 1e-4 * np.abs(curve.evaluate(curve.knots, 3)).max()


def test_deviation_at_a_lone_corner_is_the_tolerance() -> None:
    corner = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    curve = blend(corner, 0.05, simplify=0.0)
    middle = curve.evaluate(curve.corner_s[1])[0]
    assert np.linalg.norm(middle - corner[1]) == pytest.approx(0.05)


def test_dense_waypoints_make_one_curve_without_ripple() -> None:
    """Curvature of a sampled circle stays near the circle's: confined blends would double it."""
    angle = np.linspace(0.0, 2.0, 60)
    curve = blend(np.column_stack([np.cos(angle), np.sin(angle)]), 0.005)
    inner = np.linspace(0.3, curve.length - 0.3, 500)
    curvature = np.linalg.norm(curve.evaluate(inner, 2), axis=1)
    assert curvature.min() > 0.85 and curvature.max() < 1.15


@given(polylines(), st.floats(1e-3, 0.2))
@settings(max_examples=100, deadline=None)
def test_cover_contains_the_curve_joint_by_joint(waypoints: Array, tolerance: float) -> None:
    curve = blend(waypoints, tolerance)
    tube = chord_tube(curve)
    assert tube.s[0] == 0.0 and tube.s[-1] == curve.length
    for k in range(len(tube.s) - 1):
        u = np.linspace(0.0, 1.0, 15)[:, None]
        q = curve.evaluate(tube.s[k] + u[:, 0] * (tube.s[k + 1] - tube.s[k]))
        chord = tube.configurations[k] * (1.0 - u) + tube.configurations[k + 1] * u
        assert np.all(np.abs(q - chord) <= tube.slack[k] + 1e-12)


@given(polylines())
@settings(max_examples=100, deadline=None)
def test_canonical_keeps_ends_and_drops_only_what_lies_on_the_way(waypoints: Array) -> None:
    kept = canonical(waypoints)
    q = waypoints[kept]
    assert kept[0] == 0 and np.abs(q[-1] - waypoints[-1]).max() <= POINT_TOLERANCE
    assert distance_to_polyline(waypoints, q).max() <= 2 * POINT_TOLERANCE
    if len(kept) > 2:
        assert np.linalg.norm(np.diff(q, axis=0), axis=1).min() > POINT_TOLERANCE
    assert np.all(np.diff(arc_lengths(waypoints, kept)) >= 0.0)


def test_canonical_keeps_reversals() -> None:
    there_and_back = np.array([[0.0], [1.0], [0.4], [2.0]])
    assert canonical(there_and_back).tolist() == [0, 1, 2, 3]


def whole(waypoints: Array) -> PathParts:
    """One part with wide blends."""
    return PathParts(waypoints, np.array([0, len(waypoints) - 1]), np.array([0.05]))


def test_corner_without_room_is_cut_less_until_proven() -> None:
    """The world forbids to leave the corner by more than 4 mm: the blend must shrink below that."""
    corner = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])

    def is_free(part: int, chords: Array, slack: Array) -> int:
        return _first_beyond(chords, slack, corner, 0.004)

    curve = proven_blend(whole(corner), limits(2), is_free)
    q = curve.evaluate(np.linspace(0.0, curve.length, 2000))
    assert 0.0 < distance_to_polyline(q, corner).max() <= 0.004
    assert len(curve.stops) == 0


def test_corner_that_no_blend_can_pass_becomes_a_stop() -> None:
    corner = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])

    def is_free(part: int, chords: Array, slack: Array) -> int:
        return _first_beyond(chords, slack, corner, 1e-6)

    curve = proven_blend(whole(corner), limits(2), is_free)
    assert curve.stops.tolist() == [1]
    q = curve.evaluate(np.linspace(0.0, curve.length, 2000))
    assert distance_to_polyline(q, corner).max() < 1e-12


def test_straight_edge_in_collision_is_an_error_with_its_part() -> None:
    line = np.array([[0.0, 0.0], [1.0, 0.0]])
    with pytest.raises(NoPlanError, match="part 0"):
        proven_blend(whole(line), limits(2), lambda part, chords, slack: 0)


def test_each_part_is_proven_by_its_own_checker() -> None:
    waypoints = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]])
    seen: dict[int, tuple[Array, Array]] = {}

    def is_free(part: int, chords: Array, slack: Array) -> int:
        seen[part] = (chords[0], chords[-1])
        return -1

    curve = proven_blend(PathParts(waypoints, np.array([0, 1, 2]), np.full(2, 0.05)), limits(2), is_free)
    middle = curve.evaluate(curve.corner_s[1])[0]
    assert np.allclose(seen[0], [waypoints[0], middle]) and np.allclose(seen[1], [middle, waypoints[2]])


@given(polylines(), st.sampled_from([0.0, 0.002, 0.02]), st.sampled_from([0.002, 0.05]), st.data())
@settings(max_examples=150, deadline=None)
def test_a_part_stays_as_near_to_the_polyline_as_it_states(
    waypoints: Array, narrow: float, wide: float, data: st.DataObject
) -> None:
    """Blends with a neighbour that allows more belong to the neighbour, wherever the boundary is."""
    at = data.draw(st.integers(0, len(waypoints) - 1))
    blends = np.array(data.draw(st.permutations([narrow, wide])))
    parts = PathParts(waypoints, np.array([0, at, len(waypoints) - 1]), blends)
    curve = blend(waypoints, parts.tolerances)
    boundaries = parts.boundaries(curve)
    assert boundaries[0] == 0.0 and boundaries[-1] == curve.length and np.all(np.diff(boundaries) >= 0.0)
    for blend_of, start, end in zip(blends, boundaries[:-1], boundaries[1:], strict=True):
        q = curve.evaluate(np.linspace(start, end, 400))
        assert distance_to_polyline(q, waypoints).max() <= blend_of * (1.0 + 1e-9) + 2 * POINT_TOLERANCE


@pytest.mark.parametrize("away", [5e-6, 2e-5])
def test_a_line_ends_where_any_blend_of_the_coarse_motion_begins(away: float) -> None:
    """Second and third waypoint are so near that one corner stands for both, past the boundary."""
    waypoints = np.array([[0.0, 0.0], [1.0, 0.0], [1.0 + away, -away], [1.6, 0.8]])
    parts = PathParts(waypoints, np.array([0, 1, 3]), np.array([0.002, 0.05]))
    curve = blend(waypoints, parts.tolerances)
    line = np.linspace(0.0, parts.boundaries(curve)[1], 400)
    assert distance_to_polyline(curve.evaluate(line), waypoints).max() <= 0.002 + 2 * POINT_TOLERANCE


def test_a_line_ends_where_the_blend_to_a_coarse_motion_begins() -> None:
    waypoints = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0]])
    parts = PathParts(waypoints, np.array([0, 1, 2, 3]), np.array([0.002, 0.05, 0.002]))
    curve = blend(waypoints, parts.tolerances)
    half = curve.half_lengths[1]
    assert half > 0.1 and np.allclose(parts.boundaries(curve), [0.0, 1.0 - half, 2.0 + half, 3.0])
    same = PathParts(waypoints, parts.edges, np.full(3, 0.05))
    assert np.allclose(same.boundaries(blend(waypoints, same.tolerances)), [0.0, 1.0, 2.0, 3.0])


@pytest.mark.parametrize("turn", [0.02, 0.3, 1.2])
@pytest.mark.parametrize("length", [0.3, 0.02, 0.001])
def test_half_of_a_line_at_least_stays_a_line(length: float, turn: float) -> None:
    """A line may be shorter than a wide blend: its part lasts, and what follows the line is not rounded."""
    along = np.array([np.cos(turn), np.sin(turn)])
    waypoints = np.array([[-1.0, 0.0], [0.0, 0.0], length * along, (length + 0.02) * along])
    parts = PathParts(waypoints, np.array([0, 1, 2, 3]), np.array([0.05, 0.002, 0.002]))
    curve = blend(waypoints, parts.tolerances)
    begin, end = parts.boundaries(curve)[1:3]
    assert begin <= 1.0 + length / 2 + 1e-9 and end == pytest.approx(1.0 + length, abs=1e-6)
    q = curve.evaluate(np.linspace(begin, curve.length, 400))
    assert distance_to_polyline(q, waypoints).max() <= 0.002


def test_blend_that_would_leave_the_joint_limits_is_cut_back() -> None:
    """A wide bump of the one corner must not carry the next one, which lies on a limit, over it."""
    waypoints = np.array([[0.0, 0.0], [0.3, 0.0], [0.32, 0.001], [0.34, 0.0], [0.6, 0.3]])
    tight = replace(limits(2), upper=np.array([50.0, 0.3]), lower=np.array([-50.0, 0.0]))
    curve = proven_blend(whole(waypoints), tight, None)
    q = curve.evaluate(curve.knots)
    assert np.all(q >= tight.lower - 1e-9) and np.all(q <= tight.upper + 1e-9)


def test_split_cuts_at_stops() -> None:
    waypoints = random_walk(3, 5, 3)
    curve = blend(waypoints, np.array([0.02, 0.02, 0.0, 0.02, 0.02]))
    first, second = curve.split()
    assert curve.stops.tolist() == [2]
    s = np.linspace(0.0, first.length, 50)[:-1]
    assert np.allclose(first.evaluate(s), curve.evaluate(s))
    s = np.linspace(0.0, second.length, 50)
    assert np.allclose(second.evaluate(s), curve.evaluate(s + first.length))


def test_path_to_nowhere_is_one_point() -> None:
    curve = blend(np.ones((4, 3)), 0.02)
    assert curve.length == 0.0 and isinstance(curve, BlendedPath)
    assert np.array_equal(curve.evaluate(0.0), np.ones((1, 3)))


@pytest.mark.parametrize("bad", [np.empty((0, 3)), np.full((2, 3), np.nan), np.zeros(3)])
def test_unusable_waypoints_are_refused(bad: Array) -> None:
    with pytest.raises(ValueError, match="waypoints"):
        canonical(bad)


def _first_beyond(chords: Array, slack: Array, polyline: Array, allowed: float) -> int:
    """Index of the first chord whose tube reaches farther than ``allowed`` from the polyline, or -1."""
    for k in range(len(chords) - 1):
        points = chords[k] + np.linspace(0.0, 1.0, 9)[:, None] * (chords[k + 1] - chords[k])
        if distance_to_polyline(points, polyline).max() + np.linalg.norm(slack[k]) > allowed:
            return k
    return -1
