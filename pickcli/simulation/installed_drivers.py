"""Drivers by name: built-in ones, and those of installed packages."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pickcli.errors import UnknownNameError
from pickcli.plugins import added, loaded

if TYPE_CHECKING:
    from pickcli.simulation.driver import DriverFactory, DriverRequest
    from pickcli.simulation.world import World

GROUP = "apc.drivers"
SIMULATED, RECORDED = "pybullet", "recorder"
BUILT_IN = (SIMULATED, RECORDED)


def driver_names() -> list[str]:
    """Return the names of all drivers.

    Returns:
        Names, the built-in ones first.
    """
    return [*BUILT_IN, *added(GROUP, BUILT_IN)]


def driver_factory(name: str) -> DriverFactory:
    """Return the factory of a driver.

    Args:
        name: Name of the driver.

    Returns:
        Function from a request to a driver, which must be closed.

    Raises:
        InputError: No driver has that name, or the package's entry point cannot be used.
    """
    if name == SIMULATED:
        return _simulated
    if name == RECORDED:
        from pickcli.simulation.recorder import Recorder

        return Recorder.connect
    others = added(GROUP, BUILT_IN)
    if name not in others:
        raise UnknownNameError("driver", name, driver_names())
    factory: DriverFactory = loaded("driver", others[name], callable, "function that makes a driver")
    return factory


def _simulated(request: DriverRequest) -> World:
    """Create the simulated world of a request."""
    from pickcli.simulation.world import World

    world = World(request.scene, request.q, request.tool_state, reality=request.reality, seed=request.seed)
    for name, speed in request.belt_speeds.items():
        world.run_belt(name, speed)
    return world
