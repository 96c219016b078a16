"""Draws a random stream: items that come along a conveyor one after the other.

Items are drawn from those that the tool can take from above as they stand: a cup by a share of full vacuum
that bears ``RESERVE`` times their weight, fingers by places that bear it, with room beside the item and over
the belt. They stand on one of their sides, turned at random.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.conveyor import Conveyor
from pickcli.cell.item import LEAST_SHARE, Item
from pickcli.cell.station import Carrier
from pickcli.cell.tool import Tool
from pickcli.errors import Failures, InputError, UnknownNameError
from pickcli.geometry import GRAVITY, Array, pose, rotation_axis_angle
from pickcli.grasping.search import USUAL
from pickcli.grasping.surfaces import wide_faces
from pickcli.planning.belt_picks.arm_intercept import DEVIATION
from pickcli.planning.pick_problem import PickProblem, PickQuery
from pickcli.planning.planning_context import PlanningContext
from pickcli.planning.stages.extraction import CorridorSet, extraction_of
from pickcli.planning.stages.tool_clearance import with_tool_clearance
from pickcli.random_scenes.stable_poses import StablePose, stable_poses
from pickcli.scene.item_stream import ItemStream, RidingItem
from pickcli.scene.scene import PoseNoise
from pickcli.scene.stream_schema import MAX_TIME
from pickcli.seeds import derived_rng

YEAR = 2016  # of the items
RESERVE = (
    4.0  # times the weight that the tool bears at least: for acceleration, bending, and items off their pose
)
SEEN = PoseNoise(0.002, float(np.radians(1.0)))  # errors of poses, with which fingers have to have room
LANES = 0.13  # m that the middle of an item is off the middle of the belt at most
FROM_EDGE = 0.01  # m between an item and the edge of the belt, at least


@dataclass(frozen=True)
class StreamRequest:
    """What a stream is to be.

    Attributes:
        n_items: Number of items.
        speed: m/s of the belt.
        gap: m, least and greatest distance along the belt between the end of one item and the next.
        one_by_one: Whether each is set down, on a belt that stands, when the one before is gone.
        within: m from the infeed, between which they are set down so; None for the window.
    """

    n_items: int
    speed: float
    gap: tuple[float, float]
    one_by_one: bool = False
    within: tuple[float, float] | None = None


def conveyors(cell: Cell) -> dict[str, Carrier]:
    """Return the conveyors of a cell.

    Args:
        cell: The cell.

    Returns:
        Carriers by name.

    Raises:
        InputError: The cell has none.
    """
    found = {each.name: each for each in cell.own_carriers if each.conveyor is not None}
    if not found:
        raise InputError(
            f"{cell.path / 'cell.yaml'}: has no conveyor; add a place of kind conveyor "
            "(docs/formats/cell.md), or name a cell that has one, e.g. --cell conveyor_sia20"
        )
    return found


def make_stream(cell: Cell, request: StreamRequest, seed: int, conveyor: str | None = None) -> ItemStream:
    """Draw a stream.

    The first item enters the belt at 0 s, wholly past its infeed. On a belt that stands, the items lie within
    its window, the first one farthest from the infeed; or are set down one by one, anywhere within it.

    Args:
        cell: The cell with the conveyor.
        request: What it is to be.
        seed: Seed of all random choices.
        conveyor: Name of the conveyor; None for the only one, or the first.

    Returns:
        The stream, its poses and speed exact.

    Raises:
        InputError: The cell has no conveyor, it is slower, or the items do not fit or come too late.
        UnknownNameError: No conveyor has that name.
    """
    belts = conveyors(cell)
    name = next(iter(belts)) if conveyor is None else conveyor
    if name not in belts:
        raise UnknownNameError("conveyor", name, list(belts))
    belt = belts[name].conveyor
    assert belt is not None
    _refuse_one_by_one(request, belt)
    if request.speed > belt.max_speed:
        raise InputError(
            f"--speed {request.speed:g}: conveyor {name} runs at {belt.max_speed:g} m/s at most; take less"
        )
    rng = derived_rng("stream", name, seed)
    kinds = _taken_from_above(cell, name, DEVIATION if request.speed > 0.0 else 0.0)
    riding: list[RidingItem] = []
    counts: dict[str, int] = {}
    front, rear, first_rear = 0.0, 0.0, 0.0  # m along the belt, of the item, from the front of the first one
    for k in range(request.n_items):
        item, sides = kinds[int(rng.integers(len(kinds)))]
        T = _standing(item, sides[int(rng.integers(len(sides)))], belt.width, rng)
        if request.one_by_one:
            T[0, 3], stamp = rng.uniform(*(request.within or belt.window)), 0.0
            riding.append(_named(item, stamp, T, counts))
            continue
        reach, gap = float(item.shape.reach(T[:3, :3])[0]), float(rng.uniform(*request.gap))
        front = rear - gap if k else 0.0
        rear = front - 2.0 * reach
        first_rear = first_rear if k else rear
        if request.speed > 0.0:
            T[0, 3], stamp = reach, (first_rear - rear) / request.speed
        else:
            T[0, 3], stamp = belt.window[1] + front - reach, 0.0
            if T[0, 3] < belt.window[0]:
                raise InputError(
                    f"{k} of {request.n_items} items fit within the window of conveyor {name} while it "
                    "stands; take fewer, or smaller gaps"
                )
        if stamp > MAX_TIME:
            raise InputError(
                f"--speed {request.speed:g}: item {k + 1} of {request.n_items} enters at {stamp:.3g} s, "
                f"streams last {MAX_TIME:g} s at most; take a higher speed, or fewer items"
            )
        riding.append(_named(item, stamp, T, counts))
    return ItemStream(cell, name, request.speed, 0.0, PoseNoise(), tuple(riding), seed, request.one_by_one)


def _named(item: Item, stamp: float, T_belt_item: Array, counts: dict[str, int]) -> RidingItem:
    """Return an item with an id of its own; the counts of each name so far grow by it."""
    counts[item.name] = n = counts.get(item.name, 0) + 1
    return RidingItem(item.name if n == 1 else f"{item.name}#{n}", item, stamp, T_belt_item)


def _refuse_one_by_one(request: StreamRequest, belt: Conveyor) -> None:
    """Raise InputError for items one by one on a belt that runs, or beyond its ends."""
    if request.one_by_one and request.speed > 0.0:
        raise InputError("--one-by-one: items are set down so on a belt that stands; take --speed 0")
    if request.within is None:
        return
    if not request.one_by_one:
        raise InputError("--within: states where items are set down one by one; add --one-by-one")
    low, high = request.within
    if not 0.0 <= low <= high <= belt.length:
        raise InputError(
            f"--within {low:g},{high:g}: the belt is {belt.length:g} m long; take 0 <= LO <= HI up to that"
        )


def _taken_from_above(cell: Cell, conveyor: str, off: float) -> list[tuple[Item, tuple[StablePose, ...]]]:
    """Return the items that the tool takes from above, each with the sides on which they stand then.

    off: m by which the belt may be off
    """
    belt = cell.carriers[conveyor].conveyor
    assert belt is not None
    is_taken = _is_sealed if cell.robot.tool.grip.holds_by_vacuum else _is_pinched
    found = []
    for (_, year), item in sorted(cell.items.items(), key=lambda known: known[0]):
        if year != YEAR or float(np.hypot(*item.shape.extents[:2])) > belt.width - 2.0 * FROM_EDGE:
            continue
        standing = (side for side, _ in stable_poses(item) if not (side.is_on_edge or side.can_roll))
        sides = tuple(side for side in standing if is_taken(cell, conveyor, item, side, off))
        found += [(item, sides)] if sides else []
    return found


def _is_sealed(cell: Cell, conveyor: str, item: Item, side: StablePose, off: float) -> bool:
    """Whether the item's top takes the whole cup, which bears it with its reserve."""
    share, limits = _seal_of_top(item, side, cell.robot.tool), cell.robot.tool.grip.limits
    return share >= LEAST_SHARE and share * limits.max_pull >= RESERVE * GRAVITY * item.heaviest


def _is_pinched(cell: Cell, conveyor: str, item: Item, side: StablePose, off: float) -> bool:
    """Whether fingers have room to pinch the item from above, alone on the belt, with their reserve."""
    carrier = cell.carriers[conveyor]
    assert carrier.conveyor is not None
    middle = sum(carrier.conveyor.window) / 2.0
    T = pose((middle, 0.0, float(item.shape.reach(side.R_up_item)[2])), R=side.R_up_item)
    seen = replace(SEEN, position=SEEN.position + off)
    alone = ItemStream(cell, conveyor, 0.0, 0.0, seen, (RidingItem(item.name, item, 0.0, T),))
    context, place = PlanningContext(cell), next(iter(carrier.places))
    problem = PickProblem.of(context, alone.scene_at(0.0), PickQuery(place, item.name, place), 0)
    rng = derived_rng("pinched from above", item.name)
    found = context.method.sample(problem.grasp_target, rng, USUAL, 1.0 / RESERVE)
    ways_out = extraction_of(problem).transforms(CorridorSet.FEW)
    return not isinstance(ways_out, Failures) and bool(with_tool_clearance(problem, found, ways_out)[0])


def _seal_of_top(item: Item, side: StablePose, tool: Tool) -> float:
    """Share of full vacuum that the upper face keeps under the whole cup while the item stands on a side."""
    up = side.R_up_item[2]
    axis = int(np.argmax(np.abs(up)))
    top = f"{'+' if up[axis] > 0.0 else '-'}{'xyz'[axis]}"
    return item.seals.get(top, 0.0) if any(face.name == top for face in wide_faces(item, tool)) else 0.0


def _standing(item: Item, side: StablePose, width: float, rng: np.random.Generator) -> Array:
    """Random pose (4, 4) of an item on one of its sides in the frame of the belt, at the infeed."""
    R = rotation_axis_angle((0.0, 0.0, 1.0), float(rng.uniform(-np.pi, np.pi))) @ side.R_up_item
    reach = item.shape.reach(R)
    aside = max(0.0, min(LANES, width / 2 - FROM_EDGE - float(reach[1])))
    return pose((0.0, float(rng.uniform(-aside, aside)), float(reach[2])), R=R)
