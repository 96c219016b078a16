"""What the camera of a truck sees of a driving area: floor, walls, boxes, the pallet with its load, forks."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from pickcli.cell.shapes import Body, box
from pickcli.driving.driving_area import DrivingArea, StatedPallet
from pickcli.driving.truck_camera import TruckCamera, floor_pose
from pickcli.geometry import Array
from pickcli.perception.depth_picture import DepthPicture, measure_depth
from pickcli.perception.rendered_scene import OwnerKind, RenderedScene, RenderedSolid

WALL_HEIGHT, WALL = 2.5, 0.1  # m, height and thickness of walls
FLOOR = 0.1  # m, thickness of the floor


def rendered_area(area: DrivingArea, truck: Array, pallets: tuple[StatedPallet, ...]) -> RenderedScene:
    """Put up what a camera can see of an area.

    Args:
        area: The area.
        truck: (3,) m, m, rad: pose of the truck, of which cameras see the forks.
        pallets: What stands in it besides its boxes.

    Returns:
        The solids.
    """
    return RenderedScene(tuple(_solids(area, truck, pallets)))


def take_picture(
    area: DrivingArea, camera: TruckCamera, truck: Array, pallets: tuple[StatedPallet, ...], seed: int
) -> DepthPicture:
    """Take a depth picture from the truck.

    Args:
        area: The area.
        camera: The camera.
        truck: (3,) m, m, rad: pose of the truck.
        pallets: What stands in the area besides its boxes.
        seed: Of the noise.

    Returns:
        The picture; its world is the frame of the truck.
    """
    T_world_truck = floor_pose(truck)
    taken = measure_depth(
        rendered_area(area, truck, pallets), camera.model, T_world_truck @ camera.T_truck_camera, seed
    )
    return DepthPicture(taken.camera, camera.T_truck_camera, taken.depth)


def _solids(area: DrivingArea, truck: Array, pallets: tuple[StatedPallet, ...]) -> Iterator[RenderedSolid]:
    (x, y), (far_x, far_y) = area.low, area.high
    around = (
        box("floor", (x, y, -FLOOR), (far_x, far_y, 0.0)),
        box("wall -x", (x - WALL, y, 0.0), (x, far_y, WALL_HEIGHT)),
        box("wall +x", (far_x, y, 0.0), (far_x + WALL, far_y, WALL_HEIGHT)),
        box("wall -y", (x, y - WALL, 0.0), (far_x, y, WALL_HEIGHT)),
        box("wall +y", (x, far_y, 0.0), (far_x, far_y + WALL, WALL_HEIGHT)),
    )
    yield from _posed("area", around, np.zeros(3))
    for each in area.boxes:
        (length, width), height = each.size, each.height
        body = box(each.name, (-length / 2, -width / 2, 0.0), (length / 2, width / 2, height))
        yield from _posed(each.name, (body,), np.array([*each.centre, each.yaw]))
    for pallet in pallets:
        yield from _posed("pallet", pallet.bodies, pallet.pose)
    forks = area.forks.bodies(area.truck.back)
    yield from _posed("truck", forks, truck, OwnerKind.LINK)


def _posed(
    owner: str, bodies: tuple[Body, ...], at: Array, kind: OwnerKind = OwnerKind.CARRIER
) -> Iterator[RenderedSolid]:
    T = floor_pose(at)
    for body in bodies:
        yield RenderedSolid(kind, owner, body.shape, T @ body.T_parent_shape)
