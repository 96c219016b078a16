"""Locates the tote by touching it: the loop over the touches, in the simulated world."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from pickcli.calibration.tote_fit import (
    TILTED,
    UPRIGHT,
    ToteEstimate,
    TouchedPoint,
    fit_tote,
    refuse_misfit,
)
from pickcli.calibration.tote_shape import tote_shape
from pickcli.calibration.touch_measurement import STIFFNESS_ERROR, EncoderNoise, TouchReading
from pickcli.calibration.touch_planning import ToteBelief, plan_touch
from pickcli.calibration.touch_points import DEFAULT_TOUCHES, N_FIRST, RIMS, TouchPoint, touch_points
from pickcli.cell.cell import Cell
from pickcli.cell.pod_tolerance import Displacement, displaced
from pickcli.cell.station import TOTE
from pickcli.cell.tools.suction_cup import SuctionCup
from pickcli.errors import InputError
from pickcli.geometry import Array, inverse, to_rpy
from pickcli.motion.plan import Plan
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.start_state import Start
from pickcli.scene.scene import Scene, empty_scene, tote_pose
from pickcli.seeds import derived_rng, derived_seed
from pickcli.simulation.contacts import Collision
from pickcli.simulation.execute import execute
from pickcli.simulation.guarded_move import GuardedMove, TouchSensing, guarded_move
from pickcli.simulation.reality import DEFAULT
from pickcli.simulation.world import World

TOLERANCE = Displacement(0.03, 0.03, float(np.radians(3.0)))  # within which the tote may be displaced
HEIGHT = 0.002  # m, either way: it stands on the table; the clearance of all motions is more
RANDOM = "random"  # word for a displacement
ROOM = 1e-3  # m and rad that bounds of a first estimate are widened by


@dataclass(frozen=True)
class LocatingSettings:
    """How the tote is located.

    Attributes:
        n_touches: Number of touches.
        with_tilt: Whether its roll and pitch are estimated; else it stands upright.
        sensing: How a contact is felt.
        encoders: Errors of the joints as they are read.
    """

    n_touches: int = DEFAULT_TOUCHES
    with_tilt: bool = False
    sensing: TouchSensing = field(default_factory=TouchSensing)
    encoders: EncoderNoise = field(default_factory=EncoderNoise)


@dataclass(frozen=True, eq=False)
class Touch:
    """One touch that was made.

    Attributes:
        touched: Where the face was met.
        record: The guarded move.
    """

    touched: TouchedPoint
    record: GuardedMove


@dataclass(frozen=True, eq=False)
class LocatedTote:
    """The result of locating the tote.

    Attributes:
        estimate: Its pose with bounds.
        touches: The touches in their order.
        duration: s, simulated, from home to the last touch.
        collisions: Unplanned contacts.
    """

    estimate: ToteEstimate
    touches: tuple[Touch, ...]
    duration: float
    collisions: tuple[Collision, ...]


def tote_offset(T_from: Array, T_to: Array, names: tuple[str, ...] = UPRIGHT) -> dict[str, float]:
    """Return by how much a pose of the tote is off another one, in the frame of that.

    Args:
        T_from: (4, 4) e.g. where it was located.
        T_to: (4, 4) e.g. where it truly stands.
        names: Of x, y, z, yaw, roll and pitch.

    Returns:
        m and rad by name.
    """
    T = inverse(T_from) @ T_to
    roll, pitch, yaw = to_rpy(T[:3, :3])
    offsets = dict(zip(TILTED, [*T[:3, 3], yaw, roll, pitch], strict=True))
    return {name: float(offsets[name]) for name in names}


def shifted_tote(cell: Cell, shift: Displacement) -> Array:
    """Return the pose of a displaced tote.

    Args:
        cell: A cell with a tote.
        shift: The displacement in the tote's nominal frame.

    Returns:
        (4, 4) ``T_world_tote``, of the middle of its inner floor.

    Raises:
        InputError: The cell has no tote, or the displacement is beyond ``TOLERANCE``.
    """
    T = tote_shape(cell).T_world_tote
    if not TOLERANCE.allows(displaced(np.eye(4), shift.x, shift.y, shift.yaw)):
        raise InputError(
            f"--tote-shift: {1e3 * shift.x:g} mm, {1e3 * shift.y:g} mm and {np.degrees(shift.yaw):g} degrees "
            f"is beyond what touches reach: {1e3 * TOLERANCE.x:g} mm, {1e3 * TOLERANCE.y:g} mm and "
            f"{np.degrees(TOLERANCE.yaw):g} degrees either way"
        )
    return displaced(T, shift.x, shift.y, shift.yaw)


def tote_pose_in_simulation(cell: Cell, shift: Displacement | str | None, seed: int) -> Array:
    """Return where the simulated tote truly stands.

    Args:
        cell: A cell with a tote.
        shift: Its displacement; "random" for one within ``TOLERANCE``, "none" or None for none.
        seed: Seed of a random displacement.

    Returns:
        (4, 4) ``T_world_tote``.

    Raises:
        InputError: The cell has no tote, or the displacement is beyond ``TOLERANCE``.
    """
    if isinstance(shift, Displacement):
        return shifted_tote(cell, shift)
    share = derived_rng("tote shift", seed).uniform(-1.0, 1.0, 3) if shift == RANDOM else np.zeros(3)
    x, y, yaw = (float(v) for v in share * [TOLERANCE.x, TOLERANCE.y, TOLERANCE.yaw])
    return shifted_tote(cell, Displacement(x, y, yaw))


def locate_in_simulation(
    context: PlanningContext, T_world_tote: Array, settings: LocatingSettings, seed: int
) -> LocatedTote:
    """Locate the tote of an empty cell in the simulated world, beginning at home.

    Args:
        context: The cell with what motions are planned by.
        T_world_tote: (4, 4) where the tote truly stands.
        settings: How it is located.
        seed: Seed of all random choices and of all that is not as stated.

    Returns:
        The estimate and the touches.

    Raises:
        InputError: As ``locate_tote``.
        NoPlanError: As ``locate_tote``.
    """
    scene = empty_scene(context.cell)
    world = simulated_tote_world(scene, T_world_tote, seed)
    try:
        return locate_tote(context, scene, world, settings, seed)
    finally:
        world.close()


def locate_tote(
    context: PlanningContext, scene: Scene, world: World, settings: LocatingSettings, seed: int
) -> LocatedTote:
    """Locate the tote by touching it.

    Every motion to a touch is planned with the tote as the volume that it may fill, proven and verified; the
    touch itself is a guarded move. After the first touches, which fix x, y and yaw and, if there are more
    than six, check them by the wall across, the bounds of those take the place of the tolerance, so that the
    lip meets the narrow rim.

    Args:
        context: The cell with what motions are planned by.
        scene: What is known besides where the tote is.
        world: The simulated world, with the arm at rest.
        settings: How it is located.
        seed: Seed of all random choices, and of the errors of the joints.

    Returns:
        The estimate and the touches.

    Raises:
        InputError: The cell has no tote or no cup, or a touch felt nothing, or the touches do not fit.
        NoPlanError: There is no motion to a touch.
    """
    cell, shape = context.cell, tote_shape(context.cell)
    grip = cell.robot.tool.grip
    if grip.gives_way == 0.0:
        raise InputError(f"cell {cell.name}: its tool has no cup, by the lip of which the tote is felt")
    aims = touch_points(shape, settings.n_touches, grip.tip_radius)
    reading = TouchReading(context.arm, grip.stiffness, world.time_step, settings.encoders)
    belief = ToteBelief(shape.T_world_tote, TOLERANCE, HEIGHT)
    names = TILTED if settings.with_tilt else UPRIGHT
    n_first = min(N_FIRST + 1, settings.n_touches - RIMS)  # with one that checks them, if there is one
    touches: list[Touch] = []
    began = world.t
    for i, aim in enumerate(aims):
        start = Start(world.q.copy(), world.tool_state)
        planned = plan_touch(context, scene, belief, aim, start, derived_seed(seed, aim.name))
        _bring(world, planned.way, aim)
        record = guarded_move(planned.line, world, frozenset(aim.face.bodies), settings.sensing)
        _refuse_unfelt(aim, record)
        rng = derived_rng(seed, "encoders", aim.name)
        touched = reading.touched_point(aim, record, planned.tool_state, rng)
        touches.append(Touch(touched, record))
        if i + 1 == n_first:
            belief = _narrowed(belief, [each.touched for each in touches])
    points = [each.touched for each in touches]
    estimate = fit_tote(points, belief.T_world_tote, names)
    refuse_misfit(points, belief.T_world_tote, estimate)
    return LocatedTote(estimate, tuple(touches), world.t - began, world.contacts.collisions)


def simulated_tote_world(scene: Scene, T_world_tote: Array, seed: int) -> World:
    """Make the simulated world of a scene with the tote elsewhere, and the arm at home.

    The bellows are stiffer or softer than stated, as rubber is.

    Args:
        scene: The scene.
        T_world_tote: (4, 4) where the tote truly stands.
        seed: Seed of the world's deviations from its model.

    Returns:
        The world; the caller closes it.
    """
    robot, home = scene.cell.robot, scene.cell.home
    grip = robot.tool.grip
    if isinstance(grip, SuctionCup):
        share = float(derived_rng(seed, "stiffness").uniform(-1.0, 1.0)) * STIFFNESS_ERROR
        grip = replace(grip, stiffness=grip.stiffness * (1.0 + share))
    cell = replace(scene.cell, robot=replace(robot, tool=replace(robot.tool, grip=grip)))
    true = replace(scene, cell=cell, carriers={**scene.carriers, TOTE: tote_pose(cell, T_world_tote)})
    return World(true, home.q, home.tool_state, reality=DEFAULT, seed=seed)


def _bring(world: World, way: Plan, aim: TouchPoint) -> None:
    """Carry out the motion to a touch. Raises InputError if it is stopped."""
    done = execute(way, world)
    if done.stop is not None:
        raise InputError(f"tote not located: the motion to touch {aim.name} was stopped: {done.stop}")


def _refuse_unfelt(aim: TouchPoint, record: GuardedMove) -> None:
    """Refuse a touch that felt nothing, or was stopped by something else."""
    if record.is_felt:
        return
    if record.stop is not None:
        raise InputError(f"tote not located: touch {aim.name} was stopped: {record.stop}")
    raise InputError(
        f"tote not located: touch {aim.name} met nothing: the tote is displaced by more than "
        f"{1e3 * TOLERANCE.x:g} mm and {np.degrees(TOLERANCE.yaw):g} degrees, or is missing"
    )


def _narrowed(belief: ToteBelief, touched: list[TouchedPoint]) -> ToteBelief:
    """Return what the first touches leave open of where the tote is. Its height is still as before.

    If they do not fit, later motions would be proven around a tote that is elsewhere: that raises InputError.
    """
    fit = fit_tote(touched, belief.T_world_tote, ("x", "y", "yaw"))
    refuse_misfit(touched, belief.T_world_tote, fit)
    bounds = Displacement(*(fit.bound(name) + ROOM for name in ("x", "y", "yaw")))
    return ToteBelief(fit.T_world_tote, bounds, belief.height)
