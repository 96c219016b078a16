"""Consistency of a scene with its cell: names, locations, and solids that overlap or float."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import product
from typing import Protocol, TypeAlias

import numpy as np

from pickcli.cell.cell import Cell
from pickcli.cell.hollow_body import solids_of
from pickcli.cell.item import OWN_ITEMS, item_suggestion
from pickcli.cell.shapes import Shape, ShapeKind
from pickcli.cell.station import TOTE
from pickcli.files.schema import Vector
from pickcli.files.source import Key, Source
from pickcli.geometry import Array, inverse, pose
from pickcli.name_suggestion import shortened, suggestion
from pickcli.scene.scene import HeldItem, PlacedItem, Scene
from pickcli.scene.scene_schema import PlacedItemModel, SceneModel
from pickcli.scene.solid_overlap import TOUCH, PosedSolid, overlap_depth
from pickcli.scene.touching import PosedSolids, gaps

Mistake: TypeAlias = tuple[Key, str]  # key in the file, and text


class NamedItem(Protocol):
    """An item as files name it: by name and year."""

    @property
    def name(self) -> str:
        """Name of the item."""

    @property
    def year(self) -> int:
        """Year of its figures."""


SUNK = 0.005  # m, tolerated depth of an item in a stationary solid, beyond pose uncertainty
FLOATING = 0.01  # m, tolerated gap between an item and its support, beyond pose uncertainty
CONVENTION = "positions are in m, quaternions x, y, z, w"
ONE_POSE = f"correct its pose ({CONVENTION})"
FEW = 3  # up to this many mistakes of one kind are reported one by one
MANY = 20  # after this many mistakes of one kind the search stops
_POINT = 1e-4  # m, radius of a ball that represents a point
MAX_LEAN = 0.1  # rad, tolerated tilt of a pod or carrier, for poses measured by a camera
MAX_ASTRAY = 0.15  # m, largest distance of an item's centre from its place


def check_names(source: Source, model: SceneModel, cell: Cell) -> None:
    """Check that ids are unique and that items and places exist. Raises at once: other checks need them.

    Args:
        source: The file, for positions in messages.
        model: The scene as it stands in the file.
        cell: Its cell.

    Raises:
        InputError: With every mistake and its position.
    """
    locations = list(cell.places)
    seen: dict[str, PlacedItemModel] = {}
    for i, item in enumerate(model.items):
        if item.id in seen:
            source.add(("items", i, "id"), f"{item.id!r} stands twice; give each instance an id of its own")
        seen[item.id] = item
        check_id(source, ("items", i, "id"), item.id, cell)
        check_item(source, ("items", i, "name"), item, cell)
        if item.location not in locations:
            hint = "" if source.is_full else f"; {suggestion(item.location, locations)}"
            source.add(("items", i, "location"), f"unknown place {shortened(item.location)!r}{hint}")
    if model.held is not None:
        check_id(source, ("held", "id"), model.held.id, cell)
        check_item(source, ("held", "name"), model.held, cell)
        same = seen.get(model.held.id)
        if same is not None and (same.name, same.year) != (model.held.name, model.held.year):
            source.add(
                ("held", "id"), f"{same.id!r} is a {same.name} of {same.year} among the items; correct one"
            )
    source.check()


def check_id(source: Source, key: Key, item_id: str, cell: Cell) -> None:
    """Check that the id of an item is not the name of anything else that motions are checked against.

    Args:
        source: Collects the mistakes with their places in the file.
        key: Where the id stands in it.
        item_id: The id.
        cell: The cell.
    """
    if (kind := taken_by(item_id, cell)) is not None:
        source.add(key, f"{item_id!r} is the name of {kind}; give the item another id")


def taken_by(item_id: str, cell: Cell) -> str | None:
    """Tell what else that motions are checked against has the name of an item.

    Args:
        item_id: Id of the item.
        cell: The cell.

    Returns:
        What has that name; None if nothing has.
    """
    bodies = {body.name for each in cell.carriers.values() for body in each.bodies}
    bodies |= {body.name for body in cell.obstacles.bodies}
    named = {
        "a link of the robot": {link.name for link in cell.robot.links},
        "a part of the cell": bodies | {*cell.carriers, *cell.places},
    }
    return next((kind for kind, names in named.items() if item_id in names), None)


def check_item(source: Source, key: tuple[str | int, ...], item: NamedItem, cell: Cell) -> None:
    """Check that the cell knows an item.

    Args:
        source: Collects the mistakes with their places in the file.
        key: Where the item's name stands in it.
        item: The item as it stands in the file.
        cell: The cell.
    """
    if (item.name, item.year) not in cell.items:
        source.add(
            key, f"unknown item {shortened(item.name)!r} of {item.year}{_what_is_known(source, item, cell)}"
        )


def _what_is_known(source: Source, item: NamedItem, cell: Cell) -> str:
    """Suggest known items for an unknown one; "" if the list of mistakes is full."""
    if source.is_full:
        return ""
    known = [name for name, year in cell.items if year == item.year]
    if known:
        return f"; {item_suggestion(item.name, known)}"
    years = " and ".join(sorted({str(year) for _, year in cell.items}))
    return f"; there are items of {years} ({OWN_ITEMS})"


def check_carriers(source: Source, model: SceneModel, cell: Cell) -> None:
    """Check that carrier poses are for carriers of the cell, and that the pod has one.

    Args:
        source: Collects the mistakes with their places in the file.
        model: The scene as it stands in the file.
        cell: Its cell.
    """
    own = [carrier.name for carrier in cell.own_carriers] + [TOTE] * (cell.tote is not None)
    for name in model.places:
        if name not in own:
            hint = suggestion(name, own) if own else "the cell states no places"
            source.add(("places", name), f"unknown place {shortened(name)!r}; {hint}")
    if model.T_world_pod is None and cell.pod.bins:
        source.add(("T_world_pod",), "expected where the pod stands now, got nothing; add it")
    if model.T_world_pod is not None and not cell.pod.bins:
        source.add(("T_world_pod",), f"cell {cell.name} has no pod; leave it out")


def check_unknown(source: Source, model: SceneModel, cell: Cell) -> None:
    """Check that unknown space is in places of the cell, and that its boxes are some.

    Args:
        source: Collects the mistakes with their places in the file.
        model: The scene as it stands in the file.
        cell: Its cell.
    """
    seen: set[str] = set()
    for i, space in enumerate(model.unknown):
        if space.place not in cell.places:
            hint = suggestion(space.place, list(cell.places))
            source.add(("unknown", i, "place"), f"unknown place {shortened(space.place)!r}; {hint}")
        elif space.place in seen:
            source.add(("unknown", i, "place"), f"{space.place} stands twice; write all its boxes in one")
        seen.add(space.place)
        check_boxes(source, ("unknown", i, "boxes"), space.boxes)
        check_boxes(source, ("unknown", i, "unrecognised"), space.unrecognised)


def check_boxes(source: Source, key: Key, boxes: Sequence[tuple[Vector, Vector]]) -> None:
    """Check that boxes are some.

    Args:
        source: Collects the mistakes with their places in the file.
        key: Where the boxes stand in it.
        boxes: Each by two corners, the lower one first.
    """
    for k, (low, high) in enumerate(boxes):
        if not all(a < b for a, b in zip(low, high, strict=True)):
            fault = "the first corner must be below the second along x, y and z"
            source.add((*key, k), f"is no box; {fault}")


def check_upright(source: Source, scene: Scene) -> None:
    """Check that pod and carriers stand as upright as in the cell; bounds of their errors have no other axis.

    Args:
        source: Collects the mistakes with their places in the file.
        scene: The scene.
    """
    nominal = {name: carrier.T_world_carrier for name, carrier in scene.cell.carriers.items()}
    actual: dict[Key, tuple[Array, Array]] = {
        ("T_world_pod",): (scene.cell.T_world_pod, scene.T_world_pod),
        **{("places", name): (nominal[name], at.T_world_carrier) for name, at in scene.carriers.items()},
    }
    for key, (T_nominal, T) in actual.items():
        lean = float(np.arccos(np.clip(T_nominal[:3, 2] @ T[:3, 2], -1.0, 1.0)))
        if lean > MAX_LEAN:
            text = f"leans by {math.degrees(lean):.0f} degrees; it stands upright, only its yaw is free: is "
            source.add((*key, "quaternion"), f"{text}the quaternion x, y, z, w?")


def check_places(source: Source, scene: Scene) -> None:
    """Check that every item is near its stated location, and not inside of another place.

    This detects poses in another frame, and names of neighbours.

    Args:
        source: Collects the mistakes with their places in the file.
        scene: The scene.
    """
    astray_items: list[Mistake] = []
    sunk: list[Mistake] = []
    elsewhere: list[Mistake] = []
    for i, placed in enumerate(scene.items):
        place = scene.cell.places[placed.location]
        is_from_above = place.access.is_from_above
        T_place_item = inverse(scene.T_world_place(place)) @ placed.T_world_item
        p, R = T_place_item[:3, 3], T_place_item[:3, :3]
        beside = p - np.clip(p, place.room.low, place.room.high)
        # Items that fall may be high above.
        astray = float(np.linalg.norm(beside[:2] if is_from_above else beside))
        if astray > MAX_ASTRAY:
            where = f"{placed.id} is {astray:.2f} m away from {placed.location}"
            astray_items.append((("items", i, "position"), where))
            continue
        is_inside = place.room.contains(p, np.inf if is_from_above else 0.0)
        other = "" if is_inside else _place_around(scene, placed.T_world_item[:3, 3])
        under = place.room.floor_back - (p[2] - placed.item.shape.reach(R)[2])
        if not is_from_above and under > SUNK + scene.bound(placed):
            text = f"{placed.id} reaches {1000 * under:.1f} mm under the floor of {placed.location}"
            sunk.append((("items", i, "position"), text + f", into {other}" * bool(other)))
        elif other:
            text = f"{placed.id} lies in {other}, not in {placed.location}"
            elsewhere.append((("items", i, "location"), text))
    frame = "poses are those of the item's middle in the world frame (docs/formats/scene.md)"
    _add_alike(source, astray_items, frame, f"is T_world_pod where the pod stands? {frame}")
    _add_alike(source, sunk, ONE_POSE, f"correct its pose, or all: {CONVENTION}")
    _add_alike(
        source, elsewhere, "correct its location or its pose", "are their locations those of their poses?"
    )


def _place_around(scene: Scene, p: Array) -> str:
    """Name of the place whose room has a point (3,) of the world inside; "" for none."""
    for place in scene.cell.places.values():
        T_place_world = inverse(scene.T_world_place(place))
        if place.room.contains((T_place_world @ [*p, 1.0])[:3]):
            return place.name
    return ""


def _add_alike(source: Source, mistakes: Sequence[Mistake], advice: str, if_many: str) -> None:
    """Report mistakes of one kind; of many only the first, as they probably have the same cause."""
    if len(mistakes) <= FEW:
        for key, text in mistakes:
            source.add(key, f"{text}; {advice}")
    else:
        key, text = mistakes[0]
        source.add(key, f"{text}, and {len(mistakes) - 1} more are like it; {if_many}")


def check_held(source: Source, scene: Scene) -> None:
    """Check that the held item is at the tip, within pose uncertainty and compliance of the tool.

    Between two fingers it may extend behind the tip, towards the hand.

    Args:
        source: Collects the mistakes with their places in the file.
        scene: The scene.
    """
    if scene.held is None:
        return
    item, tool = PosedSolid(scene.held.item.shape, scene.held.T_tip_item), scene.cell.robot.tool
    slack = SUNK + tool.grip.gives_way + scene.bound(scene.held)
    advice = (
        "; position is that of the item's middle in the tool frame, in m: the origin at the tip of the "
        f"{tool.grip.holder}, +z out of it"
    )
    if overlap_depth(item, _ball(tool.grip.tip_radius + slack, 0.0), 0.0) == 0.0:
        away = float(np.linalg.norm(item.center))
        where = f"{away:.3g} m from the tip of the {tool.grip.holder}, which its surface is to be at"
        source.add(("held", "position"), f"the middle of {scene.held.id} is {where}{advice}")
    elif not tool.grip.takes_widths and _is_in_the_tool(scene.held, -slack - _POINT):
        where = f"reaches more than {1000 * slack:.0f} mm behind the tip of the cup, into the tool"
        source.add(("held", "position"), f"{scene.held.id} {where}{advice}")


def _is_in_the_tool(held: HeldItem, z: float) -> bool:
    """Whether an item is where the tool is, at z behind the tip; a tool may be in one of its hollows."""
    shape = held.item.shape
    at = (inverse(held.T_tip_item) @ [0.0, 0.0, z, 1.0])[:3]
    if any(hollow.contains(shape, at) for hollow in held.item.hollows):
        return False
    return overlap_depth(PosedSolid(shape, held.T_tip_item), _ball(_POINT, z), 0.0) > 0.0


def _ball(radius: float, z: float) -> PosedSolid:
    """A ball in the tool frame with its centre at z on the tool axis."""
    return PosedSolid(Shape(ShapeKind.SPHERE, (radius,)), pose((0.0, 0.0, z)))


def check_standing(source: Source, scene: Scene) -> None:
    """Check that no item penetrates a stationary body deeper than pose uncertainty explains.

    Args:
        source: Collects the mistakes with their places in the file.
        scene: The scene.
    """
    error = _largest_error(scene)
    every = PosedSolids.of(scene, scene.items, scene.standing)
    solids = [PosedSolid(shape, T) for shape, T in zip(every.shapes, every.T, strict=True)]
    a, b = every.near(len(scene.items))
    deep: list[Mistake] = []
    for i, placed in enumerate(scene.items):
        tolerance = SUNK + scene.bound(placed) + error
        near = b[(a == i) & (b >= len(scene.items))].tolist()
        depths = [(overlap_depth(solids[i], solids[k], tolerance), every.names[k]) for k in near]
        depth, name = max(depths, default=(0.0, ""))
        if depth > 0.0:
            what = f"{placed.id} stands {1000 * depth:.1f} mm deep in {name}"
            deep.append((("items", i, "position"), what))
        if len(deep) > MANY:
            break
    _add_alike(source, deep, ONE_POSE, f"correct its pose, or all: {CONVENTION}")


def _largest_error(scene: Scene) -> float:
    """Largest position error, in m, of the centre of any carrier body."""
    return max(
        (
            carrier.error.bound(float(np.linalg.norm(body.T_parent_shape[:2, 3])))
            for carrier in scene.posed_carriers
            for body in carrier.bodies
        ),
        default=0.0,
    )


def check_floating(source: Source, scene: Scene) -> None:
    """Check that every item touches something, within pose uncertainty.

    Items above an open box may be falling, and the held item is listed where it was seen. With a cloud no
    item is checked, as it may rest on something in the cloud.

    Args:
        source: Collects the mistakes with their places in the file.
        scene: The scene.
    """
    if scene.cloud is not None:
        return
    every = PosedSolids.of(scene, scene.items, scene.standing)
    reach = FLOATING + _largest_error(scene)
    found = gaps(every, *every.near(len(scene.items), reach))
    close = found.width <= reach + every.bound[found.a] + every.bound[found.b]
    touching = {*found.a[close].tolist(), *found.b[close].tolist()}
    held = "" if scene.held is None else scene.held.id
    floating: list[Mistake] = []
    for i, placed in enumerate(scene.items):
        may_be_falling = scene.cell.places[placed.location].is_open_box
        if i not in touching and not may_be_falling and placed.id != held:
            others = np.delete(np.arange(len(every.names)), i)
            widths = gaps(every, np.full(len(others), i), others).width
            name = every.names[others[widths.argmin()]]
            text = f"{placed.id} floats: {name}, the nearest to it, is {1000 * widths.min():.1f} mm away"
            floating.append((("items", i, "position"), text))
    one = "put it onto what carries it, or state in noise how far poses may be off"
    _add_alike(source, floating, one, f"{one}; positions are those of the items' middles, in m")


def _overlap_of_items(one: PlacedItem, other: PlacedItem, tolerance: float) -> float:
    """Depth, in m, by which two items reach into each other; 0 up to the tolerance."""
    outer = [PosedSolid(each.item.shape, each.T_world_item) for each in (one, other)]
    depth = overlap_depth(outer[0], outer[1], tolerance)
    if depth == 0.0 or not (one.item.hollows or other.item.hollows):
        return depth
    solids = [
        [PosedSolid(solid.shape, each.T_world_item @ solid.T_parent_shape) for solid in solids_of(each.item)]
        for each in (one, other)
    ]
    return max(overlap_depth(a, b, tolerance) for a, b in product(*solids))


def check_overlaps(source: Source, scene: Scene) -> None:
    """Check that no two items overlap deeper than pose uncertainty explains; one may lie in another's hollow.

    Args:
        source: Collects the mistakes with their places in the file.
        scene: The scene.
    """
    every = PosedSolids.of(scene, scene.items, ())
    a, b = every.near(len(scene.items))
    overlaps: list[Mistake] = []
    for i, j in zip(a.tolist(), b.tolist(), strict=True):
        tolerance = TOUCH + float(every.bound[i] + every.bound[j])
        depth = _overlap_of_items(scene.items[i], scene.items[j], tolerance)
        if depth > 0.0:
            ids = f"{scene.items[i].id} and {scene.items[j].id}"
            overlaps.append((("items", j), f"{ids} overlap by {1000 * depth:.1f} mm"))
        if len(overlaps) > MANY:
            break
    one = "correct one of the poses"
    _add_alike(source, overlaps, one, f"{one}, or all: {CONVENTION}")
