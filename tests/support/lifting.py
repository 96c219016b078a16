"""Lifts an item out of a heap in the engine, as if a cup that gives way a little held it by its centre."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pickcli.geometry import GRAVITY, Array
from pickcli.scene.scene import Scene
from pickcli.simulation.engine import Engine
from pickcli.simulation.places import location_of

GREY = (0.5, 0.5, 0.5, 1.0)
TIME_STEP = 1e-3  # s
REST = 0.03  # s in which what was settled elsewhere settles here
SPEED, RAMP = 0.25, 2.0  # m/s of a lift, m/s^2 up to it
HEIGHT = 0.18  # m: out of any crate
AFTERWARDS = 0.4  # s
STIFFNESS, TURNING = 2000.0, 5.0  # N/m, Nm/rad


@dataclass(frozen=True)
class Lifted:
    """What a lift did to the others.

    Attributes:
        pressed: N, the largest at one point with which each item that touched it pressed on the lifted one
            once that was lifted by more than the first stretch.
        out: Ids of the items that left their place.
    """

    pressed: dict[str, float]
    out: tuple[str, ...]


def lifted(scene: Scene, name: str, stretch: float) -> Lifted:
    """Lift an item straight up, as fast as a plan does.

    Args:
        scene: Items at rest.
        name: Id of the item.
        stretch: m of the way on which it may be touched.

    Returns:
        What that did to the others.
    """
    engine = Engine(TIME_STEP)
    for carrier in scene.posed_carriers:
        for body in carrier.bodies:
            engine.add_static(body, carrier.T_world_carrier, GREY)
    for placed in scene.items:
        engine.add_item(placed.id, placed.item, placed.T_world_item, GREY)
    for _ in range(round(REST / TIME_STEP)):
        engine.step()
    T, mass = engine.pose(name), scene.find(name).item.mass
    others = {placed.id for placed in scene.items} - {name}
    pressed: dict[str, float] = {}
    risen = speed = 0.0
    while risen < HEIGHT:
        speed = min(SPEED, speed + RAMP * TIME_STEP)
        risen += speed * TIME_STEP
        _hold(engine, name, mass, T, risen, speed)
        engine.step()
        for point in engine.contact_points(name) if risen > stretch else ():
            if point.b in others:
                pressed[point.b] = max(pressed.get(point.b, 0.0), point.force)
    engine.remove(name)
    for _ in range(round(AFTERWARDS / TIME_STEP)):
        engine.step()
    left = [placed for placed in scene.items if placed.id != name]
    out = [p.id for p in left if location_of(scene, p.item, engine.pose(p.id)) != p.location]
    engine.close()
    return Lifted(pressed, tuple(out))


def _hold(engine: Engine, name: str, mass: float, T: Array, risen: float, speed: float) -> None:
    """Push an item for one step towards where it is to be, upright as it was."""
    engine.wake(name)
    now = engine.pose(name)
    centre = now[:3, 3]
    velocity, turn = engine.velocity(name, "", centre)
    up = np.array([0.0, 0.0, 1.0])
    damping = 2.0 * np.sqrt(STIFFNESS * mass)
    force = STIFFNESS * (T[:3, 3] + risen * up - centre) + damping * (speed * up - velocity)
    engine.apply_force(name, force + mass * GRAVITY * up, centre)
    axes = zip(now[:3, :3].T, T[:3, :3].T, strict=True)
    askew = sum((np.cross(a, b) for a, b in axes), np.zeros(3)) / 2
    engine.twist(name, TURNING * askew - 0.02 * turn)
