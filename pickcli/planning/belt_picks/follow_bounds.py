"""Says at once that an item on a belt which the whole arm follows cannot be taken: by where the wrist can be.

While the fingers close, the tool is somewhere on the item, in one of the orientations in which the item may
be grasped, and rides with it. So the centre of the wrist is in a box that travels with the belt, before and
after in one that is larger by what lines move it at most. A table, made once for an arm and a belt, lists all
places over the belt at which the wrist can be (``kinematics.wrist_reach``). If there is no time of contact
at which all of these boxes are reached within the window, there is no plan. As the table leaves out nothing,
that is true of every grasp on the item and every branch of the arm.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from pickcli.cartesian.corridor import LEAST_LIFT
from pickcli.cell.station import Carrier
from pickcli.errors import Reason
from pickcli.files.derived_cache import content_key, derived_arrays
from pickcli.geometry import Array, inverse
from pickcli.grasping.grasp_target import GraspTarget
from pickcli.kinematics.wrist_reach import FINEST, VOXEL, WristCentre, WristReach
from pickcli.planning.pick_settings import GraspApproach
from pickcli.planning.planning_context import PlanningContext
from pickcli.scene.scene import PlacedItem, Scene

VERSION = 1  # of the table; those of others are derived again
HIGHEST = 0.3  # m over the belt of the top of the highest item that is looked at
EVERY = 0.02  # s between times of contact that are told apart
MARGIN = 0.1  # m of the table beyond the belt and the items on it: the most that lines are off them
SAME_OFFSET = 9  # digits of m to which offsets of the wrist from the tool are the same


@dataclass(frozen=True)
class RideTimes:
    """Bounds of the time of a contact, in s from the start of the plan.

    Attributes:
        speed: m/s of the belt.
        first: s of the first contact that is tried.
        last: s until which the item has to be off the belt.
    """

    speed: float
    first: float
    last: float


def why_unreached(
    context: PlanningContext, carrier: Carrier, scene: Scene, item_id: str, times: RideTimes
) -> Reason | None:
    """Say that the arm can hold no grasp of an item in time while it rides along.

    Args:
        context: The cell and its models.
        carrier: The conveyor.
        scene: The scene at the start of the plan.
        item_id: Id of the item in it.
        times: The times of the belt.

    Returns:
        The reason; None if there may be a grasp.
    """
    placed, settings = scene.find(item_id), context.settings
    closing = context.method.rests(context.cell.devices, settings.release_time).taking
    lifted = settings.first_stretch + LEAST_LIFT
    lasts = closing + lifted / settings.lift_speed
    contacts = np.arange(times.first, times.last - lasts + EVERY, EVERY)
    if len(contacts) == 0 or times.first > times.last - lasts:
        late = times.first + lasts - times.last
        return Reason("too late", item_id, f"by {1e3 * late:.0f} ms for the first contact that is tried")
    ride = _ride(context, carrier, scene, placed)
    if ride is None:
        return None
    approach = settings.approach_offset
    moments = ((-approach / settings.approach_speed, approach), (0.0, 0.0), (closing, 0.0), (lasts, lifted))
    reached = [ride.may_reach(times.speed * (contacts + t), times.speed * EVERY, by) for t, by in moments]
    if np.logical_and.reduce(reached).any():
        return None
    over = f"{times.first:.2f} to {times.last - lasts:.2f} s from the start, and ride along"
    return Reason("out of reach", item_id, f"the arm cannot be over it at any time from {over}")


@dataclass(frozen=True, eq=False)
class _Ride:
    """An item on a belt, and where the wrist is while the tool is on it.

    reach: where the wrist can be, in the frame of the belt
    middle: (3,) m of the item there, at the start
    half: (3,) m of the box around it
    offsets: (K, 3) m of the wrist from the tool, of all orientations
    """

    reach: WristReach
    middle: Array
    half: Array
    offsets: Array

    def may_reach(self, travel: Array, on: float, beyond: float) -> NDArray[np.bool_]:
        """Tell whether the wrist may be where the item is after some travel (T,) m, in each orientation.

        Returns (T, K).

        on: m that the item travels on meanwhile
        beyond: m that the tool may be off the item, to any side
        """
        at = (self.middle + self.offsets)[None] + np.multiply.outer(travel, (1.0, 0.0, 0.0))[:, None]
        half = self.half + beyond
        return self.reach.may_be_in(at - half, at + half + (on, 0.0, 0.0))


def _ride(context: PlanningContext, carrier: Carrier, scene: Scene, placed: PlacedItem) -> _Ride | None:
    """Describe the ride of an item; None if nothing is known of how it is grasped, or of the wrist."""
    T_belt_item = inverse(carrier.T_world_carrier) @ placed.T_world_item
    half = placed.item.shape.reach(T_belt_item[:3, :3])
    recorded, fixed = context.recorded, context.settings.approach is GraspApproach.LINES
    if recorded is not None or not fixed or float(T_belt_item[2, 3] + half[2]) > HIGHEST:
        return None
    place = next(iter(carrier.places.values()))
    T_world_entry = scene.T_world_place(place) @ place.T_place_entry
    target = GraspTarget(placed.id, placed.item, inverse(T_world_entry) @ placed.T_world_item, place)
    turns, wrist = context.method.orientations(target), _wrist(context)
    if turns is None or wrist is None:
        return None
    offsets = np.unique(np.round(T_belt_item[:3, :3] @ turns @ wrist.in_tip, SAME_OFFSET), axis=0)
    return _Ride(_reach(context, carrier, wrist), T_belt_item[:3, 3], half, offsets)


@lru_cache(maxsize=8)
def _wrist(context: PlanningContext) -> WristCentre | None:
    """Return the wrist of the arm, which is the same in all states of a gripper."""
    return WristCentre.of(context.arm, context.cell.robot.tool.default_state)


@lru_cache(maxsize=8)
def _reach(context: PlanningContext, carrier: Carrier, wrist: WristCentre) -> WristReach:
    """Return where the wrist can be over a belt, from the cache, or find and keep it."""
    belt, cell = carrier.conveyor, context.cell
    assert belt is not None
    from_tip = float(np.linalg.norm(wrist.in_tip))
    lower = np.array([belt.window[0], -belt.width / 2, 0.0]) - from_tip - MARGIN
    upper = np.array([belt.window[1], belt.width / 2, HIGHEST]) + from_tip + MARGIN

    def derive() -> dict[str, NDArray[np.bool_]]:
        state, T = cell.robot.tool.default_state, carrier.T_world_carrier
        return {"occupied": WristReach.within(context.arm, state, wrist, T, lower, upper).occupied}

    made_from = {
        "cell": cell.fingerprint, "belt": carrier.name, "voxel": VOXEL, "finest": FINEST, "version": VERSION,
    }  # fmt: skip
    key = content_key(cell.name, cell.arm, carrier.name)
    return WristReach(lower, derived_arrays("wrists", key, made_from, derive)["occupied"])
