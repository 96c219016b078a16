"""The support relation, judged by physics: what it says will stay stays when the item is gone."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pickcli.cell.cell_file import load_cell
from pickcli.scene.scene import Scene
from pickcli.statics.supports import Supports, supports_of
from pickcli.trial.pose_noise import DEFAULT_NOISE, perceive
from pickcli.verification.pile_statics import removal
from support.piles import PATTERNS, moved_without, pile

CELL = load_cell("apc2016_delft")
STAYED = 0.01  # m: what moved no farther has neither fallen nor rolled away
FALLEN = 0.02  # m: what moved farther has fallen or rolled away
SETTLED = 0.03  # m: the same of what the item lay on, which gives a little when the weight is off it


def moved_without_each(scene: Scene) -> dict[str, dict[str, float]]:
    """By item that vanishes: how far in m every other one moves."""
    return {placed.id: moved_without(scene, placed.id) for placed in scene.items}


def surprises(
    scene: Scene, moved: dict[str, dict[str, float]], believed: Scene
) -> dict[str, dict[str, float]]:
    """By item that vanishes: what moved although it was to stay, and how far.

    What is expected to fall is cleared before the item is taken: what only that meets as it falls may move.
    """
    supports = supports_of(believed)
    found = {}
    for gone, ways in moved.items():
        expected = supports.falling(gone)
        found[gone] = _unexpected(supports, gone, ways)
        if found[gone] and expected:
            found[gone] = _unexpected(supports, gone, moved_without(scene, gone, *expected))
    return {name: moved for name, moved in found.items() if moved}


def _unexpected(supports: Supports, gone: str, ways: dict[str, float]) -> dict[str, float]:
    expected, below = supports.falling(gone), supports.graph.chain(supports.graph.carriers, gone)
    return {
        name: way
        for name, way in ways.items()
        if way > (SETTLED if name in below else STAYED) and name not in expected
    }


@pytest.mark.parametrize("pattern", PATTERNS)
def test_what_is_to_stay_stays(pattern: str) -> None:
    scene = next(s for k in range(20) if (s := pile(CELL, pattern, k)) is not None)
    moved = moved_without_each(scene)
    assert surprises(scene, moved, scene) == {}
    assert surprises(scene, moved, perceive(scene, DEFAULT_NOISE, 1, 1)) == {}


def test_what_falls_on_another_does_not_count_as_what_did_not_stay() -> None:
    """A bear on a mailer on a roll: without the mailer it falls on the roll, and is cleared before it."""
    scene = pile(CELL, "see-saw", 5074)
    assert scene is not None
    moved, believed = moved_without_each(scene), perceive(scene, DEFAULT_NOISE, 5074, 1)
    assert max(moved["scotch_bubble_mailer#2"].values()) > SETTLED
    assert surprises(scene, moved, believed) == {}


@pytest.mark.slow
@given(st.sampled_from(PATTERNS), st.integers(0, 10_000))
@settings(max_examples=60, deadline=None, derandomize=True)
def test_what_is_to_stay_stays_in_any_pile(pattern: str, seed: int) -> None:
    scene = pile(CELL, pattern, seed)
    if scene is not None:
        believed = perceive(scene, DEFAULT_NOISE, seed, 1)
        assert surprises(scene, moved_without_each(scene), believed) == {}


@pytest.mark.slow
def test_the_verifier_sees_what_falls_or_would_be_lifted_and_no_more_than_the_planner_clears() -> None:
    """Its own statics find nine in ten of what physics moves; the planner, who keeps a margin, all of it."""
    fallen = found = 0
    for pattern in PATTERNS:
        for scene in [s for k in range(4) if (s := pile(CELL, pattern, k)) is not None]:
            supports = supports_of(scene)
            for gone, ways in moved_without_each(scene).items():
                below = supports.graph.chain(supports.graph.carriers, gone)
                moved = {name for name, way in ways.items() if way > FALLEN} - below
                effects = removal(scene, gone)
                assert effects.lifted | effects.falling <= set(supports.falling(gone)), (pattern, gone)
                fallen, found = fallen + len(moved), found + len(moved & (effects.lifted | effects.falling))
    assert fallen >= 20 and found >= 0.9 * fallen, (found, fallen)


def refused(believed: Scene) -> set[tuple[str, str]]:
    """What the planner would take, and the verifier says is lifted or falls then."""
    taken = [placed.id for placed in believed.items if not supports_of(believed).blocking(placed.id)]
    effects = {item: removal(believed, item) for item in taken}
    return {(item, name) for item in taken for name in effects[item].lifted | effects[item].falling}


@pytest.mark.parametrize("pattern", PATTERNS)
def test_the_verifier_refuses_nothing_that_the_planner_would_take(pattern: str) -> None:
    scenes = [scene for k in range(3) if (scene := pile(CELL, pattern, k)) is not None]
    assert scenes
    for scene in scenes:
        assert refused(scene) == set()
        assert refused(perceive(scene, DEFAULT_NOISE, 1, 1)) == set()


@pytest.mark.slow
@given(st.sampled_from(PATTERNS), st.integers(0, 10_000))
@settings(max_examples=60, deadline=None, derandomize=True)
def test_the_verifier_refuses_nothing_that_the_planner_would_take_from_any_pile(
    pattern: str, seed: int
) -> None:
    scene = pile(CELL, pattern, seed)
    if scene is not None:
        assert refused(scene) == set()
        assert refused(perceive(scene, DEFAULT_NOISE, seed, 1)) == set()


def test_the_judge_sees_what_falls() -> None:
    """A generator whose piles never fall would judge nothing."""
    scenes = [
        scene for pattern in PATTERNS for k in range(3) if (scene := pile(CELL, pattern, k)) is not None
    ]
    falls = [moved_without(scene, scene.items[0].id) for scene in scenes]
    assert sum(max(moved.values()) > STAYED for moved in falls) >= len(scenes) // 3
