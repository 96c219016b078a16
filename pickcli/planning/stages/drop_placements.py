"""Placements for dropping an item into a walled place: low over the lowest pile, between the walls."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from pickcli.cartesian.line import shifted
from pickcli.cartesian.line_following import follow_line
from pickcli.cell.place import Place
from pickcli.cell.tool import IN_LINE, MOVING, ToolState
from pickcli.collision.attached_item import AttachedItem
from pickcli.collision.checker import SceneChecker
from pickcli.collision.motion_segment import Mode, MotionSegment, at_rest
from pickcli.errors import Failures, Reason
from pickcli.geometry import Array, inverse, pose, rotation_axis_angle
from pickcli.motion.segment import SegmentKind, SegmentLimits
from pickcli.planning.pick_motion import GraspMotion, PlaceMotion
from pickcli.planning.pick_problem import PickProblem
from pickcli.scene.pile import Pile
from pickcli.scene.scene import Scene
from pickcli.seeds import derived_rng

WALL_DISTANCE = 0.02  # m between the held item's box and the walls, if there is enough room
LEAST_WALL_DISTANCE = 0.008
ABOVE_PILE = 0.025  # m between the item and what lies below it when it is released
ABOVE_RIM = 0.03  # m between the item and the rim while it comes in
TURN_CLEARANCE = 0.015  # m between an item that turns over and the tool where it was released
LEAST_RISE = 0.05  # m of straight way to the release and back: on a shorter one the tool gains no speed
LANCE_ABOVE_RIM = 0.04  # m between the tip and the rim if the lance is level over the place
LANCE_TURN_COST = 0.03  # m of drop that equal the cost of a turn of 1 rad
PER_ORIENTATION = 2
COVERED_COST = 0.1  # m of drop that equal the cost of covering an item that could be taken next
REACH_COST = 0.2  # m of drop per metre of distance from the shoulder, if several arms share a place
MOST_SHARED = 90  # placements that are tried then
MAX_DROP = 0.28  # m from the item's lowest point to the floor (the rules: 0.3)
ROUNDING = 1e-6  # m, so that what is released from the greatest height is not refused for it
YAWS = np.radians(np.arange(-180, 180, 15))
N_EXPLAINED = 3  # arm configurations over a placement, none of which is free
N_MOTIONS = 4  # motions from which the best is chosen
DROP_COST = 2.0  # s per metre of a drop's cost
LEVEL_LANCE = np.radians(105.0)  # largest angle of a level lance from pointing across the place


@dataclass(frozen=True, eq=False)
class DropPlacement:
    """One pose for releasing the item.

    Attributes:
        release: (4, 4) pose of the tool frame in the world at release.
        rise: m of the straight way down to it and up again; 0 over the rim.
        cost: m, height of the pile and turns of the wrist weighted together; the least is best.
    """

    release: Array
    rise: float
    cost: float

    @property
    def above(self) -> Array:
        """(4, 4) pose of the tool frame in the world above the place."""
        return shifted(self.release, np.array([0.0, 0.0, self.rise]))


@dataclass(frozen=True, eq=False)
class _Grid:
    """Release poses for A tool orientations at G positions each. In m, in the frame of the pile."""

    centres: Array  # (A, G, 2) of the item
    tip: Array  # (A, G) height of the tip
    drop: Array  # (A, G) from the item's lowest point to the floor
    rise: Array  # (A, G) of the straight way up again
    cost: Array  # (A, G), infinite if the position is not tried

    @classmethod
    def of(
        cls, pile: Pile, T_item: Array, reach: Array, play: Array, prices: Array, is_level: bool,
        over_rim: bool,
    ) -> _Grid:  # fmt: skip
        """Weigh the height of the pile, the drop, the lever, the rise and the turn of the wrist.

        An item that lands beside its middle turns over, and its near end rises towards the tool. The end of a
        rod of half length l that is stopped at the lever a is thrown up at a (l - a) / (l^2/3 + a^2) of the
        speed of the fall: half of it if a is l/3, and 0 if a is 0. So a lever counts like a drop, and if no
        pile is low the item is released with its middle over its support. What may turn over nevertheless is
        released higher, as far as it may drop: the end comes up within 0.25 s, in which a slow arm rises by
        2 mm only. The part of its way for which there is no room counts like a drop.

        T_item: (A, 4, 4) of the item, the tip at the origin; reach: (A, 3) half extents of the item;
        play: (A, 2) to either side of the middle; prices: (A,) of the turns
        """
        shares, are_tried = _places(play)
        centres = pile.middle + play[:, None] * shares
        footprints = reach[:, None, :2]
        height = pile.heights(centres, footprints)
        turn_up = pile.turn_ups(centres, reach[:, None])
        room = np.maximum(ABOVE_PILE, pile.floor + MAX_DROP - ROUNDING - height)
        above = np.clip(turn_up + TURN_CLEARANCE, ABOVE_PILE, room)
        tip = height + above + reach[:, None, 2] - T_item[:, None, 2, 3]
        if is_level:
            tip = np.maximum(tip, pile.rim + LANCE_ABOVE_RIM)
        lowest = tip + T_item[:, None, 2, 3] - reach[:, None, 2]
        if over_rim:
            higher = np.maximum(0.0, pile.rim + ABOVE_RIM - lowest)
            tip, lowest = tip + higher, lowest + higher
        rise = np.zeros_like(lowest)
        if not over_rim:
            rise = np.maximum(LEAST_RISE, pile.rim + ABOVE_RIM - lowest)
        short = np.maximum(turn_up - (lowest - height), 0.0)
        fall = lowest - height + pile.levers(centres, footprints) + short
        cost = fall + 2.0 * (height - pile.floor) + 0.3 * rise + prices[:, None]
        return cls(centres, tip, lowest - pile.floor, rise, np.where(are_tried, cost, np.inf))

    def near(self, shoulder: Array) -> _Grid:
        """Return a grid whose costs include the distance to the shoulder (2,)."""
        return replace(self, cost=self.cost + REACH_COST * np.linalg.norm(self.centres - shoulder, axis=-1))

    def beside(self, covered: Array) -> _Grid:
        """Return a grid whose costs include the number (A, G) of items covered that should not be."""
        return replace(self, cost=self.cost + COVERED_COST * covered)

    def best(self, orientations: NDArray[np.intp], n_each: int) -> list[tuple[int, int]]:
        """Return (orientation, position) of the best that do not drop too far, best first.

        orientations: those that are considered; n_each: most positions of each
        """
        cost = np.where(self.drop <= MAX_DROP, self.cost, np.inf)[orientations]
        few = np.argsort(cost, axis=1, kind="stable")[:, :n_each]
        cost = np.take_along_axis(cost, few, axis=1).ravel()
        order = [k for k in np.argsort(cost, kind="stable").tolist() if np.isfinite(cost[k])]
        return [(int(orientations[k // few.shape[1]]), int(few.flat[k])) for k in order]

    def placement(self, R_world_place: Array, R: Array, T_item: Array, a: int, g: int) -> DropPlacement:
        """Return the placement of orientation a at its position g."""
        release = pose([*(self.centres[a, g] - T_item[:2, 3]), self.tip[a, g]], R=R)
        return DropPlacement(pose(R=R_world_place) @ release, float(self.rise[a, g]), float(self.cost[a, g]))


def plan_drops(problem: PickProblem, chosen: GraspMotion) -> tuple[PlaceMotion, ...] | Failures:
    """Find motions that release the item over its destination, straight down between the walls and up again.

    Args:
        problem: The pick.
        chosen: Motion of the chosen grasp.

    Returns:
        The motions, the best placement first; or every reason for failure.
    """
    context, state, destination = problem.context, chosen.holding_state, problem.destination
    # An item that is moved within its place no longer lies there.
    without = problem.scene.without(problem.target.id)
    placements = drop_placements(without, destination, chosen.attached, state, uncovered=_uncovered(problem))
    if isinstance(placements, Failures):
        return placements
    rng = derived_rng(problem.seed, "drop", problem.target.id)
    carrying = Mode(state, chosen.attached, problem.contacts.while_transferring())
    named = context.configurations_at(destination)
    found: list[PlaceMotion] = []
    failures = Failures()
    for placement in placements:
        seeds = np.vstack([chosen.end, *named, context.arm.random_seeds(rng, 4)])
        motion = _dropped(problem, placement, seeds, carrying, chosen.grasp.tool_state)
        if isinstance(motion, Failures):
            failures += motion
            continue
        found.append(motion)
        if len(found) >= N_MOTIONS:
            break
    none = Reason(f"no free place in the {destination.name}", "place", f"{len(placements)} placements tried")
    return tuple(found) or failures + none


def _uncovered(problem: PickProblem) -> frozenset[str]:
    """Return ids of the items that an item moved aside within its place should not come to lie on."""
    if problem.destination.name != problem.place.name:
        return frozenset()
    here = problem.scene.in_location(problem.place.name)
    may_hold = problem.context.method.may_hold
    return frozenset(p.id for p in here if p.id != problem.target.id and may_hold(p.item))


def _dropped(
    problem: PickProblem, placement: DropPlacement, seeds: Array, carrying: Mode, empty: ToolState
) -> PlaceMotion | Failures:
    """Plan down to one placement and up again, from the first feasible arm configuration above it."""
    context, checker = problem.context, problem.context.checker_for(problem.scene, carrying)
    solutions = context.arm.solve(placement.above, carrying.tool_state, seeds)
    if len(solutions) == 0:
        return Failures.of(Reason("no inverse-kinematics solution", "place"))
    are_valid = checker.are_valid(solutions)
    blocked = solutions[~are_valid][:N_EXPLAINED]
    failures = Failures((lambda: (checker.explain(q).at("place") for q in blocked),))
    for q in solutions[are_valid]:
        motion = _lowered(problem, placement, q, carrying, empty)
        if not isinstance(motion, Failures):
            return motion
        failures += motion
    return failures


def _lowered(
    problem: PickProblem, placement: DropPlacement, q: Array, carrying: Mode, empty: ToolState
) -> PlaceMotion | Failures:
    """Plan down to one placement and up again, from q (n,) above it. empty: tool state on the way up."""
    context, state = problem.context, carrying.tool_state
    checker = context.checker_for(problem.scene, carrying)
    down = follow_line(context.arm, checker, placement.above, placement.release, state, q, "place")
    if isinstance(down, Failures):
        return down
    limits = SegmentLimits(max_tool_speed=context.settings.drop_speed)
    place = MotionSegment(SegmentKind.PLACE, down, limits, mode=carrying)
    after = problem.contacts.while_transferring()
    depart = replace(place.backwards(SegmentKind.DEPART), mode=Mode(empty, None, after))
    if empty == state:  # then it is the way down without the item, in volume that was just proven free
        return PlaceMotion(problem.scene, (place,), (depart,), DROP_COST * placement.cost)
    opening = at_rest(SegmentKind.DEPART, depart.start, Mode(MOVING, None, after))
    for segment in (opening, depart):
        checker = context.checker_for(problem.scene, segment.mode)
        if not checker.is_valid_path(segment.waypoints):
            return _why_not_opened(checker, segment)
    return PlaceMotion(problem.scene, (place,), (opening, depart), DROP_COST * placement.cost)


def _why_not_opened(checker: SceneChecker, segment: MotionSegment) -> Failures:
    """Explain what open or opening fingers collide with on the way up; evaluated lazily."""
    where = "place, with open fingers"
    return Failures((lambda: (checker.explain_path(segment.waypoints).at(where),),))


def drop_placements(
    scene: Scene,
    place: Place,
    held: AttachedItem,
    tool_state: ToolState,
    n_most: int = 30,
    uncovered: frozenset[str] = frozenset(),
    over_rim: bool = False,
) -> tuple[DropPlacement, ...] | Failures:
    """Find where the item fits between the walls of a place that is open above.

    Only the best few positions of each tool orientation are kept: if the arm cannot reach one with a given
    turn of the wrist, it cannot reach the ones beside it either.

    Args:
        scene: Poses as perceived.
        place: Place that the item is brought to.
        held: The item, attached to the tool.
        tool_state: State of the tool.
        n_most: Most placements.
        uncovered: Ids of items that are to stay uncovered, if there is room.
        over_rim: Whether the item is wholly over the rim when it is released.

    Returns:
        The placements, lowest pile first; or the reasons for failure.
    """
    pile = Pile.of(scene, place)
    is_level = not scene.cell.robot.tool.has_lance(tool_state, IN_LINE)
    shoulder = inverse(scene.T_world_place(place)) @ [*scene.cell.robot.shoulder, 1.0]
    prices, R = _orientations(is_level, is_from_left=bool(shoulder[1] >= 0.0))
    T_item = _posed(R) @ held.T_tip_item
    reach = held.item.shape.reach(T_item[:, :3, :3]) + held.inflate
    play = pile.half_room - reach[:, :2]
    grid = _Grid.of(
        pile, T_item, reach, play - np.clip(0.8 * play, LEAST_WALL_DISTANCE, WALL_DISTANCE), prices, is_level,
        over_rim,
    )  # fmt: skip
    grid = grid.beside(pile.covered(grid.centres, reach[:, None, :2], uncovered))
    n_each = PER_ORIENTATION
    if scene.cell.others:  # each arm reaches a part of the place: of all positions, the nearest first
        grid, n_each, n_most = grid.near(shoulder[:2]), grid.cost.shape[1], MOST_SHARED
    chosen = grid.best(np.flatnonzero(play.min(axis=1) >= LEAST_WALL_DISTANCE), n_each)
    if not chosen:
        return Failures(tuple(dict.fromkeys(_why_none(held, reach[:, :2], grid, pile, place))))
    R_world_place = scene.T_world_place(place)[:3, :3]
    return tuple(grid.placement(R_world_place, R[a], T_item[a], a, g) for a, g in chosen[:n_most])


@cache
def _orientations(is_level: bool, is_from_left: bool) -> tuple[Array, Array]:
    """Return tool orientations (A, 3, 3) in the place, the cup pointing down, and the cost (A,) of each.

    A level lance that points across the place, in the direction of the arm, is the easiest to reach.

    Args:
        is_level: Whether the lance is level then, or upright.
        is_from_left: Whether the shoulder is on the +y side of the place, from which a level lance comes.
    """
    down = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])  # x of the tool = +y of the place
    if is_level and not is_from_left:
        down = np.diag([-1.0, -1.0, 1.0]) @ down
    turns = np.array([a for a in YAWS if not is_level or abs(a) <= LEVEL_LANCE])
    price = LANCE_TURN_COST if is_level else 0.0
    return price * np.abs(turns), np.stack([rotation_axis_angle((0.0, 0.0, 1.0), a) @ down for a in turns])


def _posed(R: Array) -> Array:
    """Return poses (A, 4, 4) at the origin with orientations (A, 3, 3)."""
    T = np.tile(np.eye(4), (len(R), 1, 1))
    T[:, :3, :3] = R
    return T


def _places(play: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Return positions (G, 2) as shares of the play (A, 2) to either side, and which are tried (A, G).

    If there is hardly any play along a side, only the first position along it is tried.
    """
    x, y = np.linspace(-1.0, 1.0, 5), np.linspace(-1.0, 1.0, 3)
    shares = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    is_first = shares == -1.0
    return shares, np.asarray(((play[:, None] > 0.04) | is_first).all(axis=2))


def _why_none(held: AttachedItem, reach: Array, grid: _Grid, pile: Pile, place: Place) -> Iterator[Reason]:
    """Explain why each orientation has no position; reach: (A, 2) half extents of the item."""
    for a, half in enumerate(reach):
        if (pile.half_room - half).min() < LEAST_WALL_DISTANCE:
            size = " x ".join(f"{e * 1e3:.0f}" for e in held.item.shape.extents)
            yield Reason("does not fit between the walls", place.name, f"{held.item.name}, {size} mm")
            continue
        best = int(np.argmin(grid.cost[a]))
        far = f"{grid.drop[a, best]:.2f} m to the floor, at most {MAX_DROP}"
        yield Reason("would drop too far", place.name, far, pile.highest(grid.centres[a, best], half))
