"""Drivers by their names: those of this package, and those that installed packages add."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pickcli.errors import UnknownNameError
from pickcli.plugins import added, loaded

if TYPE_CHECKING:
    from pickcli.simulation.driver import DriverFactory

GROUP = "apc.drivers"
SIMULATED, RECORDED = "pybullet", "recorder"
BUILT_IN = (SIMULATED, RECORDED)


def driver_names() -> list[str]:
    """The names of all drivers.

    Returns:
        Those of this package first.
    """
    return [*BUILT_IN, *added(GROUP, BUILT_IN)]


def driver_factory(name: str) -> DriverFactory:
    """Find what makes a driver.

    Args:
        name: Its name.

    Returns:
        From a request to a driver, which is to be closed.

    Raises:
        InputError: There is none of that name, or what a package adds cannot be used.
    """
    if name == SIMULATED:
        from pickcli.simulation.world import World

        return lambda request: World(
            request.scene, request.q, request.tool_state, reality=request.reality, seed=request.seed
        )
    if name == RECORDED:
        from pickcli.simulation.recorder import Recorder

        return Recorder.connect
    others = added(GROUP, BUILT_IN)
    if name not in others:
        raise UnknownNameError("driver", name, driver_names())
    factory: DriverFactory = loaded("driver", others[name], callable, "function that makes a driver")
    return factory
