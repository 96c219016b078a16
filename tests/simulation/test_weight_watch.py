"""What the tool carries is weighed by the motors, and an item that it cannot be stops the motion."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace

import pytest

from pickcli.simulation.execute import execute
from pickcli.simulation.protective_stop import StopCause
from pickcli.simulation.thresholds import Thresholds
from pickcli.simulation.weight_watch import WeightWatch
from pickcli.simulation.world import World
from support.handmade_plans import CRAYOLA, pick

PLAN, SCENE = pick()
DOUBT = Thresholds().mass


@pytest.fixture
def weighed(monkeypatch: pytest.MonkeyPatch) -> list[float | None]:
    """The masses that were judged, in the order of the executions."""
    found: list[float | None] = []
    judged = WeightWatch._judged

    def recording(self: WeightWatch) -> object:
        found.append(self.mass)
        return judged(self)

    monkeypatch.setattr(WeightWatch, "_judged", recording)
    return found


def told(world: World, mass: float) -> World:
    """The world with an item of another mass than everybody is told."""
    items = tuple(replace(p, item=replace(p.item, mass=mass)) for p in world.scene.items)
    world.scene = replace(world.scene, items=items)
    return world


@pytest.fixture
def world() -> Iterator[World]:
    """A box in a bin, and the robot before it."""
    with closing(World(SCENE, PLAN.trajectory.positions[0], PLAN.segments[0].tool_state, seed=2)) as world:
        yield world


def test_an_item_is_weighed_to_a_few_grams_and_carried_on(world: World, weighed: list[float | None]) -> None:
    record = execute(PLAN, world)
    assert record.is_clean, record.trouble
    assert weighed == [pytest.approx(world.engine.mass(CRAYOLA), abs=0.01)]


@pytest.mark.parametrize("wrong", ["lighter", "heavier"])
def test_another_item_stops_the_motion_and_is_still_held(world: World, wrong: str) -> None:
    true = world.engine.mass(CRAYOLA)
    stated = (true + 1.4 * DOUBT) / 0.9 if wrong == "lighter" else (true - 1.4 * DOUBT) / 1.1
    record = execute(PLAN, told(world, stated))
    assert record.stop is not None and record.stop.cause is StopCause.WRONG_WEIGHT
    assert record.stop.where == CRAYOLA and record.stop.unit == "kg"
    assert record.stop.measured == pytest.approx(true, abs=0.01)
    assert "wrong weight" in record.stopped and record.has_item and world.held == CRAYOLA


def test_within_the_doubt_nothing_is_said(world: World) -> None:
    record = execute(PLAN, told(world, (world.engine.mass(CRAYOLA) + 0.6 * DOUBT) / 0.9))
    assert record.is_clean, record.trouble
