from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

from pickcli.cell.cell import Cell
from pickcli.simulation.planned_contacts import PlannedContacts
from pickcli.simulation.world import World
from support.pedestal import BuildWorld, evacuate, make_world


@pytest.fixture
def build_world(cell: Cell) -> Iterator[BuildWorld]:
    """``pedestal.make_world`` for the default cell; closes what it built."""
    worlds = []

    def build(*arguments: Any, **keywords: Any) -> World:
        worlds.append(make_world(cell, *arguments, **keywords))
        return worlds[-1]

    yield build
    for world in worlds:
        world.close()


@pytest.fixture
def holding(build_world: BuildWorld) -> World:
    """A world whose cup holds a cube of 0.1 kg in the air, at full vacuum."""
    world = build_world()
    evacuate(world)
    world.act("valve", "on")
    world.wait(0.4)
    assert world.held == "cube"
    world.engine.remove("pedestal")
    world.planned = PlannedContacts()
    world.wait(0.1)
    return world
